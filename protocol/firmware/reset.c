#include "reset.h"

#include "board.h"
#include "grip_link.h"

#define MAGIC 0x67726970u

/* The board has no register that tells the reason of a reset, so the way out leaves a note. */
static struct {
  uint32_t magic, boots, note;
} record __attribute__((section(".noinit")));

static uint8_t reason;

void nmi_handler(void);

void reset_init(void) {
  if (record.magic != MAGIC) {
    reason = GL_POWER_ON;
    record.magic = MAGIC;
    record.boots = 0;
  } else {
    reason = record.note == 0 ? (uint8_t)GL_RESET_PIN : (uint8_t)record.note;
  }
  record.boots++;
  record.note = 0;
}

uint8_t reset_reason(void) { return reason; }

uint32_t reset_boot_id(void) { return record.boots; }

void reset_now(void) {
  record.note = GL_SOFTWARE;
  barrier();
  AIRCR = AIRCR_RESET;
  for (;;) {
  }
}

void watchdog_start(void) {
  WATCHDOG_LOCK = WATCHDOG_KEY;
  WATCHDOG_LOAD = CPU_HZ / 1000u * WATCHDOG_MS;
  WATCHDOG_CTRL = 3; /* interrupt, reset */
}

void watchdog_feed(void) {
  record.note = 0;
  WATCHDOG_INT_CLEAR = 1;
}

/* The first expiry. Only a note: whether there is a second is up to the tasks. */
void nmi_handler(void) { record.note = GL_WATCHDOG; }
