//! Lines for people about what is known of gripd.

use super::report::{DaemonReport, Report};
use grip_session::report::statistic_text;
use grip_session::status::{EventReport, GripperReport, HealthReport, StateReport};

/// The report, a subject a line.
#[must_use]
pub fn lines(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(report.daemon.as_ref().map(daemon));
    lines.extend(report.gripper.as_ref().map(gripper));
    if report.state.is_some() && !report.flows() {
        lines.push("NO SAMPLES  what follows is how it was when the last one came".to_owned());
    }
    match &report.state {
        Some(state) => {
            let signal = report.gripper.as_ref().and_then(|gripper| gripper.stylus);
            lines.extend(grip(state, signal == Some("vibration")));
        }
        None => lines.push("grip       no samples yet".to_owned()),
    }
    lines.extend(report.object.as_ref().map(|object| format!("object     {object}")));
    match &report.health {
        Some(health) => lines.extend(figures(health)),
        None => lines.push("figures    none yet".to_owned()),
    }
    match report.events.as_slice() {
        [] => lines.push("slips      none since gripd started".to_owned()),
        events => {
            lines.push("last slips".to_owned());
            lines.extend(events.iter().map(event));
        }
    }
    lines
}

fn daemon(daemon: &DaemonReport) -> String {
    let mut text = format!("daemon     {}, up {}", daemon.daemon, duration(daemon.uptime_s));
    text += match (daemon.dry_run, daemon.commands_allowed) {
        (true, _) => ", dry run",
        (false, true) => ", takes commands of clients",
        (false, false) => ", read only for clients",
    };
    text + ", real-time " + daemon.real_time
}

fn gripper(gripper: &GripperReport) -> String {
    let Some(uid) = &gripper.uid else {
        return format!("gripper    none seen yet, link {}", gripper.link);
    };
    let force = with_unit(gripper.force_max_n, 1.0, 2, "N");
    format!(
        "gripper    {uid}, start {:08x}, link {}, {} Hz, at most {force}",
        gripper.boot_id, gripper.link, gripper.rate_hz
    )
}

fn grip(state: &StateReport, vibrates: bool) -> Vec<String> {
    let mut lines = vec![format!(
        "grip       {}, scene {}, gripper {}, statistic {} of its threshold",
        state.grip,
        state.scene,
        state.device,
        state.statistic.map_or("-".to_owned(), statistic_text)
    )];
    let estimate = with_unit(state.estimate_n, 1.0, 2, "N");
    lines.push(format!(
        "force      {} commanded on readings {} old, {} measured, estimate {estimate}",
        with_unit(state.command_n, 1.0, 2, "N"),
        with_unit(state.late_ms, 1.0, 1, "ms"),
        with_unit(state.applied_n, 1.0, 2, "N")
    ));
    lines.extend(needed(state));
    if state.fault != 0 {
        lines.push(format!("FAULT      {:04x} is latched", state.fault));
    }
    let sensors = [
        (if vibrates { "vibration" } else { "stylus" }, state.stylus),
        ("travel", state.travel),
        ("pressure", state.pressure),
        ("reference", state.reference),
    ];
    let sensors = sensors.map(|(name, health)| format!("{name} {health}"));
    lines.push(format!("sensors    {}", sensors.join(", ")));
    lines
}

/// What the object in hand needs, where that is known.
fn needed(state: &StateReport) -> Option<String> {
    let need_n = state.need_n?;
    let range = [state.need_low_n, state.need_high_n].map(|value| with_unit(value, 1.0, 2, "N"));
    let admissible = with_unit(state.admissible_m_s2, 1.0, 1, "m/s^2");
    Some(format!(
        "needed     {need_n:.2} N, with 80 % from {} to {}; the arm may accelerate by {admissible} at a risk of 10 %",
        range[0], range[1]
    ))
}

fn figures(health: &HealthReport) -> Vec<String> {
    let bad = [
        ("too long", health.bad_too_long),
        ("COBS", health.bad_cobs),
        ("length", health.bad_length),
        ("CRC", health.bad_crc),
        ("useless", health.bad_useless),
    ];
    let bad: Vec<String> = bad
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(cause, count)| format!("{count} {cause}"))
        .collect();
    let bad = if bad.is_empty() {
        "no bad frames".to_owned()
    } else {
        "bad frames: ".to_owned() + &bad.join(", ")
    };
    let clock = match (health.clock_offset_us, health.clock_half_us) {
        (Some(offset_us), Some(half_us)) => {
            let way = if offset_us < 0 { "behind" } else { "ahead of" };
            let offset_s = seconds(offset_us).abs();
            format!("daemon {offset_s:.6} s {way} the gripper, +- {half_us:.0} us")
        }
        _ => "not known".to_owned(),
    };
    vec![
        format!(
            "samples    {} at {}, {} lost, {} frames missing, {bad}",
            health.samples,
            with_unit(health.rate_hz, 1.0, 1, "Hz"),
            health.lost,
            health.gap
        ),
        format!(
            "latency    p50 {}, p99 {}, p99.9 {}, longest {}",
            with_unit(health.latency_p50_us, 1.0, 0, "us"),
            with_unit(health.latency_p99_us, 1.0, 0, "us"),
            with_unit(health.latency_p99_9_us, 1.0, 0, "us"),
            with_unit(health.latency_max_us, 1.0, 0, "us")
        ),
        format!("clock      {clock}"),
        format!(
            "dropped    {} items for log and clients, {} for the recorder, {} frames for slow clients",
            health.dropped_service, health.dropped_recorder, health.dropped_clients
        ),
        format!(
            "also       {} clients, recording {} ({} bytes), {} slips, {} lines reopened, {} force commands",
            health.clients,
            health.recording,
            health.recorded_bytes,
            health.slips,
            health.reconnects,
            health.commands
        ),
    ]
}

/// One line of `--events`.
#[must_use]
pub fn event(event: &EventReport) -> String {
    match event {
        EventReport::Slip { t_s, text, .. } => format!("{t_s:10.4} s  {text}"),
        EventReport::Notice { host_s, about, text, .. } => {
            format!("{host_s:10.4} s  {about}: {text}")
        }
        EventReport::Gripper(known) => gripper(known),
    }
}

/// A number, or a dash where it is not known.
fn with_unit(value: Option<f32>, scale: f32, digits: usize, unit: &str) -> String {
    let Some(value) = value else { return "-".to_owned() };
    format!("{:.digits$} {unit}", scale * value).trim_end().to_owned()
}

fn seconds(us: i64) -> f64 {
    us as f64 / 1e6
}

fn duration(seconds: f64) -> String {
    let (hours, minutes) = (seconds / 3600.0, seconds / 60.0);
    if hours >= 48.0 {
        format!("{:.1} days", hours / 24.0)
    } else if minutes >= 120.0 {
        format!("{hours:.1} h")
    } else if seconds >= 120.0 {
        format!("{minutes:.1} min")
    } else {
        format!("{seconds:.1} s")
    }
}

#[cfg(test)]
mod tests {
    use super::{StateReport, grip};
    use slip_core::PipelineState;

    #[test]
    fn what_the_object_needs_has_a_line_and_names_where_it_is_known() {
        let unknown = StateReport::of(&PipelineState::UNKNOWN);
        assert!(!grip(&unknown, false).iter().any(|line| line.starts_with("needed")));
        let known = StateReport::of(&PipelineState {
            need_low_n: Some(3.25),
            need_n: Some(4.0),
            need_high_n: Some(6.75),
            admissible_m_s2: Some(1.5),
            ..PipelineState::UNKNOWN
        });
        let lines = grip(&known, false);
        let needed = "needed     4.00 N, with 80 % from 3.25 N to 6.75 N; \
            the arm may accelerate by 1.5 m/s^2 at a risk of 10 %";
        assert!(lines.iter().any(|line| line == needed), "{lines:?}");
        let (known, unknown) =
            (serde_json::to_value(&known).unwrap(), serde_json::to_value(&unknown).unwrap());
        for (name, value) in
            [("need_low_n", 3.25), ("need_n", 4.0), ("need_high_n", 6.75), ("admissible_m_s2", 1.5)]
        {
            assert_eq!((known[name].as_f64(), unknown[name].is_null()), (Some(value), true));
        }
    }
}
