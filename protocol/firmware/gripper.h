/* The world outside the microcontroller: two fingers with a drive, and the object between them.
 *
 * Fingers approach, touch and press; the drive follows its target with a lag. Some time after the touch the support
 * sinks and gravity pulls the object through the fingers. Coulomb friction at both fingers holds or brakes it;
 * where it has moved by more than the length of a finger it is dropped. */
#ifndef GRIPPER_H
#define GRIPPER_H

#include <stdbool.h>
#include <stdint.h>

#include "stylus.h"

#ifndef OBJECT_MASS_KG
#define OBJECT_MASS_KG 0.4f
#endif
#ifndef OBJECT_FRICTION
#define OBJECT_FRICTION 0.4f /* kinetic; static is 1.1 times as much */
#endif
#define GRAVITY_M_S2 9.80665f
/* What each finger needs to hold the object while it slides (mN). */
#define FORCE_NEEDED_MN ((int32_t)(1000.0f * OBJECT_MASS_KG * GRAVITY_M_S2 / (2.0f * OBJECT_FRICTION)))

typedef enum { OBJECT_OPEN = 0, OBJECT_SUPPORTED, OBJECT_LIFTED, OBJECT_DROPPED } object_state;

typedef struct {
  uint32_t magic, seed, random;
  object_state object;
  float since_s; /* in this state */
  float gap_m, target_n, applied_n, peak_n;
  float speed_m_s, travel_m;
  surface profile;
  stylus tip;
  bool stylus_frozen, travel_lost;
} gripper;

/* What the sensors show: SI units. */
typedef struct {
  float stylus_m, force_n, travel_m;
} readings;

/* Open fingers over a new object. */
void gripper_init(gripper *g, uint32_t seed);
/* Whether the world has been there before this start of the microcontroller. */
bool gripper_exists(const gripper *g);
/* Advances by `us` microseconds. */
void gripper_advance(gripper *g, uint32_t us);
void gripper_read(gripper *g, readings *out);

#endif
