//! Grasp of an object of the grasp simulator with a model, or two of them, as gripfleet reads it from STATE, SLIP and ESTIMATES.

use grip_eval::grasp::{Hand, Line, Setup, play, send_all};
use grip_fleet::rollout::{Grasp, GraspLog};
use grip_link::{
    host::HostEvent,
    message::{DeviceState, FaultCode},
};
use grip_session::{
    HostConfig, HostEstimator,
    config::LinkConfig,
    model::default_text,
    report::Event,
    session::{Session, SessionError, SessionOptions, Update},
    shadow::SlipEvidence,
};
use grip_sim::Scene;
use slip_core::{Phase, PipelineState, grip::GripState, units::Micros};

/// STATE comes five times a second (us).
const STATE_US: u64 = 200_000;

/// A session whose states and slips go into a log of grasps.
struct Logged {
    session: Session,
    /// A model that is asked about the same slips, as gripd does it.
    shadow: Option<HostEstimator>,
    log: GraspLog,
    device: (DeviceState, FaultCode),
    due_us: u64,
    grasp: Option<Grasp>,
}

impl Logged {
    fn state(&mut self, grip: Option<GripState>, now_us: u64) {
        let Some(step) = self.session.latest() else { return };
        let (device, fault) = self.device;
        let state = PipelineState {
            host: Micros(now_us),
            applied_n: self.session.applied_n(),
            device,
            fault,
            ..step.state(grip.or_else(|| self.session.grip_state()), None, None)
        };
        self.grasp = self.grasp.or(self.log.state(&state).map(|finished| finished.grasp));
    }
}

impl Hand for Logged {
    fn serve(
        &mut self,
        now_us: u64,
        bytes: &[u8],
        send: &mut dyn FnMut(&[u8]),
    ) -> Result<(), SessionError> {
        let mut left = bytes;
        while let Some(update) = self.session.receive(now_us, &mut left)? {
            match update {
                Update::Event(Event::Slip(slip)) => {
                    self.log.slip(&slip);
                    let shadow = self.shadow.as_ref().filter(|_| slip.phase == Phase::Ended);
                    let evidence = SlipEvidence::of(self.session.log(), slip.t);
                    if let Some((shadow, evidence)) = shadow.zip(evidence) {
                        self.log.estimates(&evidence.beside(shadow));
                    }
                }
                Update::Link(HostEvent::Status(status)) => {
                    self.device = (status.state, status.fault);
                }
                _ => {}
            }
        }
        if now_us >= self.due_us {
            self.due_us = now_us + STATE_US;
            self.state(None, now_us);
        }
        send_all(&mut self.session, now_us, send);
        Ok(())
    }

    fn command_n(&self) -> f32 {
        0.0
    }

    fn slips(&self) -> u64 {
        0
    }

    fn samples(&self) -> (u64, u64) {
        (0, 0)
    }
}

/// The object that `seed` draws from the scene, grasped with the first model, lifted, held for `seconds` and let go; `None` where no grasp came
/// of it. The second model is asked beside it.
pub(crate) fn grasp(
    scene: &Scene,
    seed: u64,
    estimator: &HostEstimator,
    shadow: Option<&HostEstimator>,
    seconds: u64,
) -> anyhow::Result<Option<Grasp>> {
    let mut config = scene.config().clone();
    config.seed = seed;
    let scene = Scene::new(config)?;
    let link = LinkConfig { sample_rate_hz: 1000, ..LinkConfig::default() };
    let config = HostConfig { link, ..HostConfig::default() };
    let mut session = Session::new(config.clone(), estimator.clone(), SessionOptions::default())?;
    session.open(0, 1)?;
    // The fingers were open before.
    let device = DeviceState::Active;
    let released = PipelineState { grip: GripState::Released, device, ..PipelineState::UNKNOWN };
    let mut log = GraspLog::default();
    log.state(&released);
    let device = (DeviceState::Boot, FaultCode::NONE);
    let shadow = shadow.cloned();
    let mut hand = Logged { session, shadow, log, device, due_us: 0, grasp: None };
    let duration = Micros(1_000_000 * seconds);
    let (line, incident) = (Line::default(), None);
    play(&Setup { scene: &scene, config: &config, duration, line, incident }, &mut hand)?;
    hand.state(None, duration.0);
    hand.state(Some(GripState::Released), duration.0);
    Ok(hand.grasp)
}

/// The default model with another range of its target: all of its forces are `share` of what they were.
pub(crate) fn scaled(share: f64) -> anyhow::Result<String> {
    let mut text = default_text().to_owned();
    for bound in ["0.19977216", "146.0365"] {
        anyhow::ensure!(text.contains(bound), "another default model");
        text = text.replacen(bound, &(bound.parse::<f64>()? * share).to_string(), 1);
    }
    Ok(text)
}
