/* Test bench on UART1: what is true, fifty times a second, and faults on demand. Leave it out with BENCH=0.
 *
 * A line is key=value pairs; main.c and gripper.h name the numbers. One byte in is one order:
 *   n new object   f stylus freezes   C, L, S task hangs (control, link, sampling)   X the whole loop hangs
 *   R software reset   p forget the peak force */
#ifndef BENCH_H
#define BENCH_H

#include "grip_link.h"
#include "gripper.h"

enum task { TASK_CONTROL = 1, TASK_LINK = 2, TASK_SAMPLING = 4 };

#if BENCH
void bench_start(void);
/* Takes orders, and writes a line when one is due. */
void bench_run(gl_link *link, gripper *world, uint64_t now);
/* Whether a task has been told to hang. */
bool bench_hangs(enum task task);
#else
static inline void bench_start(void) {}
static inline void bench_run(gl_link *link, gripper *world, uint64_t now) { (void)link, (void)world, (void)now; }
static inline bool bench_hangs(enum task task) { return (void)task, false; }
#endif

#endif
