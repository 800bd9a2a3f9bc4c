/* Compiles the Arduino example against the few functions it uses; nothing is run. */
#include <stddef.h>
#include <stdint.h>

enum : uint8_t { A0 = 14, A1 = 15 };
unsigned long micros();
int analogRead(uint8_t pin);
void analogWrite(uint8_t pin, int value);
struct Port {
  void begin(unsigned long baud);
  int available();
  int read();
  int availableForWrite();
  size_t write(const uint8_t *bytes, size_t len);
};
extern Port Serial;
void setup();
void loop();

#include "../examples/arduino/arduino.ino"
