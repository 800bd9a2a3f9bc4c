/* The firmware: control, link and sampling take turns once a millisecond and whenever bytes come; the watchdog is fed
 * only when all three ran (rule R9). */
#include "bench.h"
#include "board.h"
#include "reset.h"
#include "sensors.h"
#include "time.h"
#include "uart.h"

#define RATE_MAX_HZ 2000u
#define FORCE_MAX_MN 40000
#define SLEW_MAX_MN_S 2000000u
#define HOLD_CAP_MN 30000
#define OBJECT_SEED 20u

static gl_link link;
static sensors probes;
static readings seen;
static uint64_t next_sample;
/* Fingers and object do not start afresh when the microcontroller does. */
static gripper world __attribute__((section(".noinit")));

static gl_ident identity(void) {
  gl_ident id = {
      .uid = "grip-link an386",
      .boot_id = reset_boot_id(),
      .tick_hz = TICK_HZ,
      .rate_max_hz = RATE_MAX_HZ,
      .force_max_mn = FORCE_MAX_MN,
      .slew_max_mn_s = SLEW_MAX_MN_S,
      .hold_cap_mn = HOLD_CAP_MN,
      .travel_max_um = 100000,
      .fw_minor = 1,
      .reset = reset_reason(),
  };
  id.channel_count = sensors_describe(id.channels);
  return id;
}

/* The force the link allows goes to the drive. "Open" is as torque off here: springs open the fingers. */
static void control_task(uint64_t now) {
  gl_drive drive = gl_drive_at(&link, now);
  world.target_n = drive.kind == GL_DRIVE_FORCE ? 1.0e-3f * (float)drive.force_mn : 0.0f;
}

static void link_task(uint64_t now) {
  uint8_t bytes[64];
  const uint8_t *input = bytes;
  size_t len = 0;
  gl_event event;
  do {
    while (gl_receive(&link, now, &input, &len, &event)) {
      if (event.type == GL_ON_CONFIGURED) sensors_configure(&probes, &event.is.config);
    }
    input = bytes;
    len = uart_read(&LINK_PORT, bytes, sizeof bytes);
  } while (len > 0);
}

static void raise_once(uint64_t now, uint16_t fault) {
  if (fault != GL_FAULT_NONE && gl_fault_now(&link) == GL_FAULT_NONE) gl_raise_fault(&link, now, fault);
}

static void sampling_task(uint64_t now) {
  for (; next_sample <= now; next_sample += probes.period_us) {
    gripper_advance(&world, probes.period_us);
    if (bench_hangs(TASK_SAMPLING)) continue; /* the world goes on all the same */
    gripper_read(&world, &seen);
    sensors_push(&probes, &link, next_sample, &seen);
    if (gl_is_sampling(&link)) raise_once(now, sensors_judge(&probes, &seen));
  }
  gl_report_motion(&link, now, world.gap_m > 0.0f && world.target_n > 0.0f);
  gl_report_force(&link, (int32_t)(1000.0f * world.applied_n + 0.5f));
  if (world.object == OBJECT_DROPPED && world.target_n > 0.0f) raise_once(now, GL_FAULT_OBJECT_LOST);
}

/* Frames go out whole, as many as the ring takes without waiting. */
static void send(uint64_t now) {
  uint8_t frame[GL_MAX_WIRE];
  while (uart_room(&LINK_PORT) >= GL_MAX_WIRE) {
    size_t len = gl_poll_transmit(&link, now, frame);
    if (len == 0) return;
    (void)uart_send(&LINK_PORT, frame, len);
  }
}

static void start(void) {
  gl_ident id;
  reset_init();
  if (!gripper_exists(&world)) gripper_init(&world, OBJECT_SEED);
  sensors_init(&probes);
  id = identity();
  if (gl_init(&link, &id) != GL_INIT_OK) {
    for (;;) {
    }
  }
  time_start();
  uart_start(&LINK_PORT, UART0_BASE);
  bench_start();
  watchdog_start();
  gl_ready(&link, time_us());
}

int main(void) {
  start();
  for (;;) {
    uint64_t now = time_us();
    if (!bench_hangs(TASK_CONTROL)) control_task(now);
    if (!bench_hangs(TASK_LINK)) {
      link_task(now);
      send(now);
    }
    sampling_task(now);
    if (gl_take_alive(&link)) watchdog_feed();
    bench_run(&link, &world, now);
    __asm volatile("wfi");
  }
}
