/* Vectors, and the way from reset to main: FPU on, .data copied, .bss zeroed. */
#include "board.h"

extern uint32_t data_start, data_end, bss_start, bss_end;
extern const uint32_t data_load;
extern uint32_t stack_top;

int main(void);
void reset_handler(void);
void nmi_handler(void);
void systick_handler(void);
void uart0_handler(void);
void uart1_handler(void);
static void unexpected(void);

typedef void (*vector)(void);

__attribute__((section(".vectors"), used)) static const struct {
  const uint32_t *stack;
  vector system[15];
  vector board[4];
} VECTORS = {
    &stack_top,
    {reset_handler, nmi_handler, unexpected, unexpected, unexpected, unexpected, 0, 0, 0, 0, unexpected, unexpected, 0,
     unexpected, systick_handler},
    {uart0_handler, uart0_handler, uart1_handler, uart1_handler}, /* UART0 rx, tx, UART1 rx, tx */
};

void reset_handler(void) {
  const uint32_t *from = &data_load;
  for (uint32_t *to = &data_start; to < &data_end;) *to++ = *from++;
  for (uint32_t *to = &bss_start; to < &bss_end;) *to++ = 0;
  CPACR |= CPACR_FPU;
  barrier();
  (void)main();
  unexpected();
}

/* A fault of the processor: stand still, the watchdog resets. */
static void unexpected(void) {
  for (;;) {
  }
}
