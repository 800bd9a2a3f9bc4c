#include "gripper.h"

#include <string.h>

#define MAGIC 0x6F626A65u
#define STEP_US 25u
#define APPROACH_M 2.0e-3f
#define APPROACH_S 0.1f
#define LAG_S 5.0e-3f
#define LIFT_AFTER_S 0.3f
#define LIFT_RAMP_S 0.05f
#define FINGER_M 0.04f
#define STATIC_RATIO 1.1f
#define STYLUS_PRELOAD_M 2.0e-4f
#define NO_READING __builtin_nanf("")

void gripper_init(gripper *g, uint32_t seed) {
  memset(g, 0, sizeof *g);
  g->magic = MAGIC;
  g->seed = seed;
  g->random = seed;
  g->gap_m = APPROACH_M;
  surface_init(&g->profile, seed);
}

bool gripper_exists(const gripper *g) { return g->magic == MAGIC; }

static void enter(gripper *g, object_state state) {
  g->object = state;
  g->since_s = 0.0f;
}

static void drive(gripper *g, float dt) {
  if (g->gap_m > 0.0f) {
    if (g->target_n > 0.0f) g->gap_m -= APPROACH_M * dt / APPROACH_S;
    return;
  }
  g->applied_n += (g->target_n - g->applied_n) * dt / (LAG_S + dt);
  if (g->applied_n > g->peak_n) g->peak_n = g->applied_n;
}

static void move(gripper *g, float dt) {
  float share = g->since_s < LIFT_RAMP_S ? g->since_s / LIFT_RAMP_S : 1.0f;
  float load_n = OBJECT_MASS_KG * GRAVITY_M_S2 * share;
  float friction_n = 2.0f * OBJECT_FRICTION * g->applied_n;
  if (g->speed_m_s <= 0.0f && load_n <= STATIC_RATIO * friction_n) return;
  g->speed_m_s += (load_n - friction_n) / OBJECT_MASS_KG * dt;
  if (g->speed_m_s < 0.0f) g->speed_m_s = 0.0f;
  g->travel_m += g->speed_m_s * dt;
}

static void drop(gripper *g) {
  enter(g, OBJECT_DROPPED);
  g->applied_n = 0.0f;
  g->speed_m_s = 0.0f;
}

static void step(gripper *g, float dt) {
  float level_m = 0.0f;
  g->since_s += dt;
  if (g->object != OBJECT_DROPPED) drive(g, dt);
  if (g->object == OBJECT_OPEN && g->gap_m <= 0.0f) enter(g, OBJECT_SUPPORTED);
  if (g->object == OBJECT_SUPPORTED && g->since_s >= LIFT_AFTER_S) enter(g, OBJECT_LIFTED);
  if (g->object == OBJECT_LIFTED) move(g, dt);
  if (g->travel_m > FINGER_M && g->object == OBJECT_LIFTED) drop(g);
  if (g->object != OBJECT_DROPPED) {
    float gap_m = g->gap_m > 0.0f ? g->gap_m : 0.0f;
    level_m = STYLUS_PRELOAD_M + surface_height(&g->profile, g->seed, g->travel_m) - gap_m;
  }
  stylus_step(&g->tip, level_m > 0.0f ? level_m : 0.0f, dt);
}

void gripper_advance(gripper *g, uint32_t us) {
  for (; us >= STEP_US; us -= STEP_US) step(g, 1.0e-6f * STEP_US);
  if (us > 0) step(g, 1.0e-6f * (float)us);
}

void gripper_read(gripper *g, readings *out) {
  float stylus_m = g->tip.tip_m + noise(&g->random, 1.0e-7f);
  float travel_um = 1.0e6f * g->travel_m + noise(&g->random, 0.3f);
  if (!g->stylus_frozen) out->stylus_m = stylus_m;
  out->force_n = g->applied_n + noise(&g->random, 5.0e-3f);
  out->travel_m = 1.0e-6f * (float)(int32_t)(travel_um + (travel_um < 0.0f ? -0.5f : 0.5f)); /* a 1 um encoder */
  if (g->travel_lost) out->travel_m = NO_READING;
}
