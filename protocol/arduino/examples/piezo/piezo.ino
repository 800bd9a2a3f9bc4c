// A piezo on A0 at up to 500 Hz: wired as docs/hardware.md shows, with the supply of this board at the upper resistor.
//
//   gripd --sensor /dev/ttyACM0 --baud 1000000
//
// A software stop is not a safety function.
#include <GripLink.h>

// What an AVR of 16 MHz keeps up with; a quicker board may offer more.
static GripBoard board(Serial, 500);

void setup() {
  Serial.begin(1000000);
  pinMode(LED_BUILTIN, OUTPUT);
  // What is not in metres is a vibration: slips are found, heights are not known.
  board.channel(GL_STYLUS, GL_UNIT_NONE, 1.0f);
  // A board that cannot begin blinks.
  while (!board.begin("arduino-piezo-01", GripBoard::noise(A1))) digitalWrite(LED_BUILTIN, millis() / 100 % 2);
}

void loop() {
  board.update();
  if (board.due()) {
    const int16_t reading = static_cast<int16_t>(analogRead(A0) - 512);
    board.push(&reading);
  }
}
