/* The sizes of the library's types as sizes of symbols, for a target that cannot run here: see scripts/firmware-check.sh. */
#include "grip_link.h"

const char gl_link_bytes[sizeof(gl_link)] = {0};
const char gl_batches_bytes[sizeof(gl_batches)] = {0};
const char gl_decoder_bytes[sizeof(gl_decoder)] = {0};
const char gl_ident_bytes[sizeof(gl_ident)] = {0};
