/* Frames, messages and the failsafe state machine of the device side. See grip_link.h and ../SPEC.md. */
#include "grip_link.h"

#if __STDC_HOSTED__
#include <string.h>
#else
#include <stddef.h>
/* A freestanding compiler brings no string.h, but its own code needs these two anyway. */
void *memcpy(void *to, const void *from, size_t len);
void *memset(void *to, int value, size_t len);
#endif

#define SAMPLES_HEADER 20u
#define IDENT_TABLE 72u
#define DUPLICATE_WINDOW 256u
#define TTL_MIN_MS 20u
#define TTL_MAX_MS 100u
#define LONGEST_STEP_MS 10u
#define SLOTS (GL_KEPT_BATCHES + 1)

typedef char gl_check_channels[GL_CHANNELS >= 1 && GL_CHANNELS <= 16 ? 1 : -1];
typedef char gl_check_kept[GL_KEPT_BATCHES >= 1 && GL_KEPT_BATCHES <= 100 ? 1 : -1];
typedef char gl_check_batch[GL_BATCH_BYTES >= 4 && GL_BATCH_BYTES <= 460 ? 1 : -1];
typedef char gl_check_batch_ms[GL_BATCH_MS >= 1 && GL_BATCH_MS <= 4 ? 1 : -1];
typedef char gl_check_float[sizeof(float) == 4 ? 1 : -1];

enum { RAN_CONTROL = 1, RAN_LINK = 2, RAN_SAMPLING = 4 };
enum { NOTE_STATE = 1, NOTE_FAULT = 2, NOTE_CLEARED = 3, NOTE_REJECTED = 4 };

/* ---- numbers ---- */

static uint16_t read16(const uint8_t *p) { return (uint16_t)(p[0] | (uint16_t)(p[1] << 8)); }

static uint32_t read32(const uint8_t *p) { return (uint32_t)read16(p) | (uint32_t)read16(p + 2) << 16; }

static uint64_t read64(const uint8_t *p) { return (uint64_t)read32(p) | (uint64_t)read32(p + 4) << 32; }

static int32_t read_i32(const uint8_t *p) {
  uint32_t bits = read32(p);
  int32_t value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static void count(uint32_t *counter, uint32_t more) {
  *counter = more > UINT32_MAX - *counter ? UINT32_MAX : *counter + more;
}

static uint64_t later(uint64_t tick, uint64_t by) { return by > UINT64_MAX - tick ? UINT64_MAX : tick + by; }

static uint64_t since(uint64_t now, uint64_t then) { return now > then ? now - then : 0; }

static uint32_t min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }

static int32_t min_i32(int32_t a, int32_t b) { return a < b ? a : b; }

static uint16_t clamp_u16(uint16_t value, uint16_t low, uint16_t high) {
  return value < low ? low : value > high ? high : value;
}

/* ---- CRC-32C, half a byte a step ---- */

static uint32_t crc_byte(uint32_t crc, uint8_t byte) {
  static const uint32_t table[16] = {
      0x00000000u, 0x105EC76Fu, 0x20BD8EDEu, 0x30E349B1u, 0x417B1DBCu, 0x5125DAD3u, 0x61C69362u, 0x7198540Du,
      0x82F63B78u, 0x92A8FC17u, 0xA24BB5A6u, 0xB21572C9u, 0xC38D26C4u, 0xD3D3E1ABu, 0xE330A81Au, 0xF36E6F75u,
  };
  crc ^= byte;
  crc = crc >> 4 ^ table[crc & 15u];
  return crc >> 4 ^ table[crc & 15u];
}

static uint32_t crc_bytes(uint32_t crc, const uint8_t *data, size_t len) {
  while (len-- > 0) crc = crc_byte(crc, *data++);
  return crc;
}

uint32_t gl_crc32c(const uint8_t *data, size_t len) { return ~crc_bytes(UINT32_MAX, data, len); }

/* ---- encoder ---- */

static void open_block(gl_encoder *e, uint8_t *out, size_t room, size_t at) {
  e->out = out;
  e->room = room;
  e->code_at = at;
  e->at = at + 1;
  e->crc = UINT32_MAX;
  e->owed = 0;
  e->fits = at < room;
}

static void write_code(gl_encoder *e) {
  if (e->code_at < e->room) e->out[e->code_at] = (uint8_t)(e->at - e->code_at);
}

static void close_block(gl_encoder *e) {
  write_code(e);
  e->code_at = e->at++;
  if (e->code_at >= e->room) e->fits = false;
}

static void stuff(gl_encoder *e, uint8_t byte) {
  if (e->at - e->code_at == 255u) close_block(e);
  if (byte == 0) {
    close_block(e);
    return;
  }
  if (e->at < e->room) e->out[e->at] = byte;
  else e->fits = false;
  e->at++;
}

size_t gl_cobs_encode(const uint8_t *data, size_t len, uint8_t *out, size_t room) {
  gl_encoder e;
  open_block(&e, out, room, 0);
  for (size_t i = 0; i < len; i++) stuff(&e, data[i]);
  write_code(&e);
  return e.fits && e.at <= room ? e.at : 0;
}

void gl_put_u8(gl_encoder *e, uint8_t value) {
  if (e->owed == 0) {
    e->fits = false;
    return;
  }
  e->owed--;
  e->crc = crc_byte(e->crc, value);
  stuff(e, value);
}

void gl_put(gl_encoder *e, const uint8_t *data, size_t len) {
  for (size_t i = 0; i < len; i++) gl_put_u8(e, data[i]);
}

void gl_put_u16(gl_encoder *e, uint16_t value) {
  gl_put_u8(e, (uint8_t)(value & 0xFFu));
  gl_put_u8(e, (uint8_t)(value >> 8));
}

void gl_put_u32(gl_encoder *e, uint32_t value) {
  gl_put_u16(e, (uint16_t)(value & 0xFFFFu));
  gl_put_u16(e, (uint16_t)(value >> 16));
}

void gl_put_u64(gl_encoder *e, uint64_t value) {
  gl_put_u32(e, (uint32_t)(value & UINT32_MAX));
  gl_put_u32(e, (uint32_t)(value >> 32));
}

void gl_put_i32(gl_encoder *e, int32_t value) { gl_put_u32(e, (uint32_t)value); }

void gl_put_f32(gl_encoder *e, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  gl_put_u32(e, bits);
}

void gl_begin(gl_encoder *e, const gl_header *header, uint16_t len, uint8_t *out, size_t room) {
  open_block(e, out, room, 1);
  if (room > 0) out[0] = 0;
  if (len > GL_MAX_PAYLOAD || header->version > 15) e->fits = false;
  e->owed = 8u + len;
  gl_put_u8(e, (uint8_t)(header->version << 4 | (header->to_host ? 1 : 0) | (header->ack_req ? 2 : 0)));
  gl_put_u8(e, header->kind);
  gl_put_u16(e, header->seq);
  gl_put_u16(e, header->session);
  gl_put_u16(e, len);
}

size_t gl_end(gl_encoder *e) {
  uint32_t crc = ~e->crc;
  if (e->owed != 0) e->fits = false;
  for (unsigned shift = 0; shift < 32; shift += 8) stuff(e, (uint8_t)(crc >> shift & 0xFFu));
  write_code(e);
  if (!e->fits || e->at >= e->room) return 0;
  e->out[e->at] = 0;
  return e->at + 1;
}

/* ---- decoder ---- */

void gl_decoder_init(gl_decoder *d, gl_role role) {
  memset(d, 0, sizeof *d);
  d->role = role;
}

void gl_decoder_open(gl_decoder *d, uint16_t session, bool has_seq, uint16_t last_seq) {
  d->has_session = true;
  d->session = session;
  d->has_seq = has_seq;
  d->last_seq = last_seq;
}

const uint8_t *gl_decoder_payload(const gl_decoder *d) { return d->body + 8; }

static void keep(gl_decoder *d, uint8_t byte) {
  if (d->filled < sizeof d->body) d->body[d->filled++] = byte;
}

static void take(gl_decoder *d, uint8_t byte) {
  count(&d->seen, 1);
  if (d->seen > GL_MAX_BLOCK) return;
  if (d->left > 0) {
    keep(d, byte);
    d->left--;
    return;
  }
  if (d->seen > 1 && !d->full_block) keep(d, 0);
  d->left = (uint8_t)(byte - 1);
  d->full_block = byte == 255;
}

static bool is_known(gl_role role, uint8_t kind) {
  switch (kind) {
    case GL_HELLO: case GL_CONFIG: case GL_START: case GL_STOP: case GL_PING: case GL_GRIP: case GL_HEARTBEAT: case GL_ESTOP:
    case GL_CLEAR_FAULT:
      return role == GL_ROLE_DEVICE;
    case GL_IDENT: case GL_CONFIG_ACK: case GL_PONG: case GL_ACK: case GL_NACK: case GL_SAMPLES: case GL_STATUS: case GL_STATS:
    case GL_EVENT: case GL_LOG:
      return role == GL_ROLE_HOST;
    default:
      return false;
  }
}

static gl_verdict follow(gl_decoder *d, uint16_t seq) {
  if (d->has_seq) {
    if ((uint16_t)(d->last_seq - seq) < DUPLICATE_WINDOW) return GL_DUPLICATE;
    count(&d->counters.gap, (uint16_t)(seq - d->last_seq - 1u));
  }
  d->has_seq = true;
  d->last_seq = seq;
  return GL_OK;
}

static gl_verdict accept(gl_decoder *d) {
  const gl_header *h = &d->header;
  bool device = d->role == GL_ROLE_DEVICE;
  bool greeting = h->kind == GL_HELLO || h->kind == GL_IDENT;
  bool open = d->has_session && d->session == h->session;
  if (h->to_host == device) return GL_ECHO;
  if (h->version != GL_PROTOCOL && !greeting) return GL_OTHER_VERSION;
  if (device ? (h->kind == GL_HELLO && !open) || (h->kind == GL_ESTOP && h->session == 0)
             : h->kind == GL_IDENT && h->session == 0) {
    return GL_OK;
  }
  if (!open) return GL_STALE;
  if (follow(d, h->seq) != GL_OK) return GL_DUPLICATE;
  return is_known(d->role, h->kind) ? GL_OK : GL_UNKNOWN;
}

static gl_verdict judge(gl_decoder *d) {
  const uint8_t *body = d->body;
  if (d->seen > GL_MAX_BLOCK) return GL_TOO_LONG;
  if (d->left > 0) return GL_COBS;
  if (d->filled < 12 || d->filled > GL_MAX_BODY || read16(body + 6) != d->filled - 12) return GL_LENGTH;
  if (gl_crc32c(body, d->filled - 4u) != read32(body + d->filled - 4)) return GL_CRC;
  d->payload_len = (uint16_t)(d->filled - 12);
  d->header.version = body[0] >> 4;
  d->header.to_host = (body[0] & 1) != 0;
  d->header.ack_req = (body[0] & 2) != 0;
  d->header.kind = body[1];
  d->header.seq = read16(body + 2);
  d->header.session = read16(body + 4);
  return accept(d);
}

gl_verdict gl_decoder_push(gl_decoder *d, uint8_t byte) {
  gl_verdict verdict;
  if (byte != 0) {
    take(d, byte);
    return GL_PENDING;
  }
  if (d->seen == 0) return GL_PENDING;
  verdict = judge(d);
  switch (verdict) {
    case GL_OK: count(&d->counters.ok, 1); break;
    case GL_TOO_LONG: count(&d->counters.too_long, 1); break;
    case GL_COBS: count(&d->counters.cobs, 1); break;
    case GL_LENGTH: count(&d->counters.length, 1); break;
    case GL_CRC: count(&d->counters.crc, 1); break;
    case GL_ECHO: count(&d->counters.echo, 1); break;
    case GL_OTHER_VERSION: count(&d->counters.version, 1); break;
    case GL_STALE: count(&d->counters.stale, 1); break;
    case GL_DUPLICATE: count(&d->counters.duplicate, 1); break;
    case GL_UNKNOWN: count(&d->counters.unknown, 1); break;
    case GL_PENDING: break;
  }
  if (verdict >= GL_TOO_LONG && verdict <= GL_CRC) count(&d->counters.garbage_bytes, d->seen);
  d->seen = 0;
  d->filled = 0;
  d->left = 0;
  d->full_block = false;
  return verdict;
}

/* ---- force guard: R1 to R5 ---- */

static const gl_drive PASSIVE = {GL_DRIVE_PASSIVE, 0};
static const gl_drive OPEN = {GL_DRIVE_OPEN, 0};

static gl_drive press(int32_t force_mn) {
  gl_drive drive = {GL_DRIVE_FORCE, 0};
  drive.force_mn = force_mn;
  return drive;
}

static uint64_t ticks(uint32_t tick_hz, uint32_t ms) { return (uint64_t)tick_hz * ms / 1000u; }

static bool limit_goal(gl_guard *g, int32_t most_mn) {
  if (g->goal.kind != GL_DRIVE_FORCE || g->goal.force_mn <= most_mn) return false;
  g->goal.force_mn = most_mn;
  return true;
}

static void guard_init(gl_guard *g, const gl_ident *ident) {
  memset(g, 0, sizeof *g);
  g->tick_hz = ident->tick_hz;
  g->config.ttl_ms = TTL_MIN_MS;
  g->config.force_max_mn = ident->force_max_mn;
  g->config.slew_mn_s = g->slew_mn_s = ident->slew_max_mn_s;
  g->config.hold_cap_mn = ident->hold_cap_mn;
  g->config.loss_after_ms = 1000;
  g->goal = PASSIVE;
}

/* New limits; command numbers start afresh, the force stays as it is. */
static void guard_arm(gl_guard *g, const gl_config *config) {
  g->config = *config;
  g->has_last = false;
  g->clamp = 0;
  limit_goal(g, config->force_max_mn);
}

/* Nothing that moves goes on rising: the force stays, at most at the hold cap. */
static void guard_stay(gl_guard *g) {
  limit_goal(g, g->applied_mn);
  if (limit_goal(g, g->config.hold_cap_mn)) g->clamp |= GL_CLAMP_HOLD_CAP;
}

static void guard_hold(gl_guard *g, uint64_t from) {
  if (g->phase == GL_PHASE_ACTIVE) {
    g->phase = GL_PHASE_HOLD;
    g->phase_tick = from;
  }
  guard_stay(g);
}

static void guard_freeze(gl_guard *g) {
  g->phase = GL_PHASE_REST;
  if (g->goal.kind == GL_DRIVE_OPEN) g->goal = PASSIVE;
  guard_stay(g);
}

static void guard_release(gl_guard *g) {
  g->phase = GL_PHASE_REST;
  g->goal = PASSIVE;
  g->applied_mn = 0;
}

typedef enum { TAKEN, OLD, REFUSED } taken;

static taken guard_command(gl_guard *g, uint64_t tick, const gl_grip *grip) {
  uint16_t ttl_ms;
  int32_t force_mn;
  uint32_t ahead = grip->cmd_id - g->last_id;
  if (g->has_last && (ahead == 0 || ahead >= UINT32_C(0x80000000))) return OLD;
  if (grip->mode < GL_MODE_FORCE || grip->mode > GL_MODE_PASSIVE || grip->force_mn < 0) return REFUSED;
  ttl_ms = grip->ttl_ms == 0 ? g->config.ttl_ms : clamp_u16(grip->ttl_ms, TTL_MIN_MS, TTL_MAX_MS);
  force_mn = min_i32(grip->force_mn, g->config.force_max_mn);
  g->slew_mn_s = grip->slew_mn_s == 0 ? g->config.slew_mn_s : min_u32(grip->slew_mn_s, g->config.slew_mn_s);
  g->clamp = 0;
  if (force_mn < grip->force_mn) g->clamp |= GL_CLAMP_FORCE;
  if (g->slew_mn_s < grip->slew_mn_s) g->clamp |= GL_CLAMP_SLEW;
  if (grip->ttl_ms != 0 && ttl_ms != grip->ttl_ms) g->clamp |= GL_CLAMP_TTL;
  g->goal = grip->mode == GL_MODE_FORCE ? press(force_mn) : grip->mode == GL_MODE_OPEN ? OPEN : PASSIVE;
  g->has_last = true;
  g->last_id = grip->cmd_id;
  g->last_tick = tick;
  g->phase = GL_PHASE_ACTIVE;
  g->phase_tick = later(tick, ticks(g->tick_hz, ttl_ms));
  return TAKEN;
}

static void guard_expire(gl_guard *g, uint64_t tick) {
  if (g->phase == GL_PHASE_ACTIVE && tick > g->phase_tick) guard_hold(g, g->phase_tick);
  if (g->phase != GL_PHASE_HOLD || since(tick, g->phase_tick) < ticks(g->tick_hz, g->config.loss_after_ms)) return;
  g->phase = GL_PHASE_LOST;
  if (g->goal.kind != GL_DRIVE_FORCE) return;
  if (g->config.loss_action == GL_LOSS_OPEN) g->goal = OPEN;
  if (g->config.loss_action == GL_LOSS_PASSIVE) g->goal = PASSIVE;
}

/* Lets commands run out and moves the force towards its goal, never by more than 10 ms of slew a call. */
static gl_drive guard_advance(gl_guard *g, uint64_t tick) {
  uint64_t step = since(tick, g->updated), longest = ticks(g->tick_hz, LONGEST_STEP_MS), allowed;
  int32_t change;
  bool blocked;
  if (step > longest) step = longest;
  if (tick > g->updated) g->updated = tick;
  guard_expire(g, tick);
  if (g->goal.kind != GL_DRIVE_FORCE) {
    g->applied_mn = 0;
    g->credit = 0;
    return g->goal;
  }
  blocked = g->at_travel_end && g->goal.force_mn > g->applied_mn;
  g->clamp = (uint8_t)(blocked ? g->clamp | GL_CLAMP_TRAVEL : g->clamp & ~GL_CLAMP_TRAVEL);
  if (blocked || g->goal.force_mn == g->applied_mn) {
    g->credit = 0;
    return press(g->applied_mn);
  }
  g->credit += step * g->slew_mn_s;
  allowed = g->credit / g->tick_hz;
  g->credit %= g->tick_hz;
  change = g->goal.force_mn - g->applied_mn; /* both are 0..INT32_MAX */
  if (change > 0 && (uint64_t)change > allowed) change = (int32_t)allowed;
  if (change < 0 && (uint64_t)-(int64_t)change > allowed) change = -(int32_t)allowed;
  g->applied_mn += change;
  return press(g->applied_mn);
}

/* ---- batches: rows -> SAMPLES; the oldest whole batch is dropped when nothing can be sent ---- */

static gl_batch *open_batch(gl_batches *b) { return &b->slots[(b->oldest + b->closed) % SLOTS]; }

static void forget_oldest(gl_batches *b) {
  b->oldest = (uint8_t)((b->oldest + 1) % SLOTS);
  b->closed--;
}

static void close_batch(gl_batches *b) {
  b->closed++;
  if (b->closed > GL_KEPT_BATCHES) {
    b->dropped_rows += b->slots[b->oldest].rows;
    count(&b->dropped_batches, 1);
    forget_oldest(b);
  }
  open_batch(b)->rows = 0;
}

static void close_old_batch(gl_batches *b, uint64_t tick) {
  const gl_batch *batch = open_batch(b);
  if (batch->rows > 0 && since(tick, batch->t0_tick) >= b->longest_ticks) close_batch(b);
}

static void configure_batches(gl_batches *b, const gl_config *config, uint16_t row_bytes, uint32_t tick_hz) {
  uint32_t fitting = row_bytes > 0 ? GL_BATCH_BYTES / (uint32_t)row_bytes : 1;
  b->oldest = 0;
  b->closed = 0;
  open_batch(b)->rows = 0;
  b->format = config->format;
  b->row_bytes = row_bytes;
  b->rows_a_batch = (uint8_t)min_u32(config->batch, fitting);
  if (b->rows_a_batch == 0) b->rows_a_batch = 1;
  b->dt_ticks = (uint16_t)min_u32(tick_hz / config->sample_rate_hz, UINT16_MAX);
  b->longest_ticks = (uint32_t)ticks(tick_hz, GL_BATCH_MS);
}

static gl_batch *begin_row(gl_batches *b, uint64_t tick) {
  gl_batch *batch;
  close_old_batch(b, tick);
  batch = open_batch(b);
  if (batch->rows == 0) {
    batch->first_index = b->next_index;
    batch->t0_tick = tick;
    batch->len = 0;
  }
  b->next_index++;
  return batch;
}

static void end_row(gl_batches *b, gl_batch *batch) {
  batch->rows++;
  if (batch->rows >= b->rows_a_batch) close_batch(b);
}

static void row_u16(gl_batch *batch, uint16_t value) {
  batch->data[batch->len++] = (uint8_t)(value & 0xFFu);
  batch->data[batch->len++] = (uint8_t)(value >> 8);
}

/* ---- what waits to be said ---- */

static uint16_t fault_code(const gl_link *l) { return l->estop ? GL_FAULT_ESTOP : l->fault; }

static gl_state latched_or(const gl_link *l, gl_state other) {
  return l->estop ? GL_ESTOPPED : l->fault != GL_FAULT_NONE ? GL_FAULT : other;
}

static void note(gl_link *l, uint64_t tick, uint8_t kind, gl_state before, int32_t value) {
  gl_note *n;
  if (l->note_used == GL_WAITING) {
    l->note_first = (uint8_t)((l->note_first + 1) % GL_WAITING);
    l->note_used--;
    l->notes_dropped++;
  }
  n = &l->notes[(l->note_first + l->note_used++) % GL_WAITING];
  n->tick = tick;
  n->kind = kind;
  n->before = (uint8_t)before;
  n->after = (uint8_t)l->state;
  n->fault = fault_code(l);
  n->value = value;
}

static gl_reply *reply(gl_link *l, uint8_t kind) {
  gl_reply *r;
  if (l->reply_used == GL_WAITING) {
    l->reply_first = (uint8_t)((l->reply_first + 1) % GL_WAITING);
    l->reply_used--;
    count(&l->unanswered, 1);
  }
  r = &l->replies[(l->reply_first + l->reply_used++) % GL_WAITING];
  memset(r, 0, sizeof *r);
  r->kind = kind;
  return r;
}

static void answer(gl_link *l, const gl_header *h, uint8_t reason) {
  gl_reply *r;
  if (!h->ack_req) return;
  r = reply(l, reason == 0 ? GL_ACK : GL_NACK);
  r->request = h->kind;
  r->reason = reason;
  r->seq = h->seq;
}

static void enter(gl_link *l, uint64_t tick, gl_state state) {
  gl_state before = l->state;
  if (before == state) return;
  l->state = state;
  l->status_due = tick;
  note(l, tick, NOTE_STATE, before, 0);
}

static gl_drive step(gl_link *l, uint64_t tick) {
  gl_drive drive = guard_advance(&l->guard, tick);
  if (l->guard.phase == GL_PHASE_HOLD && l->state == GL_ACTIVE) enter(l, tick, GL_HOLD);
  if (l->guard.phase == GL_PHASE_LOST && l->state >= GL_LINKED && l->state <= GL_HOLD) {
    enter(l, tick, GL_LOSS_ACTION);
    l->guard.phase = GL_PHASE_REST;
  }
  return drive;
}

/* ---- requests ---- */

/* Back to LINKED, or to what is latched: the force is held, the loss delay goes on. */
static void disarm(gl_link *l, uint64_t tick) {
  guard_hold(&l->guard, tick);
  l->armed = false;
  l->sampling = false;
  enter(l, tick, latched_or(l, GL_LINKED));
}

static bool on_hello(gl_link *l, uint64_t tick, const gl_header *h, const uint8_t *p, gl_event *event) {
  gl_reply *r;
  if (h->session == 0) {
    count(&l->malformed, 1);
    return false;
  }
  r = reply(l, GL_IDENT);
  r->seq = h->session;
  if (p[0] > GL_PROTOCOL || p[1] < GL_PROTOCOL) return false;
  gl_decoder_open(&l->decoder, h->session, true, h->seq);
  l->session = h->session;
  disarm(l, tick);
  event->type = GL_ON_LINKED;
  event->is.session = h->session;
  return true;
}

static gl_config read_config(const uint8_t *p) {
  gl_config c;
  c.sample_rate_hz = read32(p);
  c.batch = p[4];
  c.format = p[5];
  c.ttl_ms = read16(p + 6);
  c.channel_mask = read32(p + 8);
  c.force_max_mn = read_i32(p + 12);
  c.slew_mn_s = read32(p + 16);
  c.hold_cap_mn = read_i32(p + 20);
  c.loss_after_ms = read16(p + 24);
  c.loss_action = p[26];
  return c;
}

static bool is_possible(const gl_config *c) {
  return c->sample_rate_hz > 0 && c->batch > 0 && c->format <= GL_F32 && c->force_max_mn >= 0 && c->slew_mn_s > 0 &&
         c->hold_cap_mn >= 0 && c->loss_action <= GL_LOSS_PASSIVE;
}

/* A good request that cannot be carried out now. */
static void decline(gl_link *l, const gl_header *h, uint8_t reason) {
  count(&l->refused, 1);
  answer(l, h, reason);
}

static bool malformed(gl_link *l, const gl_header *h) {
  count(&l->malformed, 1);
  answer(l, h, GL_MALFORMED);
  return false;
}

/* Limits `asked` to what the hardware allows; the bits of the fields that changed. */
static uint8_t limit_config(const gl_ident *id, const gl_config *asked, gl_config *c) {
  uint32_t offered = 0, slowest = id->tick_hz / UINT16_MAX + (id->tick_hz % UINT16_MAX != 0 ? 1u : 0u);
  for (unsigned i = 0; i < id->channel_count; i++) {
    if ((id->channels[i].formats >> asked->format & 1) != 0) offered |= UINT32_C(1) << i;
  }
  *c = *asked;
  slowest = min_u32(slowest, id->rate_max_hz);
  c->sample_rate_hz = asked->sample_rate_hz < slowest ? slowest : min_u32(asked->sample_rate_hz, id->rate_max_hz);
  c->channel_mask &= offered;
  c->force_max_mn = min_i32(asked->force_max_mn, id->force_max_mn);
  c->slew_mn_s = min_u32(asked->slew_mn_s, id->slew_max_mn_s);
  c->ttl_ms = clamp_u16(asked->ttl_ms, TTL_MIN_MS, TTL_MAX_MS);
  c->hold_cap_mn = min_i32(min_i32(asked->hold_cap_mn, id->hold_cap_mn), c->force_max_mn);
  c->loss_after_ms = clamp_u16(asked->loss_after_ms, 100, 60000);
  return (uint8_t)((asked->sample_rate_hz != c->sample_rate_hz ? 1 : 0) | (asked->channel_mask != c->channel_mask ? 4 : 0) |
                   (asked->force_max_mn != c->force_max_mn ? 8 : 0) | (asked->slew_mn_s != c->slew_mn_s ? 16 : 0) |
                   (asked->ttl_ms != c->ttl_ms ? 32 : 0) | (asked->hold_cap_mn != c->hold_cap_mn ? 64 : 0) |
                   (asked->loss_after_ms != c->loss_after_ms ? 128 : 0));
}

static uint16_t row_bytes(const gl_ident *id, uint32_t mask, uint8_t format) {
  uint32_t elements = 0;
  for (unsigned i = 0; i < id->channel_count; i++) {
    if ((mask >> i & 1) != 0) elements += id->channels[i].count;
  }
  return (uint16_t)(elements * (format == GL_F32 ? 4u : 2u));
}

static bool on_config(gl_link *l, uint64_t tick, const gl_header *h, const uint8_t *p, gl_event *event) {
  const gl_config asked = read_config(p);
  gl_config config;
  gl_reply *r;
  uint8_t clamped;
  if (!is_possible(&asked)) return malformed(l, h);
  if (latched_or(l, GL_LINKED) != GL_LINKED) {
    decline(l, h, GL_LATCHED);
    return false;
  }
  clamped = limit_config(&l->ident, &asked, &config);
  if (config.channel_mask == 0) {
    decline(l, h, GL_MALFORMED);
    return false;
  }
  guard_arm(&l->guard, &config);
  guard_hold(&l->guard, tick);
  configure_batches(&l->batches, &config, row_bytes(&l->ident, config.channel_mask, config.format), l->ident.tick_hz);
  l->armed = true;
  l->sampling = false;
  enter(l, tick, GL_ARMED);
  r = reply(l, GL_CONFIG_ACK);
  r->seq = h->seq;
  r->clamped = clamped;
  r->is.config = config;
  event->type = GL_ON_CONFIGURED;
  event->is.config = config;
  return true;
}

static bool on_start(gl_link *l, const gl_header *h, gl_event *event) {
  bool began = !l->sampling;
  if (!l->armed) {
    decline(l, h, GL_WRONG_STATE);
    return false;
  }
  answer(l, h, 0);
  l->sampling = true;
  event->type = GL_ON_STARTED;
  return began;
}

static bool on_grip(gl_link *l, uint64_t tick, const uint8_t *p, gl_event *event) {
  gl_grip *grip = &event->is.grip;
  taken result;
  grip->cmd_id = read32(p);
  grip->mode = p[4];
  grip->flags = p[5];
  grip->ttl_ms = read16(p + 6);
  grip->force_mn = read_i32(p + 8);
  grip->slew_mn_s = read32(p + 12);
  grip->cause_sample = read32(p + 16);
  l->status_due = tick;
  result = l->state >= GL_ARMED && l->state <= GL_HOLD ? guard_command(&l->guard, tick, grip) : REFUSED;
  if (result == OLD) {
    count(&l->old, 1);
    return false;
  }
  if (result == TAKEN) {
    enter(l, tick, GL_ACTIVE);
    event->type = GL_ON_COMMAND;
    return true;
  }
  l->guard.clamp |= GL_CLAMP_REJECTED;
  l->rejected++;
  note(l, tick, NOTE_REJECTED, l->state, grip->force_mn);
  event->type = GL_ON_REJECTED;
  return true;
}

static bool on_clear(gl_link *l, uint64_t tick, const gl_header *h, uint16_t fault, gl_event *event) {
  gl_state before = l->state;
  if (fault == GL_FAULT_NONE || fault_code(l) != fault) {
    /* A repeated request whose first answer was lost: the fault is gone already. */
    if (fault != GL_FAULT_NONE && l->cleared == fault) answer(l, h, 0);
    else decline(l, h, GL_OTHER_FAULT);
    return false;
  }
  if (l->estop) l->estop = false;
  else l->fault = GL_FAULT_NONE;
  l->cleared = fault;
  answer(l, h, 0);
  disarm(l, tick);
  note(l, tick, NOTE_CLEARED, before, fault);
  event->type = GL_ON_CLEARED;
  event->is.fault = fault;
  return true;
}

static uint16_t request_size(uint8_t kind) {
  switch (kind) {
    case GL_HELLO: return 16;
    case GL_CONFIG: return 28;
    case GL_PING: return 8;
    case GL_GRIP: return 20;
    case GL_HEARTBEAT: return 12;
    case GL_CLEAR_FAULT: return 2;
    default: return 0;
  }
}

static bool on_frame(gl_link *l, uint64_t tick, gl_event *event) {
  const gl_header h = l->decoder.header;
  const uint8_t *p = gl_decoder_payload(&l->decoder);
  if (l->decoder.payload_len < request_size(h.kind)) return malformed(l, &h);
  switch (h.kind) {
    case GL_HELLO: return on_hello(l, tick, &h, p, event);
    case GL_CONFIG: return on_config(l, tick, &h, p, event);
    case GL_START: return on_start(l, &h, event);
    case GL_STOP:
      l->sampling = false;
      answer(l, &h, 0);
      event->type = GL_ON_STOPPED;
      return true;
    case GL_PING: {
      gl_reply *r = reply(l, GL_PONG);
      r->is.ping.t1_us = read64(p);
      r->is.ping.rx_tick = tick;
      return false;
    }
    case GL_GRIP: return on_grip(l, tick, p, event);
    case GL_HEARTBEAT:
      event->type = GL_ON_HEARTBEAT;
      event->is.heartbeat.turns = read32(p);
      event->is.heartbeat.longest_us = read32(p + 4);
      event->is.heartbeat.late = read16(p + 8);
      event->is.heartbeat.flags = read16(p + 10);
      return true;
    case GL_ESTOP:
      gl_latch_estop(l, tick);
      answer(l, &h, 0);
      event->type = GL_ON_ESTOP;
      return true;
    default: return on_clear(l, tick, &h, read16(p), event);
  }
}

static void on_refused_block(gl_link *l, uint64_t tick, gl_verdict verdict) {
  if (verdict == GL_UNKNOWN) answer(l, &l->decoder.header, GL_UNKNOWN_TYPE);
  if (verdict == GL_STALE && l->session == 0 && tick >= l->announce_due) {
    l->announce_due = later(tick, ticks(l->ident.tick_hz, 100));
    reply(l, GL_IDENT)->seq = 0;
  }
}

bool gl_receive(gl_link *l, uint64_t tick, const uint8_t **input, size_t *len, gl_event *event) {
  l->ran |= RAN_LINK;
  step(l, tick);
  while (*len > 0) {
    gl_verdict verdict = gl_decoder_push(&l->decoder, **input);
    (*input)++;
    (*len)--;
    if (verdict == GL_PENDING || l->state == GL_BOOT) continue;
    if (verdict != GL_OK) on_refused_block(l, tick, verdict);
    else if (on_frame(l, tick, event)) return true;
  }
  return false;
}

/* ---- firmware side ---- */

static gl_init_error check(const gl_ident *id) {
  uint32_t elements = 0;
  bool slips = false;
  if (id->tick_hz < 1000) return GL_INIT_TICK_RATE;
  if (id->rate_max_hz == 0 || id->force_max_mn < 0 || id->slew_max_mn_s == 0 || id->hold_cap_mn < 0 ||
      id->hold_cap_mn > id->force_max_mn) {
    return GL_INIT_LIMITS;
  }
  if (id->channel_count > GL_CHANNELS) return GL_INIT_ROW;
  for (unsigned i = 0; i < id->channel_count; i++) {
    const gl_channel *c = &id->channels[i];
    if (c->count < 1 || c->count > 64 || !(c->scale > 0.0f && c->scale <= 3.4028235e38f)) return GL_INIT_ROW;
    elements += c->count;
    slips = slips || c->kind == GL_STYLUS || c->kind == GL_TRAVEL || c->kind == GL_PRESSURE_ARRAY;
  }
  if (!slips) return GL_INIT_NO_STYLUS;
  return elements * 4u > GL_BATCH_BYTES ? GL_INIT_ROW : GL_INIT_OK;
}

gl_init_error gl_init(gl_link *l, const gl_ident *ident) {
  gl_init_error error = check(ident);
  if (error != GL_INIT_OK) return error;
  memset(l, 0, sizeof *l);
  l->ident = *ident;
  gl_decoder_init(&l->decoder, GL_ROLE_DEVICE);
  guard_init(&l->guard, ident);
  return GL_INIT_OK;
}

void gl_ready(gl_link *l, uint64_t tick) {
  if (l->state == GL_BOOT) enter(l, tick, GL_IDLE);
}

static bool is_minor(uint16_t fault) { return fault == GL_FAULT_ESTOP || (fault >= 0x0101 && fault <= 0x0104); }

static void react(gl_link *l, bool hold) {
  if (hold) guard_freeze(&l->guard);
  else guard_release(&l->guard);
}

void gl_raise_fault(gl_link *l, uint64_t tick, uint16_t fault) {
  gl_state before;
  if (fault == GL_FAULT_NONE || fault == GL_FAULT_ESTOP) return;
  if (l->fault == GL_FAULT_NONE || (!is_minor(fault) && is_minor(l->fault))) l->fault = fault;
  l->cleared = GL_FAULT_NONE;
  react(l, is_minor(fault));
  before = l->state;
  enter(l, tick, latched_or(l, before));
  note(l, tick, NOTE_FAULT, before, fault);
}

void gl_latch_estop(gl_link *l, uint64_t tick) {
  l->estop = true;
  l->cleared = GL_FAULT_NONE;
  react(l, !l->ident.estop_passive);
  enter(l, tick, GL_ESTOPPED);
}

void gl_report_travel(gl_link *l, int32_t position_um) {
  l->guard.at_travel_end = position_um < l->ident.travel_min_um || position_um > l->ident.travel_max_um;
}

void gl_report_force(gl_link *l, int32_t force_mn) {
  l->has_measured = true;
  l->measured_mn = force_mn;
}

void gl_report_motion(gl_link *l, uint64_t tick, bool moving) {
  if (!l->has_motion || l->moving != moving) l->status_due = tick;
  l->has_motion = true;
  l->moving = moving;
}

gl_drive gl_drive_at(gl_link *l, uint64_t tick) {
  l->ran |= RAN_CONTROL;
  return step(l, tick);
}

bool gl_take_alive(gl_link *l) {
  unsigned needed = RAN_CONTROL | RAN_LINK | (l->sampling ? RAN_SAMPLING : 0);
  bool alive = (l->ran & needed) == needed;
  if (alive) l->ran = 0;
  return alive;
}

static gl_row_error check_row(gl_link *l, uint8_t format, size_t n) {
  l->ran |= RAN_SAMPLING;
  if (!l->sampling) return GL_ROW_NOT_SAMPLING;
  if (format != l->batches.format) return GL_ROW_FORMAT;
  return n * (format == GL_F32 ? 4u : 2u) == l->batches.row_bytes ? GL_ROW_OK : GL_ROW_ELEMENTS;
}

gl_row_error gl_push_i16(gl_link *l, uint64_t tick, const int16_t *row, size_t n) {
  gl_row_error error = check_row(l, GL_I16, n);
  gl_batch *batch;
  if (error != GL_ROW_OK) return error;
  batch = begin_row(&l->batches, tick);
  for (size_t i = 0; i < n; i++) row_u16(batch, (uint16_t)row[i]);
  end_row(&l->batches, batch);
  return GL_ROW_OK;
}

gl_row_error gl_push_f32(gl_link *l, uint64_t tick, const float *row, size_t n) {
  gl_row_error error = check_row(l, GL_F32, n);
  gl_batch *batch;
  if (error != GL_ROW_OK) return error;
  batch = begin_row(&l->batches, tick);
  for (size_t i = 0; i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &row[i], sizeof bits);
    row_u16(batch, (uint16_t)(bits & 0xFFFFu));
    row_u16(batch, (uint16_t)(bits >> 16));
  }
  end_row(&l->batches, batch);
  return GL_ROW_OK;
}

bool gl_is_sampling(const gl_link *l) { return l->sampling; }

uint16_t gl_fault_now(const gl_link *l) { return fault_code(l); }

/* Microseconds of `age` ticks, at most UINT32_MAX. */
static uint32_t age_us(uint64_t age, uint32_t tick_hz) {
  uint64_t seconds = age / tick_hz, us;
  if (seconds > 4294) return UINT32_MAX;
  us = seconds * 1000000u + age % tick_hz * 1000000u / tick_hz;
  return us > UINT32_MAX ? UINT32_MAX : (uint32_t)us;
}

gl_status_report gl_status_now(const gl_link *l, uint64_t tick) {
  const gl_guard *g = &l->guard;
  gl_status_report s;
  s.last_cmd_id = g->has_last ? g->last_id : 0;
  s.state = l->state;
  s.clamp = g->clamp;
  s.fault = fault_code(l);
  s.applied_mn = l->has_measured ? l->measured_mn : g->applied_mn;
  s.target_mn = g->goal.force_mn;
  s.age_us = g->has_last ? age_us(since(tick, g->last_tick), l->ident.tick_hz) : UINT32_MAX;
  s.flags = (uint16_t)((l->sampling ? GL_SAMPLING : 0) | (l->dropped_seen != l->batches.dropped_rows ? GL_DROPPING : 0) |
                       (g->goal.kind == GL_DRIVE_PASSIVE ? GL_IS_PASSIVE : 0) | (g->goal.kind == GL_DRIVE_OPEN ? GL_IS_OPEN : 0) |
                       (g->has_last ? 0 : GL_NO_COMMAND) | (l->has_motion ? GL_TELLS_MOTION : 0) |
                       (l->has_motion && l->moving ? GL_IS_MOVING : 0));
  s.rejected = l->rejected;
  return s;
}

/* ---- sending ---- */

static gl_encoder begin(gl_link *l, uint8_t kind, uint16_t session, uint16_t len, uint8_t *out) {
  gl_encoder e;
  gl_header h;
  h.version = GL_PROTOCOL;
  h.kind = kind;
  h.to_host = true;
  h.ack_req = false;
  h.seq = l->seq++;
  h.session = session;
  count(&l->sent, 1);
  gl_begin(&e, &h, len, out, GL_MAX_WIRE);
  return e;
}

static size_t send_ident(gl_link *l, uint16_t session, uint8_t *out) {
  const gl_ident *id = &l->ident;
  gl_encoder e = begin(l, GL_IDENT, session, (uint16_t)(IDENT_TABLE + 8u * id->channel_count), out);
  gl_put_u8(&e, GL_PROTOCOL);
  gl_put_u8(&e, GL_PROTOCOL);
  gl_put_u16(&e, GL_MAX_PAYLOAD);
  gl_put_u32(&e, 0);
  gl_put(&e, id->uid, sizeof id->uid);
  gl_put_u32(&e, id->boot_id);
  gl_put_u32(&e, id->tick_hz);
  gl_put_u32(&e, id->rate_max_hz);
  gl_put_i32(&e, id->force_max_mn);
  gl_put_u32(&e, id->slew_max_mn_s);
  gl_put_i32(&e, id->hold_cap_mn);
  gl_put_i32(&e, id->travel_min_um);
  gl_put_i32(&e, id->travel_max_um);
  gl_put_u8(&e, id->fw_major);
  gl_put_u8(&e, id->fw_minor);
  gl_put_u16(&e, id->fw_patch);
  gl_put_u8(&e, id->reset);
  gl_put_u8(&e, (uint8_t)l->state);
  gl_put_u16(&e, fault_code(l));
  gl_put_u8(&e, id->channel_count);
  gl_put_u8(&e, 8);
  gl_put_u16(&e, IDENT_TABLE);
  gl_put_u32(&e, 0);
  for (unsigned i = 0; i < id->channel_count; i++) {
    const gl_channel *c = &id->channels[i];
    gl_put_u8(&e, c->kind);
    gl_put_u8(&e, c->unit);
    gl_put_u8(&e, c->formats);
    gl_put_u8(&e, c->count);
    gl_put_f32(&e, c->scale);
  }
  return gl_end(&e);
}

static void write16(uint8_t *p, uint16_t value) {
  p[0] = (uint8_t)(value & 0xFFu);
  p[1] = (uint8_t)(value >> 8);
}

static void write32(uint8_t *p, uint32_t value) {
  write16(p, (uint16_t)(value & 0xFFFFu));
  write16(p + 2, (uint16_t)(value >> 16));
}

static size_t send_config_ack(gl_link *l, const gl_reply *r, uint8_t *out) {
  const gl_config *c = &r->is.config;
  uint8_t bytes[28];
  gl_encoder e;
  write32(bytes, c->sample_rate_hz);
  bytes[4] = c->batch;
  bytes[5] = c->format;
  write16(bytes + 6, c->ttl_ms);
  write32(bytes + 8, c->channel_mask);
  write32(bytes + 12, (uint32_t)c->force_max_mn);
  write32(bytes + 16, c->slew_mn_s);
  write32(bytes + 20, (uint32_t)c->hold_cap_mn);
  write16(bytes + 24, c->loss_after_ms);
  bytes[26] = c->loss_action;
  bytes[27] = 0;
  e = begin(l, GL_CONFIG_ACK, l->session, 36, out);
  gl_put_u32(&e, gl_crc32c(bytes, sizeof bytes));
  gl_put_u16(&e, r->seq);
  gl_put_u8(&e, r->clamped);
  gl_put_u8(&e, 0);
  gl_put(&e, bytes, sizeof bytes);
  return gl_end(&e);
}

static size_t send_reply(gl_link *l, uint64_t tick, uint8_t *out) {
  const gl_reply r = l->replies[l->reply_first];
  gl_encoder e;
  l->reply_first = (uint8_t)((l->reply_first + 1) % GL_WAITING);
  l->reply_used--;
  if (r.kind == GL_IDENT) return send_ident(l, r.seq, out);
  if (r.kind == GL_CONFIG_ACK) return send_config_ack(l, &r, out);
  if (r.kind == GL_PONG) {
    e = begin(l, GL_PONG, l->session, 24, out);
    gl_put_u64(&e, r.is.ping.t1_us);
    gl_put_u64(&e, r.is.ping.rx_tick);
    gl_put_u64(&e, tick);
    return gl_end(&e);
  }
  e = begin(l, r.kind, l->session, 4, out);
  gl_put_u8(&e, r.request);
  gl_put_u8(&e, r.reason);
  gl_put_u16(&e, r.seq);
  return gl_end(&e);
}

static size_t send_note(gl_link *l, uint8_t *out) {
  const gl_note n = l->notes[l->note_first];
  gl_encoder e = begin(l, GL_EVENT, l->session, 20, out);
  l->note_first = (uint8_t)((l->note_first + 1) % GL_WAITING);
  l->note_used--;
  gl_put_u64(&e, n.tick);
  gl_put_u8(&e, n.kind);
  gl_put_u8(&e, n.before);
  gl_put_u8(&e, n.after);
  gl_put_u8(&e, 0);
  gl_put_u16(&e, n.fault);
  gl_put_u16(&e, l->notes_dropped);
  gl_put_i32(&e, n.value);
  return gl_end(&e);
}

static size_t send_samples(gl_link *l, uint8_t *out) {
  gl_batches *b = &l->batches;
  const gl_batch *batch = &b->slots[b->oldest];
  gl_encoder e = begin(l, GL_SAMPLES, l->session, (uint16_t)(SAMPLES_HEADER + batch->len), out);
  gl_put_u32(&e, batch->first_index);
  gl_put_u64(&e, batch->t0_tick);
  gl_put_u16(&e, b->dt_ticks);
  gl_put_u8(&e, batch->rows);
  gl_put_u8(&e, b->format);
  gl_put_u32(&e, b->dropped_rows);
  gl_put(&e, batch->data, batch->len);
  forget_oldest(b);
  l->samples_next = false;
  return gl_end(&e);
}

static size_t send_status(gl_link *l, uint64_t tick, uint8_t *out) {
  const gl_status_report s = gl_status_now(l, tick);
  gl_encoder e = begin(l, GL_STATUS, l->session, 24, out);
  l->status_due = later(tick, ticks(l->ident.tick_hz, 8));
  l->samples_next = true;
  l->dropped_seen = l->batches.dropped_rows;
  gl_put_u32(&e, s.last_cmd_id);
  gl_put_u8(&e, (uint8_t)s.state);
  gl_put_u8(&e, s.clamp);
  gl_put_u16(&e, s.fault);
  gl_put_i32(&e, s.applied_mn);
  gl_put_i32(&e, s.target_mn);
  gl_put_u32(&e, s.age_us);
  gl_put_u16(&e, s.flags);
  gl_put_u16(&e, s.rejected);
  return gl_end(&e);
}

static size_t send_stats(gl_link *l, uint64_t tick, uint8_t *out) {
  const gl_counters *c = &l->decoder.counters;
  const uint32_t values[19] = {
      c->ok, c->too_long, c->cobs, c->length, c->crc, c->echo, c->version, c->stale, c->duplicate, c->unknown, c->gap,
      c->garbage_bytes, l->sent, l->batches.dropped_batches, l->batches.dropped_rows, l->malformed,
      l->old, l->refused, l->unanswered,
  };
  gl_encoder e = begin(l, GL_STATS, l->session, 76, out);
  l->stats_due = later(tick, ticks(l->ident.tick_hz, 1000));
  for (unsigned i = 0; i < 19; i++) gl_put_u32(&e, values[i]);
  return gl_end(&e);
}

size_t gl_poll_transmit(gl_link *l, uint64_t tick, uint8_t *out) {
  bool status, samples;
  step(l, tick);
  if (l->reply_used > 0) return send_reply(l, tick, out);
  if (l->session == 0) return 0;
  if (l->note_used > 0) return send_note(l, out);
  close_old_batch(&l->batches, tick);
  status = tick >= l->status_due;
  samples = l->sampling && l->batches.closed > 0;
  if (samples && (l->samples_next || !status)) return send_samples(l, out);
  if (status) return send_status(l, tick, out);
  if (tick >= l->stats_due) return send_stats(l, tick, out);
  return 0;
}

size_t gl_log(gl_link *l, uint64_t tick, uint8_t level, const char *text, size_t len, uint8_t *out) {
  gl_encoder e;
  if (l->session == 0 || len > 255) return 0;
  e = begin(l, GL_LOG, l->session, (uint16_t)(10 + len), out);
  gl_put_u64(&e, tick);
  gl_put_u8(&e, level);
  gl_put_u8(&e, (uint8_t)len);
  for (size_t i = 0; i < len; i++) gl_put_u8(&e, (uint8_t)text[i]);
  return gl_end(&e);
}
