//! The board in, what `gripctl status` and people with `curl` read out: one JSON object. Names and units are a contract.

use crate::{
    board::{Board, Grant},
    latency::Latency,
    metrics::healths,
};
use grip_session::{config::Uid, report::Event, session::explain};
use serde::Serialize;
use slip_core::{PipelineState, grip::GripState, units::Micros};
use std::{borrow::Cow, collections::BTreeMap, path::Path};

/// Everything that is known of the daemon.
#[derive(Clone, Debug, Serialize)]
pub struct Status<'a> {
    /// Version of gripd.
    pub version: &'a str,
    /// Time since the start (s).
    pub uptime_s: f64,
    /// Configuration files in force, the strongest first.
    pub config_files: Vec<Cow<'a, str>>,
    /// Whether no force command is ever sent.
    pub dry_run: bool,
    /// The link and the gripper.
    pub link: Link<'a>,
    /// Samples and what was lost, by cause.
    pub samples: Samples,
    /// Frames that were not used, by cause; only causes that occurred.
    pub bad_frames: BTreeMap<&'static str, u32>,
    /// From the last byte of a frame to its command written (us).
    pub latency_us: Option<LatencyUs>,
    /// Age of the newest usable row at each command (us).
    pub evidence_age_us: Option<LatencyUs>,
    /// Commands at which it was too old to raise the force.
    pub late_commands: u64,
    /// The pipeline after the last frame; absent before there is one.
    pub pipeline: Option<Pipeline>,
    /// What is known of the object in hand or next; absent where nothing is remembered.
    pub object: Option<&'a str>,
    /// Slips since the start.
    pub slips: u64,
    /// Force commands written.
    pub commands: u64,
    /// The last events, the oldest first.
    pub events: Vec<At>,
    /// Clients.
    pub clients: Clients,
    /// The recording.
    pub recording: Recording<'a>,
    /// What was asked of the system for real time.
    pub realtime: Vec<Granted<'a>>,
    /// Items that did not fit into a ring, by ring.
    pub ring_dropped: BTreeMap<&'static str, u64>,
}

/// The link and the gripper.
#[derive(Clone, Debug, Serialize)]
pub struct Link<'a> {
    /// The port as it was asked for.
    pub port: &'a str,
    /// Whether a line is open.
    pub port_open: bool,
    /// `closed`, `open`, `hello`, `config`, `stream` or `degraded`.
    pub state: &'static str,
    /// Identity of the gripper, 32 hexadecimal digits.
    pub uid: Option<String>,
    /// Its number of starts.
    pub boot_id: Option<u32>,
    /// Version of its firmware.
    pub firmware: Option<String>,
    /// Its state as it tells it.
    pub gripper_state: Option<&'static str>,
    /// Its latched fault, 0 for none.
    pub gripper_fault: Option<u16>,
    /// State of the gripper's clock: `good`, `stopped`, `back`, `forward`, `fast` or `slow`.
    pub clock: &'static str,
    /// Faults of that clock.
    pub clock_faults: u64,
    /// Whether no usable row has come for more than 50 ms while samples should flow.
    pub blind: bool,
    /// Why the link closed last.
    pub closed: Option<String>,
    /// Times it closed by error.
    pub failures: u64,
    /// Lines opened after the first.
    pub reconnects: u64,
    /// Times the gripper has restarted.
    pub reboots: u64,
}

/// Samples.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Samples {
    /// Through the pipeline, since the start.
    pub handled: u64,
    /// Of the last second (Hz).
    pub rate_hz: Option<f64>,
    /// Lost on the line.
    pub lost_on_line: u64,
    /// Dropped by the gripper.
    pub dropped_by_gripper: u64,
    /// Readings that could not be used.
    pub unusable_readings: u64,
    /// Times samples were late or missing.
    pub degraded: u64,
}

/// Quantiles (us), to an eighth.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LatencyUs {
    /// Half are not longer.
    pub p50: f64,
    /// 99 % are not longer.
    pub p99: f64,
    /// 99.9 % are not longer.
    pub p99_9: f64,
    /// The longest.
    pub max: f64,
}

/// The pipeline after the last frame.
#[derive(Clone, Debug, Serialize)]
pub struct Pipeline {
    /// Age of what follows (s).
    pub age_s: f64,
    /// Device time (s).
    pub t_s: f64,
    /// Sample rate in force (Hz).
    pub rate_hz: u32,
    /// `idle`, `moving`, `holding` or `slipping`.
    pub scene: &'static str,
    /// What the force controller does; absent where the pipeline only observes.
    pub grip: Option<&'static str>,
    /// Slip statistic over its threshold.
    pub statistic: Option<f32>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
    /// Measured normal force (N).
    pub applied_n: Option<f32>,
    /// The last estimate (N).
    pub estimate_n: Option<f32>,
    /// Age of the newest usable row at the last command (ms), by the host's clock; absent where the clocks are not related.
    pub late_ms: Option<f32>,
    /// Health of each sensor by name.
    pub health: BTreeMap<&'static str, &'static str>,
}

/// An event and when it was heard.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct At {
    /// Host time since the start (s).
    pub host_s: f64,
    /// The event.
    #[serde(flatten)]
    pub line: Event,
}

/// Clients.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Clients {
    /// Connected now.
    pub connected: u64,
    /// Since the start.
    pub accepted: u64,
    /// Turned away because there were too many.
    pub refused: u64,
    /// Messages that slow clients did not get.
    pub dropped: u64,
    /// Commands carried out.
    pub commands: u64,
    /// Commands not allowed or not understood.
    pub bad_commands: u64,
}

/// The recording.
#[derive(Clone, Debug, Serialize)]
pub struct Recording<'a> {
    /// The file that is written.
    pub file: Option<Cow<'a, str>>,
    /// Bytes written since the start.
    pub bytes: u64,
    /// Items not recorded.
    pub dropped: u64,
    /// Why it stopped, where it did.
    pub failure: Option<&'a str>,
}

/// Something that was asked of the system.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Granted<'a> {
    /// What.
    pub what: &'a str,
    /// Whether it was granted.
    pub granted: bool,
    /// Why not.
    pub reason: Option<&'a str>,
}

impl<'a> Status<'a> {
    /// What `board` knows at host time `now_us` (us).
    #[must_use]
    pub fn of(board: &'a Board, now_us: u64) -> Self {
        let hot = board.counters();
        let about = &board.about;
        let bad = hot.bad_frames().into_iter().filter(|(_, count)| *count > 0).collect();
        let events = board.events().map(|(at, line)| At { host_s: seconds(*at), line: *line });
        Self {
            version: &about.version,
            uptime_s: seconds(now_us),
            config_files: about.config_files.iter().map(|file| file.to_string_lossy()).collect(),
            dry_run: about.dry_run,
            link: Link::of(board),
            samples: Samples {
                handled: hot.samples,
                rate_hz: board.rate_hz(),
                lost_on_line: hot.loss.lost.saturating_sub(hot.loss.dropped_by_mcu),
                dropped_by_gripper: hot.loss.dropped_by_mcu,
                unusable_readings: hot.health.unusable(),
                degraded: hot.degraded,
            },
            bad_frames: bad,
            latency_us: LatencyUs::of(&hot.latency),
            evidence_age_us: LatencyUs::of(&hot.evidence_age),
            late_commands: hot.late_commands,
            pipeline: board
                .state()
                .map(|state| Pipeline::of(Micros(now_us).since(state.host), state)),
            object: board.object.as_deref(),
            slips: hot.slips,
            commands: hot.commands,
            events: events.collect(),
            clients: Clients::of(board),
            recording: Recording {
                file: board.recording.file.as_deref().map(Path::to_string_lossy),
                bytes: board.recording.bytes,
                dropped: board.recording.dropped,
                failure: board.recording.failure.as_deref(),
            },
            realtime: about.grants.iter().map(Granted::of).collect(),
            ring_dropped: [("service", hot.service_dropped), ("recorder", hot.recorder_dropped)]
                .into(),
        }
    }

    /// On one line.
    ///
    /// # Errors
    /// Where the serialiser fails; no value here makes it.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self)
    }

    /// On many lines.
    ///
    /// # Errors
    /// Where the serialiser fails; no value here makes it.
    pub fn pretty(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

impl<'a> Link<'a> {
    fn of(board: &'a Board) -> Self {
        let link = board.link();
        Self {
            port: &board.about.port,
            port_open: link.port_open,
            state: link.state.name(),
            uid: link.gripper.map(|(uid, _)| Uid(uid).to_string()),
            boot_id: link.gripper.map(|(_, boot_id)| boot_id),
            firmware: link.firmware.map(|firmware| firmware.to_string()),
            gripper_state: link.device.map(|device| device.state.name()),
            gripper_fault: link.device.map(|device| device.fault.0),
            clock: board.counters().clock_health.name(),
            clock_faults: board.counters().clock_faults,
            blind: board.counters().blind,
            closed: link.closed.map(|(_, reason)| explain(&reason)),
            failures: link.failures,
            reconnects: board.counters().reconnects,
            reboots: link.reboots,
        }
    }
}

impl LatencyUs {
    fn of(latency: &Latency) -> Option<Self> {
        let us = |q| latency.quantile_ns(q).map(|ns| 1e6 * seconds_of_ns(ns));
        Some(Self {
            p50: us(0.5)?,
            p99: us(0.99)?,
            p99_9: us(0.999)?,
            max: 1e6 * seconds_of_ns(latency.max_ns()),
        })
    }
}

impl Pipeline {
    fn of(age: Micros, state: &PipelineState) -> Self {
        Self {
            age_s: age.as_seconds(),
            t_s: state.t.as_seconds(),
            rate_hz: state.rate_hz,
            scene: state.scene.name(),
            grip: Some(state.grip)
                .filter(|grip| *grip != GripState::Observing)
                .map(GripState::name),
            statistic: state.statistic,
            command_n: state.command_n,
            applied_n: state.applied_n,
            estimate_n: state.estimate_n,
            late_ms: state.late_ms,
            health: healths(state).into(),
        }
    }
}

impl Clients {
    fn of(board: &Board) -> Self {
        let clients = &board.clients;
        Self {
            connected: clients.connected,
            accepted: clients.accepted,
            refused: clients.refused,
            dropped: clients.dropped,
            commands: board.client_commands(),
            bad_commands: clients.bad_commands,
        }
    }
}

impl<'a> Granted<'a> {
    fn of(grant: &'a Grant) -> Self {
        let reason = grant.refused.as_deref();
        Self { what: &grant.what, granted: reason.is_none(), reason }
    }
}

#[expect(clippy::cast_precision_loss, reason = "below 2^53 us")]
fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

#[expect(clippy::cast_precision_loss, reason = "below 2^53 ns")]
fn seconds_of_ns(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
