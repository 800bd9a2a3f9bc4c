// What the sketches use of Wire.
#ifndef WIRE_H
#define WIRE_H
#include "Arduino.h"
struct TwoWire {
  void begin();
  void setClock(uint32_t hz);
  void beginTransmission(uint8_t address);
  uint8_t endTransmission(bool stop = true);
  uint8_t requestFrom(uint8_t address, uint8_t count);
  size_t write(uint8_t value);
  int read();
};
extern TwoWire Wire;
#endif
