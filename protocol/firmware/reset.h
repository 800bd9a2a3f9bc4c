/* Why the firmware started, how often it has, and the watchdog. */
#ifndef RESET_H
#define RESET_H

#include <stdint.h>

/* Reads and renews the record that survives a reset. Call it first. */
void reset_init(void);
/* enum gl_reset */
uint8_t reset_reason(void);
/* Another at every start since power-on. A product keeps it in flash, so that it differs across power cycles too. */
uint32_t reset_boot_id(void);
/* Restarts now, on purpose. */
void reset_now(void);

/* From now on a pause of WATCHDOG_MS between two feedings raises the NMI, twice that resets. */
#define WATCHDOG_MS 150u
void watchdog_start(void);
void watchdog_feed(void);

#endif
