//! Detector of moved distance: slip and the health of the channel, from the distance that the object moved and what the fingers do.
//!
//! ```text
//! forward  <- max(0, forward  + dx - drift dt)      slip when forward or backward > limit
//! backward <- max(0, backward - dx - drift dt)
//! ```
//!
//! dx is the distance the object moved against the finger since the reading before. The two sums are one-sided cumulative
//! sums (Page 1954) with the drift of the encoder as allowance: at rest a sensor of resolution q and peak-to-peak noise p
//! shows at most q + p, however long it rests, while an object that slides faster than the drift passes the limit after
//! limit / (v - drift). Slower slips are not seen. The limit must also exceed the elastic shear of the pads, which moves
//! the object without a slip (5 N on a pad of 100 N/mm: 50 um).
//!
//! While the fingers move a roller turns with them, so the sums start again when they have come to rest; where the
//! position of the finger is measured it is subtracted instead.

use crate::{
    detector::SlipState, error::ConfigError, health::SensorHealth, settings::settings,
    units::Micros,
};

/// Which way an object can slip, as the sensor counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
pub enum Direction {
    /// Both ways, or it is not known how the sensor is mounted.
    #[default]
    Either,
    /// Towards larger readings.
    Rising,
    /// Towards smaller readings.
    Falling,
}

settings! {
    /// Limits of the moved-distance method.
    pub struct DistanceConfig as c in "travel" {
        resolution_m: f32 = 1e-6, 0.0..=0.01 =>
            "Resolution of the sensor (m); the limit must be at least three times as long.";
        limit_m: f32 = 1e-4, (3.0 * c.resolution_m).max(1e-7)..=0.1 => "Moved distance that is a slip (m).";
        drift_m_s: f32 = 1e-4, 0.0..=0.1 => "Drift of the sensor and creep of the pads that is no slip (m/s).";
        max_speed_m_s: f32 = 3.0, 0.01..=100.0 =>
            "Fastest object (m/s): a reading that would need more is a jump of the sensor.";
        direction: Direction = Direction::Either => "Which way the object can slip.";
        release_ms: f32 = 50.0, 1.0..=10_000.0 => "How long the object must stand for the slip to end (ms).";
        frozen_ms: f32 = 50.0, 1.0..=1e6 =>
            "The channel counts as frozen where it shows one value for this long while another method sees a gross"
            "slip (ms).";
    }
}

/// What is known of the fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fingers {
    /// They hold still.
    Still,
    /// They move, by command or as measured, and nothing shows how far.
    Moving,
    /// Their position along the travel (m), from an encoder of the gripper.
    At(f32),
}

/// Readings without a leap after which a sensor that has jumped is believed again.
const SETTLED: u32 = 20;
/// Equal readings before a channel can count as frozen: it may be read more slowly than the stylus.
const FEWEST_EQUAL: u32 = 3;
/// Steps of the resolution that are an advance, and the least advance (m).
const ADVANCE_STEPS: f32 = 5.0;
const LEAST_ADVANCE_M: f32 = 5e-6;
/// Deviations of the noise that are an advance, and that the limit is at least: of hundreds of readings at rest none is
/// so far from another.
const ADVANCE_SIGMAS: f32 = 8.0;
const LIMIT_SIGMAS: f32 = 12.0;
/// Share of a reading in where the object stands, and how many deviations off it counts at most: a movement that begins changes little.
const LEVEL: f32 = 0.02;
const LEVEL_SIGMAS: f32 = 2.0;

/// One reading with what is known besides.
#[derive(Clone, Copy, Debug)]
pub struct TravelReading {
    /// Its time.
    pub t: Micros,
    /// The reading (m), finite.
    pub travel_m: f32,
    /// What the fingers do.
    pub fingers: Fingers,
    /// Whether another method sees the object slide.
    pub others_gross: bool,
}

/// The moved-distance method and its memory.
#[derive(Clone, Copy, Debug)]
pub struct MovedDistance {
    config: DistanceConfig,
    release: Micros,
    frozen: Micros,
    advance_m: f32,
    per_limit: f32,
    last: Option<(Micros, f32)>,
    /// Sum of the leaps left out (m).
    leaps_m: f32,
    forward_m: f32,
    backward_m: f32,
    mark_m: f32,
    advanced_at: Micros,
    state: SlipState,
    since_leap: u32,
    equal: u32,
    contradicted_since: Option<Micros>,
    frozen_now: bool,
    backwards_now: bool,
    leaps: u64,
    noise: RestNoise,
    /// As measured last (m).
    sigma_m: f32,
    interval: Interval,
    /// Smallest step between two readings (m); infinite before the first.
    smallest_m: f32,
    /// Where the object stands, or stood last (m): a mean of the readings.
    level_m: f32,
    /// Most readings that were equal as it stood.
    longest: u32,
}

/// Noise of the readings: white noise of deviation s makes two steps that follow each other go opposite ways, E dx dx' = -s^2,
/// and motion makes them go the same way.
#[derive(Clone, Copy, Debug, Default)]
struct RestNoise {
    last_m: f32,
    sum: f32,
    seen: u16,
}

impl RestNoise {
    /// Steps over which the mean is taken, and where they come seldom.
    const STEPS: u16 = 256;
    const SELDOM: u16 = 64;
    /// Steps that give a first guess.
    const FEW: u16 = 8;

    /// Takes the next step (m): the deviation (m), each time that enough of them were seen.
    #[inline]
    fn push(&mut self, dx_m: f32, seldom: bool) -> Option<f32> {
        if dx_m == 0.0 {
            return None;
        }
        self.sum -= dx_m * self.last_m;
        self.last_m = dx_m;
        self.seen += 1;
        let enough = if seldom { Self::SELDOM } else { Self::STEPS };
        (self.seen >= enough).then(|| self.finish())
    }

    #[cold]
    fn finish(&mut self) -> f32 {
        let sigma_m = self.guess();
        (self.sum, self.seen) = (0.0, 0);
        sigma_m
    }

    /// The deviation (m) as far as it is seen, 0 for too few steps.
    fn guess(&self) -> f32 {
        let mean = if self.seen < Self::FEW { 0.0 } else { self.sum / f32::from(self.seen) };
        libm::sqrtf(mean.max(0.0))
    }
}

impl MovedDistance {
    /// A method that has seen nothing yet.
    ///
    /// # Errors
    /// Where a value of the configuration is outside its range.
    pub fn new(config: DistanceConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            config,
            release: Micros::from_ms(config.release_ms),
            frozen: Micros::from_ms(config.frozen_ms),
            advance_m: (ADVANCE_STEPS * config.resolution_m).max(LEAST_ADVANCE_M),
            per_limit: 1.0 / config.limit_m,
            last: None,
            leaps_m: 0.0,
            forward_m: 0.0,
            backward_m: 0.0,
            mark_m: 0.0,
            advanced_at: Micros(0),
            state: SlipState::Quiet,
            since_leap: SETTLED,
            equal: 0,
            contradicted_since: None,
            frozen_now: false,
            backwards_now: false,
            leaps: 0,
            noise: RestNoise::default(),
            sigma_m: 0.0,
            interval: Interval::default(),
            smallest_m: f32::INFINITY,
            level_m: 0.0,
            longest: 0,
        })
    }

    /// What is an advance and what a slip, for readings with noise of this deviation (m).
    fn allow(&mut self, sigma_m: f32) {
        let resolved_m = (ADVANCE_STEPS * self.config.resolution_m).max(LEAST_ADVANCE_M);
        self.sigma_m = sigma_m;
        self.advance_m = resolved_m.max(ADVANCE_SIGMAS * sigma_m);
        self.per_limit = 1.0 / self.config.limit_m.max(LIMIT_SIGMAS * sigma_m);
    }

    /// Starts afresh with the next reading, with the noise too; the count of leaps stays.
    pub fn prime(&mut self) {
        self.noise = RestNoise::default();
        self.interval = Interval::default();
        self.smallest_m = f32::INFINITY;
        self.allow(0.0);
        self.last = None;
        self.longest = 0;
        self.leaps_m = 0.0;
        self.stand();
        self.since_leap = SETTLED;
        self.equal = 0;
        self.contradicted_since = None;
        self.frozen_now = false;
        self.backwards_now = false;
    }

    /// State of the channel.
    #[must_use]
    #[inline]
    pub fn health(&self) -> SensorHealth {
        if self.frozen_now {
            SensorHealth::Frozen
        } else if self.since_leap < SETTLED {
            SensorHealth::Jumped
        } else if self.backwards_now {
            SensorHealth::Backwards
        } else {
            SensorHealth::Good
        }
    }

    /// Leaps left out of the distance so far.
    #[must_use]
    pub fn leaps(&self) -> u64 {
        self.leaps
    }

    /// Whether the object slips, as of the last reading.
    #[must_use]
    #[inline]
    pub fn state(&self) -> SlipState {
        self.state
    }

    /// Moved distance over the limit: above 1 is a slip.
    #[must_use]
    #[inline]
    pub fn statistic(&self) -> f32 {
        let moved_m = match self.config.direction {
            Direction::Either if self.forward_m > self.backward_m => self.forward_m,
            Direction::Either => self.backward_m,
            Direction::Rising => self.forward_m,
            Direction::Falling => self.backward_m,
        };
        moved_m * self.per_limit
    }

    /// Smallest step between two readings since the object was taken (m); infinite before the first.
    #[must_use]
    pub fn smallest_step_m(&self) -> f32 {
        self.smallest_m
    }

    /// Deviation of one reading as the object rests (m), a first guess where few were seen, and 0 before; and the time between two readings,
    /// where the sensor is asked more often than it is read.
    #[must_use]
    pub fn noise(&self) -> (f32, Option<Micros>) {
        let sigma_m = if self.sigma_m > 0.0 { self.sigma_m } else { self.noise.guess() };
        (sigma_m, self.interval.known())
    }

    /// Most readings that were equal to the one before while the object stood.
    #[must_use]
    pub fn longest_equal(&self) -> u32 {
        self.longest
    }

    /// Where the object stood before the movement that is going on, and the last reading (m), both without leaps.
    #[must_use]
    pub fn stood_m(&self) -> Option<[f32; 2]> {
        self.last.map(|(_, last_m)| [self.level_m - self.leaps_m, last_m - self.leaps_m])
    }

    /// Whether there was a reading since the object was taken.
    #[must_use]
    #[inline]
    pub fn has_begun(&self) -> bool {
        self.last.is_some()
    }

    /// Whether there was a reading within `within` before `t`.
    #[must_use]
    pub fn is_live(&self, t: Micros, within: Micros) -> bool {
        self.last.is_some_and(|(last, _)| t.since(last) < within)
    }

    /// Whether the object advanced within `within` before `t`.
    #[must_use]
    pub fn advancing(&self, t: Micros, within: Micros) -> bool {
        self.state != SlipState::Quiet && t.since(self.advanced_at) < within
    }

    /// The reading with every leap of the sensor left out (m).
    #[must_use]
    #[inline]
    pub fn without_leaps(&self, travel_m: f32) -> f32 {
        travel_m - self.leaps_m
    }

    /// Takes the next reading.
    #[inline]
    pub fn step(&mut self, reading: TravelReading) {
        let TravelReading { t, travel_m, fingers, others_gross } = reading;
        let position_m =
            if let Fingers::At(finger_m) = fingers { travel_m - finger_m } else { travel_m };
        let Some((last_t, last_m)) = self.last.replace((t, position_m)) else {
            self.mark_m = position_m;
            self.level_m = position_m;
            self.advanced_at = t;
            return;
        };
        let dt_s = 1e-6 * t.since(last_t).0 as f32;
        let mut dx_m = position_m - last_m;
        let stepped = self.smallest_m < f32::INFINITY;
        let step_m = if stepped { self.smallest_m } else { self.config.resolution_m };
        self.interval.push(t, dx_m, self.equal, step_m);
        self.watch_frozen(t, dx_m, others_gross);
        let read = self.interval.known();
        let read_s = read.map_or(dt_s, |read| dt_s.max(1e-6 * read.0 as f32));
        if dx_m.abs() > self.config.max_speed_m_s * read_s + 4.0 * self.config.resolution_m {
            self.leaps += 1;
            self.leaps_m += dx_m;
            self.mark_m += dx_m;
            self.level_m += dx_m;
            self.since_leap = 0;
            dx_m = 0.0;
        } else {
            self.since_leap = self.since_leap.saturating_add(1);
        }
        if fingers == Fingers::Moving {
            self.stand();
            self.mark_m = position_m;
            self.level_m = position_m;
            self.advanced_at = t;
            return;
        }
        if dx_m != 0.0 {
            self.smallest_m = self.smallest_m.min(dx_m.abs());
        }
        // Noise that is as large as a slip cannot be distinguished from one, and after a gap in time the object is elsewhere.
        let small = dx_m.abs() < self.config.limit_m;
        if let Some(sigma_m) = small.then(|| self.noise.push(dx_m, read.is_some())).flatten() {
            // In a slip the motion hides noise, and never adds to it.
            let slips = self.state != SlipState::Quiet;
            self.allow(if slips { sigma_m.max(self.sigma_m) } else { sigma_m });
        }
        let allowed_m = self.config.drift_m_s * dt_s;
        self.forward_m = (self.forward_m + dx_m - allowed_m).max(0.0);
        self.backward_m = (self.backward_m - dx_m - allowed_m).max(0.0);
        if self.state == SlipState::Quiet {
            self.longest = self.longest.max(self.equal);
            let most_m = LEVEL_SIGMAS * self.sigma_m.max(self.config.resolution_m);
            self.level_m += LEVEL * (position_m - self.level_m).max(-most_m).min(most_m);
        }
        self.decide(t, position_m);
    }

    #[inline]
    fn decide(&mut self, t: Micros, position_m: f32) {
        if (position_m - self.mark_m).abs() > self.advance_m {
            self.mark_m = position_m;
            self.advanced_at = t;
        }
        self.watch_direction();
        if self.state != SlipState::Quiet && t.since(self.advanced_at) > self.release {
            self.stand();
        } else if self.statistic() > 1.0 {
            self.state = SlipState::Gross;
        }
    }

    /// The object stands: both sums begin again.
    #[inline]
    pub fn stand(&mut self) {
        self.forward_m = 0.0;
        self.backward_m = 0.0;
        self.state = SlipState::Quiet;
        if let Some((_, last_m)) = self.last {
            self.level_m = last_m;
        }
    }

    #[inline]
    fn watch_direction(&mut self) {
        let (right, wrong) = match self.config.direction {
            Direction::Either => return,
            Direction::Rising => (self.forward_m, self.backward_m),
            Direction::Falling => (self.backward_m, self.forward_m),
        };
        if right > self.config.limit_m {
            self.backwards_now = false;
        } else if wrong > self.config.limit_m {
            self.backwards_now = true;
        }
    }

    #[inline]
    fn watch_frozen(&mut self, t: Micros, dx_m: f32, others_gross: bool) {
        if dx_m != 0.0 {
            self.frozen_now = false;
            self.contradicted_since = None;
            self.equal = 0;
            return;
        }
        self.equal = self.equal.saturating_add(1);
        if !others_gross {
            self.contradicted_since = None;
            return;
        }
        let since = *self.contradicted_since.get_or_insert(t);
        if self.equal >= FEWEST_EQUAL && t.since(since) > self.frozen {
            self.frozen_now = true;
        }
    }
}

// Interval between two readings of a sensor that is asked more often than it is read, from readings with their times.
//
// A sensor that is read each 2 ms and asked each 0.1 ms shows each reading twenty times. So does a coarse sensor of an object that creeps,
// but that moves on by single steps.

/// A reading that was shown for so many samples more ...
const STOOD: u32 = 3;
/// ... and then moves on by more than so many of the smallest steps was not read in between.
const STEPS_AT_ONCE: f32 = 2.5;
/// Moves before they show something. Older ones count half from the second number on.
const ENOUGH: u16 = 3;
const MOST: u16 = 32;
/// What moves less often than this is no sensor that is read at all, but one that leaps.
const LONGEST: Micros = Micros(20_000);

/// The time between two readings of a sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Interval {
    changed: Micros,
    /// Moves by several steps at once, and those of them by a reading that had stood.
    moves: u16,
    late: u16,
    shortest: Option<Micros>,
}

impl Interval {
    /// Takes how far (m) the next reading is from the one before, which was shown `equal` times more, with the smallest step seen (m).
    #[inline]
    pub(crate) fn push(&mut self, t: Micros, dx_m: f32, equal: u32, step_m: f32) {
        if dx_m == 0.0 {
            return;
        }
        let before = core::mem::replace(&mut self.changed, t);
        if dx_m.abs() <= STEPS_AT_ONCE * step_m {
            return;
        }
        if self.moves >= MOST {
            (self.moves, self.late) = (self.moves / 2, self.late / 2);
        }
        self.moves += 1;
        if equal >= STOOD {
            self.late += 1;
            let since = t.since(before);
            self.shortest = Some(self.shortest.map_or(since, |shortest| shortest.min(since)));
        }
    }

    /// That time, where the sensor is asked more often.
    #[inline]
    pub(crate) fn known(&self) -> Option<Micros> {
        self.shortest.filter(|&shortest| {
            self.late >= ENOUGH && 2 * self.late > self.moves && shortest <= LONGEST
        })
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod interval_tests {
    use super::Interval;
    use crate::units::Micros;

    /// What is known after a second at 10 kHz of a sensor that is read each `every` samples and shows `shown` (um) at a time (s).
    fn known(every: u64, shown: impl Fn(f64) -> f64) -> Option<Micros> {
        let (mut interval, mut equal) = (Interval::default(), 0);
        let (mut last, mut smallest) = (shown(0.0), f64::INFINITY);
        for i in 1..10_000_u64 {
            let now = shown(1e-4 * (i - i % every) as f64);
            let dx = now - last;
            last = now;
            #[expect(clippy::cast_possible_truncation, reason = "test signal")]
            interval.push(Micros(100 * i), dx as f32, equal, smallest as f32);
            equal = if dx == 0.0 { equal + 1 } else { 0 };
            smallest = if dx == 0.0 { smallest } else { smallest.min(dx.abs()) };
        }
        interval.known()
    }

    /// Rounded to a step (um).
    fn rounded(um: f64, step: f64) -> f64 {
        (um / step).round() * step
    }

    #[test]
    fn a_sensor_that_is_read_seldom_is_told_from_a_coarse_one_and_from_one_that_leaps() {
        let falls = |t: f64| 5e5 * t * t;
        let noise = |t: f64| 10.0 * (1e6 * t).sin();
        for every in [5, 10, 20, 50, 200] {
            let wanted = Some(Micros(100 * every));
            assert_eq!(known(every, |t| rounded(falls(t), 1.0)), wanted, "slides");
            assert_eq!(known(every, |t| rounded(noise(t), 1.0)), wanted, "rests, with noise");
        }
        for step in [1.0, 20.0, 200.0] {
            assert_eq!(known(1, |t| rounded(falls(t), step)), None, "steps of {step} um");
            assert_eq!(known(1, |t| rounded(1e3 * t, step)), None, "creeps in steps of {step} um");
        }
        assert_eq!(known(1, |t| rounded(noise(t), 1.0)), None, "noise");
        assert_eq!(known(20, |t| rounded(noise(t) / 10.0, 5.0)), None, "rests within a step");
        // Leaps of 10 mm each 50 ms, for one sample or for good.
        assert_eq!(known(1, |t| if t % 0.05 < 1e-4 { 1e4 } else { rounded(t, 1.0) }), None);
        assert_eq!(known(1, |t| rounded(t, 1.0) + 1e4 * (20.0 * t).floor()), None);
    }
}
