/* A Cortex-M of QEMU (mps2-an385, -an386, -an505) around detector.c: vectors, FPU, and on stderr the instructions that each reading took. Files and
 * arguments come by semihosting. Linked with --wrap=sd_step; -icount shift=0 makes an instruction a nanosecond; INSTRUCTIONS are in a tick of SysTick. STACK is the end of the RAM. */
#include <stdint.h>
#include <stdio.h>

#include "slip_detector.h"

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define SYST_CTRL (*(volatile uint32_t *)0xE000E010u)
#define SYST_LOAD (*(volatile uint32_t *)0xE000E014u)
#define SYST_VALUE (*(volatile uint32_t *)0xE000E018u)
#define SYST_MASK 0xFFFFFFu

extern void _start(void);
static void reset(void);
sd_state __real_sd_step(sd_detector *d, float reading);
sd_state __wrap_sd_step(sd_detector *d, float reading);

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t stack;
    void (*reset)(void);
} VECTORS = {STACK, reset};

static uint64_t ticks;
static uint32_t most, readings;

static void reset(void) {
#ifdef __ARM_FP
    CPACR |= 0xFu << 20;
    __asm__ volatile("dsb\nisb");
#endif
    SYST_LOAD = SYST_MASK;
    SYST_VALUE = 0;
    SYST_CTRL = 5;
    _start();
}

sd_state __wrap_sd_step(sd_detector *d, float reading) {
    const uint32_t begin = SYST_VALUE;
    const sd_state state = __real_sd_step(d, reading);
    const uint32_t passed = (begin - SYST_VALUE) & SYST_MASK;
    ticks += passed;
    if (passed > most) most = passed;
    readings++;
    return state;
}

__attribute__((destructor)) static void report(void) {
    if (readings > 0)
        fprintf(stderr, "%lu instructions a reading, %lu at most, %lu bytes of RAM\n", (unsigned long)(ticks * INSTRUCTIONS / readings),
                (unsigned long)(most * INSTRUCTIONS), (unsigned long)sizeof(sd_detector));
}
