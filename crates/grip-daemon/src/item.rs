//! The nouns that leave the hot thread, in the order in which things happened.

use grip_link::{
    host::{CloseReason, LinkState},
    message::{Clamped, Event as DeviceEvent, Firmware, Grip, Nack, Status},
};
use grip_session::{
    report::EventLine,
    session::{Beginning, ClientCommand},
};
use slip_core::{
    Sample,
    esc::Esc,
    estimate::ForceEstimate,
    grip::GripState,
    health::SensorHealth,
    scene::Scene,
    units::{Micros, Newtons},
};

/// One thing that happened. Host times are monotonic microseconds since the start of the daemon.
#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    /// A pipeline begins, at the start of sampling, after a restart of the gripper and with a new configuration: the next samples go through it.
    Began {
        /// Host time (us).
        host_us: u64,
        /// What it begins with.
        beginning: &'a Beginning,
    },
    /// A sample went through the pipeline.
    Sample {
        /// Host time at which its frame was complete (us).
        host_us: u64,
        /// Number of the row on the device; wraps.
        index: u32,
        /// The sample.
        sample: &'a Sample,
        /// The frame of the taxel array that came with it, empty where none did.
        taxels: &'a [f32],
    },
    /// What the pipeline thinks after the last sample of a frame.
    State {
        /// Host time (us).
        host_us: u64,
        /// The state.
        state: &'a State,
    },
    /// Something worth a line.
    Event {
        /// Host time (us).
        host_us: u64,
        /// The line.
        line: &'a EventLine,
    },
    /// A force command was written to the gripper.
    Command {
        /// Host time (us).
        host_us: u64,
        /// The command as sent.
        grip: &'a Grip,
    },
    /// A client's command was carried out.
    Client {
        /// Host time (us).
        host_us: u64,
        /// What it asked for.
        command: ClientCommand,
    },
    /// Something about the link.
    Link {
        /// Host time (us).
        host_us: u64,
        /// What.
        note: &'a LinkNote,
    },
    /// Bytes as they were read from or written to the line.
    Wire {
        /// Host time (us).
        host_us: u64,
        /// Whether they went to the gripper.
        to_device: bool,
        /// The bytes.
        bytes: &'a [u8],
    },
}

/// The pipeline after a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Device time of the last sample (us).
    pub t: Micros,
    /// Scene.
    pub scene: Scene,
    /// What the force controller does; `None` where the pipeline only observes.
    pub grip: Option<GripState>,
    /// Slip statistic over its threshold.
    pub statistic: f32,
    /// Commanded force.
    pub command: Option<Newtons>,
    /// Measured normal force (N).
    pub applied_n: Option<f32>,
    /// The last E_sc as printed.
    pub esc: Option<Esc>,
    /// The last estimate.
    pub estimate: Option<ForceEstimate>,
    /// State of the stylus.
    pub health: SensorHealth,
    /// State of the motion reference.
    pub reference_health: SensorHealth,
    /// State of the travel channel.
    pub travel_health: SensorHealth,
    /// State of the taxel array.
    pub pressure_health: SensorHealth,
    /// Rows lost so far.
    pub lost: u64,
    /// Sample rate in force (Hz).
    pub rate_hz: u32,
    /// Age of the newest usable row at the last command (ms), by the host's clock; `None` where the clocks are not related.
    pub late_ms: Option<f32>,
}

/// What the link tells, as far as people and programs want to know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkNote {
    /// The state of the host's side changed.
    State(LinkState),
    /// A gripper answered.
    Identified {
        /// Its identity.
        uid: [u8; 16],
        /// Its number of starts.
        boot_id: u32,
        /// What runs on it.
        firmware: Firmware,
        /// Whether it has restarted since it was seen last.
        rebooted: bool,
    },
    /// Another gripper than the one before answered, and was left alone.
    OtherGripper {
        /// Its identity.
        uid: [u8; 16],
    },
    /// The gripper's limits are in force.
    Configured(Clamped),
    /// The gripper has restarted.
    Rebooted,
    /// State of the gripper as it tells it.
    Status(Status),
    /// The gripper reports a fault or a change of state.
    Device(DeviceEvent),
    /// The gripper refused a request.
    Refused(Nack),
    /// The link closed.
    Closed(CloseReason),
    /// The newest row was so old (us) at a command that the force was not raised; noted once an episode.
    Late(u64),
    /// The port is open.
    PortOpened,
    /// The port is gone, or cannot be opened.
    PortLost,
}
