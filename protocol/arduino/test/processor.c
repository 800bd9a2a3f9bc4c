/* A processor of QEMU around detector.c, and on stderr the instructions that each reading took; linked with --wrap=sd_step, run with -icount
 * shift=0. A Cortex-M (mps2-an385, -an386, -an505): vectors, FPU; an instruction is a nanosecond, INSTRUCTIONS are in a tick of SysTick, STACK is the
 * end of the RAM. A RISC-V (virt): files named readings and got in place of the streams, which picolibc cannot end. */
#include <stdint.h>
#include <stdio.h>

#include "slip_detector.h"

sd_state __real_sd_step(sd_detector *d, float reading);
sd_state __wrap_sd_step(sd_detector *d, float reading);

#ifdef __riscv
#define INSTRUCTIONS 1u
#define MASK UINT32_MAX
static FILE *in, *out;
#define stdin in
#define stdout out
#define main detector_main
#include "detector.c"
#undef main

static uint32_t now(void) {
    uint32_t retired;
    __asm__ volatile(".option push\n.option arch, +zicsr\ncsrr %0, minstret\n.option pop" : "=r"(retired));
    return retired;
}

int main(void) {
    char *arguments[] = {"detector", "1600", "0", NULL};
    in = fopen("readings", "rb"), out = fopen("got", "wb");
    return !in || !out || detector_main(3, arguments) || fclose(out);
}
#else
#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define SYST_CTRL (*(volatile uint32_t *)0xE000E010u)
#define SYST_LOAD (*(volatile uint32_t *)0xE000E014u)
#define SYST_VALUE (*(volatile uint32_t *)0xE000E018u)
#define MASK 0xFFFFFFu

extern void _start(void);
static void reset(void);

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t stack;
    void (*reset)(void);
} VECTORS = {STACK, reset};

static void reset(void) {
#ifdef __ARM_FP
    CPACR |= 0xFu << 20;
    __asm__ volatile("dsb\nisb");
#endif
    SYST_LOAD = MASK;
    SYST_VALUE = 0;
    SYST_CTRL = 5;
    _start();
}

static uint32_t now(void) { return ~SYST_VALUE; }
#endif

static uint64_t ticks;
static uint32_t most, readings;

sd_state __wrap_sd_step(sd_detector *d, float reading) {
    const uint32_t begin = now();
    const sd_state state = __real_sd_step(d, reading);
    const uint32_t passed = (now() - begin) & MASK;
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
