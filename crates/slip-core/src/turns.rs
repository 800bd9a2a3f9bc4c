//! Peaks and valleys of a signal, one by one.

/// A turn exceeds this many deviations of the noise, and this share of the mean swing.
const NOISES: f32 = 5.0;
const SHARE: f32 = 0.25;
/// Weight of the last swing in the mean.
const LAST: f32 = 0.3;

/// Where the signal goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Unknown,
    Up,
    Down,
}

/// What a reading is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// Neither.
    Between,
    /// Further than all since the last turn.
    Extreme,
    /// So far back from the extreme that the signal has turned there; `ends` states whether another turn came before.
    Turned { ends: bool },
}

/// A signal that goes up and down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turns {
    way: Way,
    begun: bool,
    high: f32,
    low: f32,
    last: f32,
    turned: bool,
    mean: f32,
    count: f32,
}

impl Turns {
    /// Nothing was read yet.
    pub(crate) const NEW: Self = Self {
        way: Way::Unknown,
        begun: false,
        high: 0.0,
        low: 0.0,
        last: 0.0,
        turned: false,
        mean: 0.0,
        count: 0.0,
    };

    /// Mean swing, the unit of the signal; 0 before the second turn.
    pub(crate) fn swing(&self) -> f32 {
        self.mean
    }

    /// Range since the last turns.
    pub(crate) fn range(&self) -> f32 {
        self.high - self.low
    }

    /// Takes the next reading; `sigma` is its noise (rms).
    pub(crate) fn push(&mut self, x: f32, sigma: f32) -> Turn {
        if !self.begun {
            *self = Self { begun: true, high: x, low: x, last: x, ..Self::NEW };
        }
        let least = (NOISES * sigma).max(SHARE * self.mean);
        let mut extreme = false;
        if self.way != Way::Down && x > self.high {
            self.high = x;
            extreme = true;
        }
        if self.way != Way::Up && x < self.low {
            self.low = x;
            extreme = true;
        }
        let up = x - self.low > least;
        let down = self.high - x > least;
        match self.way {
            Way::Unknown if up => {
                self.way = Way::Up;
                self.high = x;
                extreme = true;
            }
            Way::Unknown if down => {
                self.way = Way::Down;
                self.low = x;
                extreme = true;
            }
            Way::Up if down => {
                let ends = self.turn(self.high);
                self.way = Way::Down;
                self.low = x;
                return Turn::Turned { ends };
            }
            Way::Down if up => {
                let ends = self.turn(self.low);
                self.way = Way::Up;
                self.high = x;
                return Turn::Turned { ends };
            }
            _ => {}
        }
        if extreme { Turn::Extreme } else { Turn::Between }
    }

    /// The signal has turned at `at`.
    fn turn(&mut self, at: f32) -> bool {
        let swing = (at - self.last).abs();
        self.last = at;
        let ends = core::mem::replace(&mut self.turned, true);
        if ends {
            self.count += 1.0;
            self.mean += if self.mean > 0.0 { LAST * (swing - self.mean) } else { swing };
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::{Turn, Turns};

    #[test]
    fn each_peak_and_valley_of_a_wave_is_a_turn_and_noise_is_none() {
        let mut turns = Turns::NEW;
        let mut seen = 0;
        for i in 0..2000_u16 {
            let noise = if i % 2 == 0 { 1e-7 } else { -1e-7 };
            let x = 3e-6 * libm::sinf(core::f32::consts::TAU * f32::from(i) / 200.0) + noise;
            seen += u32::from(matches!(turns.push(x, 1e-7), Turn::Turned { ends: true }));
        }
        assert_eq!(seen, 19, "ten periods have 20 turns, of which the first ends nothing");
        assert!((turns.swing() - 6e-6).abs() < 4e-7, "{turns:?}");
    }

    #[test]
    fn a_slow_ramp_or_noise_has_no_turns_and_one_way_back_ends_no_distance() {
        let mut turns = Turns::NEW;
        for i in 0..1000_u16 {
            let noise = if i % 3 == 0 { 2e-7 } else { -1e-7 };
            let turn = turns.push(1e-8 * f32::from(i) + noise, 1e-7);
            assert!(!matches!(turn, Turn::Turned { .. }), "{i}");
        }
        let back = (0..200_u16).map(|i| turns.push(1e-5 - 1e-7 * f32::from(i), 1e-7));
        let turned: u16 = back.map(|turn| u16::from(turn == Turn::Turned { ends: false })).sum();
        assert_eq!((turned, turns.swing()), (1, 0.0));
    }

    /// A swing that is small against those before it is no turn; one reading that is none changes nothing.
    #[test]
    fn small_swings_among_large_ones_and_what_is_no_number_are_no_turns() {
        let mut turns = Turns::NEW;
        let large = |i: u16| 1e-5 * libm::sinf(core::f32::consts::TAU * f32::from(i) / 100.0);
        (0..400).for_each(|i| {
            turns.push(large(i), 1e-8);
        });
        let before = turns.swing();
        for i in 0..100_u16 {
            let turn = turns.push(large(400) + if i % 10 < 5 { 1e-6 } else { 0.0 }, 1e-8);
            assert!(!matches!(turn, Turn::Turned { .. }), "{i}");
        }
        assert_eq!(turns.push(f32::NAN, 1e-8), Turn::Between);
        assert!(turns.swing() == before && turns.range().is_finite());
    }
}
