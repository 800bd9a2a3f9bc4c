//! Readings with their times in; the time between two of them out, of a sensor that is asked more often than it is read.
//!
//! A sensor that is read each 2 ms and asked each 0.1 ms shows each reading twenty times. So does a coarse sensor of an object that creeps,
//! but that moves on by single steps.

use crate::units::Micros;

/// A reading that was shown for so many samples more ...
const STOOD: u32 = 3;
/// ... and then moves on by more than so many of the smallest steps was not read in between.
const STEPS_AT_ONCE: f32 = 2.5;
/// Moves before they say something. Older ones count half from the second number on.
const ENOUGH: u16 = 3;
const MOST: u16 = 32;
/// What moves less often than this is no sensor that is read at all, but one that leaps.
const LONGEST: Micros = Micros(20_000);

/// The time between two readings of a sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Interval {
    changed: Micros,
    /// Moves by several steps at once, and those of them by a reading that had stood.
    moves: u16,
    late: u16,
    shortest: Option<Micros>,
}

impl Interval {
    /// Takes how far (m) the next reading is from the one before, which was shown `equal` times more, with the smallest step seen (m).
    #[inline]
    pub(super) fn push(&mut self, t: Micros, dx_m: f32, equal: u32, step_m: f32) {
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
    pub(super) fn known(&self) -> Option<Micros> {
        self.shortest.filter(|&shortest| {
            self.late >= ENOUGH && 2 * self.late > self.moves && shortest <= LONGEST
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Interval;
    use crate::units::Micros;

    /// What is known after a second at 10 kHz of a sensor that is read each `every` samples and shows `shown` (um) at a time (s).
    fn known(every: u64, shown: impl Fn(f64) -> f64) -> Option<Micros> {
        let (mut interval, mut equal) = (Interval::default(), 0);
        let (mut last, mut smallest) = (shown(0.0), f64::INFINITY);
        for i in 1..10_000_u64 {
            #[expect(clippy::cast_precision_loss, reason = "test signal")]
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
