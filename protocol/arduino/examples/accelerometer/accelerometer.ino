// An accelerometer on I2C (SDA, SCL, 3.3 V) in the fingertip, its x axis along the slip: up to 800 rows a second, 500 on an AVR.
//
//   gripd --sensor /dev/ttyACM0 --baud 1000000
//
// Choose your part. A software stop is not a safety function.
#include <GripLink.h>
#include <Wire.h>

#if !defined(LIS2DW12) && !defined(MPU6050) && !defined(ADXL345)
#define ADXL345
#endif

struct Part {
  uint8_t address, identity, is;  // on the bus; register and content by which the part is known
  uint8_t first;                  // register of the low byte of x; of the high byte where `big`
  bool big;
  float step;                     // m/s2
  uint8_t setup[4][2];            // registers and values, in this order
};

#if defined(ADXL345)  // 800 Hz, full resolution, 16 g. SDO to ground.
static const Part part = {0x53, 0x00, 0xE5, 0x32, false, 0.0039f * 9.80665f, {{0x2C, 0x0D}, {0x31, 0x0B}, {0x38, 0x00}, {0x2D, 0x08}}};
#elif defined(LIS2DW12)  // 1600 Hz, high performance, 4 g, low noise. SA0 to 3.3 V.
static const Part part = {0x19, 0x0F, 0x44, 0x28, false, 0.000122f * 9.80665f, {{0x21, 0x0C}, {0x25, 0x14}, {0x2E, 0x00}, {0x20, 0x94}}};
#else  // MPU-6050: 1 kHz, 4 g, without its low-pass. AD0 to ground.
static const Part part = {0x68, 0x75, 0x68, 0x3B, true, 9.80665f / 8192.0f, {{0x6B, 0x01}, {0x1A, 0x00}, {0x19, 0x00}, {0x1C, 0x08}}};
#endif

#if defined(__AVR__)
static GripBoard board(Serial, 500);
#else
static GripBoard board(Serial, 800);
#endif

static bool put(uint8_t place, uint8_t value) {
  Wire.beginTransmission(part.address);
  Wire.write(place);
  Wire.write(value);
  return Wire.endTransmission() == 0;
}

// Bytes from a register on; false where the part does not answer.
static bool get(uint8_t place, uint8_t *bytes, uint8_t count) {
  Wire.beginTransmission(part.address);
  Wire.write(place);
  if (Wire.endTransmission(false) != 0) return false;
  if (Wire.requestFrom(part.address, count) != count) return false;
  for (uint8_t i = 0; i < count; i++) bytes[i] = static_cast<uint8_t>(Wire.read());
  return true;
}

// Whether the part is there, and set up.
static bool found() {
  uint8_t is = 0;
  if (!get(part.identity, &is, 1) || is != part.is) return false;
  for (uint8_t i = 0; i < 4; i++) {
    if (!put(part.setup[i][0], part.setup[i][1])) return false;
  }
  return true;
}

void setup() {
  Serial.begin(1000000);
  pinMode(LED_BUILTIN, OUTPUT);
  Wire.begin();
  Wire.setClock(400000);
  board.channel(GL_STYLUS, GL_METRE_PER_SECOND2, part.step);
  // The time of a human hand at the plug: differs from start to start.
  while (!found() || !board.begin("arduino-accel-01", micros())) digitalWrite(LED_BUILTIN, millis() / 100 % 2);
}

void loop() {
  board.update();
  if (!board.due()) return;
  static bool lost = false;
  uint8_t b[2];
  int16_t reading = GL_NO_READING;
  // One that did not answer may have been without power, and has lost its settings.
  if (!lost || found()) lost = !get(part.first, b, 2);
  if (!lost) reading = static_cast<int16_t>(part.big ? b[0] << 8 | b[1] : b[1] << 8 | b[0]);
  board.push(&reading);
}
