//! Quantiles and counts of the outcomes of many slips.

use super::trials::Trial;

/// How late a detector is. A slip that is missed counts as infinitely late, one that began under an alarm is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latency {
    /// Slips.
    pub slips: usize,
    /// Median from gross slip (ms); infinite where more than half were missed.
    pub p50: f64,
    /// 95 % come within (ms).
    pub p95: f64,
    /// Slips without alarm.
    pub missed: usize,
    /// Slips that began while an alarm stood.
    pub early: usize,
}

impl Latency {
    /// Of these slips.
    #[must_use]
    pub fn of(trials: &[Trial]) -> Self {
        let ms = trials.iter().filter_map(|trial| match trial {
            Trial::Found(ms) => Some(*ms),
            Trial::Missed => Some(f64::INFINITY),
            Trial::Early => None,
        });
        let early = trials.iter().filter(|trial| **trial == Trial::Early).count();
        Self { slips: trials.len(), early, ..Self::of_ms(ms.collect()) }
    }

    /// Of slips that were found after so many ms, or not (infinity).
    #[must_use]
    pub fn of_ms(mut ms: Vec<f64>) -> Self {
        ms.sort_by(f64::total_cmp);
        let missed = ms.iter().filter(|ms| ms.is_infinite()).count();
        let (p50, p95) = (quantile(&ms, 0.5), quantile(&ms, 0.95));
        Self { slips: ms.len(), p50, p95, missed, early: 0 }
    }
}

/// The value at the place nearest to `q` of an ordered list; infinity of none.
#[must_use]
pub fn quantile(ordered: &[f64], q: f64) -> f64 {
    let place = (ordered.len().saturating_sub(1) as f64 * q).round() as usize;
    ordered.get(place).copied().unwrap_or(f64::INFINITY)
}
