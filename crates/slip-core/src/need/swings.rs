//! Readings of the stylus during a slip in; its peaks and valleys, one by one, out.

/// A turn exceeds this many deviations of the noise, and this share of the mean swing.
const NOISES: f32 = 5.0;
const SHARE: f32 = 0.25;
/// Weight of the last swing in the mean.
const LAST: f32 = 0.3;

/// Where the stylus goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Way {
    #[default]
    Unknown,
    Up,
    Down,
}

/// What a reading is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seen {
    /// Neither.
    Between,
    /// Further than all since the last turn.
    Extreme,
    /// So far back from the extreme that the stylus has turned there; `ends` says whether another turn came before.
    Turn { ends: bool },
}

/// A stylus that goes up and down.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Swings {
    way: Way,
    begun: bool,
    high: f32,
    low: f32,
    last: f32,
    turned: bool,
    /// Mean swing (m).
    pub(super) mean_m: f32,
    /// Turns but for the first one.
    pub(super) turns: f32,
}

impl Swings {
    /// Range since the last turns (m).
    pub(super) fn range_m(&self) -> f32 {
        self.high - self.low
    }

    /// Takes the next reading (m); `sigma` is its noise (m, rms).
    pub(super) fn push(&mut self, x: f32, sigma: f32) -> Seen {
        if !self.begun {
            (self.begun, self.high, self.low, self.last) = (true, x, x, x);
        }
        let least = (NOISES * sigma).max(SHARE * self.mean_m);
        let mut extreme = false;
        if self.way != Way::Down && x > self.high {
            (self.high, extreme) = (x, true);
        }
        if self.way != Way::Up && x < self.low {
            (self.low, extreme) = (x, true);
        }
        match self.way {
            Way::Unknown if x - self.low > least => {
                (self.way, self.high, extreme) = (Way::Up, x, true);
            }
            Way::Unknown if self.high - x > least => {
                (self.way, self.low, extreme) = (Way::Down, x, true);
            }
            Way::Up if self.high - x > least => {
                let ends = self.turn(self.high);
                (self.way, self.low) = (Way::Down, x);
                return Seen::Turn { ends };
            }
            Way::Down if x - self.low > least => {
                let ends = self.turn(self.low);
                (self.way, self.high) = (Way::Up, x);
                return Seen::Turn { ends };
            }
            _ => {}
        }
        if extreme { Seen::Extreme } else { Seen::Between }
    }

    /// The stylus has turned at the height `at` (m).
    fn turn(&mut self, at: f32) -> bool {
        let swing = (at - self.last).abs();
        self.last = at;
        let ends = core::mem::replace(&mut self.turned, true);
        if ends {
            self.turns += 1.0;
            self.mean_m += if self.mean_m > 0.0 { LAST * (swing - self.mean_m) } else { swing };
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::{Seen, Swings};

    #[test]
    fn each_peak_and_valley_of_a_wave_is_a_turn_and_noise_is_none() {
        let mut swings = Swings::default();
        let mut seen = 0;
        for i in 0..2000_u16 {
            let noise = if i % 2 == 0 { 1e-7 } else { -1e-7 };
            let x = 3e-6 * libm::sinf(core::f32::consts::TAU * f32::from(i) / 200.0) + noise;
            seen += u32::from(matches!(swings.push(x, 1e-7), Seen::Turn { ends: true }));
        }
        assert_eq!(seen, 19, "ten periods have 20 turns, of which the first ends nothing");
        assert!((swings.mean_m - 6e-6).abs() < 4e-7, "{swings:?}");
    }
}
