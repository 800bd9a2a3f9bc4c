#include "bench.h"

#if BENCH

#include "board.h"
#include "reset.h"
#include "uart.h"

#define LINE_EVERY_US 20000u
#define LINE_ROOM 320u

static unsigned hung;

typedef struct {
  char text[LINE_ROOM];
  size_t len;
} line;

static void put(line *l, char c) {
  if (l->len < LINE_ROOM) l->text[l->len++] = c;
}

static void put_pair(line *l, const char *key, uint64_t value) {
  char digits[20];
  size_t n = 0;
  while (*key != '\0') put(l, *key++);
  put(l, '=');
  do {
    digits[n++] = (char)('0' + value % 10u);
    value /= 10u;
  } while (value > 0);
  while (n > 0) put(l, digits[--n]);
  put(l, ' ');
}

static uint64_t milli(float value) { return value > 0.0f ? (uint64_t)(value * 1000.0f + 0.5f) : 0; }

/* The whole line, or none where the port is behind. */
static void tell(const gl_link *link, const gripper *world, uint64_t now) {
  const gl_status_report status = gl_status_now(link, now);
  const gl_counters *count = &link->decoder.counters;
  line l;
  l.len = 0;
  put_pair(&l, "t_us", now);
  put_pair(&l, "boot", reset_boot_id());
  put_pair(&l, "reset", reset_reason());
  put_pair(&l, "state", (uint64_t)status.state);
  put_pair(&l, "fault", status.fault);
  put_pair(&l, "clamp", status.clamp);
  put_pair(&l, "rejected", status.rejected);
  put_pair(&l, "cmd", status.last_cmd_id);
  put_pair(&l, "target_mn", (uint64_t)status.target_mn);
  put_pair(&l, "drive_mn", milli(world->target_n));
  put_pair(&l, "applied_mn", milli(world->applied_n));
  put_pair(&l, "peak_mn", milli(world->peak_n));
  put_pair(&l, "travel_um", milli(1000.0f * world->travel_m));
  put_pair(&l, "object", (uint64_t)world->object);
  put_pair(&l, "seq", link->seq);
  put_pair(&l, "rx_lost", LINK_PORT.rx_lost);
  put_pair(&l, "dropped", link->batches.dropped_rows);
  put_pair(&l, "stale", count->stale);
  put_pair(&l, "duplicate", count->duplicate);
  put_pair(&l, "echo", count->echo);
  put_pair(&l, "crc", count->crc);
  put_pair(&l, "garbage", count->garbage_bytes);
  put(&l, '\n');
  (void)uart_send(&BENCH_PORT, (const uint8_t *)l.text, l.len);
}

static void order(gripper *world, uint8_t what) {
  switch (what) {
    case 'n': gripper_init(world, world->seed + 1u); break;
    case 'f': world->stylus_frozen = true; break;
    case 't': world->travel_lost = true; break;
    case 'C': hung |= TASK_CONTROL; break;
    case 'L': hung |= TASK_LINK; break;
    case 'S': hung |= TASK_SAMPLING; break;
    case 'X':
      for (;;) {
      }
    case 'R': reset_now(); break;
    case 'p': world->peak_n = world->applied_n; break;
    default: break;
  }
}

void bench_start(void) { uart_start(&BENCH_PORT, UART1_BASE); }

void bench_run(gl_link *link, gripper *world, uint64_t now) {
  static uint64_t due;
  uint8_t what;
  while (uart_read(&BENCH_PORT, &what, 1) == 1) order(world, what);
  if (now < due) return;
  due = now + LINE_EVERY_US;
  tell(link, world, now);
}

bool bench_hangs(enum task task) { return (hung & (unsigned)task) != 0; }

#endif
