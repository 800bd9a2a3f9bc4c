// Slip detection and grip force in your program; the guide is docs/c.md.
// Made by crates/slip-ffi/tests/header.rs: change it there.

#ifndef SLIP_H
#define SLIP_H

#include <stddef.h>
#include <stdint.h>

// Scene
enum {
  // nothing is held.
  SLIP_SCENE_IDLE = 0,
  // arm or fingers move: own vibration, no decision on slip.
  SLIP_SCENE_MOVING = 1,
  // an object is held.
  SLIP_SCENE_HOLDING = 2,
  // an object slips.
  SLIP_SCENE_SLIPPING = 3,
};

// GripState
enum {
  // there is none: the pipeline only observes.
  SLIP_GRIP_STATE_OBSERVING = 0,
  // fingers open, no force.
  SLIP_GRIP_STATE_OPEN = 1,
  // the force rises to the trial force.
  SLIP_GRIP_STATE_CLOSING = 2,
  // the trial force stands; contact transients fade.
  SLIP_GRIP_STATE_SETTLING = 3,
  // an object is held.
  SLIP_GRIP_STATE_HOLDING = 4,
  // a slip is being stopped.
  SLIP_GRIP_STATE_SLIPPING = 5,
  // no slip sensor can be trusted, the force stays.
  SLIP_GRIP_STATE_FAULT = 6,
  // let go by a client, until it is asked to grasp.
  SLIP_GRIP_STATE_RELEASED = 7,
  // nothing is touched any more: the object is gone, the force stays.
  SLIP_GRIP_STATE_LOST = 8,
};

// Phase
enum {
  // shear and first movements, before the object slides.
  SLIP_PHASE_INCIPIENT = 1,
  // the object slides.
  SLIP_PHASE_GROSS = 2,
  // the slip has ended.
  SLIP_PHASE_ENDED = 3,
};

// Method
enum {
  // not known: at the end of a slip.
  SLIP_METHOD_NONE = 0,
  // vibration of the stylus.
  SLIP_METHOD_STYLUS = 1,
  // moved distance of the object, from a roller or an encoder.
  SLIP_METHOD_TRAVEL = 2,
  // change of the pressure distribution under the finger.
  SLIP_METHOD_PRESSURE = 3,
};

// SpeedSource
enum {
  // no speed is known.
  SLIP_SPEED_SOURCE_NONE = 0,
  // set in the configuration.
  SLIP_SPEED_SOURCE_FIXED = 1,
  // a velocity channel.
  SLIP_SPEED_SOURCE_DIRECT = 2,
  // slope of the travel channel.
  SLIP_SPEED_SOURCE_TRAVEL = 3,
  // delay between two styli.
  SLIP_SPEED_SOURCE_TWO_STYLI = 4,
  // acceleration by weight since the first notice.
  SLIP_SPEED_SOURCE_GRAVITY = 5,
};

// Reading
enum {
  // no E_sc is known.
  SLIP_READING_NONE = 0,
  // n F v tan(sum cot(delta/s)) (W), as printed.
  SLIP_READING_LITERAL = 1,
  // n F v tan(sum arccot(delta/s)) (W): cot read as the angle whose cotangent is delta/s.
  SLIP_READING_ARC_COT = 2,
  // F v sum 2 delta/s (W): power to lift along the flanks; n F v tan(mean flank angle) to second order.
  SLIP_READING_SLOPE_POWER = 3,
  // F sum delta (J): work to lift over every irregularity once.
  SLIP_READING_LIFT_WORK = 4,
  // (pi^2/2) c v sum delta^2/s (J): what the damper c of the stylus takes at speed v over sinusoidal irregularities.
  SLIP_READING_VISCOUS_WORK = 5,
};

// Sensor
enum {
  // the stylus.
  SLIP_SENSOR_STYLUS = 1,
  // roller or encoder.
  SLIP_SENSOR_TRAVEL = 2,
  // the taxel array.
  SLIP_SENSOR_PRESSURE = 3,
  // the motion reference.
  SLIP_SENSOR_REFERENCE = 4,
};

// SensorHealth
enum {
  // nothing is wrong; without a daemon also: no such sensor.
  SLIP_SENSOR_HEALTH_GOOD = 0,
  // always the same value: a broken wire or a hung converter.
  SLIP_SENSOR_HEALTH_FROZEN = 1,
  // at the end of its range.
  SLIP_SENSOR_HEALTH_SATURATED = 2,
  // too many readings that are none.
  SLIP_SENSOR_HEALTH_FAILED = 3,
  // moves further than a change of grip force explains.
  SLIP_SENSOR_HEALTH_DRIFTING = 4,
  // leaps farther than any object can move.
  SLIP_SENSOR_HEALTH_JUMPED = 5,
  // runs the other way.
  SLIP_SENSOR_HEALTH_BACKWARDS = 6,
  // no readings, where there were some before.
  SLIP_SENSOR_HEALTH_LOST = 7,
  // contradicted by another sensor.
  SLIP_SENSOR_HEALTH_DOUBTED = 8,
  // steps or noise too coarse to show an acceleration.
  SLIP_SENSOR_HEALTH_COARSE = 9,
  // another sensor shows the same at another time: a motion reference is late or early.
  SLIP_SENSOR_HEALTH_LATE = 10,
  // other sensors show nothing of what it shows: a motion reference of another robot.
  SLIP_SENSOR_HEALTH_UNCOUPLED = 11,
  // the gripper sends nothing of such a sensor.
  SLIP_SENSOR_HEALTH_ABSENT = 12,
};

// Operation
enum {
  // hold with at least `force_mn`, within the limits; the answer to a slip stays free to press harder.
  SLIP_OPERATION_AT_LEAST = 1,
  // let go: the fingers open until GRASP.
  SLIP_OPERATION_RELEASE = 2,
  // close again after a release.
  SLIP_OPERATION_GRASP = 3,
  // stop in software, latched by the gripper; not a safety function.
  SLIP_OPERATION_STOP = 4,
  // clear the fault `fault`.
  SLIP_OPERATION_CLEAR_FAULT = 5,
  // the next objects are known to be held with `force_mn`, margin included: grasp them with that; 0: nothing is known.
  SLIP_OPERATION_EXPECT = 6,
};

// What a call led to.
typedef enum slip_status {
  // Done.
  SLIP_STATUS_OK = 0,
  // A pointer is NULL that must not be.
  SLIP_STATUS_NULL = 1,
  // A pointer is not aligned to its type.
  SLIP_STATUS_ALIGN = 2,
  // The memory is too small, or a count is too large.
  SLIP_STATUS_SIZE = 3,
  // There is no pipeline: never created, copied, or destroyed.
  SLIP_STATUS_NOT_CREATED = 4,
  // The options do not fit; slip_create() writes why.
  SLIP_STATUS_OPTIONS = 5,
  // A text is not UTF-8.
  SLIP_STATUS_TEXT = 6,
  // A value is outside its range.
  SLIP_STATUS_VALUE = 7,
  // There is no value: no irregularity, or a number that is not finite.
  SLIP_STATUS_NO_VALUE = 8,
  // The library has failed within; this pipeline is of no more use.
  SLIP_STATUS_PANICKED = 9,
} slip_status;

// What an event is about.
typedef enum slip_event_kind {
  // A slip was noticed, became gross, was certified, or has ended.
  SLIP_EVENT_KIND_SLIP = 1,
  // What became of the object in hand; `code` is SLIP_OBJECT_*.
  SLIP_EVENT_KIND_OBJECT = 2,
  // The health of sensor `sensor` (SLIP_SENSOR_*) has changed; `code` is SLIP_SENSOR_HEALTH_*.
  SLIP_EVENT_KIND_HEALTH = 3,
  // The state of the noise floor has changed; `code` is 0 for good, 1 for doubtful.
  SLIP_EVENT_KIND_FLOOR = 4,
} slip_event_kind;

// What became of the object in hand.
typedef enum slip_object {
  // There is none.
  SLIP_OBJECT_EMPTY = 1,
  // It is lost.
  SLIP_OBJECT_LOST = 2,
  // It is touched again.
  SLIP_OBJECT_REGRASPED = 3,
  // Its slip has not ended within two seconds.
  SLIP_OBJECT_PERSISTENT = 4,
  // The force that the object needs is found: no less is tried.
  SLIP_OBJECT_FOUND = 5,
  // It is held with the largest force that may be commanded: what it needs is not known.
  SLIP_OBJECT_LIMITED = 6,
} slip_object;

// What the channel `stylus` holds.
typedef enum slip_signal {
  // Displacement of the stylus (m): heights, spacings and E_sc have a meaning.
  SLIP_SIGNAL_DISPLACEMENT = 0,
  // Vibration in any unit: slips are found, heights are not known.
  SLIP_SIGNAL_VIBRATION = 1,
  // Nothing: slips are found by travel and taxels alone.
  SLIP_SIGNAL_ABSENT = 2,
} slip_signal;

// A pipeline. What is in it is of no concern to C.
typedef struct slip_pipeline slip_pipeline;

// How a pipeline is made. All zero but for the rate: the defaults for a stylus that measures displacement, observing
// only.
typedef struct slip_options {
  // Samples per second, 20 to 50,000.
  float rate_hz;
  // SLIP_SIGNAL_*.
  uint32_t signal;
  // Not 0: the controller runs and every sample leads to a command. Needs a stylus; without a force sensor it closes
  // by time.
  uint32_t control;
  // Text of a gripd.toml without `calibration` and `model`, or NULL for the defaults.
  const char *settings;
  // Text of a CAL.toml of `gripctl calibrate`, or NULL for none.
  const char *calibration;
  // Text of a model file, NULL for the built-in model, "" for no estimates.
  const char *model;
} slip_options;

// Samples, channel by channel: `rows` values each, or NULL for a channel that is not there. NaN stands for no reading
// in this row; in stylus, stylus_y and stylus_z it is a reading that cannot be used, and too many of them fail the
// stylus.
typedef struct slip_block {
  // Samples.
  size_t rows;
  // Time of each sample (us), later than the one before. NULL: spaced by the rate.
  const uint64_t *t_us;
  // Stylus (m), or vibration (any unit).
  const float *stylus;
  // Second axis of a vibration sensor (its unit).
  const float *stylus_y;
  // Third axis.
  const float *stylus_z;
  // Normal force of one finger (N).
  const float *normal_force_n;
  // Tangential force on one finger (N).
  const float *tangential_n;
  // Moved distance of the object (m).
  const float *travel_m;
  // Slip speed (m/s).
  const float *velocity_m_s;
  // Second stylus behind the first (m).
  const float *second_stylus;
  // Motion reference (own unit).
  const float *reference;
  // Second axis of the reference.
  const float *reference_y;
  // Third axis of the reference.
  const float *reference_z;
  // Static pressure of the fingertip (own unit).
  const float *pressure;
  // Commanded motion: 0 while the robot stands.
  const float *motion;
  // Frames of a taxel array, row by row: `rows * taxel_count` values.
  const float *taxels;
  // Taxels of a frame, up to 256.
  size_t taxel_count;
  // When the computer took each sample in, by its monotonic clock (us), or NULL.
  const uint64_t *arrived_us;
  // How old each sample was then (us), or NULL for 0. Evidence 20 ms older than usual raises no force.
  const uint64_t *age_us;
} slip_block;

// An event.
typedef struct slip_event {
  // Time of the sample (us).
  uint64_t t_us;
  // Row of the block.
  uint64_t row;
  // E_sc as printed (W).
  double esc_w;
  // The reading of E_sc that the settings ask for (W or J).
  double esc;
  // Length of a slip that has ended (s).
  double duration_s;
  // SLIP_EVENT_KIND_*. All that follows `code` concerns slips.
  uint32_t kind;
  // Irregularities that the stylus passed.
  uint32_t irregularities;
  // SLIP_SENSOR_* of a change of health.
  uint8_t sensor;
  // Depends on the kind.
  uint8_t code;
  // SLIP_PHASE_*; 0 of what is no slip.
  uint8_t phase;
  // SLIP_METHOD_*: what noticed it.
  uint8_t method;
  // SLIP_SPEED_SOURCE_*.
  uint8_t speed_source;
  // SLIP_READING_*: what `esc` is.
  uint8_t reading;
  // What is wrong with esc_w: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
  uint8_t esc_flags;
  // b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used.
  uint8_t notes;
  // Other causes that were ruled out: b0 knock, b1 motion, b2 grip change, b3 closing, b4 arm stop.
  uint8_t ruled_out;
  // Causes that were not; one in neither could not be judged.
  uint8_t possible;
  // 1 for the first notice of the slip.
  uint8_t first;
  // Evidence of a slip over the wanted interval.
  float statistic;
  // Probability that noise alone would not reach it.
  float confidence;
  // Slip speed (m/s).
  float speed_m_s;
  // Its standard deviation (m/s).
  float speed_sigma_m_s;
  // Distance moved since the slip was noticed (m).
  float moved_m;
  // Estimate of the adequate force (N).
  float estimate_n;
  // Its standard deviation (N).
  float estimate_sigma_n;
  // Commanded force (N).
  float command_n;
  // The interval that the slip is certified with (s).
  float certified_s;
} slip_event;

// The pipeline after a block.
typedef struct slip_state {
  // Time of the last sample (us).
  uint64_t t_us;
  // Evidence of a slip over the wanted interval: 1 and above is a slip. 0 where the bands were not needed.
  float statistic;
  // Commanded force (N); NaN without a controller.
  float command_n;
  // SLIP_SCENE_*.
  uint8_t scene;
  // SLIP_GRIP_STATE_*.
  uint8_t grip;
  // SLIP_SENSOR_HEALTH_* of stylus, travel, pressure, reference.
  uint8_t sensors[4];
  // Noise floor of the stylus: 0 good, 1 doubtful.
  uint8_t floor;
} slip_state;

// Where the results of a block go, and what came of it.
typedef struct slip_result {
  // In: room for events, or NULL.
  struct slip_event *events;
  // In: how many events there is room for.
  size_t room;
  // In: room for the statistic of every row, or NULL.
  float *statistic;
  // In: room for the command of every row (N), or NULL.
  float *command_n;
  // Out: events of the block. Those beyond `room` are lost; a row has seven at most.
  size_t found;
  // Out: the pipeline after the last row.
  struct slip_state state;
} slip_result;

// The force that the object in hand needs; NaN where nothing is known of it.
typedef struct slip_need {
  // Normal force of one finger that the object needs at full weight (N): its 10 % quantile.
  float low_n;
  // Its median (N).
  float median_n;
  // Its 90 % quantile (N).
  float high_n;
  // Acceleration of the arm beside gravity, in any direction, at which the object slips at the commanded force with a probability of 10 % (m/s^2).
  float admissible_m_s2;
} slip_need;

// Force and speed of a slip.
typedef struct slip_trial {
  // Trial force (N).
  double force_n;
  // Slip speed (m/s).
  double speed_m_s;
  // Damper of the stylus (N s/m), for SLIP_READING_VISCOUS_WORK alone.
  double damping_n_s_m;
  // Relative noise of each delta/s (one deviation), independent of the others.
  double noise;
  // Relative noise that is common to all.
  double common_noise;
} slip_trial;

// A value of E_sc with the figures for how far it can be trusted.
typedef struct slip_esc_value {
  // The value (W or J).
  double value;
  // The exact value is not below this.
  double lo;
  // The exact value is not above this.
  double hi;
  // The sum S of the reading.
  double sum;
  // Relative condition number of the value with respect to S.
  double condition;
  // Deviation of S by the noise.
  double sigma_s;
  // Irregularities in the sum.
  uint32_t n;
  // Irregularities that were left out.
  uint32_t degenerate;
  // b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
  uint32_t flags;
} slip_esc_value;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Bytes of memory that a pipeline needs.
size_t slip_size(void);

// Alignment of that memory; what malloc gives has it.
size_t slip_align(void);

// The version of this library, as in "0.1.0".
const char *slip_version(void);

// A sentence for a status; of any other number too.
const char *slip_error_text(int32_t status);

// Makes a pipeline in `memory`, `size` bytes (slip_size() or more, aligned to slip_align()), and sets `*made` to it,
// or to NULL where that fails.
//
// Why it fails is written to `why` as a sentence, as far as `why_size` bytes hold it; `why` may be NULL. A pipeline
// belongs to one thread at a time, must not be copied, and ends with slip_destroy(): one that is still in `memory`
// leaks. Needs 600 kB of stack. Traps of floating point must be masked, here and in slip_push().
//
// Each pointer is NULL or points to what its type names, for as many bytes as given; the texts end with a zero byte.
enum slip_status slip_create(void *memory,
                             size_t size,
                             const struct slip_options *options,
                             char *why,
                             size_t why_size,
                             struct slip_pipeline **made);

// Ends a pipeline. Its memory is the caller's again.
//
// `pipeline` is NULL or points to slip_size() readable bytes.
enum slip_status slip_destroy(struct slip_pipeline *pipeline);

// Takes a block of samples in order and fills in `result`. Allocates nothing, takes no lock, reads no clock.
//
// A block is taken whole or refused whole. SLIP_STATUS_VALUE: a time is not later than that of the row before, so the
// clock stands or was set back. A jump ahead is a gap; where it was a mistake, only a new slip_create() ends it.
// `found` and `state` are written in spite of a status, `state` as after the last row that was taken.
//
// Each pointer is NULL or points to what its type names: columns to `rows` values, taxels to `rows * taxel_count`,
// events to `room` of them, statistic and command_n to room for `rows` values. No other thread uses any of it
// meanwhile.
enum slip_status slip_push(struct slip_pipeline *pipeline,
                           const struct slip_block *block,
                           struct slip_result *result);

// Asks the controller to hold with at least `force_n`, to let go, to close again, or to grasp the next objects with `force_n`, which they are known to need
// (SLIP_OPERATION_AT_LEAST, _RELEASE, _GRASP, _EXPECT). A pipeline that only observes does nothing, with SLIP_STATUS_OK.
//
// `pipeline` is NULL or points to slip_size() readable bytes.
enum slip_status slip_command(struct slip_pipeline *pipeline,
                              uint8_t operation,
                              float force_n);

// Writes to `need` what the object in hand needs, as it was known after the last row.
//
// `pipeline` is NULL or points to slip_size() readable bytes, `need` is NULL or points to a slip_need. No other thread uses either meanwhile.
enum slip_status slip_needed(struct slip_pipeline *pipeline,
                             struct slip_need *need);

// E_sc of `n` irregularities of height `delta_m` and spacing `spacing_m`, read as `reading` (SLIP_READING_*).
//
// Each pointer is NULL or points to what its type names, `delta_m` and `spacing_m` to `n` values.
enum slip_status slip_esc(const double *delta_m,
                          const double *spacing_m,
                          size_t n,
                          const struct slip_trial *trial,
                          uint8_t reading,
                          struct slip_esc_value *value);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SLIP_H */
