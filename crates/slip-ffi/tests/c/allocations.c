/* Counts what the library asks of the heap: something to create a pipeline, nothing from then on, and all of it comes
 * back. */
#include <slip.h>
#include <stdio.h>
#include <string.h>

/* Linked with -Wl,--wrap of each. */
void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *pointer, size_t size);
int __real_posix_memalign(void **pointer, size_t align, size_t size);
void __real_free(void *pointer);
static long asked, living;
void *__wrap_malloc(size_t size) { ++asked; ++living; return __real_malloc(size); }
void *__wrap_calloc(size_t n, size_t size) { ++asked; ++living; return __real_calloc(n, size); }
void *__wrap_realloc(void *pointer, size_t size) { ++asked; living += pointer == NULL; return __real_realloc(pointer, size); }
int __wrap_posix_memalign(void **pointer, size_t align, size_t size) {
  ++asked; ++living;
  return __real_posix_memalign(pointer, align, size);
}
void __wrap_free(void *pointer) { living -= pointer != NULL; __real_free(pointer); }

int main(void) {
  static union { uint64_t aligned; unsigned char bytes[1 << 18]; } memory;
  static float stylus[20000], force[20000];
  slip_options options = {0};
  slip_pipeline *pipeline = NULL;
  slip_event events[64];
  slip_block block = {0};
  slip_result result = {0};
  size_t at, found = 0;
  uint32_t bits = 3000;
  long at_first, after;
  if (slip_size() > sizeof memory || slip_align() > 8) return 2;
  options.rate_hz = 10000;
  options.control = 1;
  for (at = 0; at < 20000; ++at) {
    bits = bits * 1664525u + 1013904223u;
    stylus[at] = (at > 12000 && at < 14000 ? 5e-6f : 5e-8f) * ((float)(bits >> 16) / 32768 - 1);
    force[at] = at < 1000 ? 0 : 2;
  }
  if (slip_create(memory.bytes, slip_size(), &options, NULL, 0, &pipeline) != SLIP_STATUS_OK) return 2;
  at_first = asked;
  for (at = 0; at < 20000; at += 10) {
    block.rows = 10;
    block.stylus = stylus + at;
    block.normal_force_n = force + at;
    result.events = events;
    result.room = 64;
    if (slip_push(pipeline, &block, &result) != SLIP_STATUS_OK) return 2;
    found += result.found;
    if (slip_push(pipeline, NULL, &result) != SLIP_STATUS_NULL || slip_command(pipeline, 99, 0) != SLIP_STATUS_VALUE) return 2;
  }
  after = asked - at_first;
  if (slip_destroy(pipeline) != SLIP_STATUS_OK) return 2;
  printf("%ld allocations to create, %ld in 20000 samples with %zu events, %ld not freed; %zu bytes of memory\n", at_first, after,
         found, living, slip_size());
  return at_first == 0 || after != 0 || living != 0 || found == 0;
}
