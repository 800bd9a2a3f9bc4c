//! The force of least expected loss: what an object of each hypothesis makes of a force, weighed by how likely it is.
//!
//! A force that is commanded now is there after the dead time and the lag of the drive; until then the object moves under what is on its way. From
//! there on it either slides to a stop, or until the next answer, which knows the need better. What it slides costs little at first, and as a fall the
//! more it is. What presses harder than the object needs costs little at first, and as a crushed object near [`CRUSHES`] times the need. A force that
//! is too low can be raised later, one that was too high has crushed: so a slip of which little is known is answered with the force that is missing
//! least, and one that leaves no time with more.
//!
//! Let s (m) be what a hypothesis slides from now on and f its force over what it bears:
//!
//! ```text
//! loss = fall(s) + crush(f) + SLIPS s / (s + 1 mm) + PRESSES max(0, ln f - 0.2)^2
//! fall(s) = c / (1 + c / 2),  c = ln(1 + (s / 10 mm)^4)        crush(f) = (f / 2.3)^16 / (1 + (f / 2.3)^16)
//! ```

use super::bank::Expected;
use super::math::{at_least, at_most, exp, ln};
use crate::estimate::G_M_S2;

/// Forces that are tried: the logarithm of the first one over the force at the alarm, from one to the next, and how many.
const FIRST: f32 = -0.1;
const STEP: f32 = 0.1;
const FORCES: usize = 40;
/// What an object that slides so far from now on (m) costs as a fall, and at most.
const FALLS_M: f32 = 0.01;
const FALL_MOST: f32 = 2.0;
/// A force of this many times what it bears crushes half of the objects.
const CRUSHES: f32 = 2.3;
/// Cost of a slip, half of it for this distance (m).
const SLIPS: f32 = 0.15;
const SLIPS_M: f32 = 1e-3;
/// Cost of a force over what it bears and this margin (logarithm).
const PRESSES: f32 = 0.5;
const MARGIN: f32 = 0.2;
/// The next answer comes after this share of the delay of this one, and brakes with this much of the weight.
const NEXT: f32 = 0.7;
const BRAKES: f32 = 0.8;
/// A force that is over the load by less than this share stops nothing.
const STOPS: f32 = 0.02;
/// The longest delay (s) that is reckoned with.
const LONGEST_S: f32 = 0.2;
/// An object that is slower than this (m/s) stands.
const STANDS_M_S: f32 = 1e-4;

/// Delay of the drive (s), the force that presses until then, that at the alarm, and the largest there is (N).
#[derive(Clone, Copy, Debug)]
pub(super) struct Drives {
    pub(super) delay_s: f32,
    pub(super) on_way_n: f32,
    pub(super) from_n: f32,
    pub(super) most_n: f32,
}

/// Expected losses of the forces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Losses {
    drives: Drives,
    first_ln: f32,
    forces: [f32; FORCES],
    losses: [f32; FORCES],
}

impl Losses {
    /// No hypothesis has been weighed.
    pub(super) fn new(drives: Drives) -> Self {
        let delay_s = at_most(at_least(drives.delay_s, 0.0), LONGEST_S);
        let most_n = at_least(drives.most_n, 0.0);
        let on_way_n = at_most(at_least(drives.on_way_n, 0.0), most_n);
        let drives = Drives { delay_s, on_way_n, most_n, ..drives };
        let first_ln = ln(at_least(drives.from_n, 1e-3)) + FIRST;
        #[expect(clippy::cast_precision_loss, reason = "a few forces")]
        let forces = core::array::from_fn(|k| exp(first_ln + STEP * k as f32));
        Self { drives, first_ln, forces, losses: [0.0; FORCES] }
    }

    /// A hypothesis of this weight.
    pub(super) fn add(&mut self, w: f32, object: &Expected) {
        let delay_s = self.drives.delay_s;
        let soon = |from, s| at_least(at_most(from + object.rate * s, object.most), from);
        let load = soon(object.load, delay_s);
        let a = G_M_S2 * (0.5 * (object.load + load) - self.drives.on_way_n * object.per_n);
        let v = at_least(object.v + a * delay_s, 0.0);
        let comes_m = at_least(0.5 * (object.v + v) * delay_s, 0.0);
        let next_s = NEXT * delay_s;
        let later = soon(load, next_s);
        // It bears its weight at least.
        let bears = at_least(load, 1.0);
        let (per_n, bears_ln) = (object.per_n, object.need_ln + ln(bears));
        #[expect(clippy::cast_precision_loss, reason = "a few forces")]
        for (k, (force_n, loss)) in self.forces.iter().zip(&mut self.losses).enumerate() {
            let held = force_n * per_n;
            let over = held - load;
            let moves = v > STANDS_M_S || later > held;
            let stops_m = if over > STOPS { v * v / (2.0 * G_M_S2 * over) } else { f32::MAX };
            let left = at_least(v - G_M_S2 * over * next_s, 0.0);
            let again_m = 0.5 * (v + left) * next_s + left * left / (2.0 * G_M_S2 * BRAKES);
            let slip_m = comes_m + if moves { at_most(stops_m, again_m) } else { 0.0 };
            let much = at_least(self.first_ln + STEP * k as f32 - bears_ln - MARGIN, 0.0);
            let crush = power16(held / (CRUSHES * bears));
            *loss += w
                * (fall(slip_m)
                    + crush / (1.0 + crush)
                    + SLIPS * slip_m / (slip_m + SLIPS_M)
                    + PRESSES * much * much);
        }
    }

    /// The force of the least loss (N), between two that were tried by a parabola.
    pub(super) fn best_n(&self) -> f32 {
        let mut best = 0;
        for (k, loss) in self.losses.iter().enumerate() {
            if self.losses.get(best).is_some_and(|least| loss < least) {
                best = k;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "a few forces")]
        let mut place = best as f32;
        let around = best.checked_sub(1).and_then(|before| self.losses.get(before..before + 3));
        if let Some([before, least, after]) = around {
            let curve = before - 2.0 * least + after;
            if curve > 1e-9 {
                place += at_most(at_least(0.5 * (before - after) / curve, -0.5), 0.5);
            }
        }
        at_most(exp(self.first_ln + STEP * place), self.drives.most_n)
    }
}

/// Cost of a slip of this length (m) as a fall.
fn fall(slip_m: f32) -> f32 {
    let share2 = (slip_m / FALLS_M) * (slip_m / FALLS_M);
    let cost = ln(1.0 + share2 * share2);
    cost / (1.0 + cost / FALL_MOST)
}

fn power16(x: f32) -> f32 {
    let x2 = x * x;
    let x4 = x2 * x2;
    let x8 = x4 * x4;
    x8 * x8
}

#[cfg(test)]
mod tests;
