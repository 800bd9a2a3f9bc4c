/* ../../vectors/valid.tsv and invalid.tsv: wire -> header and payload -> wire, and every bad input gets its verdict and its NACK. */
#include "peer.h"

#include <stdio.h>
#include <string.h>

static char line[PEER_LINE];
static const char *current;
static unsigned failures;

static void wrong(const char *what) {
  fprintf(stderr, "%s: %s\n", current, what);
  failures++;
}

/* The wire bytes of what was decoded, and nothing where there is too little room. */
static void check_encoding(const gl_decoder *d, const uint8_t *wire, size_t wire_len) {
  uint8_t out[GL_MAX_WIRE];
  for (size_t room = 0; room <= wire_len; room++) {
    gl_encoder e;
    size_t len;
    gl_begin(&e, &d->header, (uint16_t)d->payload_len, out, room);
    gl_put(&e, gl_decoder_payload(d), d->payload_len);
    len = gl_end(&e);
    if (len != (room == wire_len ? wire_len : 0) || memcmp(out, wire, len) != 0) wrong("encodes to other bytes, or fits where it cannot");
  }
}

static void check_cobs(bool both, const char *data_hex, const uint8_t *block, size_t len) {
  uint8_t data[600], out[600];
  size_t n = peer_unhex(data_hex, data, sizeof data);
  gl_decoder d;
  if (both && (gl_cobs_encode(data, n, out, sizeof out) != len || memcmp(out, block, len) != 0)) wrong("COBS encodes otherwise");
  if (both && len > 1 && gl_cobs_encode(data, n, out, len - 1) != 0) wrong("COBS fits where it cannot");
  gl_decoder_init(&d, GL_ROLE_DEVICE);
  for (size_t i = 0; i < len; i++) gl_decoder_push(&d, block[i]);
  if (d.left != 0 || d.filled != n || memcmp(d.body, data, n) != 0) wrong("COBS decodes otherwise");
}

/* Every message is taken; the payloads of those that a device reads or writes are compared with Rust in grip-link's tests/peers. */
static void check_valid(char **c) {
  uint8_t wire[600];
  size_t len = peer_unhex(c[6], wire, sizeof wire);
  bool both = strcmp(c[1], "both") == 0, to_host = strcmp(c[2], "to_host") == 0;
  unsigned version, ack_req, seq, session;
  gl_decoder d;
  gl_verdict verdict = GL_PENDING;
  if (strcmp(c[2], "cobs") == 0) {
    check_cobs(both, c[5] + strlen("data="), wire, len);
    return;
  }
  if (sscanf(c[4], "version=%u ack_req=%u seq=%u session=%u", &version, &ack_req, &seq, &session) != 4) peer_fail("header", c[4]);
  gl_decoder_init(&d, to_host ? GL_ROLE_HOST : GL_ROLE_DEVICE);
  gl_decoder_open(&d, (uint16_t)session, false, 0);
  for (size_t i = 0; i < len; i++) verdict = gl_decoder_push(&d, wire[i]);
  if (verdict != GL_OK || d.header.version != version || d.header.seq != seq || d.header.session != session ||
      d.header.ack_req != (ack_req == 1) || d.header.to_host != to_host) {
    wrong("not accepted, or with another header");
  } else if (both) check_encoding(&d, wire, len);
}

static void check_verdicts(char **c, const uint8_t *wire, size_t len) {
  char words[256] = "";
  gl_decoder d;
  gl_decoder_init(&d, strcmp(c[1], "device") == 0 ? GL_ROLE_DEVICE : GL_ROLE_HOST);
  if (strcmp(c[2], "beef") == 0) gl_decoder_open(&d, 0xBEEF, true, 0);
  for (size_t i = 0; i < len; i++) {
    gl_verdict verdict = gl_decoder_push(&d, wire[i]);
    if (verdict == GL_PENDING) continue;
    if (words[0] != 0) strcat(words, ",");
    strcat(words, peer_word(verdict));
  }
  if (strcmp(words, c[4]) != 0) wrong(words);
}

/* Reasons of all NACKs the device sends, as the vectors name them. */
static void nacks(gl_link *link, char *reasons) {
  static const char *const names[] = {"", "unknown_type", "malformed", "wrong_state", "latched", "other_fault", "version"};
  uint8_t out[GL_MAX_WIRE];
  size_t len;
  reasons[0] = 0;
  while ((len = gl_poll_transmit(link, 2, out)) > 0) {
    gl_decoder d;
    gl_decoder_init(&d, GL_ROLE_HOST);
    gl_decoder_open(&d, link->session, false, 0);
    for (size_t i = 0; i < len; i++) gl_decoder_push(&d, out[i]);
    if (d.counters.ok != 1) wrong("the device sends what a host refuses");
    if (d.header.kind == GL_NACK) strcat(reasons, names[gl_decoder_payload(&d)[1]]);
  }
}

static void feed(gl_link *link, const uint8_t *bytes, size_t len) {
  gl_event event;
  while (gl_receive(link, 2, &bytes, &len, &event)) {
    if (event.type != GL_ON_LINKED) wrong("the device did something");
  }
}

static void check_device(char **c, const uint8_t *wire, size_t len) {
  static const uint8_t hello[16] = {1, 1, 0xE0, 1};
  const gl_header h = {1, GL_HELLO, false, true, 0, 0xBEEF};
  const gl_ident gripper = peer_gripper();
  static gl_link link;
  uint8_t out[GL_MAX_WIRE];
  char reasons[256];
  gl_encoder e;
  gl_state before;
  if (gl_init(&link, &gripper) != GL_INIT_OK) peer_fail("refused", "gripper");
  gl_ready(&link, 0);
  if (strcmp(c[2], "beef") == 0) {
    gl_begin(&e, &h, sizeof hello, out, sizeof out);
    gl_put(&e, hello, sizeof hello);
    feed(&link, out, gl_end(&e));
    nacks(&link, reasons);
  }
  before = link.state;
  feed(&link, wire, len);
  nacks(&link, reasons);
  if (strcmp(reasons[0] == 0 ? "-" : reasons, c[6]) != 0) wrong("other NACKs");
  if (link.state != before || gl_drive_at(&link, 3).kind != GL_DRIVE_PASSIVE) wrong("moved");
  if ((strcmp(c[5], "-") != 0) != (link.malformed == 1)) wrong("malformed is miscounted");
}

static void check_invalid(char **c) {
  uint8_t wire[2048];
  size_t len = peer_unhex(c[3], wire, sizeof wire);
  check_verdicts(c, wire, len);
  if (strcmp(c[1], "device") == 0) check_device(c, wire, len);
}

static unsigned run(const char *folder, const char *file, void (*check)(char **)) {
  char path[1024];
  unsigned rows = 0;
  FILE *in;
  if (snprintf(path, sizeof path, "%s/%s", folder, file) >= (int)sizeof path) peer_fail("path too long", folder);
  in = fopen(path, "r");
  if (in == NULL) peer_fail("cannot be read", path);
  while (fgets(line, sizeof line, in) != NULL) {
    char *column[8];
    if (line[0] == '#') continue;
    if (peer_split(line, '\t', column, 8) != 7) peer_fail("not seven columns", line);
    current = column[0];
    check(column);
    rows++;
  }
  fclose(in);
  return rows;
}

int peer_vectors(const char *folder) {
  unsigned valid = run(folder, "valid.tsv", check_valid), invalid = run(folder, "invalid.tsv", check_invalid);
  current = "crc32c";
  if (gl_crc32c((const uint8_t *)"123456789", 9) != UINT32_C(0xE3069283)) wrong("check value");
  if (valid < 20 || invalid < 20) wrong("vectors are missing");
  printf("%u valid and %u invalid vectors, %u failures\n", valid, invalid, failures);
  return failures == 0 ? 0 : 1;
}
