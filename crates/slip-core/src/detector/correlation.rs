//! Energies of stylus and reference in motion in; whether the stylus follows the reference, and how late one of them is, out.
//!
//! ```text
//! x = ln(1 + energy of the stylus over its quiet floor)      y = ln(1 + floor that the gate adds for this block of the reference)
//! rho_k = mean(x_t y_(t-k)) / sqrt(mean(x^2) mean(y^2))      each less its mean of 0.2 s, over blocks of 5 ms, |k| <= 22, forgotten by e in 30 s of motion
//! ```
//!
//! Motion comes and goes, and resonances beat: the two logarithms rise and fall together where both sensors are on one
//! robot. The highest rho_k within [`NEAR`] blocks is a reference in time, elsewhere one that is late or early, and
//! where no rho_k is high it shows another robot's motion, or what the stylus does not feel. Blocks at rest are
//! left out, and those in alarms while it is in time, so that holding costs nothing and slips teach nothing. It takes
//! [`LEAST_S`] of motion.
//!
//! A parabola through the highest rho_k and its neighbours tells how late to 1.5 ms. From [`LATE_S`] to
//! [`LATEST_S`] on the stylus is made to wait as long and [`MARGIN_S`] more, since the gate looks back but not ahead. A
//! reference that is early by [`EARLY_S`] to [`EARLIEST_S`] waits as long, less [`MARGIN_S`]: that costs no latency.

use super::{
    config::{BANDS, FIRST_OCTAVE},
    delay,
    lanes::samples,
};

/// Length of a block (ms).
const BLOCK_MS: f32 = 5.0;
/// Largest shift that is looked at (blocks).
const MOST: usize = 22;
const SHIFTS: usize = 2 * MOST + 1;
/// Shifts that the gate allows for (blocks).
const NEAR: usize = 1;
/// Time in which what was seen is forgotten by e (s), and motion before anything is said (s).
const MEMORY_S: f32 = 30.0;
const LEAST_S: f32 = 10.0;
/// Time constant of the means (s): motion that comes and goes by turns of seconds would need minutes to be told from another robot's.
const MEAN_S: f32 = 0.2;
/// A correlation that shows one robot, and one below which there is none.
const FOLLOWS: f32 = 0.4;
const NONE: f32 = 0.3;
/// Time for which another relation must show (s).
const AGREED_S: f32 = 2.5;
/// The least and the most that a reference is late for the stylus to wait (s), the least and the most that it is early to
/// wait itself, and what the stylus waits more.
const LATE_S: f32 = 1e-3;
const LATEST_S: f32 = 22e-3;
const EARLY_S: f32 = 5e-3;
const EARLIEST_S: f32 = 105e-3;
const MARGIN_S: f32 = 2.5e-3;
/// Delays that far apart are the same (s).
const SAME_S: f32 = 1e-3;
/// Least variance of the logarithm of the reference that says anything.
const LEAST_VARIANCE: f32 = 0.3;

/// What the stylus shows of the motion that the reference shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Relation {
    /// It follows in time, or too little was seen.
    #[default]
    Near,
    /// It follows late or early.
    Shifted,
    /// It does not follow.
    None,
}

/// The correlations and their memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correlation {
    block_len: u32,
    share: f32,
    mean_share: f32,
    least: u32,
    /// The block that is being filled.
    filled: u32,
    sums: [f32; 2],
    /// Blocks so far, saturating at `least`, and in this stretch of motion.
    seen: u32,
    in_stretch: u32,
    means: [f32; 2],
    variances: [f32; 2],
    /// The last blocks of stylus and reference, less their means, the newest first.
    past: [[f32; MOST + 1]; 2],
    products: [f32; SHIFTS],
    relation: Relation,
    /// How long the stylus waits (s).
    wait_s: f32,
    /// Length of a block and of one that waits (s).
    block_s: f32,
    part_s: f32,
    /// Blocks for which another relation has shown.
    agreed: u32,
    agreed_len: u32,
}

impl Correlation {
    /// Nothing is known yet; energies come every `part_s` (s).
    pub(super) fn new(part_s: f32) -> Self {
        let block_len = samples(BLOCK_MS, 1.0 / part_s).max(1);
        #[expect(clippy::cast_precision_loss, reason = "at most 100")]
        let block_s = part_s * block_len as f32;
        Self {
            block_len,
            share: block_s / MEMORY_S,
            mean_share: -libm::expm1f(-block_s / MEAN_S),
            least: samples(1e3 * LEAST_S, 1.0 / block_s),
            filled: 0,
            sums: [0.0; 2],
            seen: 0,
            in_stretch: 0,
            means: [0.0; 2],
            variances: [0.0; 2],
            past: [[0.0; MOST + 1]; 2],
            products: [0.0; SHIFTS],
            relation: Relation::Near,
            wait_s: 0.0,
            block_s,
            part_s,
            agreed: 0,
            agreed_len: samples(1e3 * AGREED_S, 1.0 / block_s),
        }
    }

    /// What is known of the two.
    #[inline]
    pub(super) fn relation(&self) -> Relation {
        self.relation
    }

    /// How long the stylus waits for the reference (blocks, at most [`delay::MOST`]); below 0 the reference for the stylus.
    #[inline]
    pub(super) fn wait(&self) -> i16 {
        let most = i16::from(delay::MOST);
        #[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
        let blocks = libm::ceilf(self.wait_s / self.part_s) as i16;
        blocks.clamp(-most, most)
    }

    /// The next block does not follow the last one.
    pub(super) fn interrupt(&mut self) {
        (self.filled, self.in_stretch, self.sums) = (0, 0, [0.0; 2]);
    }

    /// Takes the energy of each band over its quiet floor and the floor that the gate makes of the reference.
    #[inline]
    pub(super) fn step(&mut self, energy: &[f32; BANDS], floor: &[f32; BANDS]) {
        for b in FIRST_OCTAVE..BANDS {
            self.sums[0] += energy[b];
            self.sums[1] += floor[b] - 1.0;
        }
        self.filled += 1;
        if self.filled >= self.block_len {
            self.end_block();
        }
    }

    #[inline(never)]
    fn end_block(&mut self) {
        #[expect(clippy::cast_precision_loss, reason = "at most 100")]
        let per_block = 1.0 / self.filled as f32;
        let logs = self.sums.map(|sum| libm::logf(1.0 + (sum * per_block).clamp(0.0, 1e30)));
        (self.filled, self.sums) = (0, [0.0; 2]);
        self.seen = self.seen.saturating_add(1).min(self.least);
        self.in_stretch = self.in_stretch.saturating_add(1);
        #[expect(clippy::cast_precision_loss, reason = "at most some thousand")]
        let share = self.share.max(1.0 / self.seen as f32);
        let kept = self.means.iter_mut().zip(&mut self.variances).zip(&mut self.past);
        for (log, ((mean, variance), past)) in logs.into_iter().zip(kept) {
            *mean += self.mean_share * (log - *mean);
            let off = log - *mean;
            *variance += share * (off * off - *variance);
            past.rotate_right(1);
            let [newest, ..] = past;
            *newest = off;
        }
        if self.in_stretch as usize <= MOST {
            return;
        }
        let [[x, older @ ..], ys @ [y, ..]] = &self.past;
        // From a reference that is MOST blocks late to one that is as early.
        let late = older.iter().rev().map(|x| x * y);
        let pairs = late.chain(ys.iter().map(|y| x * y));
        for (product, pair) in self.products.iter_mut().zip(pairs) {
            *product += share * (pair - *product);
        }
        if self.seen >= self.least {
            self.judge();
        }
    }

    fn judge(&mut self) {
        let [x, y] = self.variances;
        if y < LEAST_VARIANCE {
            return;
        }
        let (mut best, mut at) = (f32::MIN, MOST);
        for (k, product) in self.products.iter().enumerate() {
            if *product > best {
                (best, at) = (*product, k);
            }
        }
        let correlation = best / libm::sqrtf(x * y).max(f32::MIN_POSITIVE);
        let seems = if correlation < NONE {
            Relation::None
        } else if correlation < FOLLOWS {
            self.relation
        } else if at.abs_diff(MOST) <= NEAR {
            Relation::Near
        } else {
            Relation::Shifted
        };
        let late_s = self.late_s(at);
        let wait_s = match seems {
            _ if correlation < FOLLOWS => self.wait_s,
            Relation::None => 0.0,
            _ if (LATE_S..=LATEST_S).contains(&late_s) => late_s + MARGIN_S,
            _ if (EARLY_S..=EARLIEST_S).contains(&-late_s) => late_s + MARGIN_S,
            _ => 0.0,
        };
        let same = seems == self.relation && (wait_s - self.wait_s).abs() < SAME_S;
        self.agreed = if same { 0 } else { self.agreed + 1 };
        if self.agreed >= self.agreed_len {
            (self.relation, self.wait_s, self.agreed) = (seems, wait_s, 0);
        }
    }

    /// How late the reference is (s) whose highest product is that `at` a place: the top of a parabola.
    fn late_s(&self, at: usize) -> f32 {
        let three = at.checked_sub(1).and_then(|from| self.products.get(from..from + 3));
        let Some([before, top, after]) = three else { return f32::INFINITY };
        let bend = 2.0 * top - before - after;
        let off = if bend > 0.0 { 0.5 * (after - before) / bend } else { 0.0 };
        #[expect(clippy::cast_precision_loss, reason = "at most 44")]
        let blocks = MOST as f32 - at as f32 - off;
        blocks * self.block_s
    }
}
