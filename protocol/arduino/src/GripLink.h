// A board with sensors, and an actuator where it has one, on the grip link: begin, channels, and a row whenever one is due.
#ifndef GRIP_LINK_ARDUINO_H
#define GRIP_LINK_ARDUINO_H

#include <Arduino.h>

#include "grip_link.h"

class GripBoard {
 public:
  // `rate_max_hz`: the fastest rate at which the sketch can read its channels.
  GripBoard(Stream &port, uint32_t rate_max_hz) : port(port) {
    id.tick_hz = 1000000;
    id.rate_max_hz = rate_max_hz;
    // No actuator.
    id.force_max_mn = 0;
    id.slew_max_mn_s = 100000;
  }

  // The board has an actuator: its largest force, its fastest change of force, and the largest force held without commands; before begin().
  void actuator(int32_t force_max_mn, uint32_t slew_max_mn_s, int32_t hold_cap_mn) {
    id.force_max_mn = force_max_mn;
    id.slew_max_mn_s = slew_max_mn_s;
    id.hold_cap_mn = hold_cap_mn;
  }

  // What the actuator is to do now: ask at least every 10 ms.
  gl_drive drive() { return gl_drive_at(&link, now_us()); }

  // Whether all of the link ran since the last time: feed the watchdog then, and nowhere else.
  bool alive() { return gl_take_alive(&link); }

  // A boot_id for begin(): differs from start to start where the pin is left open, for its last bits are noise.
  static uint32_t noise(uint8_t pin) {
    uint32_t bits = 1;
    for (int i = 0; i < 32; i++) bits = bits << 1 ^ static_cast<uint32_t>(analogRead(pin)) ^ micros();
    return bits;
  }

  // Adds a channel before begin(); `scale` is its unit per step of i16. One of them is GL_STYLUS. False: no room for more.
  bool channel(uint8_t kind, uint8_t unit, float scale) {
    if (id.channel_count >= GL_CHANNELS) return false;
    gl_channel &c = id.channels[id.channel_count++];
    c.kind = kind;
    c.unit = unit;
    c.formats = 3;  // i16 and f32
    c.count = 1;
    c.scale = scale;
    return true;
  }

  // `uid`: 16 bytes that only this board has. `boot_id`: another number at every start. False: the channels cannot be.
  bool begin(const char *uid, uint32_t boot_id) {
    for (uint8_t i = 0; i < sizeof id.uid && uid[i]; i++) id.uid[i] = static_cast<uint8_t>(uid[i]);
    id.boot_id = boot_id;
    if (gl_init(&link, &id) != GL_INIT_OK) return false;
    gl_ready(&link, now_us());
    return true;
  }

  // Call it as often as you can: takes what the port has, and gives it what it takes without waiting.
  void update() {
    const uint64_t now = now_us();
    uint8_t bytes[32];
    size_t len = 0;
    while (len < sizeof bytes && port.available() > 0) bytes[len++] = static_cast<uint8_t>(port.read());
    const uint8_t *input = bytes;
    gl_event event;
    // Also without bytes: time goes on in the link.
    while (gl_receive(&link, now, &input, &len, &event)) {
      if (event.type == GL_ON_CONFIGURED) {
        period_us = 1000000 / event.is.config.sample_rate_hz;
        mask = event.is.config.channel_mask;
      }
    }
    (void)gl_drive_at(&link, now);
    if (sent == frame_len) {
      frame_len = gl_poll_transmit(&link, now, frame);
      sent = 0;
    }
    const int room = port.availableForWrite();
    const size_t left = frame_len - sent;
    if (room > 0 && left > 0) sent += port.write(frame + sent, left < static_cast<size_t>(room) ? left : static_cast<size_t>(room));
  }

  // Whether a host wants a row now. After a stall of 0.1 s and more the missed rows are left out.
  bool due() {
    if (!gl_is_sampling(&link)) return false;
    const uint64_t now = now_us();
    if (now < next) return false;
    next = now - next > 100000 ? now + period_us : next + period_us;
    return true;
  }

  // A row: one value for each channel in the order in which they were added, in steps; GL_NO_READING where there is none.
  void push(const int16_t *steps) {
    const uint64_t now = now_us();
    uint8_t n = 0;
    if (link.batches.format == GL_I16) {
      int16_t row[GL_CHANNELS];
      for (uint8_t i = 0; i < id.channel_count; i++) {
        if (wanted(i)) row[n++] = steps[i];
      }
      (void)gl_push_i16(&link, now, row, n);
    } else {
      float row[GL_CHANNELS];
      for (uint8_t i = 0; i < id.channel_count; i++) {
        if (wanted(i)) row[n++] = steps[i] == GL_NO_READING ? NAN : id.channels[i].scale * static_cast<float>(steps[i]);
      }
      (void)gl_push_f32(&link, now, row, n);
    }
  }

 private:
  bool wanted(uint8_t i) const { return (mask >> i & 1) != 0; }

  // micros() starts again after 71 minutes; the ticks of the link must not.
  uint64_t now_us() {
    const uint32_t now = micros();
    if (now < last) high += UINT64_C(1) << 32;
    last = now;
    return high | now;
  }

  Stream &port;
  gl_ident id = {};
  gl_link link = {};
  uint8_t frame[GL_MAX_WIRE];
  size_t frame_len = 0, sent = 0;
  uint32_t period_us = 1000, mask = 0, last = 0;
  uint64_t high = 0, next = 0;
};

#endif
