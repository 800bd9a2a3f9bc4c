//! Outcomes of many slips in, their quantiles and counts out.

use super::trials::Trial;
use serde::Serialize;

/// How late a detector is. A slip that is missed counts as infinitely late, one that began under an alarm is left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Latency {
    /// Slips.
    pub slips: usize,
    /// Median from gross slip (ms); `null` in JSON where more than half were missed.
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
        let mut ms: Vec<f64> = trials
            .iter()
            .filter_map(|trial| match trial {
                Trial::Found(ms) => Some(*ms),
                Trial::Missed => Some(f64::INFINITY),
                Trial::Early => None,
            })
            .collect();
        ms.sort_by(f64::total_cmp);
        let count = |kind: Trial| trials.iter().filter(|trial| **trial == kind).count();
        Self {
            slips: trials.len(),
            p50: quantile(&ms, 0.5),
            p95: quantile(&ms, 0.95),
            missed: count(Trial::Missed),
            early: count(Trial::Early),
        }
    }
}

/// The value at the place nearest to `q` of an ordered list; infinity of none.
#[must_use]
pub fn quantile(ordered: &[f64], q: f64) -> f64 {
    let place = (ordered.len().saturating_sub(1) as f64 * q).round() as usize;
    ordered.get(place).copied().unwrap_or(f64::INFINITY)
}
