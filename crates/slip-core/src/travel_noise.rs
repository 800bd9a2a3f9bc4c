//! Noise of a travel in motion, by third differences of its readings.

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
