//! What crosses the border by value, as C lays it out. A number that is not known is NaN.

use core::ffi::c_char;
use grip_session::report::{Condition, Event};
use slip_core::{
    NeededForce, SlipReport,
    esc::{Esc, Noise, Trial},
    grip::GripEvent,
};

/// What the channel `stylus` holds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipSignal {
    /// Displacement of the stylus (m): heights, spacings and E_sc have a meaning.
    Displacement = 0,
    /// Vibration in any unit: slips are found, heights are not known.
    Vibration = 1,
    /// Nothing: slips are found by travel and taxels alone.
    Absent = 2,
}

/// How a pipeline is made. All zero but for the rate: the defaults for a stylus that measures displacement, observing
/// only.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlipOptions {
    /// Samples per second, 20 to 50,000.
    pub rate_hz: f32,
    /// SLIP_SIGNAL_*.
    pub signal: u32,
    /// Not 0: the controller runs and every sample leads to a command. Needs a stylus; without a force sensor it closes
    /// by time.
    pub control: u32,
    /// Text of a gripd.toml without `calibration` and `model`, or NULL for the defaults.
    pub settings: *const c_char,
    /// Text of a CAL.toml of `gripctl calibrate`, or NULL for none.
    pub calibration: *const c_char,
    /// Text of a model file, NULL for the built-in model, "" for no estimates.
    pub model: *const c_char,
}

/// Samples, channel by channel: `rows` values each, or NULL for a channel that is not there. NaN stands for no reading
/// in this row; in stylus, stylus_y and stylus_z it is a reading that cannot be used, and too many of them fail the
/// stylus.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct SlipBlock {
    /// Samples.
    pub rows: usize,
    /// Time of each sample (us), later than the one before. NULL: spaced by the rate.
    pub t_us: *const u64,
    /// Stylus (m), or vibration (any unit).
    pub stylus: *const f32,
    /// Second axis of a vibration sensor (its unit).
    pub stylus_y: *const f32,
    /// Third axis.
    pub stylus_z: *const f32,
    /// Normal force of one finger (N).
    pub normal_force_n: *const f32,
    /// Tangential force on one finger (N).
    pub tangential_n: *const f32,
    /// Moved distance of the object (m).
    pub travel_m: *const f32,
    /// Slip speed (m/s).
    pub velocity_m_s: *const f32,
    /// Second stylus behind the first (m).
    pub second_stylus: *const f32,
    /// Motion reference (own unit).
    pub reference: *const f32,
    /// Second axis of the reference.
    pub reference_y: *const f32,
    /// Third axis of the reference.
    pub reference_z: *const f32,
    /// Static pressure of the fingertip (own unit).
    pub pressure: *const f32,
    /// Commanded motion: 0 while the robot stands.
    pub motion: *const f32,
    /// Frames of a taxel array, row by row: `rows * taxel_count` values.
    pub taxels: *const f32,
    /// Taxels of a frame, up to 256.
    pub taxel_count: usize,
    /// When the computer took each sample in, by its monotonic clock (us), or NULL.
    pub arrived_us: *const u64,
    /// How old each sample was then (us), or NULL for 0. Evidence 20 ms older than usual raises no force.
    pub age_us: *const u64,
}

/// What an event is about.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipEventKind {
    /// A slip was noticed, became gross, was certified, or has ended.
    Slip = 1,
    /// What became of the object in hand; `code` is SLIP_OBJECT_*.
    Object = 2,
    /// The health of sensor `sensor` (SLIP_SENSOR_*) has changed; `code` is SLIP_SENSOR_HEALTH_*.
    Health = 3,
    /// The state of the noise floor has changed; `code` is 0 for good, 1 for doubtful.
    Floor = 4,
}

/// What became of the object in hand.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipObject {
    /// There is none.
    Empty = 1,
    /// It is lost.
    Lost = 2,
    /// It is touched again.
    Regrasped = 3,
    /// Its slip has not ended within two seconds.
    Persistent = 4,
    /// The force that the object needs is found: no less is tried.
    Found = 5,
    /// It is held with the largest force that may be commanded: what it needs is not known.
    Limited = 6,
}

/// An event.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct SlipEvent {
    /// Time of the sample (us).
    pub t_us: u64,
    /// Row of the block.
    pub row: u64,
    /// E_sc as printed (W).
    pub esc_w: f64,
    /// The reading of E_sc that the settings ask for (W or J).
    pub esc: f64,
    /// Length of a slip that has ended (s).
    pub duration_s: f64,
    /// SLIP_EVENT_KIND_*. All that follows `code` concerns slips.
    pub kind: u32,
    /// Irregularities that the stylus passed.
    pub irregularities: u32,
    /// SLIP_SENSOR_* of a change of health.
    pub sensor: u8,
    /// Depends on the kind.
    pub code: u8,
    /// SLIP_PHASE_*; 0 of what is no slip.
    pub phase: u8,
    /// SLIP_METHOD_*: what noticed it.
    pub method: u8,
    /// SLIP_SPEED_SOURCE_*.
    pub speed_source: u8,
    /// SLIP_READING_*: what `esc` is.
    pub reading: u8,
    /// What is wrong with esc_w: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
    pub esc_flags: u8,
    /// b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used.
    pub notes: u8,
    /// Other causes that were ruled out: b0 knock, b1 motion, b2 grip change, b3 closing, b4 arm stop.
    pub ruled_out: u8,
    /// Causes that were not; one in neither could not be judged.
    pub possible: u8,
    /// 1 for the first notice of the slip.
    pub first: u8,
    /// Evidence of a slip over the wanted interval.
    pub statistic: f32,
    /// Probability that noise alone would not reach it.
    pub confidence: f32,
    /// Slip speed (m/s).
    pub speed_m_s: f32,
    /// Its standard deviation (m/s).
    pub speed_sigma_m_s: f32,
    /// Distance moved since the slip was noticed (m).
    pub moved_m: f32,
    /// Estimate of the adequate force (N).
    pub estimate_n: f32,
    /// Its standard deviation (N).
    pub estimate_sigma_n: f32,
    /// Commanded force (N).
    pub command_n: f32,
    /// The interval that the slip is certified with (s).
    pub certified_s: f32,
}

impl SlipEvent {
    pub(crate) fn new(event: &Event, row: u64) -> Self {
        match event {
            Event::Slip(report) => Self::slip(report, row),
            Event::Grip { t, event, command_n } => {
                let object = match event {
                    GripEvent::Empty => SlipObject::Empty,
                    GripEvent::Lost => SlipObject::Lost,
                    GripEvent::Regrasped => SlipObject::Regrasped,
                    GripEvent::Persistent => SlipObject::Persistent,
                    GripEvent::Found => SlipObject::Found,
                    GripEvent::Limited => SlipObject::Limited,
                };
                let command_n = known(*command_n);
                Self::other(t.0, row, SlipEventKind::Object, 0, object as u8, command_n)
            }
            Event::Health { t, condition } => {
                let (kind, sensor, code) = match condition {
                    Condition::Sensor(sensor, health) => {
                        (SlipEventKind::Health, sensor.code(), health.code())
                    }
                    Condition::Floor(health) => (SlipEventKind::Floor, 0, *health as u8),
                    // Only gripd judges the clock of a device.
                    Condition::Clock(_) => (SlipEventKind::Health, 0, 0),
                };
                Self::other(t.0, row, kind, sensor, code, f32::NAN)
            }
        }
    }

    fn slip(report: &SlipReport, row: u64) -> Self {
        Self {
            t_us: report.t.0,
            row,
            esc_w: report.esc_w.unwrap_or(f64::NAN),
            esc: report.esc.unwrap_or(f64::NAN),
            duration_s: report.duration_s.unwrap_or(f64::NAN),
            kind: SlipEventKind::Slip as u32,
            irregularities: report.irregularities.unwrap_or(0),
            sensor: 0,
            code: 0,
            phase: report.phase.code(),
            method: report.method.code(),
            speed_source: report.speed_source.code(),
            reading: report.esc_kind.code(),
            esc_flags: report.esc_flags,
            notes: report.notes,
            ruled_out: report.ruled_out,
            possible: report.possible,
            first: report.first.into(),
            statistic: known(report.statistic),
            confidence: known(report.confidence),
            speed_m_s: known(report.speed_m_s),
            speed_sigma_m_s: known(report.speed_sigma_m_s),
            moved_m: known(report.moved_m),
            estimate_n: known(report.estimate_n),
            estimate_sigma_n: known(report.estimate_sigma_n),
            command_n: known(report.command_n),
            certified_s: known(report.certified_s),
        }
    }

    fn other(
        t_us: u64,
        row: u64,
        kind: SlipEventKind,
        sensor: u8,
        code: u8,
        command_n: f32,
    ) -> Self {
        let nothing = SlipReport::UNKNOWN;
        let kind = kind as u32;
        Self { t_us, kind, sensor, code, command_n, phase: 0, ..Self::slip(&nothing, row) }
    }
}

/// A value, or NaN.
pub(crate) fn known(value: Option<f32>) -> f32 {
    value.unwrap_or(f32::NAN)
}

/// The pipeline after a block.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct SlipState {
    /// Time of the last sample (us).
    pub t_us: u64,
    /// Evidence of a slip over the wanted interval: 1 and above is a slip. 0 where the bands were not needed.
    pub statistic: f32,
    /// Commanded force (N); NaN without a controller.
    pub command_n: f32,
    /// SLIP_SCENE_*.
    pub scene: u8,
    /// SLIP_GRIP_STATE_*.
    pub grip: u8,
    /// SLIP_SENSOR_HEALTH_* of stylus, travel, pressure, reference.
    pub sensors: [u8; 4],
    /// Noise floor of the stylus: 0 good, 1 doubtful.
    pub floor: u8,
}

/// The force that the object in hand needs; NaN where nothing is known of it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlipNeed {
    /// Normal force of one finger that the object needs at full weight (N): its 10 % quantile.
    pub low_n: f32,
    /// Its median (N).
    pub median_n: f32,
    /// Its 90 % quantile (N).
    pub high_n: f32,
    /// Acceleration of the arm beside gravity, in any direction, at which the object slips at the commanded force with a probability of 10 % (m/s^2).
    pub admissible_m_s2: f32,
}

impl From<Option<NeededForce>> for SlipNeed {
    fn from(need: Option<NeededForce>) -> Self {
        let [low_n, median_n, high_n, admissible_m_s2] = need.map_or([f32::NAN; 4], |need| {
            [need.low_n, need.median_n, need.high_n, need.admissible_m_s2]
        });
        Self { low_n, median_n, high_n, admissible_m_s2 }
    }
}

/// Where the results of a block go, and what came of it.
#[repr(C)]
#[derive(Debug, Default)]
pub struct SlipResult {
    /// In: room for events, or NULL.
    pub events: *mut SlipEvent,
    /// In: how many events there is room for.
    pub room: usize,
    /// In: room for the statistic of every row, or NULL.
    pub statistic: *mut f32,
    /// In: room for the command of every row (N), or NULL.
    pub command_n: *mut f32,
    /// Out: events of the block. Those beyond `room` are lost; a row has seven at most.
    pub found: usize,
    /// Out: the pipeline after the last row.
    pub state: SlipState,
}

/// Force and speed of a slip.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlipTrial {
    /// Trial force (N).
    pub force_n: f64,
    /// Slip speed (m/s).
    pub speed_m_s: f64,
    /// Damper of the stylus (N s/m), for SLIP_READING_VISCOUS_WORK alone.
    pub damping_n_s_m: f64,
    /// Relative noise of each delta/s (one deviation), independent of the others.
    pub noise: f64,
    /// Relative noise that is common to all.
    pub common_noise: f64,
}

impl From<SlipTrial> for Trial {
    fn from(trial: SlipTrial) -> Self {
        let SlipTrial { force_n, speed_m_s, damping_n_s_m, noise, common_noise } = trial;
        let noise = Noise { independent: noise, common: common_noise };
        Self { force_n, speed_m_s, noise, damping_n_s_m }
    }
}

/// A value of E_sc with the figures for how far it can be trusted.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlipEsc {
    /// The value (W or J).
    pub value: f64,
    /// The exact value is not below this.
    pub lo: f64,
    /// The exact value is not above this.
    pub hi: f64,
    /// The sum S of the reading.
    pub sum: f64,
    /// Relative condition number of the value with respect to S.
    pub condition: f64,
    /// Deviation of S by the noise.
    pub sigma_s: f64,
    /// Irregularities in the sum.
    pub n: u32,
    /// Irregularities that were left out.
    pub degenerate: u32,
    /// b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
    pub flags: u32,
}

impl From<Esc> for SlipEsc {
    fn from(esc: Esc) -> Self {
        let Esc { value, lo, hi, sum, condition, sigma_s, n, degenerate, .. } = esc;
        let flags = esc.flags.bits().into();
        Self { value, lo, hi, sum, condition, sigma_s, n, degenerate, flags }
    }
}
