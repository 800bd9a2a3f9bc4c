/* memcpy and memset, which the compiler may also call by itself. Built without the loop-to-call optimisation. */
#include <string.h>

void *memcpy(void *restrict to, const void *restrict from, size_t len) {
  unsigned char *out = to;
  const unsigned char *in = from;
  while (len-- > 0) *out++ = *in++;
  return to;
}

void *memset(void *to, int value, size_t len) {
  unsigned char *out = to;
  while (len-- > 0) *out++ = (unsigned char)value;
  return to;
}
