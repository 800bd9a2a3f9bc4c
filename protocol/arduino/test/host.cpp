// A sketch with an accelerometer on this computer: serial port on standard input and output, a part on I2C that measures a triangle of 101 Hz
// and is without power for 20 ms at 1.5 s. Arguments as those of board.c, the first one unused: the time is that of the emulated clock.
#include <Wire.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static const uint8_t PART[4] = {PART_BYTES};  // address, register of the identity, identity, first register of x; bit 7: high byte first
static uint64_t now_us;
static uint8_t place, sent, addressed, input[4096];
static size_t taken, held;
static bool set_up, lost;
static uint8_t writes;

static bool there() { return addressed == PART[0] && !(now_us > 1500000 && now_us < 1520000); }

unsigned long micros() { return (unsigned long)(uint32_t)(now_us += 2); }
unsigned long millis() { return (unsigned long)(now_us / 1000); }
void digitalWrite(uint8_t, uint8_t) {}
void pinMode(uint8_t, uint8_t) {}

void TwoWire::begin() {}
void TwoWire::setClock(uint32_t) {}
void TwoWire::beginTransmission(uint8_t address) { addressed = address, sent = 0; }
size_t TwoWire::write(uint8_t value) {
  if (sent++ == 0) return place = value, 1;
  (void)value, writes += there();
  return 1;
}
uint8_t TwoWire::endTransmission(bool) {
  now_us += 25u * sent + 25;
  if (now_us > 1500000 && now_us < 1520000) set_up = false, lost = true, writes = 0;
  if (writes == 4) set_up = true;
  return there() ? 0 : 2;
}
uint8_t TwoWire::requestFrom(uint8_t, uint8_t count) { return now_us += 25u * count + 25, there() ? count : 0; }
int TwoWire::read() {
  if (place == PART[1]) return PART[2];
  const uint32_t phase = (uint32_t)(now_us % 9901);
  const int level = set_up ? (int)(phase < 4950 ? phase : 9901 - phase) * 410 / 4950 - 205 : 0;
  const bool high = (place == (PART[3] & 0x7F)) == ((PART[3] & 0x80) != 0);
  place++;
  return high ? level >> 8 & 0xFF : level & 0xFF;
}
TwoWire Wire;

int Stream::available() { return (int)(held - taken); }
int Stream::read() { return taken < held ? input[taken++] : -1; }
int Stream::availableForWrite() { return 64; }
size_t Stream::write(const uint8_t *bytes, size_t len) {
  if (::write(STDOUT_FILENO, bytes, len) != (ssize_t)len) exit(0);
  return len;
}
void Port::begin(unsigned long) {}
Port Serial;

int main(int argc, char **argv) {
  const int clock_file = argc == 4 ? open(argv[3], O_WRONLY | O_CREAT, 0644) : -1;
  if (clock_file < 0) return 2;
  fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  setup();
  const uint64_t end = (uint64_t)(atof(argv[2]) * 1e6);
  while (now_us < end) {
    if (taken == held) {
      const ssize_t got = ::read(STDIN_FILENO, input, sizeof input);
      taken = 0, held = got > 0 ? (size_t)got : 0;
    }
    loop();
    if (now_us % 100 < 10) (void)!pwrite(clock_file, &now_us, sizeof now_us, 0);
    // As slow as a board: the host lives by this clock.
    if (now_us % 1000 < 10) usleep(300);
  }
  return lost && !set_up;  // it must have been found again
}
