//! What a daemon reports, as a live view shows it.

use super::{Topic, Translator, Wanted};
use grip_link::message::daemon::{
    Appended, ClockOffset, EXTRAPOLATED, GripState, Gripper, Health, LinkState, Method, Notice,
    NoticeKind, Phase, PipelineState, Reading, RealTime, Recording, RowSet, Rows, RowsHeader,
    Scene, Sensor, SensorHealth, SlipReport, SpeedSource, ToClient, Topics, Welcome, WelcomeFlags,
};
use grip_link::message::{DeviceState, FaultCode, Versions};
use grip_record::mcap::{HealthRecord, Record};

use slip_core::units::Micros;

/// When WELCOME came, at host time 10 s.
const NOW: u64 = 1_800_000_000_000_000_000;
const ZERO: u64 = NOW - 10_000_000_000;

/// Messages that were reported: topic, log time, bytes.
type Reported = Vec<(Topic, u64, Vec<u8>)>;

fn take(translator: &mut Translator, message: &ToClient<'_>, now_ns: u64) -> Reported {
    let mut reported = Reported::new();
    translator.take(message, now_ns, &mut |topic, log_ns, bytes| {
        reported.push((topic, log_ns, bytes.to_vec()));
    });
    reported
}

/// A translator for somebody who looks at everything, after WELCOME.
fn greeted() -> Translator {
    let mut translator = Translator::default();
    translator.want(Wanted::of(|_| true));
    let reported = take(&mut translator, &ToClient::Welcome(welcome(7)), NOW);
    assert_eq!(
        link(&reported),
        ("daemon".to_owned(), r#"{"daemon":"gripd 9","run_id":7}"#.to_owned())
    );
    translator
}

const fn welcome(run_id: u32) -> Welcome<'static> {
    Welcome {
        versions: Versions::OURS,
        max_rx: 480,
        flags: WelcomeFlags(0),
        token: 0,
        run_id,
        host_us: 10_000_000,
        real_time: RealTime::NotAsked,
        text: b"gripd 9",
    }
}

fn link(reported: &Reported) -> (String, String) {
    let [(Topic::Link, _, bytes)] = reported.as_slice() else { panic!("{reported:?}") };
    let topic = Topic::Link.recorded().unwrap();
    match Record::decode(topic, bytes, &mut Vec::new()).unwrap() {
        Record::Link(link) => (link.kind.to_owned(), link.detail.to_owned()),
        other => panic!("{other:?}"),
    }
}

fn state() -> PipelineState {
    PipelineState {
        t: Micros(2_000_000),
        host: Micros(11_000_000),
        scene: Scene::Slipping,
        grip: GripState::Holding,
        sensors: [
            SensorHealth::Drifting,
            SensorHealth::Jumped,
            SensorHealth::Frozen,
            SensorHealth::Lost,
        ],
        device: DeviceState::Active,
        notes: EXTRAPOLATED,
        fault: FaultCode::NONE,
        esc_kind: Reading::Literal,
        esc: Some(0.5),
        esc_flags: 0,
        statistic: Some(1.5),
        command_n: Some(4.0),
        applied_n: None,
        estimate_n: Some(3.5),
        rate_hz: 1000,
        lost: 3,
        late_ms: None,
        need_low_n: Some(3.0),
        need_n: Some(4.0),
        need_high_n: Some(5.5),
        admissible_m_s2: Some(2.25),
    }
}

/// Rows of stylus, force and one taxel: 1 ms apart, from number 40 on.
fn rows(t0_us: u64, count: u8) -> Vec<u8> {
    let channels = RowSet(RowSet::STYLUS.0 | RowSet::NORMAL_FORCE.0);
    let header =
        RowsHeader { first_index: 40, t0_us, every_nth: 2, channels, rows: count, taxels: 1 };
    let mut bytes = vec![0; 20];
    assert_eq!(header.write(&mut bytes), Ok(20));
    for row in 0..count {
        bytes.extend((1000 * u32::from(row)).to_le_bytes());
        let force = if row == 1 { f32::NAN } else { 5.5 };
        for value in [1e-6 * f32::from(row), force, 0.25] {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

#[test]
fn only_what_somebody_looks_at_is_asked_for_and_reported() {
    let nobody = Wanted::default().subscribe(3);
    assert_eq!((nobody.topics, nobody.every_nth), (Topics::HEALTH.and(Topics::NEWS), 0));
    let samples = Wanted::of(|topic| topic == Topic::Sample).subscribe(3);
    assert_eq!((samples.topics, samples.every_nth), (nobody.topics, 3));
    let all = Wanted::of(|_| true).subscribe(0);
    let shown = nobody.topics.and(Topics::STATE).and(Topics::SLIP);
    assert_eq!((all.topics, all.every_nth, all.state_ms), (shown, 1, 10));

    let mut translator = Translator::default();
    translator.want(Wanted::of(|topic| topic == Topic::State));
    let reported = |message| take(&mut Translator::default(), &message, NOW).len();
    assert_eq!(
        (reported(ToClient::Welcome(welcome(1))), reported(ToClient::State(state()))),
        (0, 0)
    );
    let payload = rows(0, 2);
    let message = ToClient::Rows(Rows::parse(&payload).unwrap());
    assert_eq!(take(&mut translator, &message, NOW), []);
    assert_eq!(take(&mut translator, &ToClient::State(state()), NOW).len(), 1);
}

#[test]
fn a_state_comes_back_as_a_recording_would_hold_it() {
    let reported = take(&mut greeted(), &ToClient::State(state()), NOW + 2_000_000_000);
    let [(Topic::State, log_ns, bytes)] = reported.as_slice() else { panic!("{reported:?}") };
    assert_eq!(*log_ns, ZERO + 11_000_000_000);
    let topic = Topic::State.recorded().unwrap();
    let mut none = Vec::new();
    let record = Record::decode(topic, bytes, &mut none);
    // What the gripper reports of itself, and when the daemon had it, is not in the record.
    let wanted =
        PipelineState { host: Micros(0), device: DeviceState::Boot, esc_flags: 4, ..state() };
    assert_eq!(record, Ok(Record::State(wanted)));
}

#[test]
fn a_state_of_a_later_protocol_keeps_its_code() {
    let mut translator = greeted();
    let later = PipelineState { scene: Scene::Other(9), ..state() };
    let seen = take(&mut translator, &ToClient::State(later), NOW);
    let [(_, _, bytes)] = seen.as_slice() else { panic!("{seen:?}") };
    let mut none = Vec::new();
    let record = Record::decode(Topic::State.recorded().unwrap(), bytes, &mut none);
    assert!(matches!(record, Ok(Record::State(PipelineState { scene: Scene::Other(9), .. }))));
}

#[test]
fn samples_stand_at_the_time_of_the_gripper() {
    let mut translator = greeted();
    let clock = Some(ClockOffset { offset_us: 9_000_000, half_us: 50.0 });
    let appended = Some(Appended { clock, ..Appended::default() });
    let health = Health {
        host_us: 10_500_000,
        rate_hz: Some(999.0),
        link: LinkState::Stream,
        recording: Recording::Running,
        appended,
        ..Health::default()
    };
    let reported = take(&mut translator, &ToClient::Health(health), NOW + 1_000_000_000);
    let [(Topic::Health, log_ns, bytes)] = reported.as_slice() else { panic!("{reported:?}") };
    assert_eq!(*log_ns, ZERO + 10_500_000_000);
    let record = HealthRecord::decode(bytes).unwrap();
    assert_eq!((record.rate_hz, record.clock_offset_us), (999.0, 9_000_000.0));
    assert_eq!((record.link, record.recording), ("stream", "running"));

    let payload = rows(2_000_000, 3);
    let message = ToClient::Rows(Rows::parse(&payload).unwrap());
    let reported = take(&mut translator, &message, NOW + 2_000_000_000);
    let times: Vec<u64> = reported.iter().map(|(_, log_ns, _)| log_ns - ZERO).collect();
    assert_eq!(times, [11_000_000_000, 11_001_000_000, 11_002_000_000]);
    let mut taxels = Vec::new();
    let topic = Topic::Sample.recorded().unwrap();
    for (row, (_, _, bytes)) in (0..).zip(&reported) {
        let record = Record::decode(topic, bytes, &mut taxels).unwrap();
        let Record::Sample(record) = record else { panic!("{record:?}") };
        assert_eq!((record.index, record.taxels), (40 + 2 * row, &[0.25][..]));
        assert_eq!(record.sample.normal_force_n, (row != 1).then_some(5.5));
        assert_eq!(record.sample.t.0, 2_000_000 + 1000 * u64::from(row));
        assert_eq!(record.sample.travel_m, None);
    }
}

#[test]
fn times_never_go_back_and_never_lie_ahead() {
    let mut translator = greeted();
    let mut at = |host_us, now_ns| {
        let reported = take(
            &mut translator,
            &ToClient::State(PipelineState { host: Micros(host_us), ..state() }),
            now_ns,
        );
        reported[0].1
    };
    let ahead = NOW + 500_000_000;
    assert_eq!(at(11_000_000, ahead), ahead);
    assert_eq!(at(10_200_000, ahead + 1), ahead);
    assert_eq!(at(11_000_000, NOW + 3_000_000_000), ZERO + 11_000_000_000);
}

fn slip(number: u32, phase: Phase) -> SlipReport {
    SlipReport {
        number,
        t: Micros(1_500_000),
        host: Micros(9_000_000),
        phase,
        method: if phase == Phase::Ended { Method::None } else { Method::Stylus },
        speed_source: SpeedSource::None,
        esc_kind: Reading::None,
        statistic: Some(2.5),
        speed_m_s: Some(0.125),
        irregularities: Some(4),
        command_n: Some(6.5),
        ..SlipReport::UNKNOWN
    }
}

#[test]
fn a_slip_is_reported_once_in_each_run_of_the_daemon() {
    let mut translator = greeted();
    let mut report = |message| take(&mut translator, &message, NOW);
    let reported = report(ToClient::Slip(slip(1, Phase::Gross)));
    let [(Topic::Event, log_ns, bytes)] = reported.as_slice() else { panic!("{reported:?}") };
    assert_eq!(*log_ns, ZERO + 9_000_000_000);
    let topic = Topic::Event.recorded().unwrap();
    let mut none = Vec::new();
    let record = Record::decode(topic, bytes, &mut none).unwrap();
    let Record::Event(event) = record else { panic!("{record:?}") };
    assert_eq!((event.kind, event.phase, event.method), ("slip", "gross", "stylus"));
    assert_eq!((event.t_s, event.irregularities, event.json), (1.5, 4.0, ""));
    assert!(event.esc_w.is_nan() && event.confidence.is_nan());

    assert_eq!(report(ToClient::Slip(slip(1, Phase::Gross))), []);
    assert_eq!(report(ToClient::Slip(slip(2, Phase::Ended))).len(), 1);
    assert_eq!(report(ToClient::Welcome(welcome(7))), []);
    assert_eq!(report(ToClient::Slip(slip(2, Phase::Ended))), []);
    assert_eq!(report(ToClient::Welcome(welcome(8))).len(), 1);
    assert_eq!(report(ToClient::Slip(slip(1, Phase::Incipient))).len(), 1);
}

#[test]
fn updates_are_events_of_sensors_and_lines_about_the_link() {
    let mut translator = greeted();
    let (code, value) = (Sensor::Travel.code(), SensorHealth::Frozen.code().into());
    let notice = Notice { kind: NoticeKind::Sensor, code, value, count: 0, host_us: 0, text: b"" };
    let reported = take(&mut translator, &ToClient::Notice(notice), NOW);
    let topic = Topic::Event.recorded().unwrap();
    let mut none = Vec::new();
    let record = Record::decode(topic, &reported[0].2, &mut none).unwrap();
    let Record::Event(event) = record else { panic!("{record:?}") };
    assert_eq!((event.kind, event.channel, event.health), ("health", "travel", "frozen"));

    let dropped = Notice { kind: NoticeKind::Dropped, code: 1, count: 9, text: b"much", ..notice };
    let (kind, detail) = link(&take(&mut translator, &ToClient::Notice(dropped), NOW));
    assert_eq!(kind, "dropped");
    assert_eq!(detail, r#"{"code":1,"count":9,"text":"much","value":1}"#);
    let gripper = Gripper { boot_id: 5, rate_hz: 1000, ..Gripper::NONE };
    let (kind, detail) = link(&take(&mut translator, &ToClient::Gripper(gripper), NOW));
    assert!(kind == "gripper" && detail.contains(r#""boot_id":5"#), "{detail}");
    let mut reported = Reported::new();
    translator
        .lost("gone", NOW, &mut |topic, ns, bytes| reported.push((topic, ns, bytes.to_vec())));
    assert_eq!(link(&reported), ("daemon_lost".to_owned(), r#"{"reason":"gone"}"#.to_owned()));
}

/// Fields of a topic's message that a path of a layout may name.
fn has_field(topic: &str, field: &str) -> bool {
    let topic = Topic::ALL.into_iter().find(|known| known.name() == topic);
    topic.is_some_and(|topic| {
        let definition = topic.definition();
        let own = definition.split("====").next().unwrap_or_default();
        own.lines().any(|line| line.split_whitespace().nth(1) == Some(field))
    })
}

#[test]
fn every_path_of_the_layout_leads_to_a_field() {
    let text = include_str!("../../../docs/foxglove.json");
    let layout: serde_json::Value = serde_json::from_str(text).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    let placed = layout["layout"].to_string();
    let mut paths = Vec::new();
    for (name, panel) in panels {
        assert!(placed.contains(&format!("\"{name}\"")), "{name} has no place");
        let several = panel["paths"].as_array().into_iter().flatten();
        paths.extend(several.map(|path| path["value"].as_str().unwrap()));
        paths.extend(panel["topicPath"].as_str());
    }
    assert_eq!(placed.matches('!').count(), panels.len());
    assert!(paths.len() > 10, "{paths:?}");
    for path in paths {
        let (topic, field) = path.split_once('.').unwrap_or((path, "stamp"));
        assert!(has_field(topic, field), "{path}");
    }
}
