// A piezo on A0, and a load cell on an HX711 (data on pin 3, clock on pin 2) as normal force: 80 readings a second among rows at up to 500 Hz.
//
// ZERO and NEWTONS_A_STEP are made up: measure yours. A software stop is not a safety function.
#include <GripLink.h>

static const uint8_t CLOCK = 2, DATA = 3;
static const int32_t ZERO = 0;                // reading without a load
static const float NEWTONS_A_STEP = 2.3e-5f;  // of the HX711
static const float CHANNEL_N = 1e-3f;         // a step of the channel: 1 mN, 32 N at most

// What an AVR of 16 MHz keeps up with; a quicker board may offer more.
static GripBoard board(Serial, 500);

void setup() {
  Serial.begin(1000000);
  pinMode(LED_BUILTIN, OUTPUT);
  pinMode(CLOCK, OUTPUT);
  pinMode(DATA, INPUT);
  board.channel(GL_STYLUS, GL_UNIT_NONE, 1.0f);
  board.channel(GL_NORMAL_FORCE, GL_NEWTON, CHANNEL_N);
  while (!board.begin("arduino-loadcell", GripBoard::noise(A1))) digitalWrite(LED_BUILTIN, millis() / 100 % 2);
}

// The next reading in steps of the channel. The clock must not stay high for 60 us, so no interrupt may come in between.
static int16_t force() {
  int32_t value = 0;
  for (uint8_t bit = 0; bit < 25; bit++) {
    noInterrupts();
    digitalWrite(CLOCK, HIGH);
    const int level = digitalRead(DATA);
    digitalWrite(CLOCK, LOW);
    interrupts();
    // The 25th pulse chooses channel A and a gain of 128 for the next reading.
    if (bit < 24) value = value << 1 | level;
  }
  if (value & 0x800000) value -= 0x1000000;
  const float steps = static_cast<float>(value - ZERO) * (NEWTONS_A_STEP / CHANNEL_N);
  return static_cast<int16_t>(constrain(steps, -32767.0f, 32767.0f));
}

void loop() {
  board.update();
  if (board.due()) {
    int16_t row[2] = {static_cast<int16_t>(analogRead(A0) - 512), GL_NO_READING};
    if (digitalRead(DATA) == LOW) row[1] = force();
    board.push(row);
  }
}
