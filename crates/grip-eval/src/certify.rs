//! Limits and chances that a certified alarm stands on, from scores of blocks without slip.
//!
//! For each band, at rest and in motion ([`ScoreLaw`]; the alarm itself is [`Evidence`]):
//!
//! 1. **Blocks.** The shortest of 5 to 160 ms of which neighbours do not follow each other: of the pairs of blocks 1 to
//!    4 apart, no more pass a high level together than of those further apart within a second (exact intervals, at
//!    levels that one block in ten to one in 30,000 passes).
//! 2. **Clusters.** What longer blocks do not cure, motion by turns or a hum that comes and goes, shows as pairs within
//!    a second that pass a level together R times as often as independent blocks would. One that has just passed is
//!    followed by others R times as likely as on average, so the chances are multiplied by the upper bound of R. For
//!    noise that is high for a share w of the time and independent within, R is 1/w.
//! 3. **Limits.** Order statistics: the k-th largest of n blocks, k from 1 to n/20. The chance to pass it has a beta
//!    distribution whatever the law of the scores; its upper bound (Clopper-Pearson) holds for all limits of all bands
//!    together with 95 %. A limit that is raised to three times the floor is passed more seldom still.
//! 4. **Check.** Limits from one half of the stretches, alarms on the other, both ways. Where they come more often than
//!    wanted beyond chance, nothing is certified.

use crate::poisson;
use grip_session::calibration::{Certified, LawEvidence};
use slip_core::detector::{BANDS, Certificate, Evidence, LIMITS, ScoreLaw};

/// Confidence over the calibration.
const CONFIDENCE: f64 = 0.95;
/// Lengths of a block that are tried (base blocks).
const LENGTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Pairs of so many blocks apart are neighbours.
const NEAR: usize = 4;
/// Pairs within this time (s) show clusters.
const CLUSTER_S: f64 = 1.0;
/// Shares of the blocks above the levels that pairs are counted at: 1 of so many.
const LEVELS: [usize; 8] = [10, 30, 100, 300, 1000, 3000, 10_000, 30_000];
/// Expected pairs from which an upper bound states something; with fewer only what is sure counts: knocks and the like,
/// whose rare high blocks follow each other.
const PAIRS: f64 = 10.0;
const SURE: f64 = 0.999;
/// Fewest blocks above a level.
const FEWEST: usize = 4;
/// Neighbours may pass together so many times as often as others within a second.
const MORE: f64 = 1.2;
/// The lowest limit has rank n over this.
const LOWEST: usize = 20;
/// No limit is lower (energy over floor): noise that has become somewhat louder than in the calibration is no slip,
/// though its law is another.
const LEAST_LIMIT: f32 = 3.0;
/// A law needs so much signal (s): what comes and goes within it cannot be separated from chance in less.
const LEAST_S: f64 = 30.0;
/// A law whose strongest block is worth less than this factor certifies nothing.
const LEAST_FACTOR: f64 = 2.0;

/// Consecutive base blocks of rest, or of motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Whether the robot moved.
    pub moving: bool,
    /// Mean energy of each band over its floor.
    pub scores: Vec<[f32; BANDS]>,
}

/// Why nothing is certified.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotCertified {
    /// Only bands of a stylus or vibration are certified.
    #[error("a taxel array has no certified alarm")]
    Array,
    /// Too little signal for the interval.
    #[error(
        "{seconds:.0} s of signal are too short; {LEAST_S} s of rest or of motion and more are needed"
    )]
    Short {
        /// Its length (s).
        seconds: f64,
    },
    /// The halves of the recording differ.
    #[error(
        "limits from one half of the recording gave {alarms} certified alarms in {judged_s:.0} s of the other: it holds something that comes and goes too seldom to be learned"
    )]
    Unsteady {
        /// Alarms.
        alarms: u64,
        /// Signal (s).
        judged_s: f64,
    },
}

/// Certifies `interval_s` by `stretches` of base blocks of `base_s` (s), of the bands that exist.
///
/// # Errors
/// Where they do not carry it.
pub fn certify(
    stretches: &[Stretch],
    base_s: f64,
    bands: [bool; BANDS],
    interval_s: f64,
) -> Result<(Certificate, Certified), NotCertified> {
    let made = |part: &[Stretch]| {
        let law = |moving| law(part, moving, base_s, bands, interval_s).unzip();
        let ((rest, at_rest), (motion, in_motion)) = (law(false), law(true));
        #[expect(clippy::cast_possible_truncation, reason = "1 to 1e9")]
        let interval_s = interval_s as f32;
        (Certificate { interval_s, rest, motion }, at_rest, in_motion)
    };
    let (certificate, rest, motion) = made(stretches);
    if rest.is_none() && motion.is_none() {
        return Err(NotCertified::Short { seconds: seconds(stretches, base_s) });
    }
    let (first, second) = halves(stretches);
    let alarms = count(&made(&first).0, &second, base_s) + count(&made(&second).0, &first, base_s);
    let judged_s = seconds(stretches, base_s);
    let (low, high) = poisson::interval(alarms, CONFIDENCE);
    if low * interval_s > judged_s {
        return Err(NotCertified::Unsteady { alarms, judged_s });
    }
    let certified = Certified {
        judged_s,
        alarms,
        interval_low_s: judged_s / high,
        interval_high_s: (alarms > 0).then(|| judged_s / low),
        rest,
        motion,
    };
    Ok((certificate, certified))
}

fn seconds(stretches: &[Stretch], base_s: f64) -> f64 {
    stretches.iter().map(|s| s.scores.len()).sum::<usize>() as f64 * base_s
}

/// The two halves in time, of rest and of motion each.
fn halves(stretches: &[Stretch]) -> (Vec<Stretch>, Vec<Stretch>) {
    let (mut first, mut second) = (Vec::new(), Vec::new());
    for moving in [false, true] {
        let all = stretches.iter().filter(|s| s.moving == moving);
        let mut left = all.clone().map(|s| s.scores.len()).sum::<usize>() / 2;
        for stretch in all {
            let (a, b) = stretch.scores.split_at(left.min(stretch.scores.len()));
            left -= a.len();
            for (half, part) in [(&mut first, a), (&mut second, b)] {
                if !part.is_empty() {
                    half.push(Stretch { moving, scores: part.to_vec() });
                }
            }
        }
    }
    (first, second)
}

/// Certified alarms of `certificate` in `stretches`.
fn count(certificate: &Certificate, stretches: &[Stretch], base_s: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, reason = "some ms")]
    let mut evidence = Evidence::new(certificate, base_s as f32);
    let mut alarms = 0;
    for stretch in stretches {
        evidence.restart();
        for scores in &stretch.scores {
            alarms += u64::from(evidence.bet(scores, stretch.moving));
        }
    }
    alarms
}

/// The law of the stretches of rest, or of motion; `None` where they are too short to certify `interval_s`.
#[expect(clippy::cast_possible_truncation, reason = "counts of blocks, limits in f32")]
fn law(
    stretches: &[Stretch],
    moving: bool,
    base_s: f64,
    bands: [bool; BANDS],
    interval_s: f64,
) -> Option<(ScoreLaw, LawEvidence)> {
    let stretches: Vec<&Stretch> = stretches.iter().filter(|s| s.moving == moving).collect();
    let mut law = ScoreLaw {
        blocks: [0; BANDS],
        limits: [[0.0; LIMITS]; BANDS],
        chances: [[1.0; LIMITS]; BANDS],
    };
    let blocks: usize = stretches.iter().map(|s| s.scores.len()).sum();
    let mut known = LawEvidence {
        seconds: blocks as f64 * base_s,
        blocks_ms: [f64::INFINITY, 0.0],
        clusters: 1.0,
        soonest_ms: 0.0,
    };
    if known.seconds < LEAST_S {
        return None;
    }
    for b in (0..BANDS).filter(|b| bands[*b]) {
        let Some((length, blocks, clusters)) = choose(&stretches, b, base_s) else { continue };
        let sorted = blocks.descending();
        law.blocks[b] = length as u32;
        let worth = set_limits(&sorted, clusters, &mut law.limits[b], &mut law.chances[b]);
        if worth < LEAST_FACTOR {
            law.blocks[b] = 0;
            continue;
        }
        let block_ms = 1e3 * base_s * length as f64;
        // The other bands may know nothing.
        let needed = (1e3 * interval_s * BANDS as f64 / block_ms).ln() / worth.ln();
        known.blocks_ms = [known.blocks_ms[0].min(block_ms), known.blocks_ms[1].max(block_ms)];
        known.clusters = known.clusters.max(clusters);
        let soonest_ms = block_ms * needed.max(1.0).ceil();
        known.soonest_ms =
            if known.soonest_ms > 0.0 { known.soonest_ms.min(soonest_ms) } else { soonest_ms };
    }
    (known.soonest_ms > 0.0).then_some((law, known))
}

/// Fills in limits and chances, rising and falling; the largest factor that a block is worth.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "ranks below the number of blocks"
)]
fn set_limits(
    descending: &[f32],
    clusters: f64,
    limits: &mut [f32; LIMITS],
    chances: &mut [f32; LIMITS],
) -> f64 {
    let lowest = (descending.len() / LOWEST).max(1) as f64;
    // All limits of all bands and lengths, at rest and in motion, hold together.
    let together = (LIMITS * BANDS * LENGTHS.len() * 2) as f64;
    let confidence = 1.0 - (1.0 - CONFIDENCE) / together;
    let mut won = 0.0;
    for j in 0..LIMITS {
        let exponent = (LIMITS - 1 - j) as f64 / (LIMITS - 1) as f64;
        let rank = lowest.powf(exponent).round() as usize;
        let chance = poisson::chance_to_pass(rank as u64, descending.len() as u64, confidence);
        limits[j] = descending.get(rank - 1).map_or(f32::MAX, |limit| limit.max(LEAST_LIMIT));
        chances[j] = (clusters * chance).min(1.0) as f32;
        won += 1.0 / f64::from(chances[j]);
    }
    0.5 + 0.5 * won / LIMITS as f64
}

/// Scores of the blocks of one band, by stretch.
struct Blocks(Vec<Vec<f32>>);

impl Blocks {
    fn new(stretches: &[&Stretch], band: usize, length: usize) -> Self {
        let mean = |block: &[[f32; BANDS]]| {
            let count = block.len() as f32;
            block.iter().map(|scores| scores[band]).sum::<f32>() / count
        };
        let blocks = |s: &&Stretch| s.scores.chunks_exact(length).map(mean).collect();
        Self(stretches.iter().map(blocks).collect())
    }

    fn descending(&self) -> Vec<f32> {
        let mut all: Vec<f32> = self.0.iter().flatten().copied().collect();
        all.sort_by(|a, b| b.total_cmp(a));
        all
    }
}

/// Length of a block (base blocks), the blocks, and times that the chances have to be raised.
fn choose(stretches: &[&Stretch], band: usize, base_s: f64) -> Option<(usize, Blocks, f64)> {
    let mut chosen = None;
    for length in LENGTHS {
        let blocks = Blocks::new(stretches, band, length);
        if blocks.0.iter().map(Vec::len).sum::<usize>() < 10 * LOWEST {
            break;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 200 blocks"
        )]
        let apart = ((CLUSTER_S / (base_s * length as f64)) as usize).max(3 * NEAR);
        let pairs = Pairs::of(&blocks, apart);
        chosen = Some((length, blocks, pairs.clusters));
        if !pairs.neighbours_follow {
            break;
        }
    }
    chosen
}

/// What pairs of high blocks show.
struct Pairs {
    /// Whether neighbours pass a level together more often than others within a second.
    neighbours_follow: bool,
    /// Upper bound of pairs within a second over those of independent blocks, 1 and above.
    clusters: f64,
}

impl Pairs {
    /// Counts the pairs of up to `apart` blocks apart.
    fn of(blocks: &Blocks, apart: usize) -> Self {
        let sorted = blocks.descending();
        let mut pairs = Self { neighbours_follow: false, clusters: 1.0 };
        // Places for a pair that is so many blocks apart.
        let places =
            |lag: usize| blocks.0.iter().map(|s| s.len().saturating_sub(lag)).sum::<usize>() as f64;
        let places: Vec<f64> = (0..=apart).map(places).collect();
        let mut slow = 1.0_f64;
        for share in LEVELS {
            let rank = sorted.len() / share;
            if rank < FEWEST {
                break;
            }
            let seen = pairs_above(blocks, sorted[rank - 1], apart);
            let chance = passing(blocks, sorted[rank - 1]) / sorted.len() as f64;
            let of = |lags: core::ops::RangeInclusive<usize>| {
                let count = seen[lags.clone()].iter().sum::<u64>();
                Ratio::new(count, chance * chance * places[lags].iter().sum::<f64>())
            };
            let (far, near) = (of(NEAR + 1..=apart), of(1..=NEAR));
            slow = slow.max(far.believed());
            pairs.neighbours_follow |= (1..=NEAR).any(|lag| of(lag..=lag).sure > MORE * slow);
            pairs.clusters = pairs.clusters.max(far.believed()).max(near.believed());
        }
        pairs
    }
}

/// Pairs over those that independent blocks would have.
struct Ratio {
    expected: f64,
    /// It is at least this with [`SURE`].
    sure: f64,
    /// It is at most this with [`CONFIDENCE`].
    most: f64,
}

impl Ratio {
    fn new(count: u64, expected: f64) -> Self {
        let expected = expected.max(f64::MIN_POSITIVE);
        let sure = poisson::interval(count, 2.0 * SURE - 1.0).0 / expected;
        let most = poisson::interval(count, 2.0 * CONFIDENCE - 1.0).1 / expected;
        Self { expected, sure, most }
    }

    /// What the chances have to be raised by: the upper bound, or what is sure where few pairs are expected.
    fn believed(&self) -> f64 {
        if self.expected < PAIRS { self.sure } else { self.most }
    }
}

fn passing(blocks: &Blocks, level: f32) -> f64 {
    blocks.0.iter().flatten().filter(|score| **score >= level).count() as f64
}

/// Pairs of blocks that both reach `level`, by how far they are apart.
fn pairs_above(blocks: &Blocks, level: f32, apart: usize) -> Vec<u64> {
    let mut counts = vec![0; apart + 1];
    for stretch in &blocks.0 {
        let passing = |(i, score): (usize, &f32)| (*score >= level).then_some(i);
        let places: Vec<usize> = stretch.iter().enumerate().filter_map(passing).collect();
        for (n, from) in places.iter().enumerate() {
            for to in places.iter().skip(n + 1).take_while(|to| *to - from <= apart) {
                counts[to - from] += 1;
            }
        }
    }
    counts
}

#[cfg(test)]
mod tests;
