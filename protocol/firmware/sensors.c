#include "sensors.h"

#include "time.h"

#define STYLUS_SPAN_M 1.0e-3f
#define TRAVEL_SPAN_M 0.05f
#define TRAVEL 2u /* its place among the channels */
#define FROZEN_US 60000u
#define IDLE_PERIOD_US 1000u

static const gl_channel CHANNELS[SENSOR_COUNT] = {
    {GL_STYLUS, GL_METRE, 3, 1, STYLUS_SPAN_M / 32000.0f},
    {GL_NORMAL_FORCE, GL_NEWTON, 3, 1, 40.0f / 32000.0f},
    {GL_TRAVEL, GL_METRE, 3, 1, TRAVEL_SPAN_M / 32000.0f},
};

uint8_t sensors_describe(gl_channel *channels) {
  for (unsigned i = 0; i < SENSOR_COUNT; i++) channels[i] = CHANNELS[i];
  return SENSOR_COUNT;
}

void sensors_init(sensors *s) {
  s->mask = 0;
  s->format = GL_F32;
  s->period_us = IDLE_PERIOD_US;
  s->last_m = 0.0f;
  s->same_us = 0;
}

void sensors_configure(sensors *s, const gl_config *config) {
  s->mask = config->channel_mask;
  s->format = config->format;
  s->period_us = TICK_HZ / config->sample_rate_hz;
}

static int16_t raw(float value, float scale) {
  float steps = value / scale;
  if (!(steps >= 0.0f) && !(steps < 0.0f)) return INT16_MIN; /* no reading */
  if (steps > 32767.0f) return INT16_MAX;
  if (steps < -32767.0f) return -INT16_MAX;
  return (int16_t)(steps + (steps < 0.0f ? -0.5f : 0.5f));
}

void sensors_push(const sensors *s, gl_link *link, uint64_t tick, const readings *now) {
  const float all[SENSOR_COUNT] = {now->stylus_m, now->force_n, now->travel_m};
  float as_float[SENSOR_COUNT];
  int16_t as_raw[SENSOR_COUNT];
  size_t n = 0;
  for (unsigned i = 0; i < SENSOR_COUNT; i++) {
    if ((s->mask >> i & 1u) == 0) continue;
    as_float[n] = all[i];
    as_raw[n] = raw(all[i], CHANNELS[i].scale);
    n++;
  }
  if (s->format == GL_F32) (void)gl_push_f32(link, tick, as_float, n);
  else (void)gl_push_i16(link, tick, as_raw, n);
}

/* Whether the host can still see a slip by the travel: a channel that it asked for, with a reading in its range. At rest it stands still. */
static bool travel_usable(const sensors *s, const readings *now) {
  return (s->mask >> TRAVEL & 1u) != 0 && now->travel_m > -TRAVEL_SPAN_M && now->travel_m < TRAVEL_SPAN_M;
}

uint16_t sensors_judge(sensors *s, const readings *now) {
  /* A stylus with noise never repeats itself for long. */
  bool same = now->stylus_m <= s->last_m && now->stylus_m >= s->last_m;
  s->same_us = same ? s->same_us + s->period_us : 0;
  s->last_m = now->stylus_m;
  if (travel_usable(s, now)) return GL_FAULT_NONE;
  if (s->same_us >= FROZEN_US) return GL_FAULT_SENSOR_FROZEN;
  return now->stylus_m >= STYLUS_SPAN_M ? GL_FAULT_SENSOR_SATURATED : GL_FAULT_NONE;
}
