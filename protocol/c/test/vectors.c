/* ../../vectors/valid.tsv and invalid.tsv: fields -> wire -> fields, and every bad input gets its verdict. */
#include "peer.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char line[PEER_LINE];
static const char *current;
static unsigned failures;

static void wrong(const char *what) {
  fprintf(stderr, "%s: %s\n", current, what);
  failures++;
}

/* Fields of a payload in order: b u8, w u16, d u32, q u64, i i32, - a reserved byte, T16 bytes as hex. */
typedef struct {
  const char *name;
  uint8_t kind;
  const char *fields;
} message;

static const char CONFIG_FIELDS[] =
    "d sample_rate_hz,b batch,b format,w ttl_ms,d channel_mask,i force_max_mn,d slew_mn_s,i hold_cap_mn,w loss_after_ms,b loss_action,-";

static const message MESSAGES[] = {
    {"HELLO", GL_HELLO, "b min,b max,w max_rx,d caps,q time_us"},
    {"CONFIG", GL_CONFIG, CONFIG_FIELDS},
    {"START", GL_START, ""},
    {"STOP", GL_STOP, ""},
    {"PING", GL_PING, "q t1_us"},
    {"GRIP", GL_GRIP, "d cmd_id,b mode,b flags,w ttl_ms,i force_mn,d slew_mn_s,d cause_sample"},
    {"HEARTBEAT", GL_HEARTBEAT, "d turns,d longest_us,w late,w flags"},
    {"ESTOP", GL_ESTOP, ""},
    {"CLEAR_FAULT", GL_CLEAR_FAULT, "w fault"},
    {"IDENT", GL_IDENT,
     "b min,b max,w max_rx,d caps,T uid,d boot_id,d tick_hz,d rate_max_hz,i force_max_mn,d slew_max_mn_s,i hold_cap_mn,"
     "i travel_min_um,i travel_max_um,b fw_major,b fw_minor,w fw_patch,b reset,b state,w fault"},
    {"CONFIG_ACK", GL_CONFIG_ACK, "w config_seq,b clamped,-"},
    {"PONG", GL_PONG, "q t1_us,q rx_tick,q tx_tick"},
    {"ACK", GL_ACK, "b kind,-,w request_seq"},
    {"NACK", GL_NACK, "b kind,b reason,w request_seq"},
    {"SAMPLES", GL_SAMPLES, "d first_index,q t0_tick,w dt_ticks,b n,b format,d dropped_total"},
    {"STATUS", GL_STATUS,
     "d last_cmd_id,b state,b clamp,w fault,i applied_mn,i target_mn,d age_us,w flags,w rejected"},
    {"STATS", GL_STATS,
     "d ok,d too_long,d cobs,d length,d crc,d echo,d version,d stale,d duplicate,d unknown,d gap,d garbage_bytes,d sent,"
     "d dropped_batches,d dropped_rows,d malformed,d old,d refused,d unanswered"},
    {"EVENT", GL_EVENT, "q tick,b kind,b before,b after,-,w fault,w dropped,i value"},
    {"LOG", GL_LOG, "q tick,b level"},
};

/* The value of `name` in "name=value name=value ..."; copied, because lists are cut up. */
static const char *value_of(const char *list, const char *name, size_t name_len) {
  static char found[2048];
  for (const char *at = list; at != NULL; at = strchr(at, ' ')) {
    at += *at == ' ';
    if (strncmp(at, name, name_len) == 0 && at[name_len] == '=') {
      size_t len = strcspn(at + name_len + 1, " ");
      if (len >= sizeof found) peer_fail("value too long", name);
      memcpy(found, at + name_len + 1, len);
      found[len] = 0;
      return found;
    }
  }
  peer_fail("no such field", name);
  return NULL;
}

static const char *value(const char *list, const char *name) { return value_of(list, name, strlen(name)); }

static uint64_t number(const char *list, const char *name) { return strtoull(value(list, name), NULL, 10); }

/* Little-endian bytes of the fields, written without the library. */
static size_t pack(const char *table, const char *list, uint8_t *out) {
  size_t at = 0;
  while (*table != 0) {
    size_t len = strcspn(table, ",");
    if (table[0] == '-') out[at++] = 0;
    else if (table[0] == 'T') at += peer_unhex(value_of(list, table + 2, len - 2), out + at, 16);
    else {
      const char *text = value_of(list, table + 2, len - 2);
      uint64_t v = text[0] == '-' ? (uint64_t)strtoll(text, NULL, 10) : strtoull(text, NULL, 10);
      size_t size = table[0] == 'b' ? 1 : table[0] == 'w' ? 2 : table[0] == 'q' ? 8 : 4;
      for (size_t i = 0; i < size; i++) out[at++] = (uint8_t)(v >> 8 * i & 0xFF);
    }
    table += len + (table[len] == ',');
  }
  return at;
}

/* The same through the encoder of the library. */
static void put_fields(gl_encoder *e, const char *table, const char *list) {
  while (*table != 0) {
    size_t len = strcspn(table, ",");
    if (table[0] == '-') gl_put_u8(e, 0);
    else {
      const char *text = value_of(list, table + 2, len - 2);
      uint8_t raw[16];
      switch (table[0]) {
        case 'b': gl_put_u8(e, (uint8_t)strtoul(text, NULL, 10)); break;
        case 'w': gl_put_u16(e, (uint16_t)strtoul(text, NULL, 10)); break;
        case 'd': gl_put_u32(e, (uint32_t)strtoul(text, NULL, 10)); break;
        case 'q': gl_put_u64(e, strtoull(text, NULL, 10)); break;
        case 'i': gl_put_i32(e, (int32_t)strtol(text, NULL, 10)); break;
        default: gl_put(e, raw, peer_unhex(text, raw, sizeof raw));
      }
    }
    table += len + (table[len] == ',');
  }
}

static size_t channel_bytes(const char *list, uint8_t *out) {
  char text[2048], *entry[16];
  size_t n, at = 0;
  strcpy(text, value(list, "channels"));
  n = peer_split(text, ',', entry, 16);
  for (size_t i = 0; i < n; i++) {
    char *part[5];
    uint32_t bits;
    if (peer_split(entry[i], ':', part, 5) != 5) peer_fail("channel", entry[i]);
    for (size_t k = 0; k < 4; k++) out[at++] = (uint8_t)strtoul(part[k], NULL, 10);
    bits = (uint32_t)strtoul(part[4], NULL, 16);
    for (size_t k = 0; k < 4; k++) out[at++] = (uint8_t)(bits >> 8 * k & 0xFF);
  }
  return at;
}

static size_t sample_bytes(const char *list, uint8_t *out) {
  char text[2048];
  size_t at = 0;
  bool floats = number(list, "format") == GL_F32;
  strcpy(text, value(list, "rows"));
  for (char *word = strtok(text, ",;"); word != NULL; word = strtok(NULL, ",;")) {
    uint32_t bits = floats ? (uint32_t)strtoul(word, NULL, 16) : (uint32_t)strtol(word, NULL, 10);
    for (size_t k = 0; k < (floats ? 4u : 2u); k++) out[at++] = (uint8_t)(bits >> 8 * k & 0xFF);
  }
  return at;
}

/* What stands behind the fixed fields of a payload. */
static size_t variable_part(uint8_t kind, const char *list, uint8_t *out) {
  if (kind == GL_LOG) {
    size_t len = peer_unhex(value(list, "text"), out + 1, 255);
    out[0] = (uint8_t)len;
    return len + 1;
  }
  if (kind == GL_SAMPLES) return sample_bytes(list, out);
  if (kind == GL_CONFIG_ACK) return pack(CONFIG_FIELDS, list, out);
  if (kind == GL_IDENT) {
    size_t len = channel_bytes(list, out + 8);
    const uint8_t table[8] = {(uint8_t)(len / 8), 8, 72, 0, 0, 0, 0, 0};
    memcpy(out, table, sizeof table);
    return 8 + len;
  }
  return 0;
}

static void check_encoding(const message *m, const gl_header *h, const char *list, const uint8_t *wire, size_t wire_len) {
  uint8_t fixed[128], rest[512], out[GL_MAX_WIRE];
  size_t fixed_len = pack(m->fields, list, fixed), rest_len = variable_part(m->kind, list, rest);
  uint16_t extra = m->kind == GL_CONFIG_ACK ? 4 : 0;
  gl_encoder e;
  size_t len;
  gl_begin(&e, h, (uint16_t)(fixed_len + rest_len + extra), out, sizeof out);
  if (m->kind == GL_CONFIG_ACK) gl_put_u32(&e, gl_crc32c(rest, rest_len));
  put_fields(&e, m->fields, list);
  gl_put(&e, rest, rest_len);
  len = gl_end(&e);
  if (len != wire_len || memcmp(out, wire, len) != 0) wrong("encodes to other bytes");
  for (size_t room = 0; room < wire_len; room++) {
    gl_begin(&e, h, (uint16_t)(fixed_len + rest_len + extra), out, room);
    if (m->kind == GL_CONFIG_ACK) gl_put_u32(&e, gl_crc32c(rest, rest_len));
    put_fields(&e, m->fields, list);
    gl_put(&e, rest, rest_len);
    if (gl_end(&e) != 0) wrong("fits where it cannot");
  }
}

/* The decoded payload must begin with the bytes of the fields; a table of IDENT may stand further back. */
static void check_payload(const message *m, const char *list, const gl_decoder *d) {
  uint8_t expected[512];
  const uint8_t *p = gl_decoder_payload(d);
  size_t start = m->kind == GL_CONFIG_ACK ? 4 : 0;
  size_t len = pack(m->fields, list, expected);
  if (start + len > d->payload_len || memcmp(expected, p + start, len) != 0) wrong("decodes to other fields");
  start += len;
  len = variable_part(m->kind, list, expected);
  if (m->kind == GL_IDENT) {
    size_t at = p[66], stride = p[65];
    for (size_t i = 0; i < expected[0]; i++) {
      if (memcmp(expected + 8 + 8 * i, p + at + stride * i, 8) != 0) wrong("decodes to other channels");
    }
  } else if (start + len > d->payload_len || memcmp(expected, p + start, len) != 0) wrong("decodes to another list");
}

static const message *find(const char *name) {
  for (size_t i = 0; i < sizeof MESSAGES / sizeof *MESSAGES; i++) {
    if (strcmp(MESSAGES[i].name, name) == 0) return &MESSAGES[i];
  }
  peer_fail("no such message", name);
  return NULL;
}

static void check_cobs(bool both, const char *list, const uint8_t *block, size_t len) {
  uint8_t data[600], out[600];
  size_t n = peer_unhex(value(list, "data"), data, sizeof data);
  gl_decoder d;
  if (both && (gl_cobs_encode(data, n, out, sizeof out) != len || memcmp(out, block, len) != 0)) wrong("COBS encodes otherwise");
  if (both && len > 1 && gl_cobs_encode(data, n, out, len - 1) != 0) wrong("COBS fits where it cannot");
  gl_decoder_init(&d, GL_ROLE_DEVICE);
  for (size_t i = 0; i < len; i++) gl_decoder_push(&d, block[i]);
  if (d.left != 0 || d.filled != n || memcmp(d.body, data, n) != 0) wrong("COBS decodes otherwise");
}

static void check_valid(char **c) {
  uint8_t wire[600];
  size_t len = peer_unhex(c[6], wire, sizeof wire);
  bool both = strcmp(c[1], "both") == 0;
  const message *m;
  gl_header h;
  gl_decoder d;
  gl_verdict verdict = GL_PENDING;
  if (strcmp(c[2], "cobs") == 0) {
    check_cobs(both, c[5], wire, len);
    return;
  }
  m = find(c[3]);
  h.version = (uint8_t)number(c[4], "version");
  h.kind = m->kind;
  h.to_host = strcmp(c[2], "to_host") == 0;
  h.ack_req = number(c[4], "ack_req") == 1;
  h.seq = (uint16_t)number(c[4], "seq");
  h.session = (uint16_t)number(c[4], "session");
  gl_decoder_init(&d, h.to_host ? GL_ROLE_HOST : GL_ROLE_DEVICE);
  gl_decoder_open(&d, h.session, false, 0);
  for (size_t i = 0; i < len; i++) verdict = gl_decoder_push(&d, wire[i]);
  if (verdict != GL_OK || d.header.kind != h.kind || d.header.seq != h.seq || d.header.session != h.session ||
      d.header.ack_req != h.ack_req || d.header.to_host != h.to_host) {
    wrong("not accepted, or with another header");
    return;
  }
  check_payload(m, c[5], &d);
  if (both) check_encoding(m, &h, c[5], wire, len);
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
