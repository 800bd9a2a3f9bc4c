//! How an object slides: its mean speed and acceleration by travel, how far travel can be trusted, and by the turns of a stylus.
//!
//! ```text
//! x_k = mean of the readings of block k,   v = (x_2 - x_1) / T,   a = (v - (x_1 - x_0) / T) / T
//! ```
//!
//! The impulse balance ([`crate::observation`]) needs an acceleration of the last 3 ms and a sensor of a micrometre. Whether an object
//! slides on or slows down is a coarser question, and the mean of a block answers it for a coarse sensor too: n readings with the
//! deviation s each give v to sqrt(2 / n) s / T. With 10 um at 10 kHz that is 0.6 mm/s, at 1 kHz 1.8 mm/s. Speed and acceleration lag by
//! one block and by one and a half.

use crate::{sample::rounding, units::Micros};

/// Length of a block.
const BLOCK: Micros = Micros(4000);
/// A course that ended longer ago than this and two blocks shows nothing of now.
const LASTS: Micros = Micros(15_000);

/// How the object moved lately.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Speed against the finger (m/s), at least 0.
    pub speed_m_s: f32,
    /// Its growth (m/s^2), below 0 where the object slows down; `None` before the third block.
    pub acceleration_m_s2: Option<f32>,
}

impl Motion {
    /// An object that stops within this time (s), if it goes on as it does, slows down, ...
    const STOPS_WITHIN_S: f32 = 0.1;
    /// ... and so does one with half of the deceleration that the margin of an estimate gives it (m/s^2).
    const DECELERATES_M_S2: f32 = 1.0;

    /// What is no faster than this (m/s) does not slide, ...
    const CREEP_M_S: f32 = 5e-4;
    /// ... nor what is no faster than this many deviations of a reading in a second: a speed is the difference of two means of at least four
    /// readings over 4 ms.
    const NOISE_PER_S: f32 = 500.0;

    /// Whether the object slides, by readings with the deviation `travel_sigma_m` (m).
    #[must_use]
    pub fn slides(&self, travel_sigma_m: f32) -> bool {
        self.speed_m_s > Self::CREEP_M_S.max(Self::NOISE_PER_S * travel_sigma_m)
    }

    /// Whether the object slows down enough to stop by itself.
    #[must_use]
    pub fn slows(&self) -> bool {
        let enough_m_s2 = (self.speed_m_s / Self::STOPS_WITHIN_S).min(Self::DECELERATES_M_S2);
        self.acceleration_m_s2.is_some_and(|a| -a >= enough_m_s2)
    }
}

/// Mean time (s since the origin) and place (m from the origin) of a block.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    t_s: f32,
    x_m: f32,
}

/// The blocks and their memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Course {
    origin: Option<(Micros, f32)>,
    begun: Micros,
    last: Micros,
    sum: Point,
    readings: u16,
    points: [Point; 3],
    filled: u8,
    motion: Option<Motion>,
}

impl Course {
    /// Begins afresh with the next reading.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Takes a reading of the moved distance (m, finite).
    pub fn push(&mut self, t: Micros, travel_m: f32) {
        if self.origin.is_some() && t.since(self.last) > LASTS {
            self.reset();
        }
        let (t0, x0) = *self.origin.get_or_insert((t, travel_m));
        if self.readings == 0 {
            self.begun = t;
        }
        self.last = t;
        #[expect(clippy::cast_possible_truncation, reason = "seconds of one slip")]
        let t_s = t.since(t0).as_seconds() as f32;
        self.sum.t_s += t_s;
        self.sum.x_m += travel_m - x0;
        self.readings = self.readings.saturating_add(1);
        // A reading stands for the time up to the next one: on average this time over the steps, which is at least what is left of
        // the block where this time is at least as many steps as long.
        let (passed, steps) = (t.since(self.begun), u64::from(self.readings.saturating_sub(1)));
        let left = BLOCK.since(passed);
        if left == Micros(0) || (steps > 0 && passed.0 >= left.0 * steps) {
            self.end_block();
        }
    }

    fn end_block(&mut self) {
        let n = f32::from(self.readings);
        let [_, middle, last] = self.points;
        self.points = [middle, last, Point { t_s: self.sum.t_s / n, x_m: self.sum.x_m / n }];
        self.filled = (self.filled + 1).min(3);
        self.sum = Point::default();
        self.readings = 0;
        self.motion = self.motion_of_blocks();
    }

    /// How the object moved over the last blocks; `None` before the second one, and at `t` too long after the last reading.
    #[must_use]
    #[inline]
    pub fn motion(&self, t: Micros) -> Option<Motion> {
        self.motion.filter(|_| t.since(self.last) <= LASTS)
    }

    fn motion_of_blocks(&self) -> Option<Motion> {
        if self.filled < 2 {
            return None;
        }
        let [first, middle, last] = self.points;
        let slope = |from: Point, to: Point| (to.x_m - from.x_m) / (to.t_s - from.t_s);
        let speed = slope(middle, last);
        let before = (self.filled == 3).then(|| slope(first, middle));
        let acceleration_m_s2 = before.map(|before| {
            (speed - before).copysign(speed * (speed - before)) / (0.5 * (last.t_s - first.t_s))
        });
        let motion = Motion { speed_m_s: speed.abs(), acceleration_m_s2 };
        let finite = speed.is_finite() && acceleration_m_s2.is_none_or(f32::is_finite);
        finite.then_some(motion)
    }
}

// Counter of the peaks and valleys that a stylus has passed, and whether it passes fewer and fewer.
//
// One stylus cannot show how fast an object slides, since the spacing of the surface is not known. But the rate of its turns follows the speed,
// so that it falls where the object slows down.

/// Turns of one slip, counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnCount {
    /// The readings, smoothed.
    smooth: f32,
    extreme: Option<f32>,
    rising: bool,
    count: u32,
}

impl TurnCount {
    /// Takes the next reading; `noise` is the noise in the vibration band (rms, same unit). Whether there was a turn.
    #[inline]
    pub fn step(&mut self, x: f32, noise: f32) -> bool {
        let Some(extreme) = &mut self.extreme else {
            (self.smooth, self.extreme) = (x, Some(x));
            return false;
        };
        self.smooth += SMOOTHING * (x - self.smooth);
        let x = self.smooth;
        let ahead = if self.rising { x - *extreme } else { *extreme - x };
        if ahead >= 0.0 {
            *extreme = x;
        } else if -ahead > NOISES * noise {
            *extreme = x;
            self.rising = !self.rising;
            self.count = self.count.saturating_add(1);
            return true;
        }
        false
    }

    /// Peaks and valleys so far.
    #[must_use]
    #[inline]
    pub fn count(&self) -> u32 {
        self.count
    }
}

/// Turns of one slip, with their rate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turns {
    turns: TurnCount,
    /// Turns per second, lately and at most.
    rate: f32,
    most: f32,
    /// Range of the readings.
    low: f32,
    high: f32,
    countable: bool,
}

/// What the turns state of the movement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passing {
    /// Peaks and valleys a second.
    pub turns_per_s: f32,
    /// Whether that falls: the object slows down.
    pub slows: bool,
}

/// Deviations of the noise in the vibration band that a turn exceeds.
const NOISES: f32 = 12.0;
/// Weight of a reading in the smoothed signal, which leaves 0.38 of white noise.
const SMOOTHING: f32 = 0.25;
/// Time constant of the rate (s).
const TAU_S: f32 = 0.01;
/// Share of the largest rate below which the object slows down.
const SLOWER: f32 = 0.85;
/// A rate is believed from this many turns on.
const ENOUGH: u32 = 6;

impl Turns {
    /// Below this sample rate (Hz) a fast surface is not resolved.
    pub const LEAST_RATE_HZ: f32 = 6000.0;

    /// Takes the next reading, `dt_s` after the one before; `noise` is the noise in the vibration band (rms, same unit).
    #[inline]
    pub fn step(&mut self, x: f32, noise: f32, dt_s: f32) {
        if self.turns.extreme.is_none() {
            (self.low, self.high) = (x, x);
        }
        let turns = self.turns.step(x, noise);
        if !self.countable {
            let x = self.turns.smooth;
            (self.low, self.high) = (self.low.min(x), self.high.max(x));
            self.countable = self.high - self.low > 2.0 * NOISES * noise;
        }
        let share = (dt_s / TAU_S).min(1.0);
        self.rate -= share * self.rate;
        if turns {
            self.rate += 1.0 / TAU_S;
            if self.turns.count() >= ENOUGH {
                self.most = self.most.max(self.rate);
            }
        }
    }

    /// What they report; `None` where the surface is too smooth to count them.
    #[must_use]
    pub fn passing(&self) -> Option<Passing> {
        let slows = self.most > 0.0 && self.rate < SLOWER * self.most;
        self.countable.then_some(Passing { turns_per_s: self.rate, slows })
    }
}

// Readings of the moved distance of an object that slides in; the deviation of one reading, and whether they show less of the needed force
// than the stylus alone does, out.
//
// Third differences of readings that differ show the noise, since sliding leaves next to nothing of them; the smallest step shows the
// resolution. The acceleration over 3 to 4 ms, on which the estimate rests, drowns in more than some micrometres of either.

/// Readings before a square can be distinguished from the others, and the least mean of them (m2).
const TRAVEL_NOISE_ENOUGH: u16 = 16;
const LEAST: f32 = 1e-12;

/// Noise as third differences of readings that differ, of which sliding leaves next to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TravelNoise {
    last_m: [f32; 3],
    seen: u16,
    mean_square: f32,
}

impl TravelNoise {
    /// Takes the next reading (m) into a mean over the last `readings`; `false` where it repeats the one before. A square
    /// counts as `most` times their mean at most, once there are enough of them.
    pub(crate) fn push(&mut self, travel_m: f32, readings: u16, most: f32) -> bool {
        let [one, two, three] = self.last_m;
        if self.seen > 0 && travel_m == one {
            return false;
        }
        self.last_m = [travel_m, one, two];
        self.seen = self.seen.saturating_add(1);
        if self.seen > 3 {
            let third_m = (travel_m - three) - 3.0 * (one - two);
            let share = 1.0 / f32::from((self.seen - 3).min(readings));
            let most = if self.seen > TRAVEL_NOISE_ENOUGH {
                most * self.mean_square.max(LEAST)
            } else {
                f32::INFINITY
            };
            self.mean_square += share * ((third_m * third_m).min(most) - self.mean_square);
        }
        true
    }

    /// Readings so far that differed from the one before.
    pub(crate) fn seen(&self) -> u16 {
        self.seen
    }

    /// Deviation of one reading (m): that of a third difference is sqrt(20) times as large.
    pub(crate) fn sigma_m(&self) -> f32 {
        libm::sqrtf(self.mean_square / 20.0)
    }
}

/// A deviation of a reading (m) beyond which the sensor is coarse, and below which it no longer is.
const COARSE_M: f32 = 4e-6;
const FINE_M: f32 = 2.5e-6;
/// Readings of a slip that differ before the smallest step between them is judged ...
const STEPS: u16 = 4;
/// ... and before their noise is, as a mean over four times as many at most.
const READINGS: u16 = 48;
/// What is further off than the root of so many times the mean of the squares is a leap, or samples were lost: no noise.
const LEAP: f32 = 16.0;
/// Readings that are rounded to a step, and left out where they repeat, look noisier by up to this factor.
const ROUNDED: f32 = 2.5;
/// Time between two readings that the deviations are for, and from where the acceleration over 3 to 4 ms has too few of them.
const OFTEN: Micros = Micros(100);
const SLOW: Micros = Micros(2500);

/// What is known of the travel sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TravelQuality {
    noise: TravelNoise,
    /// Readings that did not differ from the one before.
    repeated: u16,
    coarse: bool,
}

impl TravelQuality {
    /// Another slip begins: the noise is measured anew. What was found stays until then.
    pub(crate) fn begin(&mut self) {
        (self.noise, self.repeated) = (TravelNoise::default(), 0);
    }

    /// Takes a reading (m) while the object slips, with the deviation that it has at least (m), the smallest step seen since the object was
    /// taken (m), and the time between two readings where the sensor is asked more often.
    pub(crate) fn read(&mut self, travel_m: f32, least_m: f32, step_m: f32, read: Option<Micros>) {
        if !self.noise.push(travel_m, 4 * READINGS, LEAP) {
            self.repeated = self.repeated.saturating_add(1);
            return;
        }
        let seen = self.noise.seen();
        if seen <= STEPS && read.is_none() {
            return;
        }
        // Between the steps of a coarse sensor readings repeat; those of a fast object do not.
        let rounding_m = if self.repeated >= seen { rounding(step_m) } else { 0.0 };
        let noise_m = if seen > READINGS { self.noise.sigma_m() } else { 0.0 };
        let noisy = noise_m > ROUNDED * rounding_m;
        let one_m = if noisy { noise_m } else { rounding_m }.max(least_m);
        let sigma_m = one_m * read.map_or(1.0, scarcity);
        let slow = read.is_some_and(|read| read > SLOW);
        if seen > READINGS || sigma_m > COARSE_M || slow {
            self.coarse = slow || sigma_m > if self.coarse { FINE_M } else { COARSE_M };
        }
    }

    pub(crate) fn is_coarse(&self) -> bool {
        self.coarse
    }
}

/// The deviation of the mean over readings with this time between them, over that of [`OFTEN`].
fn scarcity(read: Micros) -> f32 {
    let ratio = read.0 as f32 / OFTEN.0 as f32;
    libm::sqrtf(ratio.max(1.0))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Course;
    use crate::units::Micros;

    /// Readings of `x` at `rate_hz` for `ms`.
    fn course(rate_hz: u64, ms: u64, x: impl Fn(f32) -> f32) -> (Course, Micros) {
        let mut course = Course::default();
        let mut now = Micros(0);
        for i in 0..ms * rate_hz / 1000 {
            now = Micros(7_000_000 + i * 1_000_000 / rate_hz);
            course.push(now, x(i as f32 / rate_hz as f32));
        }
        (course, now)
    }

    /// A block ends where the time so far and the mean time between its readings are together as long as one.
    #[test]
    fn a_block_ends_with_the_reading_that_stands_for_its_last_part() {
        for steps_us in
            [[100_u64, 100, 100], [333, 334, 333], [1900, 7, 600], [4000, 1, 2], [5000, 1, 1]]
        {
            let (mut course, mut now, mut times) = (Course::default(), 0, std::vec![0]);
            course.push(Micros(0), 0.0);
            for step_us in steps_us.iter().cycle().take(200) {
                let filled = course.readings;
                now += step_us;
                course.push(Micros(now), 1e-6);
                if filled == 0 {
                    times.clear();
                }
                times.push(now);
                let (passed, steps) = (now - times[0], times.len() as u64 - 1);
                let period = passed.checked_div(steps).unwrap_or(0);
                assert_eq!(course.readings == 0, passed + period >= 4000, "{steps_us:?} {now}");
            }
        }
    }

    #[test]
    fn a_fall_is_measured_at_any_rate_and_with_any_sign() {
        for rate_hz in [500, 1000, 10_000] {
            for sign in [1.0, -1.0] {
                let (course, now) = course(rate_hz, 40, |t| sign * 2.0 * t * t);
                let motion = course.motion(now).unwrap();
                let late = 0.04 - 0.004;
                assert!((motion.speed_m_s - 4.0 * late).abs() < 0.02, "{rate_hz} {motion:?}");
                let a = motion.acceleration_m_s2.unwrap();
                assert!((a - 4.0).abs() < 0.05 && !motion.slows(), "{rate_hz} {motion:?}");
            }
        }
    }

    #[test]
    fn an_object_that_stops_soon_slows_and_one_that_slides_evenly_does_not() {
        let (braked, now) = course(10_000, 20, |t| 0.1 * t - t * t);
        assert!(braked.motion(now).unwrap().slows());
        let (even, now) = course(10_000, 20, |t| 0.01 * t);
        assert!(!even.motion(now).unwrap().slows());
        let (fast, now) = course(10_000, 20, |t| t - 0.6 * t * t);
        assert!(fast.motion(now).unwrap().slows(), "braked, though it takes long");
        let (slowly, now) = course(10_000, 20, |t| 0.2 * t - 0.1 * t * t);
        assert!(!slowly.motion(now).unwrap().slows(), "in a second");
    }

    #[test]
    fn coarse_readings_say_whether_it_slides() {
        let (coarse, now) = course(1000, 40, |t| (0.02 * t / 2e-5).round() * 2e-5);
        let motion = coarse.motion(now).unwrap();
        assert!((motion.speed_m_s - 0.02).abs() < 0.004, "{motion:?}");
    }

    #[test]
    fn nothing_is_stated_too_early_or_too_late() {
        let (early, now) = course(10_000, 7, |t| t);
        assert_eq!(early.motion(now), None);
        let (late, now) = course(10_000, 20, |t| t);
        assert!(late.motion(now).is_some());
        assert_eq!(late.motion(now.plus(Micros(16_000))), None);
    }
}

#[cfg(test)]
mod travel_noise_tests {
    use super::TravelQuality;
    use crate::units::Micros;

    /// An object that becomes faster from `speed_m_s` on, sampled at 10 kHz, rounded to `step_m` with every third
    /// reading off by `noise_m` (m).
    fn slid(quality: &mut TravelQuality, step_m: f32, noise_m: f32, speed_m_s: f32) -> bool {
        quality.begin();
        let (mut last_m, mut smallest_m) = (0.0_f32, f32::INFINITY);
        for i in 0..1000_u16 {
            let t_s = 1e-4 * f32::from(i);
            let off_m = if i % 3 == 0 { noise_m } else { 0.0 };
            let shown_m = (((speed_m_s + 2.0 * t_s) * t_s + off_m) / step_m).floor() * step_m;
            if shown_m != last_m {
                smallest_m = smallest_m.min((shown_m - last_m).abs());
            }
            last_m = shown_m;
            quality.read(shown_m, 0.0, smallest_m, None);
        }
        quality.is_coarse()
    }

    /// Readings at 10 kHz of an object that is accelerated at 4 m/s2, with a leap of the reading by `leap_m` once, and each
    /// time after `lost` samples of 200.
    #[test]
    fn lost_samples_and_a_leap_are_no_noise() {
        for (leap_m, lost) in [(2.5e-4_f32, 0), (0.0, 10), (2.5e-4, 10)] {
            let mut quality = TravelQuality::default();
            quality.begin();
            for i in (0..2000_u16).filter(|i| i % 200 >= lost) {
                let t_s = 1e-4 * f32::from(i);
                let flicker_m = 1e-6 * f32::from(i * 7 % 3);
                let shown_m = 2.0 * t_s * t_s + flicker_m + if i > 700 { leap_m } else { 0.0 };
                quality.read(shown_m, 0.0, 1e-6, None);
                assert!(!quality.is_coarse(), "{leap_m} m, {lost} lost: sample {i}");
            }
        }
    }

    /// What is read seldom: the noise of the few readings counts for more, and too few of them show nothing of an acceleration.
    #[test]
    fn few_readings_are_coarse_sooner() {
        let coarse = |noise_m, read| {
            let mut quality = TravelQuality::default();
            (0..200_u16).for_each(|i| quality.read(1e-5 * f32::from(i / 20), noise_m, 1e-6, read));
            quality.is_coarse()
        };
        assert!(!coarse(2e-6, None) && coarse(2e-6, Some(Micros(2000))));
        assert!(!coarse(3e-7, Some(Micros(2000))) && coarse(3e-7, Some(Micros(5000))));
    }

    #[test]
    fn coarse_steps_and_noise_are_found_and_forgotten() {
        assert!(
            slid(&mut TravelQuality::default(), 2e-5, 0.0, 0.0),
            "an encoder with steps of 20 um"
        );
        let mut quality = TravelQuality::default();
        assert!(!slid(&mut quality, 1e-6, 1e-6, 0.0));
        assert!(
            !slid(&mut quality, 1e-6, 0.0, 0.3),
            "an object that is fast from the first reading on"
        );
        assert!(slid(&mut quality, 1e-6, 2e-5, 0.0), "noise");
        quality.begin();
        quality.read(0.0, 0.0, 1e-6, None);
        assert!(quality.is_coarse(), "until it is measured again");
        assert!(!slid(&mut quality, 1e-6, 1e-6, 0.0), "the noise is gone");
    }
}
