#include "stylus.h"

/* A surface of about Ra 1.6 um. */
#define HEIGHT_M 5.6e-6f
#define SPACING_M 2.0e-4f
/* Free oscillation of the tip. */
#define OMEGA_PER_S 3100.0f
#define DAMPING_RATIO 0.3f

/* Mixes an index into 32 random bits (finaliser of MurmurHash3, A. Appleby, public domain). */
static uint32_t mix(uint32_t x) {
  x ^= x >> 16;
  x *= 0x85EBCA6Bu;
  x ^= x >> 13;
  x *= 0xC2B2AE35u;
  return x ^ x >> 16;
}

/* 0 <= value < 1 */
static float unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

static void asperity(surface *s, uint32_t seed) {
  uint32_t bits = mix(seed ^ mix(s->index + 1u));
  s->height_m = HEIGHT_M * (0.6f + 0.8f * unit(bits));
  s->spacing_m = SPACING_M * (0.7f + 0.6f * unit(mix(bits)));
}

void surface_init(surface *s, uint32_t seed) {
  s->index = 0;
  s->start_m = 0.0f;
  asperity(s, seed);
}

float surface_height(surface *s, uint32_t seed, float x_m) {
  float u, hump;
  while (x_m >= s->start_m + s->spacing_m) {
    s->start_m += s->spacing_m;
    s->index++;
    asperity(s, seed);
  }
  u = (x_m - s->start_m) / s->spacing_m;
  if (u < 0.0f) u = 0.0f;
  hump = 4.0f * u * (1.0f - u);
  return s->height_m * hump * hump; /* slope 0 in the valleys */
}

void stylus_step(stylus *s, float level_m, float dt_s) {
  float pull = OMEGA_PER_S * OMEGA_PER_S * (level_m - s->tip_m) - 2.0f * DAMPING_RATIO * OMEGA_PER_S * s->speed_m_s;
  s->speed_m_s += pull * dt_s;
  s->tip_m += s->speed_m_s * dt_s;
}

float noise(uint32_t *state, float sigma) {
  float sum = -2.0f;
  for (int i = 0; i < 4; i++) sum += unit(mix(*state += 0x9E3779B9u));
  return sum * sigma * 1.7320508f; /* the variance of a uniform number is 1/12 */
}
