//! Moved distance in; mean speed and acceleration of the object over the last blocks of 4 ms out.
//!
//! ```text
//! x_k = mean of the readings of block k,   v = (x_2 - x_1) / T,   a = (v - (x_1 - x_0) / T) / T
//! ```
//!
//! The impulse balance ([`crate::observation`]) needs an acceleration of the last 3 ms and a sensor of a micrometre. Whether an object
//! slides on or slows down is a coarser question, and the mean of a block answers it for a coarse sensor too: n readings with the
//! deviation s each give v to sqrt(2 / n) s / T. With 10 um at 10 kHz that is 0.6 mm/s, at 1 kHz 1.8 mm/s. Speed and acceleration lag by
//! one block and by one and a half.

use crate::units::Micros;

/// Length of a block.
const BLOCK: Micros = Micros(4000);
/// A course that ended longer ago than this and two blocks says nothing of now.
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
            #[expect(clippy::cast_precision_loss, reason = "test signal")]
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
