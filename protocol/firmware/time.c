#include "time.h"

#include "board.h"

#define TICKS_A_MS (CPU_HZ / 1000u)
#define TICKS_A_US (CPU_HZ / TICK_HZ)

static volatile uint64_t milliseconds;

void systick_handler(void);

void systick_handler(void) { milliseconds++; }

void time_start(void) {
  SYSTICK_RELOAD = TICKS_A_MS - 1u;
  SYSTICK_NOW = 0;
  SYSTICK_CTRL = 7; /* processor clock, interrupt, on */
}

uint64_t time_us(void) {
  static uint64_t latest;
  uint64_t ms, now;
  uint32_t left;
  interrupts_off();
  left = SYSTICK_NOW;
  ms = milliseconds;
  if ((ICSR & ICSR_SYSTICK_PENDING) != 0) {
    /* The counter started again and the interrupt still waits. */
    left = SYSTICK_NOW;
    ms++;
  }
  interrupts_on();
  now = ms * 1000u + (TICKS_A_MS - 1u - left) / TICKS_A_US;
  if (now > latest) latest = now;
  return latest;
}
