/* Slips in a recording: numbers on standard input, a row a line, the vibration in the second column (t_s,vibration,..).
 *
 *   detect RATE_HZ < recording.csv
 */
#include <math.h>
#include <slip.h>
#include <stdio.h>
#include <stdlib.h>

enum { ROWS = 100, EVENTS = 16 };

static void print_event(const slip_event *event) {
  double t_s = 1e-6 * (double)event->t_us;
  if (event->kind != SLIP_EVENT_KIND_SLIP) return;
  if (event->phase == SLIP_PHASE_ENDED) {
    printf("%.6f s  slip ended after %.1f ms\n", t_s, 1e3 * event->duration_s);
  } else {
    printf("%.6f s  slip (%s, %s), statistic %.1f\n", t_s, event->phase == SLIP_PHASE_GROSS ? "gross" : "incipient",
           event->method == SLIP_METHOD_STYLUS ? "stylus" : "other sensor", (double)event->statistic);
  }
}

int main(int argc, char **argv) {
  slip_options options = {0};
  options.rate_hz = argc > 1 ? strtof(argv[1], NULL) : NAN;
  options.signal = SLIP_SIGNAL_VIBRATION;

  void *memory = malloc(slip_size());
  slip_pipeline *pipeline = NULL;
  char why[200] = "";
  slip_status status = slip_create(memory, slip_size(), &options, why, sizeof why, &pipeline);
  if (status != SLIP_STATUS_OK) {
    fprintf(stderr, "detect: %s: %s\n", slip_error_text(status), why);
    free(memory);
    return 1;
  }

  char line[4096];
  int more = fgets(line, sizeof line, stdin) != NULL; /* names of the columns */
  while (more) {
    uint64_t t_us[ROWS];
    float vibration[ROWS];
    slip_block block = {0};
    while (block.rows < ROWS && (more = fgets(line, sizeof line, stdin) != NULL)) {
      char *rest;
      t_us[block.rows] = (uint64_t)(1e6 * strtod(line, &rest) + 0.5);
      vibration[block.rows++] = strtof(rest + (*rest == ','), NULL);
    }
    block.t_us = t_us;
    block.stylus = vibration;

    slip_event events[EVENTS];
    slip_result result = {0};
    result.events = events;
    result.room = EVENTS;
    status = slip_push(pipeline, &block, &result);
    if (status != SLIP_STATUS_OK) break;
    for (size_t i = 0; i < result.found && i < EVENTS; ++i) print_event(&events[i]);
  }
  if (status != SLIP_STATUS_OK) fprintf(stderr, "detect: %s\n", slip_error_text(status));
  slip_destroy(pipeline);
  free(memory);
  return status != SLIP_STATUS_OK;
}
