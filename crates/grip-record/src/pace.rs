//! The pace of a recording, found from the stamps of its rows, and times for rows whose stamps are coarser than their steps.
//!
//! A block of stamps is regular where its steps are one step, or whole numbers of it where rows were lost: such stamps stay as
//! they are. It is coarse where
//!
//! - rows repeat the stamp of the row before (whole milliseconds at 1600 Hz, bursts with one stamp), or
//! - rows over duration contradicts the usual step by more than 2 %: 6 kHz in steps of 0.1 ms, 900 Hz in whole milliseconds,
//!   a host that stamps late and then catches up, 1600 Hz in steps of 0.1 ms, or
//! - steps longer than 1.5 usual ones cancel with short ones: jitter, no lost rows.
//!
//! In a file with a coarse block each row stands one period after the one before, drawn towards its stamp by 1/256 of the
//! difference, so that a sensor's clock may drift; a step longer than those between bursts is a gap and stays one. The period
//! is duration over rows, without gaps. A row is misplaced by at most the coarseness of the stamps.

use core::fmt;

/// Rows that are looked at together, and the fewest that show anything.
const BLOCK: usize = 4096;
const FEWEST: usize = 8;
/// Share by which two rates differ that contradict each other, and of repeated stamps that no longer are single faults.
const CONTRADICTS: f64 = 0.02;
const REPEATS: f64 = 0.01;
/// Share of the difference to its stamp by which a row is drawn there.
const GAIN: f64 = 1.0 / 256.0;
/// Rows on longer steps that it takes to tell rounding, which comes evenly, from losses, which do not.
const LONG_STEPS: usize = 12;
/// Rows on each side of a long step that show whether it cancels, and how many that do hide one that does not.
const BESIDE: usize = 16;
const FEW: usize = 20;

/// Takes stamps and finds their pace.
#[derive(Clone, Debug, Default)]
pub struct PaceFinder {
    block: Vec<i64>,
    blocks: usize,
    sum: Look,
    repeated: usize,
    rows: usize,
}

/// What a block shows: time and rows without gaps, and the shortest gap.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    ns: f64,
    rows: f64,
    gap_ns: i64,
    usual_ns: i64,
    /// How far rows are ahead of their stamps on average (ns).
    lead_ns: f64,
    coarse: bool,
}

/// How far apart rows were measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Time between rows, without gaps (ns).
    pub period_ns: f64,
    /// Whether rows are placed by it, because their stamps are coarser.
    pub coarse: bool,
    usual_ns: i64,
    gap_ns: i64,
    lead_ns: f64,
    repeated: usize,
    rows: usize,
    /// Whether rows are drawn towards their stamps; not where a rate is given that contradicts them.
    drawn: bool,
}

impl PaceFinder {
    /// Takes the next stamp (ns), which is not before the last one.
    pub fn push(&mut self, stamp_ns: i64) {
        self.repeated += usize::from(self.block.last() == Some(&stamp_ns));
        self.block.push(stamp_ns);
        self.rows += 1;
        if self.block.len() == BLOCK {
            self.close();
            // Steps between blocks count too.
            self.block.push(stamp_ns);
        }
    }

    fn close(&mut self) {
        if let Some(look) = Look::at(&self.block) {
            let sum = &mut self.sum;
            self.blocks += 1;
            sum.ns += look.ns;
            sum.rows += look.rows;
            if look.coarse || !sum.coarse {
                let first = !sum.coarse;
                sum.gap_ns =
                    if look.coarse && first { look.gap_ns } else { look.gap_ns.max(sum.gap_ns) };
                sum.usual_ns = look.usual_ns;
                sum.lead_ns = if first { look.lead_ns } else { sum.lead_ns };
            }
            sum.coarse |= look.coarse;
        }
        self.block.clear();
    }

    /// The pace; `None` where time never goes on.
    #[must_use]
    pub fn finish(mut self) -> Option<Pace> {
        // A few rows at the end show less than the blocks before.
        if self.blocks == 0 || self.block.len() > BLOCK / 4 {
            self.close();
        }
        let Look { ns, rows, gap_ns, usual_ns, lead_ns, coarse } = self.sum;
        let (repeated, rows_all) = (self.repeated, self.rows);
        let period_ns = Some(ns / rows).filter(|period| period.is_finite() && *period > 0.0)?;
        Some(Pace {
            period_ns,
            coarse,
            usual_ns,
            gap_ns,
            lead_ns,
            repeated,
            rows: rows_all,
            drawn: true,
        })
    }
}

impl Look {
    fn at(stamps: &[i64]) -> Option<Self> {
        let steps = sorted(stamps.windows(2).map(|pair| pair[1] - pair[0]));
        let usual = *steps.get(steps.len() / 2)?;
        // The first row of each stamp: the time between two belongs to the rows between.
        let mut firsts: Vec<(usize, i64)> = stamps.iter().copied().enumerate().collect();
        firsts.dedup_by_key(|(_, stamp)| *stamp);
        let spans: Vec<(usize, i64)> =
            firsts.windows(2).map(|pair| (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1)).collect();
        let long = sorted(spans.iter().map(|(_, ns)| *ns));
        let share = |tenths: usize| long.get(long.len() * tenths / 10).copied();
        let (short, long) = (share(1)?, share(9)?);
        let gap_ns = if 10 * long <= 21 * short { long + long / 2 } else { long.saturating_mul(4) };
        let near = spans.iter().filter(|(_, ns)| *ns <= gap_ns);
        let (rows, ns) =
            near.fold((0.0, 0.0), |(rows, ns), (r, n)| (rows + *r as f64, ns + *n as f64));
        let mut look = Self { ns, rows, gap_ns, usual_ns: usual, ..Self::default() };
        if stamps.len() < FEWEST {
            look.coarse = usual == 0;
            return Some(look);
        }
        let repeats = steps.iter().filter(|step| **step == 0).count();
        let (regular_rows, regular_ns) = regular(&steps, usual);
        let mean = regular_ns / regular_rows;
        let on_grid = |step: &&i64| {
            let steps = **step as f64 / mean;
            steps >= 0.5 && (steps - steps.round()).abs() <= 0.2
        };
        // A microsecond is what times of a recording are rounded to.
        let contradicts = |period: f64| {
            (period / usual as f64 - 1.0).abs() > CONTRADICTS && (period - usual as f64).abs() > 1e3
        };
        // One step within half, and rounded where its mean is not the usual one; not another rate from some row on.
        let by_mean = |look: Self| {
            let gap_ns = usual.saturating_mul(3) / 2;
            let coarse = contradicts(mean) && swing(stamps, mean, gap_ns)[0] <= 5.0 * mean;
            Self { ns: regular_ns, rows: regular_rows, gap_ns, coarse, ..look }
        };
        if repeats as f64 > REPEATS * steps.len() as f64 || usual == 0 {
            look.coarse = true;
        } else if steps.iter().filter(on_grid).count() * 50 >= steps.len() * 49 {
            // Steps of one and of two: rounded, or rows that were lost.
            let rounded = rounded(stamps, usual).filter(|(rows, ns)| contradicts(ns / rows));
            look = if let Some((rows, ns)) = rounded {
                Self { ns, rows, gap_ns: usual * 5 / 2, coarse: true, ..look }
            } else {
                by_mean(look)
            };
        } else if contradicts(ns / rows) && regular_ns < 0.6 * ns {
            // Late and then caught up, but not another rate from some row on.
            look.coarse = swing(stamps, ns / rows, gap_ns)[0] < 0.1 * ns;
        } else if let Some(gap_ns) = jitter(stamps, mean) {
            let (rows, ns) = up_to(&steps, gap_ns);
            look = Self { ns, rows, gap_ns, coarse: true, ..look };
        } else {
            look = by_mean(look);
        }
        look.lead_ns = swing(stamps, look.ns / look.rows, look.gap_ns)[1].max(0.0);
        Some(look)
    }
}

/// Number and duration of the steps within half of the usual one.
fn regular(steps: &[i64], usual: i64) -> (f64, f64) {
    let short = steps.partition_point(|step| step.saturating_mul(2) < usual);
    up_to(&steps[short..], usual.saturating_mul(3) / 2)
}

/// Number and duration of the sorted steps up to this one.
fn up_to(steps: &[i64], longest: i64) -> (f64, f64) {
    let near = &steps[..steps.partition_point(|step| *step <= longest)];
    (near.len() as f64, near.iter().map(|step| *step as f64).sum())
}

/// The shortest gap, where longer steps are those of jitter: rows after them are no later than those before.
#[expect(clippy::cast_possible_truncation, reason = "steps, in ns")]
fn jitter(stamps: &[i64], mean: f64) -> Option<i64> {
    let first = *stamps.first()?;
    let late: Vec<f64> =
        stamps.iter().enumerate().map(|(k, t)| (t - first) as f64 - k as f64 * mean).collect();
    let (mut cancelled, mut lost) = (Vec::new(), Vec::new());
    for (at, rows) in late.windows(2 * BESIDE).enumerate() {
        let step = stamps[at + BESIDE] - stamps[at + BESIDE - 1];
        if step as f64 > 1.5 * mean {
            let (before, after) = rows.split_at(BESIDE);
            let later = after.iter().sum::<f64>() - before.iter().sum::<f64>();
            let lists = if later < 0.5 * mean * BESIDE as f64 { &mut cancelled } else { &mut lost };
            lists.push(step);
        }
    }
    let gap_ns = cancelled.iter().max()?.saturating_add(mean as i64 / 8);
    let hidden = lost.iter().filter(|step| **step <= gap_ns).count();
    (hidden * FEW <= cancelled.len()).then_some(gap_ns)
}

/// Rows and duration of the longest run without a gap, where its steps of one and two are those of rounding.
fn rounded(stamps: &[i64], step: i64) -> Option<(f64, f64)> {
    let runs = stamps.chunk_by(|one, next| (next - one) * 10 <= step * 22);
    let run = runs.max_by_key(|run| run.len())?;
    let ns = (run.last()? - run.first()?) as f64;
    let rows = (run.len() - 1) as f64;
    let long = run.windows(2).filter(|pair| (pair[1] - pair[0]) * 2 > step * 3).count();
    let evenly = swing(run, ns / rows, i64::MAX)[0] <= 2.2 * step as f64;
    (long >= LONG_STEPS && evenly).then_some((rows, ns))
}

/// How far stamps are from equal periods, from the most late to the most early, and how far behind the first one on average (ns);
/// gaps are left out.
fn swing(stamps: &[i64], period_ns: f64, gap_ns: i64) -> [f64; 2] {
    let steps = stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step <= gap_ns);
    let (mut late, mut least, mut most, mut sum) = (0.0, 0.0_f64, 0.0_f64, 0.0);
    for step in steps {
        late += step as f64 - period_ns;
        (least, most, sum) = (least.min(late), most.max(late), sum - late);
    }
    [most - least, sum / stamps.len().max(1) as f64]
}

fn sorted(steps: impl Iterator<Item = i64>) -> Vec<i64> {
    let mut steps: Vec<i64> = steps.collect();
    steps.sort_unstable();
    steps
}

impl Pace {
    /// The pace of these stamps (ns).
    #[must_use]
    pub fn of(stamps: &[i64]) -> Option<Self> {
        let mut finder = PaceFinder::default();
        stamps.iter().for_each(|stamp| finder.push(*stamp));
        finder.finish()
    }

    /// That of rows which all have one stamp.
    #[must_use]
    pub fn at_rate(rate_hz: f32) -> Self {
        let period_ns = 1e9 / f64::from(rate_hz);
        let (usual_ns, gap_ns, lead_ns) = (0, i64::MAX, 0.0);
        Self {
            period_ns,
            coarse: true,
            usual_ns,
            gap_ns,
            lead_ns,
            repeated: 0,
            rows: 0,
            drawn: false,
        }
    }

    /// The same with a rate that the caller knows. Regular stamps stay as they are.
    #[must_use]
    pub fn with_rate(self, rate_hz: f32) -> Self {
        let period_ns = 1e9 / f64::from(rate_hz);
        if !self.coarse {
            return self;
        }
        let drawn = (self.period_ns / period_ns - 1.0).abs() <= CONTRADICTS;
        Self { period_ns, drawn, ..self }
    }

    /// Samples per second (Hz).
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "a rate in Hz is given as f32")]
    pub fn rate_hz(&self) -> f32 {
        (1e9 / self.period_ns) as f32
    }

    /// What places rows; `None` where their stamps stay as they are.
    #[must_use]
    pub fn placer(&self) -> Option<Placer> {
        self.coarse.then_some(Placer { pace: *self, last: None })
    }

    /// The times of rows with these stamps.
    #[must_use]
    pub fn placed(&self, mut stamps: Vec<i64>) -> Vec<i64> {
        if let Some(mut placer) = self.placer() {
            stamps.iter_mut().for_each(|stamp| *stamp = placer.place(*stamp));
        }
        stamps
    }
}

impl fmt::Display for Pace {
    /// What to know of it; nothing where the stamps stay as they are.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.coarse {
            return Ok(());
        }
        let Self { repeated, rows, .. } = self;
        write!(f, "the stamps are coarser than the rows: ")?;
        match self.usual_ns {
            0 => write!(f, "{repeated} of {rows} repeat the one before")?,
            usual if *repeated > 0 => write!(
                f,
                "{repeated} of {rows} repeat the one before and their usual step would give {:.1} Hz",
                1e9 / usual as f64
            )?,
            usual => write!(f, "their usual step would give {:.1} Hz", 1e9 / usual as f64)?,
        }
        let by = if self.drawn { "rows over duration" } else { "the rate given" };
        write!(f, "; rows are placed evenly at {:.1} Hz ({by})", self.rate_hz())
    }
}

/// Places rows one after the other.
#[derive(Clone, Debug)]
pub struct Placer {
    pace: Pace,
    /// Place of the last row, to a fraction of a nanosecond, and its stamp.
    last: Option<(i64, f64, i64)>,
}

impl Placer {
    /// The time of the row with this stamp (ns): later than that of the row before.
    #[expect(clippy::cast_possible_truncation, reason = "differences in ns")]
    pub fn place(&mut self, stamp_ns: i64) -> i64 {
        let Pace { period_ns, gap_ns, lead_ns, drawn, .. } = self.pace;
        let Some((place, fraction, stamp)) = self.last else {
            self.last = Some((stamp_ns, 0.0, stamp_ns));
            return stamp_ns;
        };
        // How far behind its stamp the row would stand, one period after the last one.
        let behind = stamp_ns.saturating_sub(place) as f64 - fraction - period_ns;
        let step = if stamp_ns.saturating_sub(stamp) > gap_ns {
            period_ns + behind.max(0.0)
        } else if drawn {
            period_ns + (GAIN * (behind + lead_ns)).clamp(-0.875 * period_ns, 0.4 * period_ns)
        } else {
            period_ns
        };
        let whole = (fraction + step).floor();
        let place = place.saturating_add(whole as i64);
        self.last = Some((place, fraction + step - whole, stamp_ns));
        place
    }
}

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, reason = "times of some minutes")]
mod tests {
    use super::*;

    const S: f64 = 1e9;

    /// A generator of numbers in 0..1, and rows at `rate` with stamps of `resolution_ns`.
    fn random(state: &mut u64) -> f64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f64 / f64::from(1 << 24)
    }

    fn stamps(rows: u32, rate: f64, resolution_ns: f64) -> Vec<i64> {
        let at = |k: u32| (f64::from(k) * S / rate / resolution_ns).floor() * resolution_ns;
        (0..rows).map(|k| at(k) as i64).collect()
    }

    #[track_caller]
    fn is_placed(stamps: &[i64], rate: f64, within_ns: f64) -> Vec<i64> {
        let pace = Pace::of(stamps).unwrap();
        assert!(pace.coarse, "{pace:?}");
        assert!(
            (f64::from(pace.rate_hz()) / rate - 1.0).abs() < 0.005,
            "{rate} {pace:?} {}",
            stamps.len()
        );
        let placed = pace.placed(stamps.to_vec());
        let period = S / rate;
        for pair in placed.windows(2) {
            let step = (pair[1] - pair[0]) as f64 / period;
            assert!(step > 0.1, "{pair:?}");
        }
        for (place, stamp) in placed.iter().zip(stamps) {
            assert!(((place - stamp) as f64).abs() <= within_ns, "{place} {stamp}");
        }
        placed
    }

    #[test]
    fn rounded_stamps_are_placed_by_rows_over_duration() {
        for rows in [400, 6400, 60_000] {
            for (rate, resolution) in [
                (1600.0, 1e6),
                (900.0, 1e6),
                (950.0, 1e6),
                (600.0, 1e6),
                (1100.0, 1e6),
                (400.0, 1e6),
                (6000.0, 1e5),
                (20_000.0, 1e5),
            ] {
                let stamps = stamps(rows, rate, resolution);
                let placed = is_placed(&stamps, rate, 2.5 * resolution);
                let even = placed.windows(2).filter(|pair| {
                    let step = (pair[1] - pair[0]) as f64 * rate / S;
                    (0.9..1.1).contains(&step)
                });
                assert_eq!(even.count(), placed.len() - 1, "{rate} {rows}");
            }
        }
    }

    #[test]
    fn bursts_with_one_stamp_are_spread() {
        let rows: Vec<i64> = (0..6400).map(|k| k / 16 * 10_000_000).collect();
        is_placed(&rows, 1600.0, 1.1e7);
        let few: Vec<i64> = (0..400).map(|k| k / 16 * 10_000_000).collect();
        is_placed(&few, 1600.0, 1.1e7);
        let pace = Pace::of(&few).unwrap();
        assert!(pace.to_string().contains("375 of 400 repeat"), "{pace}");
        // A rate that the caller knows is kept to.
        assert_eq!(pace.with_rate(1600.0).rate_hz(), 1600.0);
        let slow = pace.with_rate(800.0).placed(few);
        assert_eq!(slow[1] - slow[0], 1_250_000);
    }

    #[test]
    fn a_host_that_stamps_late_and_catches_up_is_smoothed() {
        let mut state = 7;
        let mut last = 0;
        // Every 4 ms a host looks; what it finds gets stamps 20 us apart.
        let rows: Vec<i64> = (0..6400_i64)
            .map(|k| {
                let found = (k * 625_000 / 4_000_000 + 1) * 4_000_000;
                last = (last + 20_000).max(found + (random(&mut state) * 2e4) as i64);
                last
            })
            .collect();
        is_placed(&rows, 1600.0, 8e6);
    }

    #[test]
    fn regular_stamps_stay_with_their_losses_and_jitter() {
        let mut state = 3;
        let even = stamps(20_000, 2200.0, 1000.0);
        assert!(!Pace::of(&even).unwrap().coarse);
        for lost in [0.001, 0.02, 0.05, 0.12] {
            for resolution in [1.0, 1e6] {
                let rows = stamps(20_000, 1000.0, resolution);
                let rows: Vec<i64> =
                    rows.into_iter().filter(|_| random(&mut state) > lost).collect();
                let pace = Pace::of(&rows).unwrap();
                assert!(
                    !pace.coarse && pace.to_string().is_empty(),
                    "{lost} {resolution} {pace:?}"
                );
                assert_eq!(pace.placed(rows.clone()), rows);
            }
        }
        let mut jitter = stamps(8000, 1000.0, 1.0);
        jitter.iter_mut().for_each(|t| *t += (random(&mut state) * 3e5) as i64);
        assert!(!Pace::of(&jitter).unwrap().coarse);
        // Another rate from the middle on is no contradiction.
        let slower = (0..6000_i64)
            .map(|k| if k < 3000 { k * 1_000_000 } else { k * 2_000_000 - 3_000_000_000 });
        assert!(!Pace::of(&slower.collect::<Vec<_>>()).unwrap().coarse);
    }

    #[test]
    fn finely_rounded_stamps_give_the_rate_with_and_without_losses() {
        for (rate, resolution) in [
            (800.0, 1e5),
            (1344.0, 1e5),
            (1600.0, 1e5),
            (1600.0, 1e4),
            (12_000.0, 1e4),
            (13_333.0, 1e4),
            (16_000.0, 1e4),
            (18_000.0, 1e4),
            (20_000.0, 1e4),
        ] {
            for lost in [0.0, 0.001, 0.05, 0.12] {
                let mut state = 5;
                let mut rows = stamps(8000, rate, resolution);
                rows.retain(|_| random(&mut state) >= lost);
                let gaps = |rows: &[i64]| {
                    let long = |pair: &&[i64]| (pair[1] - pair[0]) as f64 * rate > 1.5 * S;
                    rows.windows(2).filter(long).count()
                };
                let pace = Pace::of(&rows).unwrap();
                let off = (f64::from(pace.rate_hz()) / rate - 1.0).abs();
                assert!(off < 0.005, "{rate} {resolution} {lost} {pace:?}");
                let placed = pace.placed(rows.clone());
                assert_eq!(gaps(&placed), gaps(&rows), "{rate} {resolution} {lost}");
            }
        }
    }

    #[test]
    fn jitter_is_no_loss_and_hides_none_of_several_rows() {
        for rate in [800.0, 1600.0, 6000.0, 20_000.0] {
            for sigma in [0.1, 0.2, 0.3] {
                for lost in [0, 10, 400] {
                    let mut state = 11;
                    // Twelve numbers in 0..1 have a variance of 1.
                    let mut normal = || (0..12).map(|_| random(&mut state)).sum::<f64>() - 6.0;
                    let mut rows: Vec<i64> = (0..15_000)
                        .filter(|k| *k < 5000 || *k >= 5000 + lost)
                        .map(|k| ((f64::from(k) + 9.0 + sigma * normal()) * S / rate) as i64)
                        .collect();
                    rows.sort_unstable();
                    let pace = Pace::of(&rows).unwrap();
                    let off = (f64::from(pace.rate_hz()) / rate - 1.0).abs();
                    assert!(off < 0.005, "{rate} {sigma} {lost} {pace:?}");
                    let placed = pace.placed(rows);
                    let long = placed.windows(2).filter(|p| (p[1] - p[0]) as f64 * rate > 1.5 * S);
                    assert_eq!(long.count(), usize::from(lost > 0), "{rate} {sigma} {lost}");
                }
                // Many single rows lost: the stamps stay, and so do their gaps.
                let mut state = 13;
                let mut rows = stamps(15_000, rate, 1.0);
                rows.iter_mut().for_each(|t| *t += (random(&mut state) * sigma * S / rate) as i64);
                rows.retain(|_| random(&mut state) > 0.05);
                let pace = Pace::of(&rows).unwrap();
                assert!(!pace.coarse, "{rate} {sigma} {pace:?}");
                assert!((f64::from(pace.rate_hz()) / rate - 1.0).abs() < 0.005, "{pace:?}");
            }
        }
    }

    #[test]
    fn a_gap_among_coarse_stamps_stays_one() {
        let mut rows = stamps(6400, 1600.0, 1e6);
        rows.iter_mut().skip(3000).for_each(|t| *t += 500_000_000);
        let placed = is_placed(&rows, 1600.0, 2.5e6);
        let gaps: Vec<usize> =
            (1..placed.len()).filter(|at| placed[*at] - placed[at - 1] > 1_000_000).collect();
        assert_eq!(gaps, [3000]);
        let epoch: Vec<i64> = rows.iter().map(|t| t + 1_700_000_000_000_000_000).collect();
        let moved = Pace::of(&epoch).unwrap().placed(epoch);
        assert!(moved.iter().zip(&placed).all(|(m, p)| m - p == 1_700_000_000_000_000_000));
    }

    #[test]
    fn a_drifting_clock_is_followed() {
        // 1 % faster than on average at first, 1 % slower in the end, in whole milliseconds.
        let at = |k: f64| k * 0.000_625 * (0.99 + 0.02 * k / 200_000.0);
        let rows: Vec<i64> =
            (0..100_000_u32).map(|k| (at(f64::from(k)) * 1e3).floor() as i64 * 1_000_000).collect();
        is_placed(&rows, 1600.0, 2e7);
    }

    #[test]
    fn time_that_stands_still_has_no_pace() {
        assert_eq!(Pace::of(&[]), None);
        assert_eq!(Pace::of(&[5]), None);
        assert_eq!(Pace::of(&[5; 50]), None);
        assert!(!Pace::of(&[0, 1000, 2000, 2000, 3000]).unwrap().coarse);
    }
}
