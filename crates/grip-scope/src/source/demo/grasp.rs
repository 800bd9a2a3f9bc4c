//! Simulation of an object over time, and what sensors, pipeline and controller do with it.

use super::{BETWEEN_US, GRASP_US, World};
use crate::feed::{EventMark, Feed};
use crate::source::outlet::Outlet;
use grip_link::device::Peer;
use grip_link::frame::MAX_WIRE;
use grip_link::message::{
    Unit,
    daemon::{GripState, Gripper, SlipReport},
};
use grip_session::model::default_estimator;
use grip_session::report::Event;
use grip_session::{HostConfig, Session, SessionOptions, Update};
use slip_core::ClientCommand;
use slip_core::PipelineState;
use slip_core::{Sample, units::Micros};

/// States come at most this often (us), and on change.
const STATE_US: u64 = 5_000;

/// Whether a person has stopped the gripper, which then keeps the force it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stopped {
    No,
    Yes,
    /// The fingers were asked to close again: on the next object.
    Over,
}

/// One object in the fingers.
pub(super) struct Grasp {
    gripper: Box<dyn Peer>,
    boot_id: u32,
    pub(super) session: Session,
    released: bool,
    stopped: Stopped,
    greeted: bool,
}

impl Grasp {
    pub(super) fn new(
        gripper: Box<dyn Peer>,
        boot_id: u32,
        config: &HostConfig,
    ) -> Result<Self, String> {
        let estimator = default_estimator().map_err(|error| error.to_string())?;
        let options = SessionOptions::default();
        let mut session =
            Session::new(config.clone(), estimator, options).map_err(|error| error.to_string())?;
        let nonce = u16::try_from(boot_id % 65_535).unwrap_or(0) + 1;
        session.open(0, nonce).map_err(|error| error.to_string())?;
        Ok(Self {
            gripper,
            boot_id,
            session,
            released: false,
            stopped: Stopped::No,
            greeted: false,
        })
    }

    pub(super) fn now_us(&self) -> u64 {
        self.gripper.now_us()
    }

    /// Whether the next object has to wait.
    pub(super) fn goes_on(&self) -> bool {
        match self.stopped {
            Stopped::No => self.now_us() < GRASP_US + BETWEEN_US,
            Stopped::Yes => true,
            Stopped::Over => false,
        }
    }

    /// Carries out what a person asks for: what became of it.
    pub(super) fn obey(&mut self, command: ClientCommand) -> String {
        if self.stopped != Stopped::No && command == ClientCommand::Grasp {
            self.stopped = Stopped::Over;
            return "grasp: the stop is over, the next object comes".to_owned();
        }
        let done = self.session.obey(self.now_us(), command);
        if command == ClientCommand::Stop {
            self.stopped = Stopped::Yes;
            return "stop: the simulated gripper keeps its force and waits for grasp".to_owned();
        }
        match (done, self.stopped) {
            (true, _) => format!("{command}: carried out by the simulated gripper"),
            (false, Stopped::No) => format!("{command}: not possible now"),
            (false, _) => format!("{command}: not possible while it is stopped"),
        }
    }

    pub(super) fn about(&self) -> Gripper {
        let link = self.session.link();
        let in_force = link.in_force();
        let force_max_n = in_force.map(|config| config.force_max_mn as f32 / 1e3);
        Gripper {
            uid: link.ident().map_or([0; 16], |ident| ident.uid),
            boot_id: self.boot_id,
            rate_hz: in_force.map_or(0, |config| config.sample_rate_hz),
            force_max_n,
            link: link.state(),
            taxels: u8::try_from(self.session.taxels()).unwrap_or(u8::MAX),
            stylus: Unit::Metre,
        }
    }

    /// Lets simulation and session go on.
    pub(super) fn run_until(
        &mut self,
        until_us: u64,
        world: &mut World,
        outlet: &mut Outlet,
    ) -> Result<(), String> {
        let mut bytes = Vec::with_capacity(4 * MAX_WIRE);
        let mut frame = [0; MAX_WIRE];
        while self.gripper.next_due_us() <= until_us {
            let now_us = self.gripper.next_due_us();
            self.gripper.receive(now_us, &[]);
            bytes.clear();
            while let Some(len) = self.gripper.poll_transmit(now_us, &mut frame) {
                bytes.extend(frame.iter().take(len));
            }
            self.turn(now_us, &bytes, world, outlet)?;
            self.report_state(world, outlet);
            let due = now_us > GRASP_US && self.stopped == Stopped::No;
            if due && !core::mem::replace(&mut self.released, true) {
                self.session.obey(now_us, ClientCommand::Release);
            }
        }
        Ok(())
    }

    /// One exchange of bytes.
    fn turn(
        &mut self,
        now_us: u64,
        bytes: &[u8],
        world: &mut World,
        outlet: &Outlet,
    ) -> Result<(), String> {
        let mut out = [0; MAX_WIRE];
        let World { tally, stream, start_us, .. } = world;
        let began = outlet.now();
        let mut left = bytes;
        while let Some(updates) =
            self.session.receive(now_us, &mut left).map_err(|error| error.to_string())?
        {
            match updates {
                Update::Step { index, sample, taxels, .. } => {
                    stream.number(index, 1);
                    stream.push(&Sample { t: sample.t.plus(Micros(*start_us)), ..*sample }, taxels);
                }
                Update::Event(Event::Slip(slip)) => {
                    let slip = SlipReport { t: slip.t.plus(Micros(*start_us)), ..slip };
                    stream.mark(EventMark::slip(&slip));
                }
                _ => {}
            }
        }
        let answer = self.session.command(now_us, &mut out);
        if !bytes.is_empty() {
            let took = outlet.now().saturating_sub(began).as_nanos();
            tally.latency.record(u64::try_from(took).unwrap_or(u64::MAX));
        }
        if let Some(len) = answer {
            self.gripper.receive(now_us, out.get(..len).unwrap_or(&out));
        }
        while let Some(len) = self.session.poll_transmit(now_us, &mut out) {
            self.gripper.receive(now_us, out.get(..len).unwrap_or(&out));
        }
        Ok(())
    }

    fn report_state(&mut self, world: &mut World, outlet: &mut Outlet) {
        let Some(state) = self.state(world.start_us) else { return };
        if !core::mem::replace(&mut self.greeted, true) {
            outlet.offer(Feed::Gripper(self.about()));
        }
        // What is let go falls because it shall.
        let truth = self.gripper.truth().filter(|_| state.grip != GripState::Released);
        world.stream.state(state, truth, STATE_US);
    }

    fn state(&self, start_us: u64) -> Option<PipelineState> {
        let (features, estimate) = self.session.log().evidence();
        let esc = features.and_then(|features| features.esc_chosen);
        let state = self.session.latest()?.state(self.session.grip_state(), esc, estimate);
        Some(PipelineState {
            t: state.t.plus(Micros(start_us)),
            device: self.gripper.link().state(),
            fault: self.gripper.link().fault(),
            applied_n: self.session.applied_n(),
            lost: self.session.lost(),
            rate_hz: self.session.link().in_force().map_or(0, |config| config.sample_rate_hz),
            ..state
        })
    }
}
