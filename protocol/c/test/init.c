/* gl_init: what it refuses, by which reason, and the last values it takes. */
#include "peer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct {
  const char *name;
  void (*change)(gl_ident *);
  gl_init_error wanted;
} refusal;

static void nothing(gl_ident *id) { (void)id; }
static void tick_999(gl_ident *id) { id->tick_hz = 999; }
static void tick_1000(gl_ident *id) { id->tick_hz = 1000; }
static void tick_0(gl_ident *id) { id->tick_hz = 0; }
static void rate_0(gl_ident *id) { id->rate_max_hz = 0; }
static void force_0(gl_ident *id) { id->force_max_mn = id->hold_cap_mn = 0; }
static void force_negative(gl_ident *id) { id->force_max_mn = -1; }
static void slew_0(gl_ident *id) { id->slew_max_mn_s = 0; }
static void cap_negative(gl_ident *id) { id->hold_cap_mn = -1; }
static void cap_0(gl_ident *id) { id->hold_cap_mn = 0; }
static void cap_equal(gl_ident *id) { id->hold_cap_mn = id->force_max_mn; }
static void cap_over(gl_ident *id) { id->hold_cap_mn = id->force_max_mn + 1; }
static void channels_none(gl_ident *id) { id->channel_count = 0; }
/* All good, and so is what lies behind the last. */
static void channels_many(gl_ident *id) {
  for (unsigned i = 1; i < GL_CHANNELS; i++) id->channels[i] = id->channels[0];
  id->channel_count = GL_CHANNELS + 1;
}
static void channels_all(gl_ident *id) {
  channels_many(id);
  id->channel_count = GL_CHANNELS;
}
static void second_stylus(gl_ident *id) { id->channels[0].kind = GL_SECOND_STYLUS, id->channel_count = 1; }
static void taxels(gl_ident *id) { id->channels[0].kind = GL_NORMAL_FORCE; }
static void travel(gl_ident *id) { id->channels[0].kind = GL_TRAVEL, id->channel_count = 1; }
static void stylus_last(gl_ident *id) {
  id->channels[0].kind = GL_NORMAL_FORCE;
  id->channels[2].kind = GL_STYLUS;
}
static void count_0(gl_ident *id) { id->channels[1].count = 0; }
static void count_64(gl_ident *id) { id->channels[2].count = 64; }
static void count_65(gl_ident *id) { id->channels[2].count = 65; }
static void scale_0(gl_ident *id) { id->channels[1].scale = 0.0f; }
static void scale_negative(gl_ident *id) { id->channels[1].scale = -1.0f; }
static void scale_nan(gl_ident *id) { id->channels[1].scale = NAN; }
static void scale_infinite(gl_ident *id) { id->channels[1].scale = INFINITY; }
/* 115 elements of four bytes are the 460 bytes of a batch. */
static void row_full(gl_ident *id) { id->channels[1].count = 64, id->channels[2].count = 50; }
static void row_over(gl_ident *id) { id->channels[1].count = 64, id->channels[2].count = 51; }

static const refusal TABLE[] = {
    {"the reference gripper", nothing, GL_INIT_OK},
    {"tick rate 999", tick_999, GL_INIT_TICK_RATE},
    {"tick rate 1000", tick_1000, GL_INIT_OK},
    {"tick rate 0", tick_0, GL_INIT_TICK_RATE},
    {"sample rate 0", rate_0, GL_INIT_LIMITS},
    {"F_max 0: no actuator", force_0, GL_INIT_OK},
    {"F_max -1", force_negative, GL_INIT_LIMITS},
    {"slew 0", slew_0, GL_INIT_LIMITS},
    {"hold cap -1", cap_negative, GL_INIT_LIMITS},
    {"hold cap 0", cap_0, GL_INIT_OK},
    {"hold cap = F_max", cap_equal, GL_INIT_OK},
    {"hold cap > F_max", cap_over, GL_INIT_LIMITS},
    {"no channels", channels_none, GL_INIT_NO_STYLUS},
    {"a second stylus only", second_stylus, GL_INIT_NO_STYLUS},
    {"taxels without a stylus", taxels, GL_INIT_OK},
    {"a travel alone", travel, GL_INIT_OK},
    {"stylus as the last channel", stylus_last, GL_INIT_OK},
    {"as many channels as there is room for", channels_all, GL_INIT_OK},
    {"more channels than there is room for", channels_many, GL_INIT_ROW},
    {"a channel of 0 elements", count_0, GL_INIT_ROW},
    {"a channel of 64 elements", count_64, GL_INIT_OK},
    {"a channel of 65 elements", count_65, GL_INIT_ROW},
    {"scale 0", scale_0, GL_INIT_ROW},
    {"scale -1", scale_negative, GL_INIT_ROW},
    {"scale NaN", scale_nan, GL_INIT_ROW},
    {"scale infinite", scale_infinite, GL_INIT_ROW},
    {"a row that fills a batch", row_full, GL_INIT_OK},
    {"a row over a batch", row_over, GL_INIT_ROW},
};

/* One line a case; the exit code. A refused link is left as it was. */
int peer_init(void) {
  static const char *const words[] = {"ok", "tick rate", "limits", "no stylus", "row"};
  static gl_link link, before;
  int failures = 0;
  for (size_t i = 0; i < sizeof TABLE / sizeof TABLE[0]; i++) {
    struct {
      gl_ident id;
      gl_channel behind;
    } given;
    gl_init_error found;
    memset(&link, 0x5A, sizeof link);
    before = link;
    given.id = peer_gripper();
    given.behind = given.id.channels[0];
    TABLE[i].change(&given.id);
    found = gl_init(&link, &given.id);
    if (found != TABLE[i].wanted || (found != GL_INIT_OK && memcmp(&link, &before, sizeof link) != 0)) {
      fprintf(stderr, "%s: %s instead of %s, or the link was touched\n", TABLE[i].name, words[found], words[TABLE[i].wanted]);
      failures++;
    }
    printf("%s: %s\n", TABLE[i].name, words[found]);
  }
  return failures > 0;
}
