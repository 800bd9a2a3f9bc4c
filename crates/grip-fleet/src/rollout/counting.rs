//! STATE and SLIP of a daemon in, what there was to slip, and what slipped, out.

use super::{Bursts, Counts};
use slip_core::{Phase, PipelineState, SlipReport, grip::GripState, scene::Scene};

/// Two STATE are 0.2 s apart; what lies further apart than this was not watched (us).
const LONGEST_US: u64 = 1_000_000;

/// Counts of one gripper since its daemon was heard first.
#[derive(Clone, Debug, Default)]
pub struct Counting {
    counts: Counts,
    bursts: Bursts,
    last: Option<PipelineState>,
    /// Whether the fingers were open since the last grasp. Another model closes them on what they hold.
    open: bool,
}

impl Counting {
    /// Takes what the pipeline thinks.
    pub fn state(&mut self, state: &PipelineState) {
        let Some(last) = self.last.replace(*state) else { return };
        let Counts { seconds, faults, grasps, .. } = &mut self.counts;
        let passed_us = state.host.0.saturating_sub(last.host.0);
        if matches!(state.grip, GripState::Open | GripState::Released) {
            self.open = true;
        } else if has_object(state) && state.grip != GripState::Observing {
            *grasps += u64::from(core::mem::take(&mut self.open));
        }
        if has_object(&last) && passed_us <= LONGEST_US {
            #[expect(clippy::cast_precision_loss, reason = "a second at most")]
            let passed_us = passed_us as f64;
            *seconds += 1e-6 * passed_us;
        }
        let is_new = state.fault.0 != 0 && state.fault != last.fault;
        *faults += u64::from(is_new);
    }

    /// Takes a slip, which counts when it is noticed.
    pub fn slip(&mut self, slip: &SlipReport) {
        let noticed = u64::from(slip.phase != Phase::Ended);
        self.counts.slips += self.bursts.take(self.counts.seconds, noticed);
    }

    /// All counts.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.counts
    }
}

/// Whether something is between the fingers: by the controller, or by the scene where there is none.
fn has_object(state: &PipelineState) -> bool {
    match state.grip {
        GripState::Open | GripState::Closing | GripState::Released => false,
        GripState::Observing => state.scene != Scene::Idle,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::Counting;
    use crate::rollout::Counts;
    use slip_core::{
        Phase, PipelineState, SlipReport, grip::GripState, scene::Scene, units::Micros,
    };

    #[test]
    fn time_with_an_object_grasps_slips_and_faults_are_counted() {
        let mut counting = Counting::default();
        let (idle, moving) =
            ((GripState::Released, Scene::Moving), (GripState::Observing, Scene::Moving));
        let holding = (GripState::Holding, Scene::Idle);
        let reported = [
            (0, holding, 0),
            (200, holding, 0),
            (400, idle, 0x0201),
            (600, idle, 0x0201),
            (800, moving, 0),
            (1000, holding, 0x0201),
            // A line that was silent shows nothing.
            (5000, holding, 0x0202),
        ];
        for (ms, (grip, scene), fault) in reported {
            let mut state = PipelineState { grip, scene, ..PipelineState::UNKNOWN };
            state.host = Micros(1000 * ms);
            state.fault.0 = fault;
            counting.state(&state);
        }
        for phase in [Phase::Incipient, Phase::Gross, Phase::Ended] {
            counting.slip(&SlipReport { phase, ..SlipReport::UNKNOWN });
        }
        let Counts { seconds, slips, faults, grasps } = counting.counts();
        assert!((seconds - 0.6).abs() < 1e-9, "{seconds}");
        assert_eq!((slips, faults, grasps), (1, 3, 1));
    }
}
