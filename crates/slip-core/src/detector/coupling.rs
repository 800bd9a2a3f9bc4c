//! What motion alone shows of the stylus: whether it follows the reference, how strongly in each band, and alarms that come with jumps of it.
//!
//! How strongly the stylus shows motion that the reference shows differs from robot to robot and from band to band. Where motion alone comes near
//! a slip the gain of that band is raised by what would have explained it ([`AlarmSum::unexplained`](super::AlarmSum)).
//! A stretch without an alarm counts when the next
//! one is over without an alarm too. An alarm counts as motion when it is short, weak and followed by no other within a second, since what slides
//! lasts longer; or when a dozen follow each other and all are weak, since what slides becomes fast. What was learned fades over minutes of motion.

use super::{
    config::{BANDS, FIRST_OCTAVE},
    lanes::samples,
    reference::LONGEST_DELAY,
    slip::SlipState,
    sum::COMPONENTS,
};

/// Energy over floor from which a band has part in what the octaves show together.
const PART: f32 = 3.0;
/// The largest factor on a gain.
const MOST: f32 = 4.0;
/// Length of a stretch (ms).
const STRETCH_MS: f32 = 150.0;
/// An alarm of at most this length (ms, without the time of its release) and of this strength ([`AlarmSum::strength`](super::AlarmSum)) is no slip.
const SHORT_MS: f32 = 60.0;
pub(super) const WEAK: f32 = 4.0;
/// So many weak alarms in a row are motion, however long they last: what slides becomes fast.
const MANY: u32 = 12;
/// After an alarm nothing is learned for this long (ms).
const PAUSE_MS: f32 = 1000.0;
/// Motion in which what was learned fades by e (s).
const FADES_S: f32 = 600.0;

/// What a block of motion showed, or the most of a stretch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Highest {
    /// Energy of each band over its floor, as a mean over some milliseconds.
    pub(super) energy: [f32; BANDS],
    /// Its strength.
    pub(super) strength: f32,
    /// Factor on the floor that explains each component.
    pub(super) factors: [f32; COMPONENTS],
}

impl Highest {
    const NONE: Self = Self { energy: [0.0; BANDS], strength: 0.0, factors: [1.0; COMPONENTS] };

    fn with(&self, other: &Self) -> Self {
        Self {
            energy: core::array::from_fn(|b| self.energy[b].max(other.energy[b])),
            strength: self.strength.max(other.strength),
            factors: core::array::from_fn(|i| self.factors[i].max(other.factors[i])),
        }
    }
}

/// The gains that were learned, and what they are learned from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupling {
    factors: [f32; BANDS],
    fading: f32,
    stretch_len: u32,
    short_len: u32,
    pause_len: u32,
    pause: u32,
    /// Blocks of this stretch, or of the alarm.
    blocks: u32,
    alarmed: bool,
    now: Highest,
    before: Highest,
    /// Weak alarms in a row.
    weak: u32,
    /// A short and weak alarm, which no other has followed yet.
    alone: Option<Highest>,
}

impl Coupling {
    /// Nothing is learned yet. Alarms end `release_ms` after what they saw.
    pub(super) fn new(release_ms: f32, block_s: f32) -> Self {
        let blocks_hz = 1.0 / block_s;
        Self {
            factors: [1.0; BANDS],
            fading: block_s / FADES_S,
            stretch_len: samples(STRETCH_MS, blocks_hz),
            short_len: samples(SHORT_MS + release_ms, blocks_hz),
            pause_len: samples(PAUSE_MS, blocks_hz),
            pause: 0,
            blocks: 0,
            alarmed: false,
            now: Highest::NONE,
            before: Highest::NONE,
            weak: 0,
            alone: None,
        }
    }

    /// Nothing is learned yet.
    pub(super) fn forget(&mut self) {
        self.factors = [1.0; BANDS];
        (self.weak, self.alone) = (0, None);
        self.start();
    }

    /// Factors on the gains of the bands, 1 and above.
    #[inline]
    pub(super) fn factors(&self) -> &[f32; BANDS] {
        &self.factors
    }

    /// The stretch starts afresh.
    pub(super) fn start(&mut self) {
        (self.blocks, self.alarmed) = (0, false);
        (self.now, self.before) = (Highest::NONE, Highest::NONE);
    }

    /// Takes a block of motion and the state after it.
    #[inline]
    pub(super) fn step(&mut self, seen: &Highest, state: SlipState) {
        self.now = self.now.with(seen);
        self.blocks = self.blocks.saturating_add(1);
        if state != SlipState::Quiet {
            if !self.alarmed {
                (self.alarmed, self.blocks) = (true, 0);
            }
            return;
        }
        if self.alarmed {
            let highest = self.now.with(&self.before);
            let weak = highest.strength < WEAK;
            let alone = weak && self.blocks <= self.short_len && self.pause == 0;
            self.alone = Some(highest).filter(|_| alone);
            self.weak = if weak { self.weak.saturating_add(1) } else { 0 };
            if self.weak >= MANY {
                self.learn(&highest);
            }
            self.pause = self.pause_len;
            self.start();
        } else if self.pause > 0 {
            self.pause -= 1;
            self.start();
            if self.pause == 0 {
                self.weak = self.weak.saturating_sub(1);
                if let Some(highest) = self.alone.take() {
                    self.learn(&highest);
                }
            }
        } else if self.blocks >= self.stretch_len {
            let highest = core::mem::replace(&mut self.before, self.now);
            self.learn(&highest);
            self.blocks = 0;
            self.now = Highest::NONE;
        }
    }

    #[cold]
    fn learn(&mut self, highest: &Highest) {
        let faded = self.stretch_len as f32 * self.fading;
        for b in 0..BANDS {
            let factor = &mut self.factors[b];
            *factor += faded * (1.0 - *factor);
            let has_part = b >= FIRST_OCTAVE && highest.energy[b] > PART;
            let together = if has_part { highest.factors[BANDS] } else { 1.0 };
            *factor = (*factor * highest.factors[b].max(together)).min(MOST);
        }
    }
}

// Correlation of the energies of stylus and reference in motion: whether the stylus follows the reference, and how late one of them is.

/// Length of a block (ms).
const BLOCK_MS: f32 = 5.0;
/// Largest shift that is looked at (blocks).
const MOST_SHIFT: usize = 22;
const SHIFTS: usize = 2 * MOST_SHIFT + 1;
/// Shifts that the gate allows for (blocks).
const NEAR_SHIFTS: usize = 1;
/// Time in which what was seen is forgotten by e (s), and motion before anything is said (s).
const MEMORY_S: f32 = 30.0;
const LEAST_S: f32 = 10.0;
/// Time constant of the means (s): motion that comes and goes by turns of seconds would need minutes to be distinguished from another robot's.
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
/// Least variance of the logarithm of the reference that states anything.
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
///
/// ```text
/// x = ln(1 + energy of the stylus over its quiet floor)      y = ln(1 + floor that the gate adds for this block of the reference)
/// rho_k = mean(x_t y_(t-k)) / sqrt(mean(x^2) mean(y^2))      each less its mean of 0.2 s, over blocks of 5 ms, |k| <= 22, forgotten by e in 30 s of motion
/// ```
///
/// Motion comes and goes, and resonances beat: the two logarithms rise and fall together where both sensors are on one
/// robot. The highest rho_k within [`NEAR`] blocks is a reference in time, elsewhere one that is late or early, and
/// where no rho_k is high it shows another robot's motion, or what the stylus does not feel. Blocks at rest are
/// left out, so that holding costs nothing. A slip in motion lasts a small part of the memory. It takes [`LEAST_S`] of motion.
///
/// A parabola through the highest rho_k and its neighbours gives how late to 1.5 ms. From [`LATE_S`] to
/// [`LATEST_S`] on the stylus is made to wait as long and [`MARGIN_S`] more, since the gate looks back but not ahead. A
/// reference that is early by [`EARLY_S`] to [`EARLIEST_S`] waits as long, less [`MARGIN_S`]: that costs no latency.
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
    past: [[f32; MOST_SHIFT + 1]; 2],
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
            past: [[0.0; MOST_SHIFT + 1]; 2],
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

    /// How long the stylus waits for the reference (blocks, at most [`LONGEST_DELAY`]); below 0 the reference for the stylus.
    #[inline]
    pub(super) fn wait(&self) -> i16 {
        let most = i16::from(LONGEST_DELAY);
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
        let per_block = 1.0 / self.filled as f32;
        let logs = self.sums.map(|sum| libm::logf(1.0 + (sum * per_block).clamp(0.0, 1e30)));
        (self.filled, self.sums) = (0, [0.0; 2]);
        self.seen = self.seen.saturating_add(1).min(self.least);
        self.in_stretch = self.in_stretch.saturating_add(1);
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
        if self.in_stretch as usize <= MOST_SHIFT {
            return;
        }
        let [[x, older @ ..], ys @ [y, ..]] = &self.past;
        // From a reference that is MOST_SHIFT blocks late to one that is as early.
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
        let (mut best, mut at) = (f32::MIN, MOST_SHIFT);
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
        } else if at.abs_diff(MOST_SHIFT) <= NEAR_SHIFTS {
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
        let blocks = MOST_SHIFT as f32 - at as f32 - off;
        blocks * self.block_s
    }
}

// Detector of a late reference: whether alarms come a little before jumps of the reference.
//
// A knock reaches stylus and reference within half a millisecond of each other. Where the reference is late by 1 to 4 ms
// the stylus alarms first. An alarm of a slip does that by chance only, since the reference jumps about once a second.
// The envelopes of motion show less: at a sound reference they lead or lag by 1 ms too ([`correlation`](super::correlation)).

/// Time by which an alarm may be before the jump that explains it (ms).
const BEFORE_MS: f32 = 3.5;
/// Such alarms that show a late reference, and jumps with which one is forgotten.
const MANY_KNOCKS: u8 = 3;
const FORGOTTEN: u8 = 128;
/// What the stylus waits then (ms).
const WAIT_MS: f32 = 4.0;

/// What was seen of alarms and jumps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knocks {
    before_len: u32,
    wait_len: i16,
    /// Blocks of the alarm.
    alarmed: u32,
    rang: bool,
    jumps: u8,
    seen: u8,
}

impl Knocks {
    /// Nothing was seen; blocks have `block_s` (s).
    pub(super) fn new(block_s: f32) -> Self {
        Self {
            before_len: samples(BEFORE_MS, 1.0 / block_s),
            wait_len: i16::try_from(samples(WAIT_MS, 1.0 / block_s)).unwrap_or(i16::MAX),
            alarmed: 0,
            rang: false,
            jumps: 0,
            seen: 0,
        }
    }

    /// How long the stylus waits for a reference that shows knocks later (blocks). It stays so: what waits alarms no more.
    #[inline]
    pub(super) fn wait(&self) -> i16 {
        if self.seen >= MANY_KNOCKS { self.wait_len } else { 0 }
    }

    /// Takes a block: whether there is an alarm, and whether the reference jumped not long ago.
    #[inline]
    pub(super) fn step(&mut self, alarmed: bool, rings: bool) {
        if rings && !self.rang {
            self.jump(alarmed && self.alarmed <= self.before_len);
        }
        self.rang = rings;
        self.alarmed = if alarmed { self.alarmed.saturating_add(1) } else { 0 };
    }

    #[cold]
    fn jump(&mut self, is_late: bool) {
        if self.seen >= MANY_KNOCKS {
            return;
        }
        self.seen += u8::from(is_late);
        self.jumps += 1;
        if self.jumps >= FORGOTTEN {
            (self.jumps, self.seen) = (0, self.seen.saturating_sub(1));
        }
    }
}

#[cfg(test)]
mod knocks_tests {
    use super::Knocks;

    /// `times` jumps of 40 ms, one a second in blocks of 0.5 ms; an alarm begins so many blocks before each `every`th.
    fn late(times: u32, every: u32, before: u32) -> bool {
        let mut knocks = Knocks::new(5e-4);
        for i in 0..2000 * times {
            let (jump, at) = (i / 2000, i % 2000);
            let alarmed = jump % every == 0 && at + before >= 1000 && at < 1100;
            knocks.step(alarmed, (1000..1080).contains(&at));
        }
        knocks.wait() == 8
    }

    #[test]
    fn three_alarms_just_before_a_jump_show_a_late_reference() {
        assert!(late(3, 1, 0) && late(3, 1, 7) && !late(2, 1, 3));
        assert!(!late(300, 1, 8), "a slip in which the robot begins to move");
        assert!(late(100, 40, 3) && !late(2000, 200, 3), "by chance");
    }
}
