//! Simulation of a grasp with a scene, a hand and a line between them: what became of the object.

use super::{
    hand::Hand,
    line::{Line, Wire},
};
use crate::grasp::trial::TrialError;
use grip_link::frame::MAX_WIRE;
use grip_session::config::HostConfig;
use grip_sim::{
    Scene, Truth, VirtualMcu,
    mcu::{Sensor, SensorFault},
};
use slip_core::{estimate::ForceEstimate, grip::Trials, units::Micros};

/// One grasp before it begins.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The object and its gripper.
    pub scene: &'a Scene,
    /// Settings of the hand.
    pub config: &'a HostConfig,
    /// Length of the grasp.
    pub duration: Micros,
    /// Between gripper and hand.
    pub line: Line,
    /// What happens during the grasp; `None` where nothing does.
    pub incident: Option<Incident>,
}

/// Something that happens once during a grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incident {
    /// When it begins; samples from this time on are affected.
    pub at: Micros,
    /// What it is.
    pub kind: IncidentKind,
}

/// What may happen once during a grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IncidentKind {
    /// A sensor fails and stays so.
    Sensor(Sensor, SensorFault),
    /// The line holds all frames of the gripper for this long and then delivers them at once, in order, without a loss.
    LineStall(Micros),
    /// The host does not run for this long. Up to [`HOST_BUFFER`] bytes wait for it, further ones are lost; then it gets all at once.
    HostStall(Micros),
}

/// Bytes that the operating system keeps for a host that does not read.
pub const HOST_BUFFER: usize = 64 * 1024;

/// What became of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The simulator's truth at the end.
    pub truth: Truth,
    /// Slips that were noticed.
    pub slips: u64,
    /// How the object was tried until it was held; what it moved is as measured. Nothing where an older law commands.
    pub trials: Trials,
    /// The last estimate of the adequate force, with its deviation.
    pub estimate: Option<ForceEstimate>,
    /// Highest force commanded (N).
    pub peak_command_n: f32,
    /// Last force commanded (N).
    pub command_n: f32,
    /// Samples handled.
    pub samples: u64,
    /// Samples lost.
    pub lost: u64,
}

impl Outcome {
    /// Final applied force over the needed one.
    #[must_use]
    pub fn force_ratio(&self) -> f64 {
        self.truth.applied_n / self.truth.force_needed_n
    }

    /// The object was lifted and is still in the fingers, whole.
    #[must_use]
    pub fn held(&self) -> bool {
        self.truth.lifted() && !self.truth.dropped() && !self.truth.crushed
    }
}

/// Grasps, lifts and holds the object of `setup`.
///
/// # Errors
/// Where the scene does not make a device, or the hand fails.
pub fn play(setup: &Setup<'_>, hand: &mut dyn Hand) -> Result<Outcome, TrialError> {
    let mut mcu = VirtualMcu::new(setup.scene, 1)?;
    let (mut up, mut down) = (Wire::from_gripper(setup.line), Wire::to_gripper(setup.line));
    let mut bytes = Vec::with_capacity(4 * MAX_WIRE);
    let mut frame = [0; MAX_WIRE];
    let mut peak_command_n = 0.0_f32;
    let mut ahead = setup.incident;
    let mut stopped_until = Micros(0);
    if let Some(Incident { kind: IncidentKind::Sensor(_, SensorFault::Late(delay)), .. }) = ahead {
        mcu.remember_readings(delay);
    }
    loop {
        let arrivals = [up.next(), down.next()].into_iter().flatten();
        let now = arrivals.fold(mcu.next_due(), core::cmp::min);
        if now > setup.duration {
            break;
        }
        if let Some(incident) = ahead.take_if(|incident| now >= incident.at) {
            match incident.kind {
                IncidentKind::Sensor(sensor, fault) => mcu.break_sensor(sensor, Some(fault)),
                IncidentKind::LineStall(length) => up.hold_until(incident.at.plus(length)),
                IncidentKind::HostStall(length) => stopped_until = incident.at.plus(length),
            }
        }
        mcu.advance(now);
        hand.witness(&mcu.truth());
        while let Some(len) = mcu.poll_transmit(now, &mut frame) {
            up.send(now, frame.get(..len).unwrap_or(&frame));
        }
        while let Some(arrived) = up.receive(now) {
            bytes.extend(arrived);
        }
        if now >= stopped_until {
            hand.serve(now.0, &bytes, &mut |frame| down.send(now, frame))?;
            bytes.clear();
        } else {
            bytes.truncate(HOST_BUFFER);
        }
        while let Some(arrived) = down.receive(now) {
            mcu.receive(now, &arrived);
        }
        peak_command_n = peak_command_n.max(hand.command_n());
    }
    let (samples, lost) = hand.samples();
    let (trials, estimate) = hand.tried();
    Ok(Outcome {
        truth: mcu.truth(),
        slips: hand.slips(),
        trials,
        estimate,
        peak_command_n,
        command_n: hand.command_n(),
        samples,
        lost,
    })
}
