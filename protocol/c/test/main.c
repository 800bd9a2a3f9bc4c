/* Tests of the C device side: vectors, and two modes that print what it does, to be compared with the other peers. */
#include "peer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void peer_fail(const char *what, const char *where) {
  fprintf(stderr, "%s: %s\n", where, what);
  exit(1);
}

static int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

size_t peer_unhex(const char *text, uint8_t *out, size_t room) {
  size_t n = 0;
  for (; text[0] != 0; text += 2) {
    int high = digit(text[0]), low = high < 0 ? -1 : digit(text[1]);
    if (low < 0 || n >= room) peer_fail("not hex, or too long", text);
    out[n++] = (uint8_t)(high << 4 | low);
  }
  return n;
}

void peer_print_hex(const uint8_t *bytes, size_t len) {
  for (size_t i = 0; i < len; i++) printf("%02x", bytes[i]);
}

size_t peer_split(char *line, char separator, char **parts, size_t most) {
  size_t n = 0;
  line[strcspn(line, "\r\n")] = 0;
  while (line != NULL && n < most) {
    char *end = strchr(line, separator);
    parts[n++] = line;
    if (end != NULL) *end++ = 0;
    line = end;
  }
  return n;
}

const char *peer_word(gl_verdict verdict) {
  static const char *const words[] = {"pending", "ok",      "too_long", "cobs",      "length", "crc",
                                      "echo",    "version", "stale",    "duplicate", "unknown"};
  return words[verdict];
}

gl_ident peer_gripper(void) {
  static const gl_ident gripper = {
      "grip-link-test-", 0xB007, 1000000, 20000, 20000, 400000, 15000, 0, 50000, 1, 2, 3, GL_POWER_ON, false, 3,
      {{GL_STYLUS, GL_METRE, 3, 1, 1e-8f}, {GL_NORMAL_FORCE, GL_NEWTON, 3, 1, 1e-3f}, {GL_PRESSURE_ARRAY, GL_PASCAL, 3, 4, 10.0f}}};
  gl_ident ident = gripper;
  ident.uid[15] = '1';
  return ident;
}

int main(int argc, char **argv) {
  if (argc == 3 && strcmp(argv[1], "vectors") == 0) return peer_vectors(argv[2]);
  if (argc == 2 && strcmp(argv[1], "init") == 0) return peer_init();
  if (argc == 2 && strcmp(argv[1], "decode") == 0) return peer_decode();
  if (argc == 2 && strcmp(argv[1], "device") == 0) return peer_device();
  if (argc == 2 && strcmp(argv[1], "sizes") == 0) {
    printf("gl_link %zu bytes, of these decoder %zu, batches %zu, identity %zu\n", sizeof(gl_link), sizeof(gl_decoder),
           sizeof(gl_batches), sizeof(gl_ident));
    return 0;
  }
  fprintf(stderr,
          "usage: %s vectors FOLDER   check valid.tsv and invalid.tsv\n"
          "       %s init             what gl_init takes and refuses\n"
          "       %s decode           lines 'device|host SESSION[:SEQ]|- HEX' in, verdicts out\n"
          "       %s device           a script of ticks and bytes in, all that the device does out\n"
          "       %s sizes            memory of the link on this machine\n",
          argv[0], argv[0], argv[0], argv[0], argv[0]);
  return 2;
}
