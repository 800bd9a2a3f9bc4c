//! Slips as they come in, slips that say something of their own out.
//!
//! An object that slips slips again at once until it is held with enough, and an object that is lifted slips some times on the way: such
//! slips are one finding and not several. The judge compares counts of findings that know nothing of each other, or it would condemn a
//! good model at its first grasp.

/// Slips that come within this time of the one before are the same finding (s).
const APART_S: f64 = 5.0;

/// Counts slips that are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bursts {
    /// When the last slip was, in the time that is counted (s).
    last_s: Option<f64>,
}

impl Bursts {
    /// So many slips are new at that time (s), which never goes back: how many of them count, none or one.
    pub fn take(&mut self, at_s: f64, slips: u64) -> u64 {
        if slips == 0 {
            return 0;
        }
        let apart = self.last_s.is_none_or(|last_s| at_s - last_s >= APART_S);
        self.last_s = Some(at_s);
        u64::from(apart)
    }
}

#[cfg(test)]
mod tests {
    use super::Bursts;
    use crate::rollout::{Counts, JudgeConfig, Judgement};

    #[test]
    fn slips_of_one_lift_count_once_and_the_next_lift_counts_again() {
        let mut bursts = Bursts::default();
        let taken: Vec<u64> = [(0.25, 2), (0.5, 0), (0.75, 3), (5.5, 1), (10.6, 1), (30.0, 4)]
            .into_iter()
            .map(|(at_s, slips)| bursts.take(at_s, slips))
            .collect();
        assert_eq!(taken, [1, 0, 0, 0, 1, 1]);
    }

    /// Two slips in each lift, once a minute, before and after: an equal model stays at every look of the first hour.
    #[test]
    fn an_equal_model_is_not_condemned_at_its_first_grasps() {
        let judge = JudgeConfig { watch_s: 3600.0, ..JudgeConfig::default() };
        let slips = |tenth: u32| match tenth % 600 {
            0 | 4 => 1,
            _ => 0,
        };
        let count = |counts: &mut Counts, bursts: &mut Bursts, tenth: u32| {
            counts.seconds += 0.1;
            counts.slips += bursts.take(counts.seconds, slips(tenth));
        };
        let (mut before, mut bursts) = (Counts::default(), Bursts::default());
        (0..36_000).for_each(|tenth| count(&mut before, &mut bursts, tenth));
        assert_eq!(before.slips, 60);
        let mut now = Counts { grasps: 1, ..Counts::default() };
        let looks: Vec<Judgement> = (0..36_001)
            .map(|tenth| {
                count(&mut now, &mut bursts, tenth);
                judge.judge(&before, &now)
            })
            .collect();
        let worse = looks.iter().position(|look| matches!(look, Judgement::Worse(_)));
        assert_eq!(worse, None);
        assert_eq!(looks.last(), Some(&Judgement::Good));
        // With each slip for itself, the first lift would have ended it.
        let lift = Counts { seconds: 0.5, slips: 2, faults: 0, grasps: 1 };
        let each = Counts { slips: 120, ..before };
        assert!(matches!(judge.judge(&each, &lift), Judgement::Worse(_)));
    }
}
