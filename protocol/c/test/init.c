/* gl_init: what it refuses, by which reason, and the last values it takes. */
#include "peer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures;

/* One line a case. A refused link is left as it was. */
static void judge(const char *name, const gl_ident *id, gl_init_error wanted) {
  static const char *const words[] = {"ok", "tick rate", "limits", "no stylus", "row"};
  static gl_link link, before;
  gl_init_error found;
  memset(&link, 0x5A, sizeof link);
  before = link;
  found = gl_init(&link, id);
  if (found != wanted || (found != GL_INIT_OK && memcmp(&link, &before, sizeof link) != 0)) {
    fprintf(stderr, "%s: %s instead of %s, or the link was touched\n", name, words[found], words[wanted]);
    failures++;
  }
  printf("%s: %s\n", name, words[found]);
}

/* The reference gripper with a change; what lies behind its channels is a good channel too. */
#define CASE(name, wanted, ...)               \
  do {                                        \
    struct {                                  \
      gl_ident id;                            \
      gl_channel behind;                      \
    } given;                                  \
    gl_ident *id = &given.id;                 \
    given.id = peer_gripper();                \
    given.behind = given.id.channels[0];      \
    __VA_ARGS__;                              \
    judge(name, id, wanted);                  \
  } while (0)

static void channels(gl_ident *id, unsigned count) {
  for (unsigned i = 1; i < GL_CHANNELS; i++) id->channels[i] = id->channels[0];
  id->channel_count = (uint8_t)count;
}

/* The exit code. */
int peer_init(void) {
  CASE("the reference gripper", GL_INIT_OK, (void)0);
  CASE("tick rate 999", GL_INIT_TICK_RATE, id->tick_hz = 999);
  CASE("tick rate 1000", GL_INIT_OK, id->tick_hz = 1000);
  CASE("tick rate 0", GL_INIT_TICK_RATE, id->tick_hz = 0);
  CASE("sample rate 0", GL_INIT_LIMITS, id->rate_max_hz = 0);
  CASE("F_max 0: no actuator", GL_INIT_OK, id->force_max_mn = id->hold_cap_mn = 0);
  CASE("F_max -1", GL_INIT_LIMITS, id->force_max_mn = -1);
  CASE("slew 0", GL_INIT_LIMITS, id->slew_max_mn_s = 0);
  CASE("hold cap -1", GL_INIT_LIMITS, id->hold_cap_mn = -1);
  CASE("hold cap 0", GL_INIT_OK, id->hold_cap_mn = 0);
  CASE("hold cap = F_max", GL_INIT_OK, id->hold_cap_mn = id->force_max_mn);
  CASE("hold cap > F_max", GL_INIT_LIMITS, id->hold_cap_mn = id->force_max_mn + 1);
  CASE("no channels", GL_INIT_NO_STYLUS, id->channel_count = 0);
  CASE("a second stylus only", GL_INIT_NO_STYLUS, id->channels[0].kind = GL_SECOND_STYLUS, id->channel_count = 1);
  CASE("taxels without a stylus", GL_INIT_OK, id->channels[0].kind = GL_NORMAL_FORCE);
  CASE("a travel alone", GL_INIT_OK, id->channels[0].kind = GL_TRAVEL, id->channel_count = 1);
  CASE("stylus as the last channel", GL_INIT_OK, id->channels[0].kind = GL_NORMAL_FORCE, id->channels[2].kind = GL_STYLUS);
  CASE("as many channels as there is room for", GL_INIT_OK, channels(id, GL_CHANNELS));
  CASE("more channels than there is room for", GL_INIT_ROW, channels(id, GL_CHANNELS + 1));
  CASE("a channel of 0 elements", GL_INIT_ROW, id->channels[1].count = 0);
  CASE("a channel of 64 elements", GL_INIT_OK, id->channels[2].count = 64);
  CASE("a channel of 65 elements", GL_INIT_ROW, id->channels[2].count = 65);
  CASE("scale 0", GL_INIT_ROW, id->channels[1].scale = 0.0f);
  CASE("scale -1", GL_INIT_ROW, id->channels[1].scale = -1.0f);
  CASE("scale NaN", GL_INIT_ROW, id->channels[1].scale = NAN);
  CASE("scale infinite", GL_INIT_ROW, id->channels[1].scale = INFINITY);
  /* 115 elements of four bytes are the 460 bytes of a batch. */
  CASE("a row that fills a batch", GL_INIT_OK, id->channels[1].count = 64, id->channels[2].count = 50);
  CASE("a row over a batch", GL_INIT_ROW, id->channels[1].count = 64, id->channels[2].count = 51);
  return failures > 0;
}
