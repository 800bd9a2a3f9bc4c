//! Readings of the moved distance in slips in; whether they say less of the needed force than the stylus alone does, out.
//!
//! Third differences of readings that differ show the noise, since sliding leaves next to nothing of them; the smallest step shows the
//! resolution. The acceleration over 3 to 4 ms, on which the estimate rests, drowns in more than some micrometres of either.

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

/// Deviation of a reading that is rounded, over its step: 1 / sqrt(12).
const PER_STEP: f32 = 0.288_675_13;

/// What is known of the travel sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TravelQuality {
    last_m: [f32; 3],
    /// Readings that differed from the one before, and readings that did not.
    seen: u16,
    repeated: u16,
    mean_square: f32,
    coarse: bool,
}

impl TravelQuality {
    /// Another slip begins: the noise is measured anew. What was found stays until then.
    pub(super) fn begin(&mut self) {
        (self.seen, self.repeated, self.mean_square) = (0, 0, 0.0);
    }

    /// Takes a reading (m) while the object slips, with the deviation that is configured and the smallest step seen since the object was taken (m).
    pub(super) fn read(&mut self, travel_m: f32, configured_m: f32, step_m: f32) {
        let [one, two, three] = self.last_m;
        if self.seen > 0 && travel_m == one {
            self.repeated = self.repeated.saturating_add(1);
            return;
        }
        self.last_m = [travel_m, one, two];
        self.seen = self.seen.saturating_add(1);
        if self.seen > 3 {
            let third_m = (travel_m - three) - 3.0 * (one - two);
            let share = 1.0 / f32::from((self.seen - 3).min(4 * READINGS));
            self.mean_square += share * (third_m * third_m / THIRD - self.mean_square);
        }
        if self.seen > STEPS {
            // Between the steps of a coarse sensor readings repeat; those of a fast object do not.
            let rounding_m = if self.repeated >= self.seen { PER_STEP * step_m } else { 0.0 };
            let noise_m = libm::sqrtf(self.mean_square);
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

    /// An object that becomes faster from `speed_m_s` on, sampled at 10 kHz, rounded to `step_m` with every third reading off by `noise_m` (m).
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
            quality.read(shown_m, 0.0, smallest_m);
        }
        quality.is_coarse()
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
        quality.read(0.0, 0.0, 1e-6);
        assert!(quality.is_coarse(), "until it is measured again");
        assert!(!slid(&mut quality, 1e-6, 1e-6, 0.0), "the noise is gone");
    }
}
