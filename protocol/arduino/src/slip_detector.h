/* Readings of one vibration sensor in, quiet / incipient / gross out: the detector of slip-core for a still gripper, in C99.
 *
 * The bands of slip-core that decide while the robot stands still (20-400, 100-800, 250-700, 700-3000 Hz, as far as the rate
 * carries them), its noise floor, its sum in seconds and hysteresis, in f32, with the same operations in the same order. What needs more
 * than one sensor is left out: while the arm moves it alarms where slip-core knows better. So feed it while the arm rests.
 *
 * No heap, no clock, no port. Calls sqrtf, roundf and, from sd_init alone, tan, exp and ceilf. Built without contraction of
 * products and sums (-ffp-contract=off) it gives the states of slip-core bit by bit where the mathematics library does. Not for
 * interrupts and loop at once. */
#ifndef SLIP_DETECTOR_H
#define SLIP_DETECTOR_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SD_BANDS 4u
#define SD_PARTS 16u /* parts of the floor, whose median it is */
#define SD_BLOCK 25u /* readings of the longest block */

typedef enum {
    SD_LEARNING,  /* the noise floor is not known yet: 0.2 s of rest, longer at low rates */
    SD_QUIET,     /* nothing above the noise */
    SD_INCIPIENT, /* movement without sliding, or before it */
    SD_GROSS      /* the object slides */
} sd_state;

/* A Butterworth section of second order, and its memory. */
typedef struct {
    float a1, a2, a3, ic1, ic2;
} sd_section;

/* The last readings, in turn, from which isolated wrong ones are distinguished. */
typedef struct {
    float outputs[4], first, usual; /* first: of those held back; usual: mean step */
    uint8_t at, quiet, held, most, seen;
    bool started;
} sd_guard;

/* All of it is the detector's own. */
typedef struct {
    struct {
        sd_section high, low;
        bool used;
        float slope, offset, evidence_s;             /* of the log-likelihood of a block; evidence of a slip (s) */
        float weight, scale, energy;                 /* of the mean energy; reciprocal rms of the floor; mean energy over the floor */
        float floor, measured, sum, parts[SD_PARTS]; /* noise energy; the same without rounding; of the part, of all parts */
    } bands[SD_BANDS];
    float readings[SD_BLOCK]; /* of the block that is being filled */
    uint16_t block_len, filled;
    uint32_t prime_len, priming; /* readings whose mean becomes the zero of the filters */
    float first, prime_sum, offset;
    float configured, least; /* noise energy that is believed at least: as configured, and with what rounding adds */
    float last, step;        /* of the resolution: the reading before and the smallest step so far */
    bool has_last, has_step, learning;
    uint32_t steps, odd, same;
    uint32_t part_len, later_len, in_part, done;
    sd_state state;
    float block_s, share, statistic;
    uint32_t release_len, quiet_run;
    sd_guard guard;
} sd_detector;

/* A detector that begins to learn its floor. `rate_hz`: of the readings, 65 to 50,000. `min_rms`: the smallest noise that is believed, in the unit of
 * the readings (any); 0 leaves it to the steps between them. False, and nothing is set, where the rate or the noise is out of range. */
bool sd_init(sd_detector *d, float rate_hz, float min_rms);

/* Takes the next reading, in any unit; one that is no number, or 1e15 or more, is left out. From 1 kHz on one that leaps out of a quiet
 * stretch is held back until the next shows whether it was a wrong one, from 10 kHz on a pair of them. The state changes at the end of a block (0.5 ms, or each reading below 2 kHz). */
sd_state sd_step(sd_detector *d, float reading);

/* Evidence of the last block over the wanted time between false alarms, 600 s: 1 and above is a slip. */
float sd_statistic(const sd_detector *d);

/* Noise of a band (rms, unit of the readings), 0 to SD_BANDS - 1; 0 while it is unknown or where the rate does not carry the band. */
float sd_noise(const sd_detector *d, unsigned band);

/* Begins again with the next reading, for example after a gap or a move of the arm: the floor stays, where it is known. */
void sd_restart(sd_detector *d);

#ifdef __cplusplus
}
#endif

#endif
