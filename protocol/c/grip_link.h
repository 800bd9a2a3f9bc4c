/* Bytes of a serial port in, samples and status out: the device side of the grip link, protocol version 1.
 *
 * One header, one source, C99, no heap, nothing of libc but memcpy and memset, no clock and no port: time is the
 * tick count of the firmware and bytes are arguments. SPEC.md describes the protocol.
 *
 * A firmware calls, as often as it can and from one context (or with interrupts locked around each call):
 *   gl_receive        with what the port gave, until it returns false
 *   gl_push_i16/_f32  with every sample while samples are wanted
 *   gl_drive_at       from the force loop: the force the actuator is to have now
 *   gl_poll_transmit  whenever the port can take a frame: one frame, one write
 *   gl_take_alive     and feeds the watchdog only when it says true
 * A software ESTOP is not a safety function.
 *
 * RAM: one gl_link (see README.md for measured sizes) and GL_MAX_WIRE bytes for the frame being sent.
 * GL_CHANNELS, GL_KEPT_BATCHES, GL_BATCH_BYTES and GL_BATCH_MS may be set by the build (-DGL_KEPT_BATCHES=2). */
#ifndef GRIP_LINK_H
#define GRIP_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GL_PROTOCOL 1u
#define GL_MAX_PAYLOAD 480u /* bytes of the largest payload */
#define GL_MAX_BODY 492u    /* header, payload, CRC */
#define GL_MAX_BLOCK 494u   /* the same as a COBS block */
#define GL_MAX_WIRE 496u    /* the same between two delimiters */
#define GL_NO_READING INT16_MIN /* i16 element of a channel without a reading */

/* An AVR has a few kilobytes of RAM, and ports that are no quicker for it. */
#ifdef __AVR__
#ifndef GL_CHANNELS
#define GL_CHANNELS 4
#endif
#ifndef GL_BATCH_BYTES
#define GL_BATCH_BYTES 64
#endif
#ifndef GL_BATCH_MS
#define GL_BATCH_MS 4
#endif
#endif

#ifndef GL_CHANNELS
#define GL_CHANNELS 16 /* most channels described, 1..16 */
#endif
#ifndef GL_KEPT_BATCHES
#define GL_KEPT_BATCHES 4 /* closed batches that wait for the port */
#endif
#ifndef GL_BATCH_BYTES
#define GL_BATCH_BYTES 460 /* bytes of rows in a batch, at most 460; a row of all channels must fit */
#endif
#ifndef GL_BATCH_MS
#define GL_BATCH_MS 1 /* a batch is closed after this time at the latest, 1..4; more for a slow port */
#endif

/* ---- codes of the wire ---- */

enum gl_kind {
  GL_HELLO = 0x01, GL_CONFIG = 0x03, GL_START = 0x04, GL_STOP = 0x05, GL_PING = 0x06, GL_GRIP = 0x10,
  GL_HEARTBEAT = 0x11, GL_ESTOP = 0x12, GL_CLEAR_FAULT = 0x13,
  GL_IDENT = 0x81, GL_CONFIG_ACK = 0x83, GL_PONG = 0x86, GL_ACK = 0x8E, GL_NACK = 0x8F, GL_SAMPLES = 0x90,
  GL_STATUS = 0x91, GL_STATS = 0x92, GL_EVENT = 0x93, GL_LOG = 0x94
};

typedef enum {
  GL_BOOT = 0, GL_IDLE, GL_LINKED, GL_ARMED, GL_ACTIVE, GL_HOLD, GL_LOSS_ACTION, GL_FAULT, GL_ESTOPPED
} gl_state;

enum gl_fault_code {
  GL_FAULT_NONE = 0, GL_FAULT_ESTOP = 0x0001,
  /* minor: the force is held */
  GL_FAULT_SENSOR_DEAD = 0x0101, GL_FAULT_SENSOR_FROZEN = 0x0102, GL_FAULT_SENSOR_SATURATED = 0x0103, GL_FAULT_TASK_HUNG = 0x0104,
  /* major, as every other code: torque off */
  GL_FAULT_OBJECT_LOST = 0x0201, GL_FAULT_POSITION_UNDEFINED = 0x0202, GL_FAULT_OVER_TEMPERATURE = 0x0203,
  GL_FAULT_OVER_CURRENT = 0x0204, GL_FAULT_DRIVE = 0x0205, GL_FAULT_SUPPLY = 0x0206
};

enum gl_channel_kind {
  GL_STYLUS = 1, GL_NORMAL_FORCE, GL_TANGENTIAL_FORCE, GL_TRAVEL, GL_VELOCITY, GL_SECOND_STYLUS, GL_REFERENCE, GL_PRESSURE,
  GL_PRESSURE_ARRAY
};
enum gl_unit { GL_UNIT_NONE = 0, GL_METRE, GL_NEWTON, GL_METRE_PER_SECOND, GL_METRE_PER_SECOND2, GL_PASCAL };
enum gl_format { GL_I16 = 0, GL_F32 = 1 };
enum gl_reset { GL_RESET_UNKNOWN = 0, GL_POWER_ON, GL_RESET_PIN, GL_WATCHDOG, GL_SOFTWARE, GL_BROWNOUT };
enum gl_mode { GL_MODE_FORCE = 1, GL_MODE_OPEN, GL_MODE_PASSIVE };
enum gl_loss_action { GL_LOSS_HOLD = 0, GL_LOSS_OPEN, GL_LOSS_PASSIVE };
enum gl_nack_reason { GL_UNKNOWN_TYPE = 1, GL_MALFORMED, GL_WRONG_STATE, GL_LATCHED, GL_OTHER_FAULT, GL_VERSION };
enum gl_log_level { GL_ERROR = 0, GL_WARN, GL_INFO, GL_DEBUG };

/* Bits of STATUS.clamp. */
enum gl_clamp {
  GL_CLAMP_FORCE = 1, GL_CLAMP_SLEW = 2, GL_CLAMP_TTL = 4, GL_CLAMP_REJECTED = 8, GL_CLAMP_HOLD_CAP = 16, GL_CLAMP_TRAVEL = 32
};
/* Bits of STATUS.flags. */
enum gl_status_flag {
  GL_SAMPLING = 1, GL_DROPPING = 2, GL_IS_PASSIVE = 4, GL_IS_OPEN = 8, GL_NO_COMMAND = 16, GL_TELLS_MOTION = 32,
  GL_IS_MOVING = 64
};

/* ---- decoder: bytes in any chunking -> frames ---- */

/* What came of a block; GL_PENDING until its delimiter. Each but GL_OK and GL_PENDING has a counter. */
typedef enum {
  GL_PENDING = 0, GL_OK, GL_TOO_LONG, GL_COBS, GL_LENGTH, GL_CRC, GL_ECHO, GL_OTHER_VERSION, GL_STALE, GL_DUPLICATE, GL_UNKNOWN
} gl_verdict;

typedef enum { GL_ROLE_DEVICE, GL_ROLE_HOST } gl_role;

typedef struct {
  uint8_t version, kind;
  bool to_host, ack_req;
  uint16_t seq, session;
} gl_header;

/* In the order of STATS; all saturate. */
typedef struct {
  uint32_t ok, too_long, cobs, length, crc, echo, version, stale, duplicate, unknown, gap, garbage_bytes;
} gl_counters;

typedef struct {
  uint8_t body[GL_MAX_BODY + 1];
  uint16_t filled, encoded;
  uint32_t seen;
  uint8_t left;
  bool full_block;
  bool has_session, has_seq;
  uint16_t session, last_seq;
  gl_role role;
  gl_header header; /* of the last good frame, or of one of unknown type */
  uint16_t payload_len;
  gl_counters counters;
} gl_decoder;

void gl_decoder_init(gl_decoder *d, gl_role role);
/* Takes frames of `session` from now on. */
void gl_decoder_open(gl_decoder *d, uint16_t session, bool has_seq, uint16_t last_seq);
/* Takes one byte. After GL_OK the frame is in header and gl_decoder_payload until the next byte. */
gl_verdict gl_decoder_push(gl_decoder *d, uint8_t byte);
const uint8_t *gl_decoder_payload(const gl_decoder *d);

uint32_t gl_crc32c(const uint8_t *data, size_t len);

/* ---- encoder: fields one after the other -> COBS with CRC, straight into the wire buffer ---- */

typedef struct {
  uint8_t *out;
  size_t room, at, code_at, owed;
  uint32_t crc;
  bool fits;
} gl_encoder;

/* Begins a frame with a payload of exactly `len` bytes in `out` of `room` bytes. */
void gl_begin(gl_encoder *e, const gl_header *header, uint16_t len, uint8_t *out, size_t room);
void gl_put(gl_encoder *e, const uint8_t *data, size_t len);
void gl_put_u8(gl_encoder *e, uint8_t value);
void gl_put_u16(gl_encoder *e, uint16_t value);
void gl_put_u32(gl_encoder *e, uint32_t value);
void gl_put_u64(gl_encoder *e, uint64_t value);
void gl_put_i32(gl_encoder *e, int32_t value);
void gl_put_f32(gl_encoder *e, float value);
/* Ends the frame; its length on the wire, 0 when it did not fit. */
size_t gl_end(gl_encoder *e);

/* COBS alone, without delimiters; 0 when it does not fit. */
size_t gl_cobs_encode(const uint8_t *data, size_t len, uint8_t *out, size_t room);

/* ---- messages ---- */

typedef struct {
  uint32_t sample_rate_hz;
  uint8_t batch, format;
  uint16_t ttl_ms;
  uint32_t channel_mask;
  int32_t force_max_mn;
  uint32_t slew_mn_s;
  int32_t hold_cap_mn;
  uint16_t loss_after_ms;
  uint8_t loss_action;
} gl_config;

typedef struct {
  uint32_t cmd_id;
  uint8_t mode, flags;
  uint16_t ttl_ms;
  int32_t force_mn;
  uint32_t slew_mn_s;
  uint32_t cause_sample;
} gl_grip;

typedef struct {
  uint32_t turns, longest_us;
  uint16_t late, flags;
} gl_heartbeat;

typedef struct {
  uint32_t last_cmd_id;
  gl_state state;
  uint8_t clamp;
  uint16_t fault;
  int32_t applied_mn, target_mn;
  uint32_t age_us;
  uint16_t flags, rejected;
} gl_status_report;

typedef struct {
  uint8_t kind, unit;
  uint8_t formats; /* b0 i16, b1 f32 */
  uint8_t count;   /* elements, 1..64 */
  float scale;     /* unit per i16 step */
} gl_channel;

/* What the firmware says about its gripper; constant while the link lives. */
typedef struct {
  uint8_t uid[16];
  uint32_t boot_id; /* another at every start */
  uint32_t tick_hz; /* 1000.. */
  uint32_t rate_max_hz;
  int32_t force_max_mn; /* 0: sensors alone, no actuator; hold_cap_mn is 0 then */
  uint32_t slew_max_mn_s;
  int32_t hold_cap_mn;
  int32_t travel_min_um, travel_max_um;
  uint8_t fw_major, fw_minor;
  uint16_t fw_patch;
  uint8_t reset; /* enum gl_reset */
  bool estop_passive; /* ESTOP takes the torque off; else the force is held */
  uint8_t channel_count;
  gl_channel channels[GL_CHANNELS];
} gl_ident;

/* ---- device ---- */

typedef enum { GL_DRIVE_PASSIVE, GL_DRIVE_FORCE, GL_DRIVE_OPEN } gl_drive_kind;

/* What the actuator is to do. */
typedef struct {
  gl_drive_kind kind;
  int32_t force_mn; /* 0 unless GL_DRIVE_FORCE */
} gl_drive;

typedef enum {
  GL_ON_LINKED, GL_ON_CONFIGURED, GL_ON_STARTED, GL_ON_STOPPED, GL_ON_COMMAND, GL_ON_REJECTED, GL_ON_HEARTBEAT, GL_ON_ESTOP,
  GL_ON_CLEARED
} gl_event_type;

/* What a received frame meant; the link has already acted on it. */
typedef struct {
  gl_event_type type;
  union {
    uint16_t session; /* LINKED */
    gl_config config; /* CONFIGURED: set the sampling up */
    gl_grip grip;     /* COMMAND, REJECTED */
    gl_heartbeat heartbeat;
    uint16_t fault; /* CLEARED */
  } is;
} gl_event;

typedef enum { GL_ROW_OK, GL_ROW_NOT_SAMPLING, GL_ROW_FORMAT, GL_ROW_ELEMENTS } gl_row_error;
typedef enum { GL_INIT_OK, GL_INIT_TICK_RATE, GL_INIT_LIMITS, GL_INIT_NO_STYLUS, GL_INIT_ROW } gl_init_error;

/* The rest is private: read it, do not write it. */

typedef struct {
  gl_config config;
  gl_drive goal;
  enum { GL_PHASE_REST, GL_PHASE_ACTIVE, GL_PHASE_HOLD, GL_PHASE_LOST } phase;
  uint64_t phase_tick; /* ACTIVE: until; HOLD: since */
  uint64_t updated, credit, last_tick;
  uint32_t tick_hz, slew_mn_s, last_id;
  int32_t applied_mn;
  uint8_t clamp;
  bool has_last, at_travel_end;
} gl_guard;

typedef struct {
  uint64_t t0_tick;
  uint32_t first_index;
  uint16_t len;
  uint8_t rows;
  uint8_t data[GL_BATCH_BYTES];
} gl_batch;

typedef struct {
  gl_batch slots[GL_KEPT_BATCHES + 1];
  uint8_t oldest, closed, rows_a_batch, format;
  uint16_t row_bytes, dt_ticks;
  uint32_t next_index, dropped_rows, dropped_batches, longest_ticks;
} gl_batches;

typedef struct {
  uint8_t kind, request, reason, clamped;
  uint16_t seq;
  union {
    gl_config config;
    struct { uint64_t t1_us, rx_tick; } ping;
  } is;
} gl_reply;

typedef struct {
  uint64_t tick;
  int32_t value;
  uint16_t fault;
  uint8_t kind, before, after;
} gl_note;

#define GL_WAITING 8

typedef struct {
  gl_ident ident;
  gl_decoder decoder;
  gl_guard guard;
  gl_batches batches;
  gl_reply replies[GL_WAITING];
  gl_note notes[GL_WAITING];
  uint8_t reply_first, reply_used, note_first, note_used;
  uint16_t notes_dropped;
  gl_state state;
  bool estop, armed, sampling, has_measured, has_motion, moving, samples_next;
  uint8_t ran;
  uint16_t fault, cleared, seq, session, rejected;
  int32_t measured_mn;
  uint32_t sent, malformed, old, refused, unanswered, dropped_seen;
  uint64_t status_due, stats_due, announce_due;
} gl_link;

/* A link in state BOOT: passive, and deaf until gl_ready. */
gl_init_error gl_init(gl_link *link, const gl_ident *ident);
/* Self-tests are over: BOOT -> IDLE. */
void gl_ready(gl_link *link, uint64_t tick);
/* Takes bytes off *input up to the next event; false when they are used up. Call it until then, with no bytes too. */
bool gl_receive(gl_link *link, uint64_t tick, const uint8_t **input, size_t *len, gl_event *event);
/* Writes the next frame that is due to out[GL_MAX_WIRE]; its length, or 0. */
size_t gl_poll_transmit(gl_link *link, uint64_t tick, uint8_t *out);
/* What the actuator is to do at this tick (R1 to R5). */
gl_drive gl_drive_at(gl_link *link, uint64_t tick);
/* Appends a row of the channels in force; elements without a reading are GL_NO_READING or NaN. */
gl_row_error gl_push_i16(gl_link *link, uint64_t tick, const int16_t *row, size_t n);
gl_row_error gl_push_f32(gl_link *link, uint64_t tick, const float *row, size_t n);
/* Latches a fault of the firmware: minor ones hold, all others take the torque off (R6 to R8). */
void gl_raise_fault(gl_link *link, uint64_t tick, uint16_t fault);
/* Latches a stop, as ESTOP of the host does. */
void gl_latch_estop(gl_link *link, uint64_t tick);
/* Finger position: outside the travel of IDENT the force does not rise. */
void gl_report_travel(gl_link *link, int32_t position_um);
/* Measured force for STATUS; without it STATUS tells the force set. */
void gl_report_force(gl_link *link, int32_t force_mn);
/* Whether the fingers travel freely or the arm is known to move, for STATUS. Fingers that press on something do not move, however
   the force changes: a host hears less well in motion. */
void gl_report_motion(gl_link *link, uint64_t tick, bool moving);
/* Whether control, link and (while sampling) samples all ran since the last true: feed the watchdog then only (R9). */
bool gl_take_alive(gl_link *link);
/* Writes a LOG of at most 255 bytes of UTF-8 to out[GL_MAX_WIRE]; its length, 0 without a session. */
size_t gl_log(gl_link *link, uint64_t tick, uint8_t level, const char *text, size_t len, uint8_t *out);
/* Whether rows are wanted now. */
bool gl_is_sampling(const gl_link *link);
/* Latched fault; ESTOP comes first. */
uint16_t gl_fault_now(const gl_link *link);
/* STATUS as it would be sent now. */
gl_status_report gl_status_now(const gl_link *link, uint64_t tick);

#ifdef __cplusplus
}
#endif
#endif
