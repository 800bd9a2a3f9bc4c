// A gripper on an Arduino core: stylus on A0, motor driver on pin 9. Copy grip_link.h and grip_link.c beside this file.
//
// The scales and the limits below are made up: measure yours first. A software stop is not a safety function.
#include "grip_link.h"

static const uint8_t STYLUS_PIN = A0;
static const uint8_t MOTOR_PIN = 9;
static const int32_t FORCE_MAX_MN = 10000;  // at full duty
static const uint32_t RATE_MAX_HZ = 1000;

static gl_link grip;
static uint8_t frame[GL_MAX_WIRE];
static size_t frame_len, frame_sent;
static uint32_t period_us = 1000;
static uint64_t next_sample;

// micros() starts again after 71 minutes; the link's ticks must not.
static uint64_t now_us() {
  static uint32_t last;
  static uint64_t high;
  const uint32_t now = micros();
  if (now < last) high += UINT64_C(1) << 32;
  last = now;
  return high | now;
}

// Has to differ from start to start: better a counter in EEPROM or the random generator of the chip.
static uint32_t boot_id() {
  uint32_t id = 0;
  for (int i = 0; i < 32; i++) id = id << 1 ^ static_cast<uint32_t>(analogRead(A1)) ^ micros();
  return id;
}

void setup() {
  gl_ident id = {};
  id.uid[0] = 1;  // 16 bytes that only this gripper has
  id.boot_id = boot_id();
  id.tick_hz = 1000000;
  id.rate_max_hz = RATE_MAX_HZ;
  id.force_max_mn = FORCE_MAX_MN;
  id.slew_max_mn_s = 200000;
  id.hold_cap_mn = FORCE_MAX_MN;
  id.travel_max_um = 100000;
  id.channel_count = 1;
  id.channels[0].kind = GL_STYLUS;
  id.channels[0].unit = GL_METRE;
  id.channels[0].formats = 3;  // i16 and f32
  id.channels[0].count = 1;
  id.channels[0].scale = 1e-6f;  // a step of the converter is 1 um
  Serial.begin(1000000);
  if (gl_init(&grip, &id) != GL_INIT_OK) {
    for (;;) {
    }
  }
  gl_ready(&grip, now_us());
}

static void receive(uint64_t now) {
  uint8_t bytes[64];
  size_t len = 0;
  while (len < sizeof bytes && Serial.available() > 0) bytes[len++] = static_cast<uint8_t>(Serial.read());
  const uint8_t *input = bytes;
  gl_event event;
  // Also without bytes: time goes on in the link.
  while (gl_receive(&grip, now, &input, &len, &event)) {
    if (event.type == GL_ON_CONFIGURED) period_us = 1000000 / event.is.config.sample_rate_hz;
  }
}

static void sample(uint64_t now) {
  if (now < next_sample) return;
  next_sample = now - next_sample > 100000 ? now + period_us : next_sample + period_us;
  const int16_t reading = static_cast<int16_t>(analogRead(STYLUS_PIN));
  if (grip.batches.format == GL_F32) {
    const float metres = 1e-6f * reading;
    (void)gl_push_f32(&grip, now, &metres, 1);
  } else {
    (void)gl_push_i16(&grip, now, &reading, 1);
  }
}

static void drive(uint64_t now) {
  const gl_drive d = gl_drive_at(&grip, now);
  analogWrite(MOTOR_PIN, static_cast<int>(d.kind == GL_DRIVE_FORCE ? 255 * static_cast<int64_t>(d.force_mn) / FORCE_MAX_MN : 0));
}

// As much as the port takes without waiting; a frame is begun only when the one before is out.
static void transmit(uint64_t now) {
  if (frame_sent == frame_len) {
    frame_len = gl_poll_transmit(&grip, now, frame);
    frame_sent = 0;
  }
  const size_t room = static_cast<size_t>(Serial.availableForWrite());
  const size_t left = frame_len - frame_sent;
  frame_sent += Serial.write(frame + frame_sent, left < room ? left : room);
}

void loop() {
  const uint64_t now = now_us();
  receive(now);
  drive(now);
  sample(now);
  transmit(now);
  if (gl_take_alive(&grip)) {
    // Feed the watchdog of your board here, and nowhere else.
  }
}
