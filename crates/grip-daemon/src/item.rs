//! The nouns that leave the hot thread, in the order in which things happened.

use grip_link::{
    host::{CloseReason, LinkState},
    message::{Clamped, Event as DeviceEvent, EventKind, Firmware, Grip, Nack, Status},
};
use grip_session::{
    config::Uid,
    report::Event,
    session::{Beginning, explain},
    shadow::SlipEvidence,
};
use slip_core::ClientCommand;
use slip_core::{PipelineState, Sample};

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
    State(&'a PipelineState),
    /// Something worth a line.
    Event {
        /// Host time (us).
        host_us: u64,
        /// What.
        event: &'a Event,
    },
    /// What a slip that has ended showed, where there is a shadow model to be asked about it.
    Evidence {
        /// Host time (us).
        host_us: u64,
        /// What.
        evidence: &'a SlipEvidence,
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

impl LinkNote {
    /// A sentence for people; `None` for what STATE and GRIPPER hold.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        Some(match self {
            LinkNote::State(_) | LinkNote::Status(_) | LinkNote::Configured(_) => return None,
            LinkNote::Identified { uid, rebooted, .. } => {
                let again = if *rebooted { ", restarted" } else { "" };
                format!("gripper {}{again}", Uid(*uid))
            }
            LinkNote::OtherGripper { uid } => format!("another gripper answered: {}", Uid(*uid)),
            LinkNote::Rebooted => "the gripper has restarted".to_owned(),
            LinkNote::Device(event) => {
                let fault = event.fault.0;
                match event.kind {
                    EventKind::Fault => format!("the gripper has stopped with fault {fault:04x}"),
                    EventKind::FaultCleared => format!("the gripper is free of fault {fault:04x}"),
                    EventKind::CommandRejected => {
                        format!("the gripper takes no command because of fault {fault:04x}")
                    }
                    _ => format!("gripper: {} -> {}", event.before, event.after),
                }
            }
            LinkNote::Refused(nack) => {
                format!("the gripper refused type {:02x}: {}", nack.kind.0, nack.reason)
            }
            LinkNote::Closed(reason) => format!("link closed: {}", explain(reason)),
            LinkNote::Late(late_us) => {
                format!("readings were {} ms late, the force was not raised", late_us / 1000)
            }
            LinkNote::PortOpened => "the port is open".to_owned(),
            LinkNote::PortLost => "the port is gone".to_owned(),
        })
    }
}
