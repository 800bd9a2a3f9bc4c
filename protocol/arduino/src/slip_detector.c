#include "slip_detector.h"

#include <math.h>
#include <string.h>

#define BLOCK_S 5e-4f
#define MAX_CORNER 0.4f /* of the rate */
#define LOWERED 0.25f   /* lower corner of a band that had to be lowered, of the highest corner */
#define PRIME_MS 2.0f
#define LEARN_MS 200.0f
#define LATER_MS 1000.0f
#define LOWER_BELOW 0.4f
#define ENVELOPE_S 5e-3f
#define MEAN_READINGS 6.0f
#define PART_READINGS 4.0f
#define GROSS 25.0f
#define RELEASE_MS 50.0f

/* The sum: wanted time between false alarms (s), rise that is looked for, most log-likelihood of a block, most evidence that
 * is remembered and least that a slip has, both over that time. */
#define INTERVAL_S 600.0f
#define RATIO 6.0f
#define LOG_RATIO 1.7917595f
#define CLIP 5.0f
#define MOST 7.389056f
#define GONE 0.002478752f

#define TINY 1e-18f
#define HUGE_READING 1e15f /* squares of what is larger are no numbers any more */
#define ROOT_2 1.41421356237309504880
#define PI 3.14159265358979323846

/* Rounding of a sensor: steps that make it known, and which of them are no multiples of the smallest one. */
#define KNOWN 64u
#define ODD 0.1f
#define MULTIPLES 30.0f
#define MOST_ODD 8u
#define ROUNDING 0.28867513f

/* Isolated wrong readings: a step of so many usual ones leaps, readings between two that are held back, steps that make the usual one
 * known, those before one is bounded, how many times the mean one may count and its weight, and the rates from which one reading and
 * two are held back (Hz). */
#define LEAP 6.0f
#define LEAP_QUIET 4u
#define LEAP_KNOWN 64u
#define LEAP_BOUNDED 8u
#define LEAP_MOST 3.0f
#define LEAP_WEIGHT (1.0f / 256.0f)
#define SINGLE_HZ 1e3f
#define PAIR_HZ 1e4f

/* The bands that decide at rest: shear and vibration, which every rate carries in some place, and the two highest octaves. */
static const struct {
    float low_hz, high_hz, slack;
} BANDS[SD_BANDS] = {{20, 400, 4}, {100, 800, 3}, {250, 700, 3}, {700, 3000, 3}};
#define MOVABLE 2u

static uint32_t samples(float ms, float rate_hz) {
    const float n = ceilf(1e-3f * ms * rate_hz);
    return n < 1.0f ? 1u : n > 1e9f ? 1000000000u : (uint32_t)n;
}

static uint32_t part_len(float ms, float blocks_hz) {
    const float n = ms * 1e-3f * blocks_hz / 16.0f;
    return n < 1.0f ? 1u : n > 1e6f ? 1000000u : (uint32_t)n;
}

static void section(sd_section *s, float corner_hz, float rate_hz) {
    const double g = tan(PI * (double)corner_hz / (double)rate_hz);
    const double a1 = 1.0 / (1.0 + g * (g + ROOT_2));
    s->a1 = (float)a1;
    s->a2 = (float)(g * a1);
    s->a3 = (float)(g * g * a1);
}

/* Gives the low-pass part; `band` is the band-pass part. */
static float low_of(sd_section *s, float x, float *band) {
    const float v3 = x - s->ic2;
    const float v1 = s->a1 * s->ic1 + s->a2 * v3;
    const float v2 = s->ic2 + s->a2 * s->ic1 + s->a3 * v3;
    s->ic1 = 2.0f * v1 - s->ic1;
    s->ic2 = 2.0f * v2 - s->ic2;
    *band = v1;
    return v2;
}

static void flush_tiny(sd_section *s) {
    if (fabsf(s->ic1) < TINY) s->ic1 = 0.0f;
    if (fabsf(s->ic2) < TINY) s->ic2 = 0.0f;
}

bool sd_init(sd_detector *d, float rate_hz, float min_rms) {
    if (!(rate_hz >= 65.0f && rate_hz <= 5e4f && min_rms >= 0.0f && min_rms <= 1e18f)) return false;
    memset(d, 0, sizeof *d);
    const float limit_hz = MAX_CORNER * rate_hz;
    const uint32_t block_len = samples(1e3f * BLOCK_S * 0.999f, rate_hz);
    d->block_len = (uint16_t)(block_len < SD_BLOCK ? block_len : SD_BLOCK);
    const float block_s = (float)d->block_len / rate_hz, blocks_hz = 1.0f / block_s;
    float least = INFINITY, used = 0.0f;
    for (unsigned b = 0; b < SD_BANDS; b++) {
        float low_hz = BANDS[b].low_hz, high_hz = BANDS[b].high_hz, tau_s = ENVELOPE_S;
        d->bands[b].used = low_hz < 0.8f * MAX_CORNER * rate_hz;
        if (!d->bands[b].used) {
            if (b >= MOVABLE) continue;
            low_hz = LOWERED * limit_hz;
            high_hz = limit_hz;
            d->bands[b].used = true;
        }
        if (high_hz > limit_hz) high_hz = limit_hz;
        section(&d->bands[b].high, low_hz, rate_hz);
        section(&d->bands[b].low, high_hz, rate_hz);
        const float readings = 2.0f * (high_hz - low_hz) * block_s;
        if (b < MOVABLE) {
            const float least_s = 0.5f * MEAN_READINGS / (readings / block_s);
            if (least_s > tau_s) tau_s = least_s;
            if (readings < least) least = readings;
        }
        /* An AVR has no expm1f. */
        d->bands[b].weight = (float)(1.0 - exp(-(double)(block_s / tau_s)));
        d->bands[b].slope = 0.5f * readings * (1.0f - 1.0f / RATIO) / BANDS[b].slack;
        d->bands[b].offset = 0.5f * readings * LOG_RATIO;
        used += 1.0f;
        d->bands[b].scale = d->bands[b].energy = 1.0f;
    }
    d->block_s = block_s;
    d->share = 1.0f / used;
    const uint32_t part = samples(1e3f, PART_READINGS / least);
    d->part_len = part_len(LEARN_MS, blocks_hz);
    d->later_len = part_len(LATER_MS, blocks_hz);
    if (d->part_len < part) d->part_len = part;
    if (d->later_len < part) d->later_len = part;
    d->configured = d->least = min_rms * min_rms;
    d->prime_len = samples(PRIME_MS, rate_hz);
    d->release_len = samples(RELEASE_MS, blocks_hz);
    d->learning = true;
    d->guard.most = (uint8_t)((rate_hz >= SINGLE_HZ) + (rate_hz >= PAIR_HZ));
    sd_restart(d);
    return true;
}

void sd_restart(sd_detector *d) {
    for (unsigned b = 0; b < SD_BANDS; b++) {
        d->bands[b].energy = 1.0f;
        d->bands[b].evidence_s = 0.0f;
        d->bands[b].sum = 0.0f;
    }
    d->priming = d->prime_len;
    d->filled = 0;
    d->in_part = 0;
    if (d->learning) d->done = 0;
    d->quiet_run = 0;
    d->statistic = 0.0f;
    d->state = d->learning ? SD_LEARNING : SD_QUIET;
    d->guard.started = false;
}

static void learn_step(sd_guard *g, float step) {
    if (step == 0.0f) return;
    const float most = g->seen < LEAP_BOUNDED ? step : LEAP_MOST * g->usual;
    if (g->seen < LEAP_KNOWN) g->seen++;
    const float change = (step < most ? step : most) - g->usual;
    g->usual += g->seen < LEAP_KNOWN ? change / (float)g->seen : LEAP_WEIGHT * change;
}

/* The reading, or the mean of the last four outputs while it may be an isolated wrong one. In a slip every reading counts. */
static float guarded(sd_guard *g, float x, bool slips) {
    if (!g->started) {
        for (unsigned i = 0; i < 4; i++) g->outputs[i] = x;
        g->quiet = LEAP_QUIET;
        g->held = 0;
        g->started = true;
    }
    const float last = g->outputs[g->at], step = fabsf(x - last);
    const bool leaps = g->seen >= LEAP_KNOWN && step > LEAP * g->usual;
    learn_step(g, step);
    bool holds = leaps && !slips && g->held < g->most;
    if (holds) holds = g->held == 0 ? g->quiet >= LEAP_QUIET : fabsf(x - g->first) < fabsf(g->first - last);
    if (holds && g->held == 0) g->first = x;
    g->held = holds ? (uint8_t)(g->held + 1u) : 0u;
    if (leaps) g->quiet = 0;
    else if (g->quiet < LEAP_QUIET) g->quiet++;
    const float mean = 0.25f * ((g->outputs[0] + g->outputs[1]) + (g->outputs[2] + g->outputs[3]));
    g->at = (uint8_t)((g->at + 1u) & 3u);
    g->outputs[g->at] = holds ? mean : x;
    return g->outputs[g->at];
}

static void prime(sd_detector *d, float x) {
    if (d->priming == d->prime_len) {
        d->first = x;
        d->prime_sum = 0.0f;
    }
    d->prime_sum += x - d->first;
    if (--d->priming > 0) return;
    d->offset = d->first + d->prime_sum / (float)d->prime_len;
    for (unsigned b = 0; b < SD_BANDS; b++) {
        sd_section *sections[] = {&d->bands[b].high, &d->bands[b].low};
        for (unsigned s = 0; s < 2; s++) sections[s]->ic1 = sections[s]->ic2 = 0.0f;
    }
}

/* Whatever is in units of the floor is so with the new one. */
static void rescale(sd_detector *d) {
    for (unsigned b = 0; b < SD_BANDS; b++)
        if (d->bands[b].used) d->bands[b].scale = 1.0f / sqrtf(d->bands[b].floor);
    if (d->learning) d->state = SD_QUIET;
    d->learning = false;
}

/* The noise that rounding to the sensor's own steps makes, from the readings of this block. */
static void resolve(sd_detector *d) {
    for (unsigned i = 0; i < d->filled; i++) {
        const float x = d->readings[i], step = fabsf(x - d->last);
        const bool differs = step > 0.0f;
        if (d->has_last && !differs) d->same++;
        if (d->has_last && differs) {
            d->steps++;
            const float multiple = !d->has_step ? INFINITY : step > d->step ? step / d->step : d->step / step;
            if (multiple < MULTIPLES && fabsf(multiple - roundf(multiple)) > ODD) d->odd++;
            if (!d->has_step || step < d->step) {
                if (!d->has_step || step < 0.9f * d->step) d->odd = 0;
                d->step = step;
                d->has_step = true;
            }
        }
        d->last = x;
        d->has_last = true;
    }
    const bool coarse = d->steps > 0 && d->same > d->steps && MOST_ODD * d->odd <= d->steps;
    const float rms = d->has_step ? ROUNDING * d->step : 0.0f;
    const float rounding = coarse || d->configured == 0.0f ? rms * rms : 0.0f;
    d->least = d->configured > rounding ? d->configured : rounding;
    if (d->learning) return;
    bool changed = false;
    for (unsigned b = 0; b < SD_BANDS; b++) {
        const float floor = d->bands[b].measured > d->least ? d->bands[b].measured : d->least;
        changed = changed || (d->bands[b].used && floor != d->bands[b].floor);
        d->bands[b].floor = floor;
    }
    if (changed) rescale(d);
}

static float median(const float parts[SD_PARTS]) {
    float sorted[SD_PARTS];
    for (unsigned i = 0; i < SD_PARTS; i++) {
        unsigned at = i;
        for (; at > 0 && sorted[at - 1] > parts[i]; at--) sorted[at] = sorted[at - 1];
        sorted[at] = parts[i];
    }
    return 0.5f * (sorted[SD_PARTS / 2 - 1] + sorted[SD_PARTS / 2]);
}

/* Takes the energies of a block, over the floor where that is known. */
static void learn(sd_detector *d, const float energy[SD_BANDS]) {
    for (unsigned b = 0; b < SD_BANDS; b++) d->bands[b].sum += d->learning ? energy[b] : energy[b] * d->bands[b].floor;
    if (++d->in_part < d->part_len) return;
    const float per_block = 1.0f / (float)d->in_part;
    for (unsigned b = 0; b < SD_BANDS; b++) {
        d->bands[b].parts[d->done] = d->bands[b].sum * per_block;
        d->bands[b].sum = 0.0f;
    }
    d->in_part = 0;
    if (++d->done < SD_PARTS) return;
    d->done = 0;
    /* One and the same reading: a sensor that shows nothing yet. */
    if (d->least == 0.0f) return;
    d->part_len = d->later_len;
    bool changed = false;
    for (unsigned b = 0; b < SD_BANDS; b++) {
        const float shown = median(d->bands[b].parts), measured = shown > d->least ? shown : d->least;
        if (!d->bands[b].used || !(d->learning || measured < LOWER_BELOW * d->bands[b].floor)) continue;
        d->bands[b].floor = measured;
        d->bands[b].measured = shown;
        changed = true;
    }
    if (changed) rescale(d);
}

/* e^x for x up to 80, as slip-core has it. */
static float exponential(float x) {
    const float round = 12582912.0f; /* adding and taking it off rounds to the nearest whole number */
    if (x < -80.0f) x = -80.0f;
    const float shifted = x * 1.44269504f + round;
    const float y = x - (shifted - round) * 0.693147181f;
    const float series = 1.0f + y * (1.0f + y * (0.5f + y * (1.0f / 6.0f + y * (1.0f / 24.0f + y * (1.0f / 120.0f + y * (1.0f / 720.0f))))));
    uint32_t bits, zero;
    float power;
    memcpy(&bits, &shifted, sizeof bits);
    memcpy(&zero, &round, sizeof zero);
    bits = (bits - zero + 127u) << 23;
    memcpy(&power, &bits, sizeof power);
    return series * power;
}

static void decide(sd_detector *d, const float energy[SD_BANDS]) {
    float sum_s = 0.0f, sliding = 0.0f;
    for (unsigned b = 0; b < SD_BANDS; b++) {
        if (!d->bands[b].used) continue;
        d->bands[b].energy += d->bands[b].weight * (energy[b] - d->bands[b].energy);
        if (b > 0 && d->bands[b].energy > sliding) sliding = d->bands[b].energy;
        float gain = d->bands[b].slope * energy[b] - d->bands[b].offset;
        if (gain > CLIP) gain = CLIP;
        const float evidence_s = exponential(gain) * (d->bands[b].evidence_s + d->block_s);
        sum_s += d->share * evidence_s;
        d->bands[b].evidence_s = evidence_s < MOST * INTERVAL_S ? evidence_s : MOST * INTERVAL_S;
    }
    d->statistic = sum_s / INTERVAL_S;
    if (d->statistic >= 1.0f) {
        d->quiet_run = 0;
        if (sliding > GROSS) d->state = SD_GROSS;
        else if (d->state == SD_QUIET) d->state = SD_INCIPIENT;
    } else if (d->statistic >= GONE) {
        d->quiet_run = 0;
    } else {
        d->quiet_run += d->quiet_run < UINT32_MAX;
        if (d->quiet_run >= d->release_len) d->state = SD_QUIET;
    }
}

static void end_block(sd_detector *d) {
    if (d->learning || d->steps < KNOWN) resolve(d);
    const float per_sample = 1.0f / (float)d->block_len;
    float energy[SD_BANDS] = {0};
    for (unsigned b = 0; b < SD_BANDS; b++) {
        if (!d->bands[b].used) continue;
        sd_section *high = &d->bands[b].high, *low = &d->bands[b].low;
        for (unsigned i = 0; i < d->filled; i++) {
            const float x = d->readings[i] - d->offset;
            float band, rest;
            const float below = low_of(high, x, &band);
            const float scaled = low_of(low, x - (float)ROOT_2 * band - below, &rest) * d->bands[b].scale;
            energy[b] += scaled * scaled;
        }
        flush_tiny(high);
        flush_tiny(low);
        energy[b] *= per_sample;
    }
    d->filled = 0;
    if (!d->learning) decide(d, energy);
    learn(d, energy);
}

sd_state sd_step(sd_detector *d, float reading) {
    if (!(fabsf(reading) < HUGE_READING)) return d->state;
    reading = guarded(&d->guard, reading, d->state > SD_QUIET);
    if (d->priming > 0) {
        prime(d, reading);
        return d->state;
    }
    d->readings[d->filled++] = reading;
    if (d->filled >= d->block_len) end_block(d);
    return d->state;
}

float sd_statistic(const sd_detector *d) { return d->statistic; }

float sd_noise(const sd_detector *d, unsigned band) {
    return band < SD_BANDS && d->bands[band].used && !d->learning ? sqrtf(d->bands[band].floor) : 0.0f;
}
