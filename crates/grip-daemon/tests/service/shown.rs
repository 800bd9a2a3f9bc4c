//! Metrics and status of a board.

use crate::{made, parser::parse};
use grip_daemon::{
    Board, HotCounters, Item, LinkNote,
    board::About,
    client::{Report, lines},
    clients,
    exposition::Exposition,
    metrics,
    status::Status,
};
use grip_link::host::{CloseReason, LinkState};
use grip_link::message::daemon::{ClockOffset, Gripper, ToClient};
use grip_session::session::ClockHealth;
use slip_core::{Phase, alarm::Method};

fn page(board: &Board) -> String {
    let mut page = Exposition::default();
    metrics::write(board, 2_500_000, &mut page);
    page.text().to_owned()
}

/// A name and one label.
fn key(name: &str, label: &str, value: &str) -> (String, Vec<(String, String)>) {
    (name.to_owned(), vec![(label.to_owned(), value.to_owned())])
}

#[test]
fn the_page_is_read_by_a_strict_reader() {
    let text = page(&made::board());
    // For scripts/metrics-check.sh, which lets another program read it.
    std::fs::write(concat!(env!("CARGO_TARGET_TMPDIR"), "/metrics.txt"), &text).unwrap();
    let samples = parse(&text);
    let one = |name: &str| samples[&(name.to_owned(), Vec::new())];
    for (name, value) in [
        ("gripd_uptime_seconds", 2.5),
        ("gripd_samples_total", 20_000.0),
        ("gripd_sample_rate_hertz", 10_000.0),
        ("gripd_force_command_newtons", 2.5),
    ] {
        assert_eq!(one(name), value, "{name}");
    }
    assert!(one("gripd_force_applied_newtons").is_nan());
    for (name, label, of, value) in [
        ("gripd_samples_lost_total", "cause", "line", 3.0),
        ("gripd_samples_lost_total", "cause", "dropped_by_gripper", 2.0),
        ("gripd_frames_bad_total", "cause", "crc", 4.0),
        ("gripd_link_state", "state", "stream", 1.0),
        ("gripd_link_state", "state", "closed", 0.0),
        ("gripd_slips_gross_total", "method", "travel", 1.0),
        ("gripd_scene", "scene", "holding", 1.0),
        ("gripd_sensor_good", "sensor", "stylus", 1.0),
        ("gripd_sensor_good", "sensor", "reference", 0.0),
        ("gripd_reloads_total", "result", "refused", 2.0),
        ("gripd_build_info", "version", "1.2.3", 1.0),
    ] {
        assert_eq!(samples[&key(name, label, of)], value, "{name} {of}");
    }
    assert!(!samples.contains_key(&key("gripd_sensor_good", "sensor", "pressure")), "it has none");
}

#[test]
fn the_shipped_alarms_ask_for_what_there_is() {
    // The reference is compared with the metrics by a test of its own.
    let reference = include_str!("../../../../docs/reference/metrics.md");
    let rules = include_str!("../../../../packaging/prometheus-alarms.yml");
    let exprs: Vec<&str> =
        rules.lines().filter_map(|line| line.trim().strip_prefix("expr: ")).collect();
    assert_eq!(exprs.len(), rules.matches("- alert: ").count());
    for expr in exprs.iter().filter(|expr| !expr.starts_with("up{")) {
        let (_, rest) = expr.split_once("gripd_").unwrap_or_else(|| panic!("no metric: {expr}"));
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap();
        let (name, rest) = (format!("gripd_{}", &rest[..end]), &rest[end..]);
        let name = name.trim_end_matches("_bucket");
        let row = reference.lines().find(|row| row.starts_with(&format!("| `{name}` |")));
        let row = row.unwrap_or_else(|| panic!("no metric {name} for {expr}"));
        if let Some(label) = rest.strip_prefix('{').and_then(|rest| rest.split('}').next()) {
            let (label, value) = label.split_once('=').unwrap();
            let asked = value.trim_matches('"');
            assert!(row.contains(&format!("`{label}`")) && row.contains(asked), "{expr}: {row}");
        }
    }
}

#[test]
fn the_histogram_is_whole() {
    let samples = parse(&page(&made::board()));
    let buckets: Vec<(f64, f64)> = samples
        .iter()
        .filter(|((name, _), _)| name == "gripd_latency_seconds_bucket")
        .map(|((_, labels), count)| match labels[0].1.as_str() {
            "+Inf" => (f64::INFINITY, *count),
            upper => (upper.parse().unwrap(), *count),
        })
        .collect();
    assert_eq!(buckets.len(), 24);
    let mut sorted = buckets;
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(sorted.is_sorted_by(|a, b| a.1 <= b.1), "{sorted:?}");
    let (_, all) = sorted[23];
    assert_eq!(all, samples[&("gripd_latency_seconds_count".to_owned(), Vec::new())]);
    assert_eq!(all, 1000.0);
    // 1 us to 1 ms, once each: 131 are below 131.072 us.
    assert!(
        sorted.iter().any(|(upper, count)| (upper - 131.072e-6).abs() < 1e-12 && *count == 131.0)
    );
    let sum = samples[&("gripd_latency_seconds_sum".to_owned(), Vec::new())];
    assert!((sum - 0.5005).abs() < 1e-9, "{sum}");
}

#[test]
fn clients_are_reported_the_same_histogram_and_quantiles_and_the_clocks() {
    let mut board = made::board();
    let reported = clients::health(&board, 2_500_000);
    let appended = reported.appended.unwrap();
    assert_eq!(appended.histogram.iter().sum::<u64>(), 1000);
    // 1 us to 1 ms, once each: below 131.072 us are 131, below 262.144 us 131 more.
    assert_eq!((appended.histogram[9], appended.histogram[10]), (66, 131));
    let p999_us = appended.p999_us.unwrap();
    assert!((999.0..=1000.0 * 1.125).contains(&p999_us), "{p999_us}");
    assert_eq!(appended.clock, None);
    let clock = Some(ClockOffset { offset_us: -7, half_us: 40.0 });
    board.count(&HotCounters { clock, ..*board.counters() });
    assert_eq!(clients::health(&board, 2_500_000).appended.unwrap().clock, clock);
}

#[test]
fn a_daemon_that_has_just_started_has_a_page_and_a_status() {
    let board = Board::new(About::default());
    let samples = parse(&page(&board));
    assert_eq!(samples[&("gripd_samples_total".to_owned(), Vec::new())], 0.0);
    assert!(!samples.contains_key(&("gripd_sample_rate_hertz".to_owned(), Vec::new())));
    let status = serde_json::to_value(Status::of(&board, 1)).unwrap();
    assert!(status["pipeline"].is_null() && status["latency_us"].is_null());
    assert_eq!(status["link"]["state"], "closed");
    assert!(!board.is_healthy());
}

#[test]
fn the_status_states_what_a_person_asks() {
    let board = made::board();
    let status = serde_json::to_value(Status::of(&board, 2_500_000)).unwrap();
    assert_eq!(status["link"]["uid"], "ab".repeat(16));
    assert_eq!(status["samples"]["rate_hz"], 10_000.0);
    assert_eq!(
        (&status["samples"]["lost_on_line"], &status["bad_frames"]["crc"]),
        (&3.into(), &4.into())
    );
    assert_eq!(status["bad_frames"].as_object().unwrap().len(), 1, "only what occurred");
    assert_eq!(status["pipeline"]["health"]["reference"], "lost");
    assert_eq!(status["pipeline"]["age_s"], 0.6);
    assert!(status["pipeline"]["applied_n"].is_null(), "not a number");
    assert_eq!(status["events"].as_array().unwrap().len(), 3);
    assert_eq!(status["events"][0]["type"], "slip");
    assert_eq!(status["realtime"][1]["reason"], "not permitted");
    let p50 = status["latency_us"]["p50"].as_f64().unwrap();
    assert!((500.0..=563.0).contains(&p50), "{p50}");
    assert!(Status::of(&board, 0).json().unwrap().lines().count() == 1);
}

/// A link that is up and a source that is silent: what was is not shown as what is.
#[test]
fn a_silent_source_has_no_samples_though_its_link_is_up() {
    let board = made::board();
    let mut health = clients::health(&board, 2_500_000);
    let mut told = |rate_hz| {
        health.rate_hz = Some(rate_hz);
        let gripper = Gripper { link: LinkState::Stream, ..Gripper::NONE };
        let mut report = Report::default();
        report.take(&ToClient::Gripper(gripper));
        report.take(&ToClient::State(made::STATE));
        report.take(&ToClient::Health(health));
        report.judge_sensors();
        lines(&report).join("\n")
    };
    let (flowing, silent) = (told(1000.0), told(0.0));
    assert!(flowing.contains("stylus good") && !flowing.contains("NO SAMPLES"), "{flowing}");
    assert!(silent.contains("stylus unread") && silent.contains("NO SAMPLES"), "{silent}");
}

#[test]
fn counters_that_begin_anew_give_no_rate() {
    let mut board = made::board();
    board.count(&HotCounters { host_us: 3_000_000, samples: 5, ..HotCounters::default() });
    assert_eq!(board.rate_hz(), None);
    board.count(&HotCounters { host_us: 3_500_000, samples: 55, ..HotCounters::default() });
    assert_eq!(board.rate_hz(), Some(100.0));
}

/// A device clock that lies, commands on late rows and blindness are shown, and the last is no good health.
#[test]
fn clocks_and_ages_are_shown() {
    let mut board = made::board();
    let mut counters = *board.counters();
    counters.evidence_age.record(2_000_000);
    (counters.clock_health, counters.clock_faults) = (ClockHealth::Stopped, 3);
    (counters.late_commands, counters.blind) = (7, true);
    board.count(&counters);
    assert!(!board.is_healthy());
    let status = serde_json::to_value(Status::of(&board, 9)).unwrap();
    let link = &status["link"];
    assert_eq!((&link["clock"], &link["clock_faults"]), (&"stopped".into(), &3.into()));
    assert_eq!((&link["blind"], &status["late_commands"]), (&true.into(), &7.into()));
    assert_eq!(status["evidence_age_us"]["max"], 2000.0);
    assert_eq!(status["pipeline"]["late_ms"], 1.5);
    let names = ["need_low_n", "need_n", "need_high_n", "admissible_m_s2"];
    let shown = names.map(|name| status["pipeline"][name].as_f64());
    assert_eq!(shown, [1.75, 2.0, 2.25, 1.0].map(Some));
    let mut page = Exposition::default();
    metrics::write(&board, 9, &mut page);
    for line in [
        "gripd_gripper_clock{state=\"stopped\"} 1",
        "gripd_gripper_clock_faults_total 3",
        "gripd_late_commands_total 7",
        "gripd_evidence_age_seconds_count 1",
        "gripd_blind 1",
        "gripd_needed_force_newtons{quantile=\"0.1\"} 1.75",
        "gripd_needed_force_newtons{quantile=\"0.5\"} 2",
        "gripd_needed_force_newtons{quantile=\"0.9\"} 2.25",
        "gripd_admissible_acceleration_meters_per_second_squared 1",
    ] {
        assert!(page.text().lines().any(|other| other == line), "{line}");
    }
}

#[test]
fn a_link_that_closed_is_reported_with_its_reason() {
    let mut board = made::board();
    assert!(board.is_healthy());
    let note = LinkNote::Closed(CloseReason::Lost { silent_us: 500_000 });
    board.take(&Item::Link { host_us: 5, note: &note });
    let status = serde_json::to_value(Status::of(&board, 9)).unwrap();
    assert_eq!(status["link"]["closed"], "the gripper fell silent (500 ms without a frame)");
    assert_eq!((&status["link"]["state"], board.is_healthy()), (&"closed".into(), false));
    // What the last sample showed is no health.
    let health = &status["pipeline"]["health"];
    assert_eq!((&health["stylus"], &health["pressure"]), (&"unread".into(), &"absent".into()));
    let samples = parse(&page(&board));
    for (sensor, good) in [("stylus", Some(0.0)), ("travel", Some(0.0)), ("pressure", None)] {
        let shown = samples.get(&key("gripd_sensor_good", "sensor", sensor));
        assert_eq!(shown.copied(), good, "{sensor}");
    }
    for n in 0..1000 {
        board.take(&Item::Event { host_us: n, event: &made::slip(Phase::Gross, Method::Pressure) });
    }
    assert_eq!(board.events().count(), 32, "memory stays small");
    assert_eq!(board.event_counts().gross, [1, 1, 1000]);
}

#[test]
fn the_documentation_has_every_metric_with_its_type_and_no_other() {
    let page_of_all = include_str!("../../../../docs/reference/metrics.md");
    let documented = page_of_all.lines().filter_map(|line| {
        let (name, rest) = line.strip_prefix("| `gripd_")?.split_once("` | ")?;
        Some(format!("gripd_{name} {}", rest.split(' ').next()?))
    });
    let board = made::board();
    let note = LinkNote::Status(made::STATUS);
    let mut full = board;
    full.take(&Item::Link { host_us: 1, note: &note });
    let text = page(&full);
    let written = text.lines().filter_map(|line| line.strip_prefix("# TYPE ")).map(str::to_owned);
    let (documented, written): (Vec<String>, Vec<String>) =
        (documented.collect(), written.collect());
    assert_eq!(documented, written, "in the order of the page");
}
