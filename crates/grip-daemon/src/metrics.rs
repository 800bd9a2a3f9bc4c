//! The page that Prometheus reads, from the board. Names are a contract: dashboards use them.

use crate::{board::Board, exposition::Exposition};
use grip_link::host::LinkState;
use grip_session::{session::ClockHealth, status::unread};
use slip_core::{PipelineState, alarm::Method, health::SensorHealth};
use slip_core::{grip::GripState, sample::Scene};

/// Writes all metrics. `now_us` is host time (us).
pub fn write(board: &Board, now_us: u64, page: &mut Exposition) {
    page.clear();
    let version = board.about.version.as_str();
    page.info("gripd_build_info", "Version of gripd.", &[("version", version)]);
    let uptime_s = now_us as f64 * 1e-6;
    page.gauge("gripd_uptime_seconds", "Time since gripd started.").one(uptime_s);
    link(board, page);
    counts(board, page);
    events(board, page);
    if let Some(state) = board.state() {
        pipeline(board, state, page);
    }
    others(board, page);
}

fn link(board: &Board, page: &mut Exposition) {
    let link = board.link();
    let states = LinkState::ALL.map(|state| (state.name(), u8::from(state == link.state)));
    page.gauge("gripd_link_state", "1 for the state the link is in.").each("state", states);
    page.gauge("gripd_port_open", "Whether a line is open.").one(u8::from(link.port_open));
    if let Some((uid, boot_id)) = link.gripper {
        let uid = grip_session::config::Uid(uid).to_string();
        page.info(
            "gripd_gripper_info",
            "Identity of the gripper and its number of starts.",
            &[("uid", &uid), ("boot_id", &boot_id.to_string())],
        );
    }
    if let Some(device) = link.device {
        let state = device.state.name();
        page.info("gripd_gripper_state", "State, as reported by the gripper.", &[("state", state)]);
        page.gauge("gripd_gripper_fault_code", "Latched fault of the gripper, 0 for none.")
            .one(device.fault.0);
    }
    page.counter("gripd_link_failures_total", "Times the link closed by error.").one(link.failures);
    page.counter("gripd_gripper_reboots_total", "Times the gripper restarted in a session.")
        .one(link.reboots);
    page.counter("gripd_gripper_faults_total", "Faults that the gripper reported.")
        .one(link.faults.0);
    page.counter("gripd_requests_refused_total", "Requests that the gripper refused.")
        .one(link.refusals);
}

fn counts(board: &Board, page: &mut Exposition) {
    let hot = board.counters();
    page.counter("gripd_samples_total", "Samples that went through the pipeline.").one(hot.samples);
    page.gauge("gripd_sample_rate_hertz", "Samples per second of the last second.")
        .known(board.rate_hz());
    page.counter("gripd_samples_lost_total", "Samples that are missing, by cause.")
        .each("cause", hot.lost_samples());
    page.counter("gripd_frames_total", "Good frames from the gripper.").one(hot.frames.ok);
    page.counter("gripd_frames_missing_total", "Frames missing by their numbers.")
        .one(hot.frames.gap);
    page.counter("gripd_frames_bad_total", "Blocks and frames that were not used, by cause.")
        .each("cause", hot.bad_frames());
    let bytes = [("from_gripper", hot.rx_bytes), ("to_gripper", hot.tx_bytes)];
    page.counter("gripd_bytes_total", "Bytes on the line.").each("direction", bytes);
    page.counter("gripd_garbage_bytes_total", "Bytes in blocks that were no frames.")
        .one(hot.frames.garbage_bytes);
    page.counter("gripd_commands_total", "Force commands written.").one(hot.commands);
    page.counter("gripd_degraded_total", "Times samples were late or missing.").one(hot.degraded);
    page.counter("gripd_reconnects_total", "Lines opened after the first.").one(hot.reconnects);
    page.counter("gripd_turns_total", "Turns of the hot loop.").one(hot.turns);
    page.counter("gripd_stage_samples_total", "Samples that went through each stage.")
        .each("stage", hot.stages());
    page.counter("gripd_floor_lowered_total", "Times a quieter second lowered the noise floor.")
        .one(hot.stages.floor_lowered);
    page.counter("gripd_readings_unusable_total", "Readings that could not be used, by cause.")
        .each("cause", hot.unusable_readings());
    page.counter(
        "gripd_readings_isolated_total",
        "Wrong readings that leapt out of a quiet stretch and back, and were replaced.",
    )
    .one(hot.health.isolated);
    let rings = [("service", hot.service_dropped), ("recorder", hot.recorder_dropped)];
    page.counter("gripd_ring_dropped_total", "Items that did not fit into a ring.")
        .each("ring", rings);
    page.histogram(
        "gripd_latency_seconds",
        "From the last byte of a frame to its command written.",
        &hot.latency,
    );
    page.histogram(
        "gripd_evidence_age_seconds",
        "Age of the newest usable row at each command, by the host's clock.",
        &hot.evidence_age,
    );
    page.counter(
        "gripd_late_commands_total",
        "Commands that did not raise the force: the newest usable row was 20 ms older than usual.",
    )
    .one(hot.late_commands);
    let clocks =
        ClockHealth::ALL.map(|health| (health.name(), u8::from(health == hot.clock_health)));
    page.gauge(
        "gripd_gripper_clock",
        "1 for the state of the gripper's clock; fast and slow: by more than 1 %.",
    )
    .each("state", clocks);
    page.counter("gripd_gripper_clock_faults_total", "Faults of the gripper's clock.")
        .one(hot.clock_faults);
    page.gauge(
        "gripd_blind",
        "Whether no usable row came for more than 50 ms while samples should flow.",
    )
    .one(u8::from(hot.blind));
}

fn events(board: &Board, page: &mut Exposition) {
    let counts = board.event_counts();
    page.counter("gripd_slips_total", "Slips.").one(board.counters().slips);
    page.counter("gripd_slips_incipient_total", "Slips noticed as incipient, by method.")
        .each("method", Method::ALL.map(Method::name).into_iter().zip(counts.incipient));
    page.counter("gripd_slips_gross_total", "Slips noticed as, or turned, gross, by method.")
        .each("method", Method::ALL.map(Method::name).into_iter().zip(counts.gross));
    page.counter("gripd_slips_ended_total", "Slips that ended.").one(counts.ended);
    page.counter("gripd_health_changes_total", "Changes of a sensor's health.").one(counts.health);
    page.counter("gripd_pipelines_total", "Pipelines begun: starts, restarts, new settings.")
        .one(board.pipelines());
}

fn pipeline(board: &Board, state: &PipelineState, page: &mut Exposition) {
    let scenes = Scene::ALL.map(|scene| (scene.name(), u8::from(scene == state.scene)));
    page.gauge("gripd_scene", "1 for the scene.").each("scene", scenes);
    if state.grip != GripState::Observing {
        let grips = GripState::ALL.map(|grip| (grip.name(), u8::from(grip == state.grip)));
        page.gauge("gripd_grip_state", "1 for the state of the grip.").each("state", grips);
    }
    page.gauge("gripd_slip_statistic", "Evidence of a slip over the wanted interval.")
        .known(state.statistic.map(Number));
    page.gauge("gripd_force_command_newtons", "Commanded force of one finger.")
        .known(state.command_n.map(Number));
    page.gauge("gripd_force_applied_newtons", "Measured normal force.")
        .known(state.applied_n.map(Number));
    page.gauge("gripd_force_estimate_newtons", "The last estimate of the adequate force.")
        .known(state.estimate_n.map(Number));
    let need = [("0.1", state.need_low_n), ("0.5", state.need_n), ("0.9", state.need_high_n)];
    let known = need.into_iter().filter_map(|(at, need_n)| Some((at, Number(need_n?))));
    let text = "Quantiles of the normal force of one finger that the object needs at full weight.";
    page.gauge("gripd_needed_force_newtons", text).each("quantile", known);
    let text = "Acceleration of the arm at which the object slips with a probability of 10 %.";
    page.gauge("gripd_admissible_acceleration_meters_per_second_squared", text)
        .known(state.admissible_m_s2.map(Number));
    let sent = healths(board, state)
        .into_iter()
        .filter(|(_, health)| *health != SensorHealth::Absent.name());
    let good = sent.map(|(sensor, health)| (sensor, u8::from(health == SensorHealth::Good.name())));
    let text =
        "Whether a sensor that the gripper has is good: 0 also while no usable samples come.";
    page.gauge("gripd_sensor_good", text).each("sensor", good);
}

fn others(board: &Board, page: &mut Exposition) {
    let clients = &board.clients;
    page.gauge("gripd_clients", "Clients connected.").one(clients.connected);
    page.counter("gripd_clients_total", "Clients accepted.").one(clients.accepted);
    page.counter("gripd_clients_refused_total", "Clients turned away: too many.")
        .one(clients.refused);
    page.counter("gripd_client_messages_dropped_total", "Messages slow clients did not get.")
        .one(clients.dropped);
    page.counter("gripd_client_commands_total", "Commands of clients, by what became of them.")
        .each("result", [("done", board.client_commands()), ("refused", clients.bad_commands)]);
    let recording = &board.recording;
    page.gauge("gripd_recording", "Whether a recording is written.")
        .one(u8::from(recording.file.is_some()));
    page.counter("gripd_recording_bytes_total", "Bytes recorded.").one(recording.bytes);
    page.counter("gripd_recording_files_total", "Files of recordings begun.").one(recording.files);
    page.counter("gripd_recording_dropped_total", "Items that were not recorded.")
        .one(recording.dropped);
    let (taken, refused) = board.about.reloads;
    page.counter("gripd_reloads_total", "Reloads of the configuration, by what became of them.")
        .each("result", [("taken", taken), ("refused", refused)]);
}

/// Each sensor and its state now: `unread` while no usable samples come.
pub(crate) fn healths(board: &Board, state: &PipelineState) -> [(&'static str, &'static str); 4] {
    let [stylus, travel, pressure, reference] = state
        .sensors
        .map(SensorHealth::name)
        .map(|health| if board.is_healthy() { health } else { unread(health) });
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
