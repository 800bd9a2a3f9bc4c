// A piezo on A0 at 1000 Hz, the detector on the board, and the LED on a slip: without gripd. Wired as docs/hardware.md shows, with the supply of this
// board at the upper resistor. For a Cortex-M; an AVR is too slow.
//
// Let the finger rest for 0.2 s after a start: the noise is learned then. A software stop is not a safety function.
#include <slip_detector.h>

static const uint32_t RATE_HZ = 1000;
static sd_detector detector;
static uint32_t due_us;

void setup() {
  pinMode(LED_BUILTIN, OUTPUT);
  // A converter of whole steps: the noise that is believed at least is left to them.
  (void)sd_init(&detector, static_cast<float>(RATE_HZ), 0.0f);
  due_us = static_cast<uint32_t>(micros());
}

void loop() {
  const uint32_t now_us = static_cast<uint32_t>(micros());
  if (static_cast<int32_t>(now_us - due_us) < 0) return;
  due_us += 1000000 / RATE_HZ;
  // Late by ten readings: what comes now does not follow the one before.
  if (static_cast<int32_t>(now_us - due_us) > static_cast<int32_t>(10 * (1000000 / RATE_HZ))) {
    due_us = now_us;
    sd_restart(&detector);
  }
  const sd_state state = sd_step(&detector, static_cast<float>(analogRead(A0)));
  digitalWrite(LED_BUILTIN, state >= SD_INCIPIENT ? HIGH : LOW);
}
