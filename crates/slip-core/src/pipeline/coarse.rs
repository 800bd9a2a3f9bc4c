//! Readings of the moved distance in slips in; whether they say less of the needed force than the stylus alone does, out.
//!
//! Third differences of readings that differ show the noise, since sliding leaves next to nothing of them; the smallest step shows the
//! resolution. The acceleration over 3 to 4 ms, on which the estimate rests, drowns in more than some micrometres of either.

use crate::resolution::Resolution;

/// A deviation of a reading (m) beyond which the sensor is coarse, and below which it no longer is.
const COARSE_M: f32 = 4e-6;
const FINE_M: f32 = 2.5e-6;
/// Readings of a slip that differ before the smallest step between them is judged, and their noise; its mean is one over four times as many at most.
const STEPS: u16 = 4;
const READINGS: u16 = 48;
/// Readings that are rounded to a step, and left out where they repeat, look noisier by up to this factor.
const ROUNDED: f32 = 2.5;
/// The deviation of a third difference over that of a reading, squared.
const THIRD: f32 = 20.0;

/// What is known of the travel sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TravelQuality {
    resolution: Resolution,
    last_m: [f32; 3],
    seen: u16,
    mean_square: f32,
    coarse: bool,
}

impl TravelQuality {
    /// Another slip begins: the noise is measured anew. What was found stays until then.
    pub(super) fn begin(&mut self) {
        (self.seen, self.mean_square) = (0, 0.0);
    }

    /// Takes a reading (m) while the object slips; `configured_m` is its deviation as far as that is configured (m).
    pub(super) fn read(&mut self, travel_m: f32, configured_m: f32) {
        let [one, two, three] = self.last_m;
        if self.seen > 0 && travel_m == one {
            return;
        }
        self.resolution.push(travel_m);
        self.last_m = [travel_m, one, two];
        self.seen = self.seen.saturating_add(1);
        if self.seen > 3 {
            let third_m = (travel_m - three) - 3.0 * (one - two);
            let share = 1.0 / f32::from((self.seen - 3).min(4 * READINGS));
            self.mean_square += share * (third_m * third_m / THIRD - self.mean_square);
        }
        if self.seen > STEPS {
            let (noise_m, rounding_m) = (libm::sqrtf(self.mean_square), self.resolution.rms());
            let noisy = self.seen > READINGS && noise_m > ROUNDED * rounding_m;
            let sigma_m = if noisy { noise_m } else { rounding_m }.max(configured_m);
            let known = self.seen > READINGS || sigma_m > COARSE_M;
            if known {
                self.coarse = sigma_m > if self.coarse { FINE_M } else { COARSE_M };
            }
        }
    }

    pub(super) fn is_coarse(&self) -> bool {
        self.coarse
    }
}

#[cfg(test)]
mod tests {
    use super::TravelQuality;

    /// An object that becomes faster, sampled at 10 kHz, rounded to `step_m` with every third reading off by `noise_m` (m).
    fn slid(quality: &mut TravelQuality, step_m: f32, noise_m: f32) -> bool {
        quality.begin();
        for i in 0..1000_u16 {
            let t_s = 1e-4 * f32::from(i);
            let off_m = if i % 3 == 0 { noise_m } else { 0.0 };
            quality.read(((2.0 * t_s * t_s + off_m) / step_m).floor() * step_m, 0.0);
        }
        quality.is_coarse()
    }

    #[test]
    fn coarse_steps_and_noise_are_found_and_forgotten() {
        let mut quality = TravelQuality::default();
        assert!(slid(&mut quality, 2e-5, 0.0), "an encoder with steps of 20 um");
        let mut quality = TravelQuality::default();
        assert!(!slid(&mut quality, 1e-6, 1e-6));
        assert!(slid(&mut quality, 1e-6, 2e-5), "noise");
        quality.begin();
        quality.read(0.0, 0.0);
        assert!(quality.is_coarse(), "until it is measured again");
        assert!(!slid(&mut quality, 1e-6, 1e-6), "the noise is gone");
    }
}
