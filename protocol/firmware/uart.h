/* Interrupt-driven UART: bytes received wait in a ring, frames to send go out of another, both bounded. */
#ifndef UART_H
#define UART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define UART_RX_ROOM 1024u /* powers of two */
#define UART_TX_ROOM 1024u

typedef struct {
  uint32_t base;
  volatile uint32_t rx_in, rx_out, tx_in, tx_out, rx_lost;
  uint8_t rx[UART_RX_ROOM], tx[UART_TX_ROOM];
} uart;

/* Interrupts are shared with the handlers in uart.c. */
extern uart LINK_PORT;  /* UART0: the host */
extern uart BENCH_PORT; /* UART1: the test bench */

/* `base`: UART0_BASE or UART1_BASE. */
void uart_start(uart *u, uint32_t base);
/* Takes at most `room` received bytes; how many. */
size_t uart_read(uart *u, uint8_t *out, size_t room);
/* Bytes that can be sent without waiting. */
size_t uart_room(const uart *u);
/* Queues all bytes, or none where they do not fit. */
bool uart_send(uart *u, const uint8_t *bytes, size_t len);

#endif
