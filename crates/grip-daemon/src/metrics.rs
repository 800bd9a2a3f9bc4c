//! The board in, the page that Prometheus reads out. Names are a contract: dashboards use them.

use crate::{
    board::Board,
    exposition::{
        Exposition,
        Kind::{Counter, Gauge},
    },
};
use grip_link::host::LinkState;
use grip_session::session::ClockHealth;
use slip_core::{PipelineState, alarm::Method, health::SensorHealth};
use slip_core::{grip::GripState, sample::Scene};

/// Writes all metrics. `now_us` is host time (us).
pub fn write(board: &Board, now_us: u64, page: &mut Exposition) {
    page.clear();
    let version = board.about.version.as_str();
    page.info(("gripd_build_info", "Version of gripd."), &[("version", version)]);
    #[expect(clippy::cast_precision_loss, reason = "below 2^53 us")]
    let uptime_s = now_us as f64 * 1e-6;
    page.one(Gauge, ("gripd_uptime_seconds", "Time since gripd started."), uptime_s);
    link(board, page);
    counts(board, page);
    events(board, page);
    if let Some(state) = board.state() {
        pipeline(state, page);
    }
    others(board, page);
}

fn link(board: &Board, page: &mut Exposition) {
    let link = board.link();
    let states = LinkState::ALL.map(|state| (state.name(), u8::from(state == link.state)));
    page.each(Gauge, ("gripd_link_state", "1 for the state the link is in."), "state", states);
    page.one(Gauge, ("gripd_port_open", "Whether a line is open."), u8::from(link.port_open));
    if let Some((uid, boot_id)) = link.gripper {
        let uid = grip_session::config::Uid(uid).to_string();
        let named = ("gripd_gripper_info", "Identity of the gripper and its number of starts.");
        page.info(named, &[("uid", &uid), ("boot_id", &boot_id.to_string())]);
    }
    if let Some(device) = link.device {
        let state = device.state.name();
        page.info(
            ("gripd_gripper_state", "State, as reported by the gripper."),
            &[("state", state)],
        );
        let named = ("gripd_gripper_fault_code", "Latched fault of the gripper, 0 for none.");
        page.one(Gauge, named, device.fault.0);
    }
    let named = ("gripd_link_failures_total", "Times the link closed by error.");
    page.one(Counter, named, link.failures);
    let named = ("gripd_gripper_reboots_total", "Times the gripper restarted in a session.");
    page.one(Counter, named, link.reboots);
    let named = ("gripd_gripper_faults_total", "Faults that the gripper reported.");
    page.one(Counter, named, link.faults.0);
    let named = ("gripd_requests_refused_total", "Requests that the gripper refused.");
    page.one(Counter, named, link.refusals);
}

fn counts(board: &Board, page: &mut Exposition) {
    let hot = board.counters();
    let named = ("gripd_samples_total", "Samples that went through the pipeline.");
    page.one(Counter, named, hot.samples);
    let named = ("gripd_sample_rate_hertz", "Samples per second of the last second.");
    page.known(Gauge, named, board.rate_hz());
    let named = ("gripd_samples_lost_total", "Samples that are missing, by cause.");
    page.each(Counter, named, "cause", hot.lost_samples());
    let named = ("gripd_frames_total", "Good frames from the gripper.");
    page.one(Counter, named, hot.frames.ok);
    let named = ("gripd_frames_missing_total", "Frames missing by their numbers.");
    page.one(Counter, named, hot.frames.gap);
    let named = ("gripd_frames_bad_total", "Blocks and frames that were not used, by cause.");
    page.each(Counter, named, "cause", hot.bad_frames());
    let bytes = [("from_gripper", hot.rx_bytes), ("to_gripper", hot.tx_bytes)];
    page.each(Counter, ("gripd_bytes_total", "Bytes on the line."), "direction", bytes);
    let named = ("gripd_garbage_bytes_total", "Bytes in blocks that were no frames.");
    page.one(Counter, named, hot.frames.garbage_bytes);
    page.one(Counter, ("gripd_commands_total", "Force commands written."), hot.commands);
    let named = ("gripd_degraded_total", "Times samples were late or missing.");
    page.one(Counter, named, hot.degraded);
    let named = ("gripd_reconnects_total", "Lines opened after the first.");
    page.one(Counter, named, hot.reconnects);
    page.one(Counter, ("gripd_turns_total", "Turns of the hot loop."), hot.turns);
    let named = ("gripd_stage_samples_total", "Samples that went through each stage.");
    page.each(Counter, named, "stage", hot.stages());
    let named = ("gripd_floor_lowered_total", "Times a quieter second lowered the noise floor.");
    page.one(Counter, named, hot.stages.floor_lowered);
    let named = ("gripd_readings_unusable_total", "Readings that could not be used, by cause.");
    page.each(Counter, named, "cause", hot.unusable_readings());
    let rings = [("service", hot.service_dropped), ("recorder", hot.recorder_dropped)];
    let named = ("gripd_ring_dropped_total", "Items that did not fit into a ring.");
    page.each(Counter, named, "ring", rings);
    let named = ("gripd_latency_seconds", "From the last byte of a frame to its command written.");
    page.histogram(named, &hot.latency);
    let named = (
        "gripd_evidence_age_seconds",
        "Age of the newest usable row at each command, by the host's clock.",
    );
    page.histogram(named, &hot.evidence_age);
    let named = (
        "gripd_late_commands_total",
        "Commands that did not raise the force: the newest usable row was 20 ms older than usual.",
    );
    page.one(Counter, named, hot.late_commands);
    let clocks =
        ClockHealth::ALL.map(|health| (health.name(), u8::from(health == hot.clock_health)));
    let named = (
        "gripd_gripper_clock",
        "1 for the state of the gripper's clock; fast and slow: by more than 1 %.",
    );
    page.each(Gauge, named, "state", clocks);
    let named = ("gripd_gripper_clock_faults_total", "Faults of the gripper's clock.");
    page.one(Counter, named, hot.clock_faults);
    let named = (
        "gripd_blind",
        "Whether no usable row came for more than 50 ms while samples should flow.",
    );
    page.one(Gauge, named, u8::from(hot.blind));
}

fn events(board: &Board, page: &mut Exposition) {
    let counts = board.event_counts();
    page.one(Counter, ("gripd_slips_total", "Slips."), board.counters().slips);
    let named = ("gripd_slips_incipient_total", "Slips noticed as incipient, by method.");
    page.each(
        Counter,
        named,
        "method",
        Method::ALL.map(Method::name).into_iter().zip(counts.incipient),
    );
    let named = ("gripd_slips_gross_total", "Slips noticed as, or turned, gross, by method.");
    page.each(
        Counter,
        named,
        "method",
        Method::ALL.map(Method::name).into_iter().zip(counts.gross),
    );
    page.one(Counter, ("gripd_slips_ended_total", "Slips that ended."), counts.ended);
    let named = ("gripd_health_changes_total", "Changes of a sensor's health.");
    page.one(Counter, named, counts.health);
    let named = ("gripd_pipelines_total", "Pipelines begun: starts, restarts, new settings.");
    page.one(Counter, named, board.pipelines());
}

fn pipeline(state: &PipelineState, page: &mut Exposition) {
    let scenes = Scene::ALL.map(|scene| (scene.name(), u8::from(scene == state.scene)));
    page.each(Gauge, ("gripd_scene", "1 for the scene."), "scene", scenes);
    if state.grip != GripState::Observing {
        let grips = GripState::ALL.map(|grip| (grip.name(), u8::from(grip == state.grip)));
        page.each(Gauge, ("gripd_grip_state", "1 for the state of the grip."), "state", grips);
    }
    let named = ("gripd_slip_statistic", "Slip statistic over its threshold.");
    page.known(Gauge, named, state.statistic.map(Number));
    let named = ("gripd_force_command_newtons", "Commanded force of one finger.");
    page.known(Gauge, named, state.command_n.map(Number));
    let named = ("gripd_force_applied_newtons", "Measured normal force.");
    page.known(Gauge, named, state.applied_n.map(Number));
    let named = ("gripd_force_estimate_newtons", "The last estimate of the adequate force.");
    page.known(Gauge, named, state.estimate_n.map(Number));
    let good = healths(state).map(|(sensor, health)| (sensor, u8::from(health == "good")));
    page.each(Gauge, ("gripd_sensor_good", "Whether a sensor is good."), "sensor", good);
}

fn others(board: &Board, page: &mut Exposition) {
    let clients = &board.clients;
    page.one(Gauge, ("gripd_clients", "Clients connected."), clients.connected);
    page.one(Counter, ("gripd_clients_total", "Clients accepted."), clients.accepted);
    let named = ("gripd_clients_refused_total", "Clients turned away: too many.");
    page.one(Counter, named, clients.refused);
    let named = ("gripd_client_messages_dropped_total", "Messages slow clients did not get.");
    page.one(Counter, named, clients.dropped);
    let named = ("gripd_client_commands_total", "Commands of clients, by what became of them.");
    let commands = [("done", board.client_commands()), ("refused", clients.bad_commands)];
    page.each(Counter, named, "result", commands);
    let recording = &board.recording;
    let named = ("gripd_recording", "Whether a recording is written.");
    page.one(Gauge, named, u8::from(recording.file.is_some()));
    let named = ("gripd_recording_bytes_total", "Bytes recorded.");
    page.one(Counter, named, recording.bytes);
    let named = ("gripd_recording_files_total", "Files of recordings begun.");
    page.one(Counter, named, recording.files);
    let named = ("gripd_recording_dropped_total", "Items that were not recorded.");
    page.one(Counter, named, recording.dropped);
    let (taken, refused) = board.about.reloads;
    let named = ("gripd_reloads_total", "Reloads of the configuration, by what became of them.");
    page.each(Counter, named, "result", [("taken", taken), ("refused", refused)]);
}

/// Each sensor and its state.
pub(crate) fn healths(state: &PipelineState) -> [(&'static str, &'static str); 4] {
    let [stylus, travel, pressure, reference] = state.sensors.map(SensorHealth::name);
    [("stylus", stylus), ("reference", reference), ("travel", travel), ("pressure", pressure)]
}

/// A number as Prometheus writes those that are not finite.
struct Number(f32);

impl core::fmt::Display for Number {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            x if x.is_nan() => f.write_str("NaN"),
            x if x.is_infinite() => f.write_str(if x > 0.0 { "+Inf" } else { "-Inf" }),
            x => write!(f, "{x}"),
        }
    }
}
