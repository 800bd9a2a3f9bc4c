/* What the parts of the test program share. */
#ifndef PEER_H
#define PEER_H

#include "../grip_link.h"

#define PEER_LINE (1u << 20)

/* Hex digits in, bytes out; returns how many. Ends the program on anything else. */
size_t peer_unhex(const char *text, uint8_t *out, size_t room);
void peer_print_hex(const uint8_t *bytes, size_t len);
/* Cuts a line at `separator`; returns the parts, at most `most`. */
size_t peer_split(char *line, char separator, char **parts, size_t most);
const char *peer_word(gl_verdict verdict);
/* The gripper of the vector "ident". */
gl_ident peer_gripper(void);
void peer_fail(const char *what, const char *where);

int peer_vectors(const char *folder);
int peer_init(void);
int peer_decode(void);
int peer_device(void);

#endif
