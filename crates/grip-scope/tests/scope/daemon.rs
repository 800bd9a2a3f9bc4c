//! A daemon that is there, goes, comes back, stalls, shows nothing, speaks otherwise.

use crate::rig::{Watch, pause, samples};
use core::time::Duration;
use grip_daemon::clients::{About, Clients, ClientsConfig, Listen};
use grip_daemon::{Item, LinkNote};
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Header, MAX_PAYLOAD, MAX_WIRE, encode};
use grip_link::message::daemon::{
    Appended, ClockOffset, Health, LinkState, RealTime, Welcome, WelcomeFlags,
};
use grip_link::message::{Kind, Versions};
use grip_scope::{Channel, EventKind, SourceSpec, SourceStatus};
use slip_core::ClientCommand;
use slip_core::PipelineState;
use slip_core::{Sample, grip::GripState, sample::Scene, units::Micros};
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::path::Path;

/// The part of gripd that clients see, without a gripper.
struct Daemon {
    clients: Clients,
    now_us: u64,
    index: u32,
}

impl Daemon {
    fn new(path: &Path, commands: bool) -> Self {
        let about = About {
            name: "gripd test".into(),
            run_id: 99,
            dry_run: false,
            records: true,
            real_time: RealTime::Partly,
        };
        let config = ClientsConfig {
            listen: Listen::Unix(path.to_owned()),
            allow_commands: commands,
            ..ClientsConfig::default()
        };
        Self { clients: Clients::listen(config, about).unwrap(), now_us: 1000, index: 0 }
    }

    fn turn(&mut self) {
        self.now_us += 1000;
        self.clients.poll(self.now_us, Duration::ZERO).unwrap();
    }

    /// A millisecond at 10 kHz.
    fn samples(&mut self) {
        for _ in 0..10 {
            let t = Micros(u64::from(self.index) * 100);
            let sample = Sample { normal_force_n: Some(2.0), ..Sample::stylus(t, 1e-6) };
            let (host_us, index) = (self.now_us, self.index);
            self.index += 1;
            self.clients.take(&Item::Sample { host_us, index, sample: &sample, taxels: &[] });
        }
        let state = PipelineState {
            t: Micros(u64::from(self.index - 1) * 100),
            host: Micros(self.now_us),
            scene: Scene::Holding,
            grip: GripState::Holding,
            statistic: Some(0.25),
            applied_n: Some(3.5),
            need_low_n: Some(1.5),
            need_n: Some(1.75),
            need_high_n: Some(2.5),
            rate_hz: 10_000,
            ..PipelineState::UNKNOWN
        };
        self.clients.take(&Item::State(&state));
        self.turn();
    }
}

fn watch(path: &Path) -> Watch {
    Watch::new(SourceSpec::Daemon(Listen::Unix(path.to_owned())))
}

#[test]
fn what_a_daemon_reports_is_shown_and_derived_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("socket");
    let mut daemon = Daemon::new(&path, false);
    let mut watch = watch(&path);
    watch.until(|| daemon.turn(), |model| model.info().daemon.is_some());
    let clock = Some(ClockOffset { offset_us: -5_000_000, half_us: 40.0 });
    let mut histogram = [0; Appended::BUCKETS];
    (histogram[7], histogram[23]) = (90, 1);
    let appended = Some(Appended { p999_us: Some(400.0), clock, histogram });
    let health = Health { samples: 5, rate_hz: Some(9_999.0), appended, ..Health::default() };
    daemon.clients.health(&health);
    watch.until(
        || daemon.samples(),
        |model| {
            let energy = model.series(Channel::Band0);
            energy.is_some() && model.health().latest.is_some() && model.end_s() > 0.3
        },
    );
    assert_eq!(watch.model.status(), &SourceStatus::Live);
    let about = watch.model.info().daemon.clone().unwrap();
    assert_eq!((about.name.as_str(), about.may_command, about.every_nth), ("gripd test", false, 1));
    let latest = |channel| watch.model.series(channel).unwrap().latest().unwrap().1;
    assert_eq!(latest(Channel::Applied), 3.5);
    let fan = [Channel::NeedLow, Channel::Need, Channel::NeedHigh];
    assert_eq!(fan.map(latest), [1.5, 1.75, 2.5]);
    let health = watch.model.health().latest.as_deref().unwrap();
    assert_eq!((health.rate_hz, health.appended), (Some(9_999.0), appended));
    assert!(samples(&watch.model, Channel::Stylus) > 1000);
    assert!(watch.model.events().marks.iter().all(|mark| mark.kind != EventKind::Gap));
    watch.handle.orders.send(ClientCommand::Release).unwrap();
    watch.until(
        || daemon.samples(),
        |model| model.notices().any(|line| line.contains("allows no commands")),
    );
    let answer =
        watch.model.events().marks.iter().find(|mark| mark.kind == EventKind::Client).unwrap();
    assert!(answer.text.contains("allows no commands"), "{}", answer.text);
}

#[test]
fn a_daemon_that_goes_is_waited_for_and_the_gap_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("socket");
    let mut watch = watch(&path);
    watch.until(|| {}, |model| matches!(model.status(), SourceStatus::Waiting { .. }));
    assert!(watch.model.status().sentence().starts_with("no daemon answers at unix:"));
    let mut daemon = Daemon::new(&path, false);
    watch.until(|| daemon.samples(), |model| model.series(Channel::Stylus).is_some());
    drop(daemon);
    watch.until(|| {}, |model| matches!(model.status(), SourceStatus::Waiting { .. }));
    let before = samples(&watch.model, Channel::Stylus);
    let mut daemon = Daemon::new(&path, false);
    // The gripper went on meanwhile.
    daemon.index = 1_000_000;
    let live =
        |model: &grip_scope::Model| model.status() == &SourceStatus::Live && model.end_s() > 100.0;
    watch.until(|| daemon.samples(), live);
    assert!(samples(&watch.model, Channel::Stylus) > before);
    let series = watch.model.series(Channel::Stylus).unwrap();
    let mut parts = Vec::new();
    series.envelope(grip_scope::Span::new(99.0, 102.0), 3, &mut parts);
    assert!(parts.iter().any(|part| part.broken), "{parts:?}");
    let gap = watch.model.events().marks.iter().find(|mark| mark.kind == EventKind::Gap).unwrap();
    assert!(gap.text.starts_with("samples are missing for"), "{}", gap.text);
}

/// A payload in a frame to a client, in the session that the client opened.
fn frame(session: u16, kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) -> Vec<u8> {
    let (mut payload, mut wire) = ([0; MAX_PAYLOAD], [0; MAX_WIRE]);
    let len = write(&mut payload);
    let header = Header::new(Direction::ToHost, kind, 0, session);
    let len = encode(&header, &payload[..len], &mut wire).unwrap();
    wire[..len].to_vec()
}

#[test]
fn a_daemon_of_another_protocol_is_named_as_such() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    let mut watch = Watch::new(SourceSpec::parse(&place.to_string()).unwrap());
    let (mut peer, _) = listener.accept().unwrap();
    let mut bytes = [0; 256];
    let count = peer.read(&mut bytes).unwrap();
    let mut decoder = Decoder::new(Role::Daemon);
    let mut input = &bytes[..count];
    let Some(Verdict::Frame(asked)) = decoder.next(&mut input) else { panic!("no SUBSCRIBE") };
    let welcome = Welcome {
        versions: Versions { min: 9, max: 11 },
        max_rx: 480,
        flags: WelcomeFlags::default(),
        token: 0,
        run_id: 1,
        host_us: 0,
        real_time: RealTime::NotAsked,
        text: b"gripd of tomorrow",
    };
    let answer = frame(asked.header.session, Kind::WELCOME, |out| welcome.write(out).unwrap());
    peer.write_all(&answer).unwrap();
    watch.until(|| {}, |model| model.status().sentence().contains("versions 9 to 11"));
    assert!(watch.model.status().sentence().contains("install both from one release"));
    assert!(watch.model.info().daemon.is_none());
}

#[test]
fn lost_rows_and_a_gripper_that_restarts_are_events() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("socket");
    let mut daemon = Daemon::new(&path, false);
    let mut watch = watch(&path);
    watch.until(|| daemon.samples(), |model| model.end_s() > 0.2);
    daemon.index += 25;
    let has =
        |kind| move |model: &grip_scope::Model| model.events().marks.iter().any(|m| m.kind == kind);
    watch.until(|| daemon.samples(), has(EventKind::Gap));
    let gap = watch.model.events().marks.iter().find(|mark| mark.kind == EventKind::Gap).unwrap();
    assert!(gap.text.starts_with("25 rows are missing"), "{}", gap.text);
    daemon.index = 0;
    watch.until(|| daemon.samples(), has(EventKind::Clock));
}

#[test]
fn a_stream_that_stalls_states_for_how_long() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("socket");
    let mut daemon = Daemon::new(&path, false);
    let mut watch = watch(&path);
    watch.until(|| daemon.samples(), |model| model.status() == &SourceStatus::Live);
    watch.until(|| daemon.turn(), |model| matches!(model.status(), SourceStatus::Stalled { .. }));
    assert_eq!(watch.model.status().sentence(), "no samples for 1.0 s");
    watch.until(|| daemon.samples(), |model| model.status() == &SourceStatus::Live);
}

#[test]
fn commands_reach_a_daemon_that_allows_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("socket");
    let mut daemon = Daemon::new(&path, true);
    let mut watch = watch(&path);
    watch.until(|| daemon.samples(), |model| model.info().daemon.is_some());
    assert!(watch.model.info().daemon.as_ref().unwrap().may_command);
    let note = LinkNote::State(LinkState::Stream);
    daemon.clients.take(&Item::Link { host_us: daemon.now_us, note: &note });
    watch.handle.orders.send(ClientCommand::AtLeast(4.5)).unwrap();
    watch.handle.orders.send(ClientCommand::Release).unwrap();
    let mut asked = Vec::new();
    for _ in 0..60_000 {
        daemon.turn();
        while let Some(next) = daemon.clients.next_command() {
            asked.push(format!("{:?}", next));
        }
        if asked.len() == 2 {
            break;
        }
        pause();
    }
    assert_eq!(asked, ["AtLeast(4.5)", "Release"]);
}

#[test]
fn what_is_no_daemon_is_reported_and_tried_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    let mut watch = Watch::new(SourceSpec::parse(&format!("tcp:{place}")).unwrap());
    let (mut peer, _) = listener.accept().unwrap();
    let mut bytes = [0; 64];
    assert!(peer.read(&mut bytes).unwrap() > 0);
    peer.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n").unwrap();
    watch.until(|| {}, |model| model.status().sentence().contains("not as gripd does"));
    // The next attempt comes by itself and does not hide why the one before was of no use.
    let again =
        |model: &grip_scope::Model| matches!(model.status(), SourceStatus::Connecting { .. });
    watch.until(|| {}, again);
    let sentence = watch.model.status().sentence();
    assert!(sentence.ends_with("not as gripd does; trying again"), "{sentence}");
    // A connection that is closed at once is reported too.
    drop(listener.accept().unwrap());
    watch.until(|| {}, |model| model.status().sentence().contains("closed the connection"));
}
