// A gripper: a stylus on A0, its motor driver on pin 9.
//
// The scale and the limits are made up: measure yours first. A software stop is not a safety function.
#include <GripLink.h>

static const uint8_t MOTOR = 9;
static const int32_t FORCE_MAX_MN = 10000;  // at full duty

// What an AVR of 16 MHz keeps up with; a quicker board may offer more.
static GripBoard board(Serial, 500);

void setup() {
  Serial.begin(1000000);
  pinMode(LED_BUILTIN, OUTPUT);
  board.channel(GL_STYLUS, GL_METRE, 1e-6f);  // a step of the converter is 1 um
  board.actuator(FORCE_MAX_MN, 200000, FORCE_MAX_MN);
  while (!board.begin("arduino-grip-01", GripBoard::noise(A1))) digitalWrite(LED_BUILTIN, millis() / 100 % 2);
}

void loop() {
  board.update();
  const gl_drive drive = board.drive();
  analogWrite(MOTOR, static_cast<int>(drive.kind == GL_DRIVE_FORCE ? 255 * static_cast<int64_t>(drive.force_mn) / FORCE_MAX_MN : 0));
  if (board.due()) {
    const int16_t reading = static_cast<int16_t>(analogRead(A0) - 512);
    board.push(&reading);
  }
  if (board.alive()) {
    // Feed the watchdog of your board here, and nowhere else.
  }
}
