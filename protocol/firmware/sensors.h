/* Readings -> rows in the channels and format the host asked for, and a watch over the slip sensors (rule R7). */
#ifndef SENSORS_H
#define SENSORS_H

#include "grip_link.h"
#include "gripper.h"

#define SENSOR_COUNT 3u

typedef struct {
  uint32_t mask, period_us;
  uint8_t format;
  float last_m;
  uint32_t same_us;
} sensors;

/* The channels for IDENT; how many. */
uint8_t sensors_describe(gl_channel *channels);
void sensors_init(sensors *s);
/* What the host wants from now on. */
void sensors_configure(sensors *s, const gl_config *config);
void sensors_push(const sensors *s, gl_link *link, uint64_t tick, const readings *now);
/* The fault the stylus shows where no other slip sensor is left, or GL_FAULT_NONE. */
uint16_t sensors_judge(sensors *s, const readings *now);

#endif
