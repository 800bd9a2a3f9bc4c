/* An ATmega2560 at 16 MHz in simavr: an ELF file in; its USART0 on standard input and output, a triangle of 100 Hz on ADC0, an HX711 on pins
 * 2 (clock) and 3 (data) with the reading 100,000 eighty times a second.
 *
 *   board FIRMWARE.elf SECONDS CLOCK
 *
 * CLOCK is a file that gets the emulated time in us, 8 bytes little-endian: the host at the other end lives by it. */
#include <fcntl.h>
#include <math.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static avr_t *avr;
static int ready = 1;

static void sent(struct avr_irq_t *irq, uint32_t value, void *param) {
  const unsigned char byte = (unsigned char)value;
  (void)irq, (void)param;
  if (write(STDOUT_FILENO, &byte, 1) != 1) exit(0);
}

static void may_send(struct avr_irq_t *irq, uint32_t value, void *param) { (void)irq, (void)value, (void)param, ready = 1; }
static void must_wait(struct avr_irq_t *irq, uint32_t value, void *param) { (void)irq, (void)value, (void)param, ready = 0; }

/* The HX711: data is low while a reading is there; each rising edge of the clock brings a bit, the 25th ends it. */
static const uint32_t READING = 100000;
static avr_irq_t *data;
static int edges;

static void clocked(struct avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)param;
  if (value == 0 || edges >= 25) return;
  edges++;
  avr_raise_irq(data, edges < 25 ? READING >> (24 - edges) & 1 : 1);
}

int main(int argc, char **argv) {
  elf_firmware_t firmware = {{0}};
  uint32_t flags = 0;
  int clock_file;
  if (argc != 4 || (clock_file = open(argv[3], O_WRONLY | O_CREAT, 0644)) < 0 || elf_read_firmware(argv[1], &firmware) != 0 || !(avr = avr_make_mcu_by_name("atmega2560"))) {
    fprintf(stderr, "board FIRMWARE.elf SECONDS CLOCK\n");
    return 2;
  }
  avr_init(avr);
  avr->frequency = 16000000;
  avr->vcc = avr->avcc = avr->aref = 5000;
  avr_load_firmware(avr, &firmware);
  avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
  flags &= (uint32_t)~(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), sent, NULL);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), may_send, NULL);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), must_wait, NULL);
  avr_irq_t *receive = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_t *volts = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0);
  data = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('E'), 5);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('E'), 4), clocked, NULL);
  avr_raise_irq(data, 1);
  edges = 25;
  fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);

  const avr_cycle_count_t end = (avr_cycle_count_t)(atof(argv[2]) * 16e6);
  avr_cycle_count_t next = 0, reading = 0;
  while (avr->cycle < end) {
    const int state = avr_run(avr);
    if (state == cpu_Done || state == cpu_Crashed) return 1;
    if (avr->cycle < next) continue;
    next = avr->cycle + 160; /* a byte of 1 Mbaud takes 160 cycles */
    const double phase = fmod((double)avr->cycle / 16e6 * 100, 1);
    avr_raise_irq(volts, (uint32_t)(1500 + 2000 * fabs(2 * phase - 1)));
    const uint64_t now_us = avr->cycle / 16;
    if (now_us % 100 < 10 && pwrite(clock_file, &now_us, sizeof now_us, 0) != sizeof now_us) return 1;
    if (avr->cycle >= reading) {
      reading += 200000;
      edges = 0;
      avr_raise_irq(data, 0);
    }
    unsigned char byte;
    if (ready && read(STDIN_FILENO, &byte, 1) == 1) avr_raise_irq(receive, byte);
  }
  return 0;
}
