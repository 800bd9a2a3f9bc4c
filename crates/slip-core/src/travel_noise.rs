//! Readings of the moved distance of an object that slides in; the deviation of one reading, and whether they say less of the needed force
//! than the stylus alone does, out.
//!
//! Third differences of readings that differ show the noise, since sliding leaves next to nothing of them; the smallest step shows the
//! resolution. The acceleration over 3 to 4 ms, on which the estimate rests, drowns in more than some micrometres of either.

use crate::{resolution::rounding, units::Micros};

/// Readings before a square can be told from the others, and the least mean of them (m2).
const ENOUGH: u16 = 16;
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
            let most =
                if self.seen > ENOUGH { most * self.mean_square.max(LEAST) } else { f32::INFINITY };
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
    #[expect(clippy::cast_precision_loss, reason = "a ratio of times")]
    let ratio = read.0 as f32 / OFTEN.0 as f32;
    libm::sqrtf(ratio.max(1.0))
}

#[cfg(test)]
mod tests {
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

    /// What is read seldom: the noise of the few readings counts for more, and too few of them say nothing of an acceleration.
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
