//! Slips found by chance: by as many alarms as a detector raised, thrown at random into the same recordings.
//!
//! Of N alarms in recordings of T seconds in all, at least one falls into a window of w seconds with the probability
//! 1 - (1 - w/T)^N. The number of windows that are hit has the sum of these as its mean; for the probability of so many or more
//! the windows are taken as independent, which is on the safe side: alarms that hit one window are missing in the others.

use serde::Serialize;

/// What chance finds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chance {
    /// Slips that are found on average.
    pub found: f64,
    /// Probability that chance finds as many as the detector did, or more; [`Chance::LEAST_P`] stands for all below.
    pub p: f64,
}

impl Chance {
    /// No recordings are so independent of each other that less would mean more.
    pub const LEAST_P: f64 = 1e-12;
}

/// `alarms` thrown at `total_s` of recordings; each slip is found by an alarm in its window of `windows_s`, and the detector
/// found `found`. `None` where there is no slip.
pub(super) fn chance(
    windows_s: impl Iterator<Item = f64>,
    alarms: u32,
    total_s: f64,
    found: usize,
) -> Option<Chance> {
    let hit = |window_s: f64| {
        if alarms == 0 || total_s <= 0.0 {
            return 0.0;
        }
        let share = (window_s / total_s).clamp(0.0, 1.0);
        -(f64::from(alarms) * (-share).ln_1p()).exp_m1()
    };
    let hits: Vec<f64> = windows_s.map(hit).collect();
    if hits.is_empty() {
        return None;
    }
    // Probability of each count, one window at a time.
    let mut counts = vec![0.0; hits.len() + 1];
    counts[0] = 1.0;
    for p in &hits {
        for k in (0..counts.len()).rev() {
            let from_below = if k > 0 { counts[k - 1] * p } else { 0.0 };
            counts[k] = counts[k] * (1.0 - p) + from_below;
        }
    }
    let p: f64 = counts.iter().skip(found).sum();
    Some(Chance { found: hits.iter().sum(), p: p.clamp(Chance::LEAST_P, 1.0) })
}

#[cfg(test)]
mod tests {
    use super::chance;

    #[test]
    fn chance_finds_what_random_alarms_hit() {
        // 594 alarms in 1364 s hit a window of 0.75 s with 1 - (1 - 0.75 / 1364)^594.
        let by = chance([0.75; 70].into_iter(), 594, 1364.0, 19).unwrap();
        assert!((by.found - 19.5).abs() < 0.1, "{by:?}");
        assert!((0.5..0.7).contains(&by.p), "{by:?}");
        assert_eq!(chance([].into_iter(), 5, 10.0, 0), None);
        let none = chance([1.0, 1.0].into_iter(), 0, 10.0, 1).unwrap();
        assert_eq!((none.found, none.p), (0.0, 1e-12));
        let all = chance([10.0].into_iter(), 1, 10.0, 1).unwrap();
        assert_eq!((all.found, all.p), (1.0, 1.0));
    }
}
