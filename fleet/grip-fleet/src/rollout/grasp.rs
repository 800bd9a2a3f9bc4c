//! Log of grasps, from STATE, SLIP and ESTIMATES of a daemon: what each finished grasp came to.
//!
//! A grasp begins when the controller holds something after the fingers were open, and ends when they open or the object is lost. It counts
//! only where the gripper was active and without a fault, and where one model held it from beginning to end. Everything is counted: an object
//! that slips ten times counts ten times.

use super::shadow::Compared;
use grip_link::message::{
    DeviceState, FaultCode,
    daemon::{Estimates, Unsure},
};
use serde::{Deserialize, Serialize};
use slip_core::{Phase, PipelineState, SlipReport, grip::GripState, units::Micros};

/// Two STATE are 0.2 s apart; a grasp with a longer gap than this was not watched (us).
const LONGEST_US: u64 = 1_000_000;

/// What a grasp came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grasp {
    /// The gripper has latched the loss of the object.
    pub lost: bool,
    /// Times the object slipped and was held with more force.
    pub regrasps: u32,
    /// What it moved in these slips, as measured (mm).
    pub slip_mm: f32,
    /// The last force in the hold over the force at which it slipped last; `None` where nothing slipped.
    pub force_ratio: Option<f32>,
    /// What two models made of its first slip that either had an estimate of; `None` without a shadow model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<Compared>,
}

impl Grasp {
    /// A force ratio above this is over-force.
    pub const OVER_FORCE: f32 = 2.5;

    /// Whether it was held with more than [`Grasp::OVER_FORCE`] times what it had been shown to need.
    #[must_use]
    pub fn over_force(&self) -> bool {
        self.force_ratio.is_some_and(|ratio| ratio > Self::OVER_FORCE)
    }

    /// Whether a gripper can have measured that: at most a million slips and a kilometre, no negative number and none that is none.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let measured = |value: f32| (0.0..=1e6).contains(&value);
        self.regrasps <= 1_000_000
            && measured(self.slip_mm)
            && self.force_ratio.is_none_or(measured)
            && self.compared.is_none_or(|compared| compared.is_sane())
    }
}

/// What a gripper's own recordings show of a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rehearsal {
    /// Recordings that were replayed to their ends.
    pub recordings: usize,
    /// What kept others from it, a sentence each; also that there are none.
    pub skipped: Vec<String>,
    /// Grasps in which both models were asked, in their order.
    pub grasps: Vec<Grasp>,
}

/// A finished grasp and its number, from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finished {
    /// +1 for each grasp that has begun.
    pub number: u64,
    /// What it came to.
    pub grasp: Grasp,
}

/// A grasp that goes on.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    grasp: Grasp,
    /// Forces at the last slip and in the hold after it (N).
    slipped_n: Option<f32>,
    held_n: Option<f32>,
    /// A slip goes on that moved the object so far (mm).
    slip_mm: Option<f32>,
    /// Estimates of the model in force and of the shadow model (N).
    estimates: Option<[Option<f32>; 2]>,
    /// The controller has begun anew with the object in the fingers: it counts only if it is lost.
    broken: bool,
}

/// The grasps of one gripper since its daemon was connected.
#[derive(Clone, Debug, Default)]
pub struct GraspLog {
    begun: u64,
    open: Option<Open>,
    /// The fingers were open since the last grasp. A new model makes the controller close them on what they hold.
    released: bool,
    last: Micros,
}

impl GraspLog {
    /// Takes the state of the pipeline; the grasp that has ended with it.
    pub fn state(&mut self, state: &PipelineState) -> Option<Finished> {
        let gap_us = state.host.0.saturating_sub(self.last.0);
        self.last = state.host;
        if gap_us > LONGEST_US {
            self.open = None;
        }
        if state.fault == FaultCode::OBJECT_LOST {
            self.released = true;
            return self.finish(true);
        }
        if state.fault.is_fault() || state.device != DeviceState::Active {
            self.open = None;
            return None;
        }
        match state.grip {
            GripState::Open | GripState::Released => {
                self.released = true;
                return self.finish(false);
            }
            GripState::Settling | GripState::Holding | GripState::Slipping | GripState::Lost => {
                self.hold(state)
            }
            GripState::Closing => {
                if let Some(open) = &mut self.open {
                    open.broken = true;
                }
            }
            _ => self.open = None,
        }
        None
    }

    fn hold(&mut self, state: &PipelineState) {
        if core::mem::take(&mut self.released) {
            self.begun += 1;
            self.open = Some(Open::default());
        }
        let Some(open) = self.open.as_mut().filter(|_| state.grip == GripState::Holding) else {
            return;
        };
        if open.slip_mm.is_none() {
            open.held_n = state.applied_n.or(state.command_n);
        }
    }

    /// Takes a slip.
    pub fn slip(&mut self, slip: &SlipReport) {
        let Some(open) = &mut self.open else { return };
        let moved_mm = slip.moved_m.map_or(0.0, |moved_m| 1e3 * moved_m.abs());
        let before_mm = open.slip_mm.unwrap_or_default();
        if open.slip_mm.is_none() && slip.phase != Phase::Ended {
            open.grasp.regrasps += 1;
            open.slipped_n = slip.command_n;
            open.held_n = None;
        }
        open.grasp.slip_mm += (moved_mm - before_mm).max(0.0);
        open.slip_mm = (slip.phase != Phase::Ended).then_some(moved_mm.max(before_mm));
    }

    /// Takes what two models made of the last slip; what is too unsure to move the fingers is none.
    pub fn estimates(&mut self, made: &Estimates) {
        let Some(open) = &mut self.open else { return };
        let sure = |force_n: Option<f32>, unsure| force_n.filter(|_| !made.unsure.has(unsure));
        let both = [sure(made.in_force_n, Unsure::IN_FORCE), sure(made.shadow_n, Unsure::SHADOW)];
        if both != [None, None] {
            open.estimates.get_or_insert(both);
        }
    }

    /// Another shadow model is there, or none: estimates of the grasp that goes on belong to neither. Grasps of higher numbers are its own.
    pub fn cast(&mut self) -> u64 {
        if let Some(open) = &mut self.open {
            open.estimates = None;
        }
        self.begun
    }

    /// Another model is in force. The grasp that goes on belongs to neither; grasps of higher numbers belong to the new one.
    pub fn swapped(&mut self) -> u64 {
        self.open = None;
        self.begun
    }

    fn finish(&mut self, lost: bool) -> Option<Finished> {
        let Open { grasp, slipped_n, held_n, broken, estimates, .. } = self.open.take()?;
        if broken && !lost {
            return None;
        }
        let ratio = held_n.zip(slipped_n.filter(|force_n| *force_n > 0.0));
        let force_ratio = ratio.map(|(held_n, slipped_n)| held_n / slipped_n).filter(|_| !lost);
        let held_n = held_n.filter(|_| !lost);
        let compared = estimates.zip(slipped_n).map(|([in_force_n, shadow_n], slipped_n)| {
            Compared { in_force_n, shadow_n, slipped_n, held_n }
        });
        let grasp = Grasp { lost, force_ratio, compared, ..grasp };
        Some(Finished { number: self.begun, grasp })
    }
}

#[cfg(test)]
mod tests {
    use super::{Compared, Finished, Grasp, GraspLog};
    use grip_link::message::{
        DeviceState, FaultCode,
        daemon::{Estimates, Unsure},
    };
    use slip_core::{Phase, PipelineState, SlipReport, grip::GripState, units::Micros};

    /// A gripper that reports five times a second.
    #[derive(Default)]
    struct Gripper {
        log: GraspLog,
        now_us: u64,
        finished: Vec<Grasp>,
    }

    impl Gripper {
        fn report(&mut self, grip: GripState, applied_n: f32, device: DeviceState, fault: u16) {
            self.now_us += 200_000;
            let state = PipelineState {
                host: Micros(self.now_us),
                grip,
                device,
                fault: FaultCode(fault),
                applied_n: Some(applied_n),
                ..PipelineState::UNKNOWN
            };
            self.finished.extend(self.log.state(&state).map(|finished| finished.grasp));
        }

        fn active(&mut self, grip: GripState, applied_n: f32) {
            self.report(grip, applied_n, DeviceState::Active, 0);
        }

        fn slip(&mut self, phase: Phase, moved_mm: f32, command_n: f32) {
            let (moved_m, command_n) = (Some(1e-3 * moved_mm), Some(command_n));
            self.log.slip(&SlipReport { phase, moved_m, command_n, ..SlipReport::UNKNOWN });
        }

        fn grasp(&mut self) {
            for grip in [GripState::Released, GripState::Closing, GripState::Settling] {
                self.active(grip, 1.0);
            }
        }
    }

    #[test]
    fn a_grasp_has_all_its_slips_and_the_force_after_the_last() {
        let mut gripper = Gripper::default();
        gripper.grasp();
        // Every slip counts, however soon it comes after another one.
        for n in 0..264 {
            gripper.slip(Phase::Incipient, 0.0, 2.0);
            gripper.slip(Phase::Gross, 0.1, 2.0);
            gripper.slip(Phase::Ended, 0.25, 4.0);
            if n % 50 == 0 {
                gripper.active(GripState::Holding, 9.0);
            }
        }
        gripper.active(GripState::Holding, 5.0);
        gripper.active(GripState::Released, 1.0);
        let [grasp] = gripper.finished[..] else { panic!("{:?}", gripper.finished) };
        assert_eq!((grasp.lost, grasp.regrasps, grasp.force_ratio), (false, 264, Some(2.5)));
        assert!((grasp.slip_mm - 66.0).abs() < 0.01 && !grasp.over_force(), "{grasp:?}");
    }

    #[test]
    fn an_object_that_is_lost_ends_the_grasp_and_counts_once() {
        let mut gripper = Gripper::default();
        gripper.grasp();
        gripper.active(GripState::Holding, 5.0);
        gripper.active(GripState::Closing, 0.0);
        for _ in 0..50 {
            gripper.report(GripState::Closing, 0.0, DeviceState::Fault, 0x0201);
        }
        assert_eq!(gripper.finished, [Grasp { lost: true, ..Grasp::default() }]);
    }

    #[test]
    fn empty_fingers_faults_and_what_was_not_watched_are_no_grasps() {
        let mut gripper = Gripper::default();
        // A moving arm with empty fingers, a gripper that only observes, and one that has held something since before.
        for grip in
            [GripState::Closing, GripState::Observing, GripState::Holding, GripState::Released]
        {
            gripper.active(grip, 1.0);
        }
        // Another fault, a device that does not follow, and a line that was silent.
        for (device, fault, silence_us) in [
            (DeviceState::Fault, 0x0203, 0),
            (DeviceState::Hold, 0, 0),
            (DeviceState::Active, 0, 2_000_000),
        ] {
            gripper.grasp();
            gripper.now_us += silence_us;
            gripper.report(GripState::Holding, 1.0, device, fault);
            gripper.active(GripState::Released, 1.0);
        }
        // A controller that begins anew with the object between the fingers.
        gripper.grasp();
        for grip in
            [GripState::Holding, GripState::Closing, GripState::Holding, GripState::Released]
        {
            gripper.active(grip, 1.0);
        }
        assert_eq!(gripper.finished, []);
    }

    #[test]
    fn estimates_stand_beside_what_the_grasp_later_showed() {
        let mut gripper = Gripper::default();
        let made = |in_force_n, shadow_n, unsure| Estimates {
            slip: 0,
            t: Micros(0),
            host: Micros(0),
            slipped_n: Some(2.0),
            in_force_n,
            shadow_n,
            unsure,
        };
        gripper.grasp();
        gripper.slip(Phase::Incipient, 0.0, 2.0);
        gripper.slip(Phase::Ended, 0.2, 3.0);
        // The first one counts, as far as it may move fingers.
        gripper.log.estimates(&made(Some(3.0), Some(4.0), Unsure::IN_FORCE));
        gripper.slip(Phase::Incipient, 0.0, 3.0);
        gripper.slip(Phase::Ended, 0.2, 5.0);
        gripper.log.estimates(&made(Some(6.0), Some(7.0), Unsure::default()));
        gripper.active(GripState::Holding, 5.5);
        gripper.active(GripState::Released, 1.0);
        let compared = |gripper: &Gripper| gripper.finished.last().unwrap().compared;
        let wanted =
            Compared { in_force_n: None, shadow_n: Some(4.0), slipped_n: 3.0, held_n: Some(5.5) };
        assert_eq!(compared(&gripper), Some(wanted));
        // Of a grasp in which the shadow changed nothing is compared.
        gripper.grasp();
        gripper.slip(Phase::Incipient, 0.0, 2.0);
        gripper.slip(Phase::Ended, 0.2, 3.0);
        gripper.log.estimates(&made(Some(3.0), Some(4.0), Unsure::default()));
        assert_eq!(gripper.log.cast(), 2);
        gripper.active(GripState::Holding, 5.5);
        gripper.active(GripState::Released, 1.0);
        assert_eq!((gripper.finished.len(), compared(&gripper)), (2, None));
    }

    #[test]
    fn the_grasp_in_which_a_model_changes_is_no_ones() {
        let mut gripper = Gripper::default();
        gripper.grasp();
        assert_eq!(gripper.log.swapped(), 1);
        gripper.active(GripState::Holding, 1.0);
        gripper.active(GripState::Released, 1.0);
        gripper.active(GripState::Holding, 1.0);
        gripper.now_us += 200_000;
        let host = Micros(gripper.now_us);
        let device = DeviceState::Active;
        let open = PipelineState { host, device, grip: GripState::Open, ..PipelineState::UNKNOWN };
        let finished = gripper.log.state(&open);
        assert_eq!(finished, Some(Finished { number: 2, grasp: Grasp::default() }));
    }
}
