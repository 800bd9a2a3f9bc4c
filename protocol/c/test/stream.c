/* Lines in, what the decoder or the device does with them out: for comparing peers byte by byte. */
#include "peer.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char line[PEER_LINE];
static uint8_t bytes[PEER_LINE / 2];

/* Line: ROLE SESSION HEX. ROLE is device or host; SESSION is four hex digits, with :SEQ (decimal) for the newest sequence
 * number, or - for none. Out: the verdicts in order, good frames as ok:TYPE:CRC of the payload, then gap and garbage. */
int peer_decode(void) {
  while (fgets(line, sizeof line, stdin) != NULL) {
    char *part[3];
    gl_decoder d;
    size_t len;
    bool any = false;
    if (peer_split(line, ' ', part, 3) != 3) peer_fail("want ROLE SESSION HEX", line);
    gl_decoder_init(&d, strcmp(part[0], "device") == 0 ? GL_ROLE_DEVICE : GL_ROLE_HOST);
    if (part[1][0] != '-') {
      const char *seq = strchr(part[1], ':');
      gl_decoder_open(&d, (uint16_t)strtoul(part[1], NULL, 16), seq != NULL, seq ? (uint16_t)strtoul(seq + 1, NULL, 10) : 0);
    }
    len = peer_unhex(part[2], bytes, sizeof bytes);
    for (size_t i = 0; i < len; i++) {
      gl_verdict verdict = gl_decoder_push(&d, bytes[i]);
      if (verdict == GL_PENDING) continue;
      printf("%s%s", any ? "," : "", peer_word(verdict));
      any = true;
      if (verdict == GL_OK) {
        printf(":%02x:%08" PRIx32, d.header.kind, gl_crc32c(gl_decoder_payload(&d), d.payload_len));
      }
    }
    printf("%s gap=%" PRIu32 " garbage=%" PRIu32 "\n", any ? "" : "-", d.counters.gap, d.counters.garbage_bytes);
  }
  return 0;
}

static void print_event(const gl_event *e) {
  switch (e->type) {
    case GL_ON_LINKED: printf("linked %04x\n", e->is.session); break;
    case GL_ON_CONFIGURED:
      printf("configured %" PRIu32 " %u %u %u %" PRIu32 " %" PRId32 " %" PRIu32 " %" PRId32 " %u %u\n", e->is.config.sample_rate_hz,
             e->is.config.batch, e->is.config.format, e->is.config.ttl_ms, e->is.config.channel_mask, e->is.config.force_max_mn,
             e->is.config.slew_mn_s, e->is.config.hold_cap_mn, e->is.config.loss_after_ms, e->is.config.loss_action);
      break;
    case GL_ON_STARTED: printf("started\n"); break;
    case GL_ON_STOPPED: printf("stopped\n"); break;
    case GL_ON_COMMAND:
    case GL_ON_REJECTED:
      printf("%s %" PRIu32 " %u %u %u %" PRId32 " %" PRIu32 " %" PRIu32 "\n", e->type == GL_ON_COMMAND ? "command" : "rejected",
             e->is.grip.cmd_id, e->is.grip.mode, e->is.grip.flags, e->is.grip.ttl_ms, e->is.grip.force_mn, e->is.grip.slew_mn_s,
             e->is.grip.cause_sample);
      break;
    case GL_ON_HEARTBEAT:
      printf("heartbeat %" PRIu32 " %" PRIu32 " %u %u\n", e->is.heartbeat.turns, e->is.heartbeat.longest_us, e->is.heartbeat.late,
             e->is.heartbeat.flags);
      break;
    case GL_ON_ESTOP: printf("estop\n"); break;
    case GL_ON_CLEARED: printf("cleared %04x\n", e->is.fault); break;
  }
}

static void receive(gl_link *link, uint64_t tick, const char *hex) {
  const uint8_t *input = bytes;
  size_t len = peer_unhex(hex, bytes, sizeof bytes);
  gl_event event;
  while (gl_receive(link, tick, &input, &len, &event)) print_event(&event);
}

static void transmit(gl_link *link, uint64_t tick, unsigned long most) {
  uint8_t out[GL_MAX_WIRE];
  size_t len;
  while (most-- > 0 && (len = gl_poll_transmit(link, tick, out)) > 0) {
    printf("frame ");
    peer_print_hex(out, len);
    printf("\n");
  }
}

static void push_row(gl_link *link, uint64_t tick, bool floats, char **word, size_t n) {
  static const char *const results[] = {"taken", "not sampling", "format", "elements"};
  int16_t whole[64];
  float real[64];
  for (size_t i = 0; i < n; i++) {
    uint32_t bits = (uint32_t)strtoul(word[i], NULL, 16);
    whole[i] = (int16_t)strtol(word[i], NULL, 10);
    memcpy(&real[i], &bits, sizeof bits);
  }
  printf("row %s\n", results[floats ? gl_push_f32(link, tick, real, n) : gl_push_i16(link, tick, whole, n)]);
}

static void drive(gl_link *link, uint64_t tick) {
  static const char *const kinds[] = {"passive", "force", "open"};
  gl_drive d = gl_drive_at(link, tick);
  printf("drive %s %" PRId32 " state %d fault %04x\n", kinds[d.kind], d.force_mn, (int)link->state, gl_fault_now(link));
}

/* One command a line, the tick second: ready T | rx T HEX | tx T MOST | drive T | i16 T values | f32 T hex bits |
 * fault T HEX | estop T | travel T UM | force T MN | alive T | log T LEVEL HEX | new T [passive] (another gripper, whose
 * ESTOP takes the torque off). Out: all that comes of it. */
int peer_device(void) {
  static gl_link link;
  gl_ident gripper = peer_gripper();
  if (gl_init(&link, &gripper) != GL_INIT_OK) peer_fail("refused", "gripper");
  while (fgets(line, sizeof line, stdin) != NULL) {
    char *word[66];
    size_t n = peer_split(line, ' ', word, 66);
    uint64_t tick = n > 1 ? strtoull(word[1], NULL, 10) : 0;
    const char *first = n > 2 ? word[2] : "0";
    if (strcmp(word[0], "ready") == 0) gl_ready(&link, tick);
    else if (strcmp(word[0], "new") == 0) {
      gripper.estop_passive = strcmp(first, "passive") == 0;
      if (gl_init(&link, &gripper) != GL_INIT_OK) peer_fail("refused", "gripper");
    }
    else if (strcmp(word[0], "rx") == 0) receive(&link, tick, n > 2 ? word[2] : "");
    else if (strcmp(word[0], "tx") == 0) transmit(&link, tick, strtoul(first, NULL, 10));
    else if (strcmp(word[0], "drive") == 0) drive(&link, tick);
    else if (strcmp(word[0], "i16") == 0 || strcmp(word[0], "f32") == 0) push_row(&link, tick, word[0][0] == 'f', word + 2, n - 2);
    else if (strcmp(word[0], "fault") == 0) gl_raise_fault(&link, tick, (uint16_t)strtoul(first, NULL, 16));
    else if (strcmp(word[0], "estop") == 0) gl_latch_estop(&link, tick);
    else if (strcmp(word[0], "travel") == 0) gl_report_travel(&link, (int32_t)strtol(first, NULL, 10));
    else if (strcmp(word[0], "force") == 0) gl_report_force(&link, (int32_t)strtol(first, NULL, 10));
    else if (strcmp(word[0], "motion") == 0) gl_report_motion(&link, tick, first[0] == '1');
    else if (strcmp(word[0], "alive") == 0) printf("alive %d\n", gl_take_alive(&link));
    else if (strcmp(word[0], "log") == 0 && n == 4) {
      uint8_t out[GL_MAX_WIRE];
      size_t len = peer_unhex(word[3], bytes, sizeof bytes);
      printf("log ");
      peer_print_hex(out, gl_log(&link, tick, (uint8_t)strtoul(first, NULL, 10), (const char *)bytes, len, out));
      printf("\n");
    } else peer_fail("no such command", word[0]);
  }
  return 0;
}
