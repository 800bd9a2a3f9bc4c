#include "uart.h"

#include "board.h"

uart LINK_PORT, BENCH_PORT;

void uart0_handler(void);
void uart1_handler(void);

/* Interrupt context: everything that has come. A byte without room is lost and counted; its frame fails the CRC. */
static void receive(uart *u) {
  while ((REG(u->base + UART_STATE) & UART_RX_FULL) != 0) {
    uint8_t byte = (uint8_t)REG(u->base + UART_DATA);
    if (u->rx_in - u->rx_out < UART_RX_ROOM) {
      u->rx[u->rx_in % UART_RX_ROOM] = byte;
      u->rx_in++;
    } else {
      u->rx_lost++;
    }
  }
}

/* Interrupt context, or interrupts off: as much as the port takes. */
static void transmit(uart *u) {
  while (u->tx_out != u->tx_in && (REG(u->base + UART_STATE) & UART_TX_FULL) == 0) {
    REG(u->base + UART_DATA) = u->tx[u->tx_out % UART_TX_ROOM];
    u->tx_out++;
  }
}

static void serve(uart *u) {
  REG(u->base + UART_INT_CLEAR) = UART_RX_BIT | UART_TX_BIT;
  receive(u);
  transmit(u);
}

void uart0_handler(void) { serve(&LINK_PORT); }

void uart1_handler(void) { serve(&BENCH_PORT); }

void uart_start(uart *u, uint32_t base) {
  u->base = base;
  REG(u->base + UART_BAUD_DIV) = 16; /* 1.5625 Mbit/s, the fastest */
  REG(u->base + UART_CTRL) = UART_ENABLE_ALL;
  NVIC_ENABLE = base == UART0_BASE ? 0x3u : 0xCu;
}

size_t uart_read(uart *u, uint8_t *out, size_t room) {
  size_t len = 0;
  while (len < room && u->rx_out != u->rx_in) {
    out[len++] = u->rx[u->rx_out % UART_RX_ROOM];
    u->rx_out++;
  }
  return len;
}

size_t uart_room(const uart *u) { return UART_TX_ROOM - (u->tx_in - u->tx_out); }

bool uart_send(uart *u, const uint8_t *bytes, size_t len) {
  if (uart_room(u) < len) return false;
  for (size_t i = 0; i < len; i++) u->tx[(u->tx_in + i) % UART_TX_ROOM] = bytes[i];
  interrupts_off();
  u->tx_in += (uint32_t)len;
  transmit(u);
  interrupts_on();
  return true;
}
