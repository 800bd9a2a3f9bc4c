/* Random calls across the border: right, null, misaligned and stale pointers, memory that is too small, counts that
 * cannot be, NaN, infinities, rates, times that go back. Every buffer ends at a page that may not be touched, so a byte
 * too many ends the program.
 *
 *   fuzz [CALLS [SEED]]       prints how often each status came; ends with 1 where one is unknown or not as it must be
 */
#define _DEFAULT_SOURCE
#include <math.h>
#include <slip.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { ROWS = 300, TAXELS = 16, EVENTS = 40, COLUMNS = 18 };

static uint64_t seed = 3000;
static uint32_t random_bits(void) { /* xorshift64* */
  seed ^= seed >> 12;
  seed ^= seed << 25;
  seed ^= seed >> 27;
  return (uint32_t)((seed * UINT64_C(2685821657736338717)) >> 32);
}
static uint32_t below(uint32_t n) { return random_bits() % n; }
static int one_in(uint32_t n) { return below(n) == 0; }

/* `size` bytes that end at a page without rights. */
static void *guarded(size_t size) {
  size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (size + page - 1) / page * page;
  char *start = mmap(NULL, whole + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (start == MAP_FAILED || mprotect(start + whole, page, PROT_NONE) != 0) exit(2);
  return start + whole - size;
}

static float any_float(void) {
  static const float ODD[] = {0.0f, -0.0f, 1e-30f, 1e30f, -1e30f, 3.4e38f, 1.0f, -1.0f};
  union { uint32_t bits; float value; } any;
  switch (below(8)) {
    case 0: return NAN;
    case 1: return INFINITY;
    case 2: return -INFINITY;
    case 3: return ODD[below(8)];
    case 4: any.bits = random_bits(); return any.value;
    default: return 1e-6f * (float)below(1000) - 5e-4f;
  }
}

static float *columns[COLUMNS];
static uint64_t *times[3];
static float *taxels, *statistic, *command_n;
static slip_event *events;
static void *memory[4];
static slip_pipeline *made[4];
static uint64_t last_us[4];
static size_t size;
static unsigned long counts[16];

static void fail(const char *what) {
  fprintf(stderr, "fuzz: %s (seed state %llu)\n", what, (unsigned long long)seed);
  exit(1);
}

static void count(slip_status status) {
  if (status < SLIP_STATUS_OK || status > SLIP_STATUS_PANICKED) fail("unknown status");
  if (status == SLIP_STATUS_PANICKED) fail("a panic");
  if (strlen(slip_error_text((int32_t)status)) < 4) fail("no sentence");
  ++counts[status];
}

/* A pointer as it should be, or seldom null or misaligned. */
static void *bent(void *pointer) {
  if (one_in(300)) return NULL;
  if (one_in(300)) return (char *)pointer + 1 + below(3);
  return pointer;
}

static char *text_of(const char *const *texts, uint32_t n) {
  static char bytes[3][128];
  static int next;
  char *text = bytes[next = (next + 1) % 3];
  snprintf(text, sizeof bytes[0], "%s", texts[below(n)]);
  if (one_in(3) && text[0] != 0) text[below((uint32_t)strlen(text))] = (char)(1 + below(255));
  return text;
}

static void create(uint32_t at) {
  static const float RATES[] = {20, 100, 1000, 2200, 10000, 50000, 19.9f, 50001, 0, -1};
  static const char *const SETTINGS[] = {"", "[grip]\nf_max_n = 20.0\n", "[detector]\ngross = 30.0\n", "[", "methods = [\"travel\"]"};
  static const char *const OTHERS[] = {"", "{}", "floor = 1", "sample_rate_hz = 1000.0\n[taxels]\nrms = 1.0\n"};
  slip_options options = {0};
  char why[64];
  size_t why_size = below(sizeof why + 1);
  slip_status status;
  int plain = below(4) > 0;
  options.rate_hz = plain ? RATES[below(6)] : one_in(4) ? any_float() : RATES[below(10)];
  options.signal = plain ? below(2) : one_in(9) ? random_bits() : below(3);
  options.control = below(2);
  if (!plain) options.settings = text_of(SETTINGS, 5);
  if (!plain && one_in(3)) options.calibration = text_of(OTHERS, 4);
  if (!plain && one_in(3)) options.model = text_of(OTHERS, 2);
  if (made[at] != NULL) count(slip_destroy(made[at]));
  made[at] = NULL;
  last_us[at] = 0;
  memset(why, 1, sizeof why);
  status = slip_create(bent(memory[at]), one_in(20) ? below((uint32_t)size) : size, bent(&options), one_in(9) ? NULL : why,
                       why_size, bent(&made[at]));
  if (status != SLIP_STATUS_OK) {
    if (made[at] != NULL) fail("made in spite of a status");
    if (why_size < sizeof why && why[why_size] != 1) fail("why is longer than its room");
  }
  count(status);
}

static void push(uint32_t at) {
  slip_block block = {0};
  slip_result result = {0};
  slip_status status;
  const float **channel[] = {&block.stylus, &block.stylus_y, &block.stylus_z, &block.normal_force_n, &block.tangential_n,
                             &block.travel_m, &block.velocity_m_s, &block.second_stylus, &block.reference,
                             &block.reference_y, &block.reference_z, &block.pressure, &block.motion};
  size_t rows = one_in(10) ? 0 : one_in(4) ? ROWS : 1 + below(20);
  uint64_t t = one_in(40) ? below(1000000) : last_us[at];
  uint32_t i;
  size_t row;
  block.rows = rows;
  for (i = 0; i < sizeof channel / sizeof *channel; ++i) {
    float *end = columns[i] + ROWS - rows;
    int wild = one_in(5);
    if (i > 0 && one_in(2)) continue;
    for (row = 0; row < rows; ++row) end[row] = wild ? any_float() : 1e-6f * (float)below(100);
    *channel[i] = bent(end);
  }
  for (row = 0; row < rows; ++row) {
    times[0][ROWS - rows + row] = t += one_in(5000) ? ((uint64_t)random_bits() << below(32)) : 100;
    times[1][ROWS - rows + row] = t + below(300);
    times[2][ROWS - rows + row] = one_in(9) ? random_bits() : below(300);
  }
  if (one_in(2)) block.t_us = bent(times[0] + ROWS - rows);
  if (one_in(3)) block.arrived_us = bent(times[1] + ROWS - rows);
  if (one_in(3)) block.age_us = bent(times[2] + ROWS - rows);
  if (one_in(4)) {
    block.taxel_count = one_in(30) ? 257 + random_bits() : below(TAXELS + 1);
    if (block.taxel_count <= TAXELS) {
      size_t values = rows * block.taxel_count;
      float *end = taxels + ROWS * TAXELS - values;
      for (row = 0; row < values; ++row) end[row] = one_in(40) ? any_float() : 1.0f + 1e-3f * (float)below(100);
      block.taxels = bent(end);
    }
  }
  if (one_in(40)) block.rows = SIZE_MAX - below(1000);
  result.room = below(EVENTS + 1);
  if (one_in(2)) result.events = bent(events + EVENTS - result.room);
  if (one_in(2)) result.statistic = bent(statistic + ROWS - rows);
  if (one_in(2)) result.command_n = bent(command_n + ROWS - rows);
  result.found = SIZE_MAX;
  status = slip_push(bent(made[at]), bent(&block), bent(&result));
  if (status == SLIP_STATUS_OK && rows > 0 && block.t_us != NULL && result.state.t_us <= last_us[at]) {
    fail("a time that does not rise");
  }
  if (status == SLIP_STATUS_OK) last_us[at] = result.state.t_us;
  if (result.found > 7 * rows && (status == SLIP_STATUS_OK || result.found < SIZE_MAX)) {
    fail("more events than there can be");
  }
  count(status);
}

static void esc(void) {
  double lengths[2][32];
  uint32_t n = below(33), i;
  slip_trial trial;
  slip_esc_value value;
  slip_status status;
  for (i = 0; i < n; ++i) {
    lengths[0][i] = one_in(5) ? (double)any_float() : 1e-9 * below(10000);
    lengths[1][i] = one_in(5) ? (double)any_float() : 1e-8 * below(10000);
  }
  trial.force_n = (double)any_float();
  trial.speed_m_s = (double)any_float();
  trial.damping_n_s_m = (double)any_float();
  trial.noise = (double)any_float();
  trial.common_noise = (double)any_float();
  status = slip_esc(bent(lengths[0]), bent(lengths[1]), one_in(30) ? SIZE_MAX : n, bent(&trial), (uint8_t)below(8), bent(&value));
  if (status == SLIP_STATUS_OK && !(value.lo <= value.hi)) fail("an enclosure without a value");
  count(status);
}

int main(int argc, char **argv) {
  unsigned long calls = argc > 1 ? strtoul(argv[1], NULL, 10) : 100000, call;
  uint32_t i;
  if (argc > 2) seed = strtoull(argv[2], NULL, 10);
  size = slip_size();
  for (i = 0; i < 4; ++i) memory[i] = guarded(size);
  for (i = 0; i < COLUMNS; ++i) columns[i] = guarded(ROWS * sizeof(float));
  for (i = 0; i < 3; ++i) times[i] = guarded(ROWS * sizeof(uint64_t));
  taxels = guarded(ROWS * TAXELS * sizeof(float));
  statistic = guarded(ROWS * sizeof(float));
  command_n = guarded(ROWS * sizeof(float));
  events = guarded(EVENTS * sizeof(slip_event));
  for (call = 0; call < calls; ++call) {
    uint32_t at = below(4);
    switch (below(40)) {
      case 0: case 1: case 2: create(at); break;
      case 3: count(slip_command(bent(made[at]), (uint8_t)below(6), any_float())); break;
      case 4: esc(); break;
      case 5: if (one_in(4)) { /* a copy is no pipeline */
          void *copy = malloc(size);
          if (copy == NULL) return 2;
          memcpy(copy, memory[at], size);
          if (slip_destroy(copy) != SLIP_STATUS_NOT_CREATED) fail("a copy was taken for a pipeline");
          free(copy);
        } break;
      case 6: if (one_in(4)) { /* ended twice, and used after */
          slip_pipeline *ended = made[at];
          made[at] = NULL;
          count(slip_destroy(ended));
          if (ended != NULL && slip_destroy(ended) != SLIP_STATUS_NOT_CREATED) fail("ended twice");
        } break;
      default: push(at);
    }
  }
  for (i = 0; i < 4; ++i) if (made[i] != NULL) count(slip_destroy(made[i]));
  printf("%lu calls:", calls);
  for (i = 0; i <= SLIP_STATUS_PANICKED; ++i) printf(" %lu %s%s", counts[i], slip_error_text((int32_t)i), i < SLIP_STATUS_PANICKED ? "," : "\n");
  return counts[SLIP_STATUS_OK] < calls / 3;
}
