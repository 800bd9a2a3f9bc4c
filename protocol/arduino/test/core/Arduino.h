// The few functions of an Arduino core that the library and its sketches use; for the compiler alone.
#ifndef ARDUINO_H
#define ARDUINO_H

#include <stddef.h>
#include <stdint.h>

#define NAN (__builtin_nanf(""))
#define constrain(value, low, high) ((value) < (low) ? (low) : (value) > (high) ? (high) : (value))

enum : uint8_t { INPUT, OUTPUT, LOW = 0, HIGH, A0 = 14, A1 = 15, LED_BUILTIN = 13 };
unsigned long micros();
unsigned long millis();
int analogRead(uint8_t pin);
void analogWrite(uint8_t pin, int value);
int digitalRead(uint8_t pin);
void digitalWrite(uint8_t pin, uint8_t level);
void pinMode(uint8_t pin, uint8_t mode);
void interrupts();
void noInterrupts();

struct Stream {
  int available();
  int read();
  int availableForWrite();
  size_t write(const uint8_t *bytes, size_t len);
};
struct Port : Stream {
  void begin(unsigned long baud);
};
extern Port Serial;
void setup();
void loop();

#endif
