/* Synthetic stylus: a rough surface, and a tip on a spring and damper that rides over it. */
#ifndef STYLUS_H
#define STYLUS_H

#include <stdint.h>

/* A place on the profile: asperities of random height and spacing, each a smooth hump. */
typedef struct {
  uint32_t index;
  float start_m, spacing_m, height_m;
} surface;

typedef struct {
  float tip_m, speed_m_s;
} stylus;

/* The profile of `seed` from x = 0. */
void surface_init(surface *s, uint32_t seed);
/* Height (m) at `x_m`, which never falls from call to call. */
float surface_height(surface *s, uint32_t seed, float x_m);
/* Advances the tip by `dt_s`; the surface stands at `level_m` above its free position (0: no surface). */
void stylus_step(stylus *s, float level_m, float dt_s);
/* Noise with mean 0 and the given standard deviation: the sum of four uniform numbers. */
float noise(uint32_t *state, float sigma);

#endif
