//! One JSON object of the board, for `gripctl status` and people with `curl`. Names and units are a contract.

use crate::{
    board::{Board, ClientCounts, Grant, RecordingState},
    counters::HotCounters,
    latency::Latency,
    metrics::healths,
};
use grip_session::{config::Uid, json_object, report::Event, session::explain};
use serde::Serialize;
use slip_core::{PipelineState, grip::GripState, units::Micros};
use std::{borrow::Cow, collections::BTreeMap, path::Path};

json_object! {
    /// Everything that `board` knows of the daemon at host time `now_us` (us).
    #[derive(Clone, Debug, Serialize)]
    pub struct Status<'a> of (board: &'a Board, now_us: u64) {
        /// Version of gripd.
        version: &'a str = &board.about.version;
        /// Time since the start (s).
        uptime_s: f64 = seconds(now_us);
        /// Configuration files in force, the strongest first.
        config_files: Vec<Cow<'a, str>> = board.about.config_files.iter().map(|file| file.to_string_lossy()).collect();
        /// Whether no force command is ever sent.
        dry_run: bool = board.about.dry_run;
        /// The link and the gripper.
        link: Link<'a> = Link::of(board);
        /// Samples and what was lost, by cause.
        samples: Samples = Samples::of(board);
        /// Frames that were not used, by cause; only causes that occurred.
        bad_frames: BTreeMap<&'static str, u32> = board.counters().bad_frames().into_iter().filter(|(_, count)| *count > 0).collect();
        /// From the last byte of a frame to its command written (us).
        latency_us: Option<LatencyUs> = LatencyUs::of(&board.counters().latency);
        /// Age of the newest usable row at each command (us).
        evidence_age_us: Option<LatencyUs> = LatencyUs::of(&board.counters().evidence_age);
        /// Commands at which it was too old to raise the force.
        late_commands: u64 = board.counters().late_commands;
        /// The pipeline after the last frame; absent before there is one.
        pipeline: Option<Pipeline> = board.state().map(|state| Pipeline::of(board, now_us, state));
        /// What is known of the object in hand or next; absent where nothing is remembered.
        object: Option<&'a str> = board.object.as_deref();
        /// Slips since the start.
        slips: u64 = board.counters().slips;
        /// Force commands written.
        commands: u64 = board.counters().commands;
        /// The last events, the oldest first.
        events: Vec<At> = board.events().map(|(at, line)| At { host_s: seconds(*at), line: *line }).collect();
        /// Clients.
        clients: Clients = Clients { counts: board.clients, commands: board.client_commands() };
        /// The recording.
        recording: Recording<'a> = Recording::of(&board.recording);
        /// What was asked of the system for real time.
        realtime: Vec<Granted<'a>> = board.about.grants.iter().map(Granted::of).collect();
        /// Items that did not fit into a ring, by ring.
        ring_dropped: BTreeMap<&'static str, u64> = dropped(board.counters()).into();
    }
}

json_object! {
    /// The link and the gripper.
    #[derive(Clone, Debug, Serialize)]
    pub struct Link<'a> of (board: &'a Board) {
        /// The port as it was asked for.
        port: &'a str = &board.about.port;
        /// Whether a line is open.
        port_open: bool = board.link().port_open;
        /// `closed`, `open`, `hello`, `config`, `stream` or `degraded`.
        state: &'static str = board.link().state.name();
        /// Identity of the gripper, 32 hexadecimal digits.
        uid: Option<String> = board.link().gripper.map(|(uid, _)| Uid(uid).to_string());
        /// Its number of starts.
        boot_id: Option<u32> = board.link().gripper.map(|(_, boot_id)| boot_id);
        /// Version of its firmware.
        firmware: Option<String> = board.link().firmware.map(|firmware| firmware.to_string());
        /// Its state, as it reports it.
        gripper_state: Option<&'static str> = board.link().device.map(|device| device.state.name());
        /// Its latched fault, 0 for none.
        gripper_fault: Option<u16> = board.link().device.map(|device| device.fault.0);
        /// State of the gripper's clock: `good`, `stopped`, `back`, `forward`, `fast` or `slow`.
        clock: &'static str = board.counters().clock_health.name();
        /// Faults of that clock.
        clock_faults: u64 = board.counters().clock_faults;
        /// Whether no usable row has come for more than 50 ms while samples should flow.
        blind: bool = board.counters().blind;
        /// Why the link closed last.
        closed: Option<String> = board.link().closed.map(|(_, reason)| explain(&reason));
        /// Times it closed by error.
        failures: u64 = board.link().failures;
        /// Lines opened after the first.
        reconnects: u64 = board.counters().reconnects;
        /// Times the gripper has restarted.
        reboots: u64 = board.link().reboots;
    }
}

json_object! {
    /// Samples.
    #[derive(Clone, Copy, Debug, Serialize)]
    pub struct Samples of (board: &Board) {
        /// Through the pipeline, since the start.
        handled: u64 = board.counters().samples;
        /// Of the last second (Hz).
        rate_hz: Option<f64> = board.rate_hz();
        /// Lost on the line.
        lost_on_line: u64 = board.counters().loss.lost.saturating_sub(board.counters().loss.dropped_by_mcu);
        /// Dropped by the gripper.
        dropped_by_gripper: u64 = board.counters().loss.dropped_by_mcu;
        /// Readings that could not be used.
        unusable_readings: u64 = board.counters().health.unusable();
        /// Isolated wrong readings that were replaced.
        isolated_readings: u64 = board.counters().health.isolated;
        /// Times samples were late or missing.
        degraded: u64 = board.counters().degraded;
    }
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

json_object! {
    /// The pipeline after the last frame.
    #[derive(Clone, Debug, Serialize)]
    pub struct Pipeline of (board: &Board, now_us: u64, state: &PipelineState) {
        /// Age of what follows (s).
        age_s: f64 = Micros(now_us).since(state.host).as_seconds();
        /// Device time (s).
        t_s: f64 = state.t.as_seconds();
        /// Sample rate in force (Hz).
        rate_hz: u32 = state.rate_hz;
        /// `idle`, `moving`, `holding` or `slipping`.
        scene: &'static str = state.scene.name();
        /// What the force controller does; absent where the pipeline only observes.
        grip: Option<&'static str> = (state.grip != GripState::Observing).then(|| state.grip.name());
        /// Evidence of a slip over the wanted interval.
        statistic: Option<f32> = state.statistic;
        /// Commanded force (N).
        command_n: Option<f32> = state.command_n;
        /// Measured normal force (N).
        applied_n: Option<f32> = state.applied_n;
        /// The last estimate (N).
        estimate_n: Option<f32> = state.estimate_n;
        /// 10 % quantile of the normal force of one finger that the object needs at full weight (N).
        need_low_n: Option<f32> = state.need_low_n;
        /// Its median (N).
        need_n: Option<f32> = state.need_n;
        /// Its 90 % quantile (N).
        need_high_n: Option<f32> = state.need_high_n;
        /// Acceleration of the arm beside gravity at which the object slips with a probability of 10 % (m/s^2).
        admissible_m_s2: Option<f32> = state.admissible_m_s2;
        /// Age of the newest usable row at the last command (ms), by the host's clock; absent where the clocks are not related.
        late_ms: Option<f32> = state.late_ms;
        /// Health of each sensor by name; `unread` while no usable samples come.
        health: BTreeMap<&'static str, &'static str> = healths(board, state).into();
    }
}

/// An event and when it was received.
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
    /// Counts of the sockets.
    #[serde(flatten)]
    pub counts: ClientCounts,
    /// Commands carried out.
    pub commands: u64,
}

json_object! {
    /// The recording.
    #[derive(Clone, Debug, Serialize)]
    pub struct Recording<'a> of (recording: &'a RecordingState) {
        /// The file that is written.
        file: Option<Cow<'a, str>> = recording.file.as_deref().map(Path::to_string_lossy);
        /// Bytes written since the start.
        bytes: u64 = recording.bytes;
        /// Items not recorded.
        dropped: u64 = recording.dropped;
        /// Why it stopped, where it did.
        failure: Option<&'a str> = recording.failure.as_deref();
    }
}

json_object! {
    /// Something that was asked of the system.
    #[derive(Clone, Copy, Debug, Serialize)]
    pub struct Granted<'a> of (grant: &'a Grant) {
        /// What.
        what: &'a str = &grant.what;
        /// Whether it was granted.
        granted: bool = grant.refused.is_none();
        /// Why not.
        reason: Option<&'a str> = grant.refused.as_deref();
    }
}

impl Status<'_> {
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

fn dropped(hot: &HotCounters) -> [(&'static str, u64); 2] {
    [("service", hot.service_dropped), ("recorder", hot.recorder_dropped)]
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

fn seconds_of_ns(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
