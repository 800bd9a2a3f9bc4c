/* Microseconds since the start, from SysTick. */
#ifndef TIME_H
#define TIME_H

#include <stdint.h>

#define TICK_HZ 1000000u

void time_start(void);
/* Never goes back. Main loop only. */
uint64_t time_us(void);

#endif
