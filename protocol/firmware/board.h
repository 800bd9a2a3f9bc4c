/* Registers of the MPS2 board with the AN386 image (Cortex-M4): Arm DAI 0386; CMSDK blocks: Arm DDI 0479. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#define CPU_HZ 25000000u

#define REG(address) (*(volatile uint32_t *)(uintptr_t)(address))

/* CMSDK APB UART */
#define UART0_BASE 0x40004000u
#define UART1_BASE 0x40005000u
#define UART_DATA 0x00u
#define UART_STATE 0x04u
#define UART_CTRL 0x08u
#define UART_INT_CLEAR 0x0Cu
#define UART_BAUD_DIV 0x10u
#define UART_TX_FULL 1u
#define UART_RX_FULL 2u
#define UART_TX_BIT 1u
#define UART_RX_BIT 2u
#define UART_ENABLE_ALL 0xFu /* both directions, both interrupts */

/* CMSDK APB watchdog: the first expiry raises the NMI, the second resets. */
#define WATCHDOG_LOAD REG(0x40008000u)
#define WATCHDOG_CTRL REG(0x40008008u)
#define WATCHDOG_INT_CLEAR REG(0x4000800Cu)
#define WATCHDOG_LOCK REG(0x40008C00u)
#define WATCHDOG_KEY 0x1ACCE551u

/* Armv7-M system control */
#define SYSTICK_CTRL REG(0xE000E010u)
#define SYSTICK_RELOAD REG(0xE000E014u)
#define SYSTICK_NOW REG(0xE000E018u)
#define NVIC_ENABLE REG(0xE000E100u)
#define ICSR REG(0xE000ED04u)
#define ICSR_SYSTICK_PENDING (1u << 26)
#define AIRCR REG(0xE000ED0Cu)
#define AIRCR_RESET 0x05FA0004u
#define CPACR REG(0xE000ED88u)
#define CPACR_FPU (0xFu << 20)

static inline void interrupts_off(void) { __asm volatile("cpsid i" ::: "memory"); }
static inline void interrupts_on(void) { __asm volatile("cpsie i" ::: "memory"); }
static inline void barrier(void) { __asm volatile("dsb\n\tisb" ::: "memory"); }

#endif
