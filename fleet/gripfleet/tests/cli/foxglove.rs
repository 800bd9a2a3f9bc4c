//! `gripfleet foxglove` between a daemon that the test plays and an app that the test plays: what is asked for, shown, dropped, refused.

use crate::{
    daemon::{Daemon, listening},
    fleet::running,
    run::run as gripfleet,
};
use core::{
    sync::atomic::{AtomicBool, AtomicU32, Ordering},
    time::Duration,
};
use grip_daemon::Item;
use grip_fleet::live::Topic;
use grip_record::mcap::Record;
use serde_json::{Value, json};
use slip_core::{Sample, units::Micros};
use std::{net::TcpStream, path::Path, sync::Arc};
use stories::{Program, Signal, until};
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

/// Longer than anything takes, however busy the machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A daemon whose sample of number n has the height n um and the force n / 1000 N.
struct Sampled {
    wants_samples: Arc<AtomicBool>,
    clients: Arc<AtomicU32>,
    _daemon: Daemon,
}

impl Sampled {
    /// Listens in `folder` and makes `rate` samples a millisecond, each with so many taxels.
    fn start(folder: &Path, run_id: u32, rate: u32, taxels: usize) -> Self {
        let listen = format!("unix:{}", folder.join("gripd.sock").display());
        let clients = listening(&listen, run_id, 0.25);
        let wants_samples = Arc::new(AtomicBool::new(false));
        let count = Arc::new(AtomicU32::new(0));
        let (wanted, counted) = (wants_samples.clone(), count.clone());
        let (mut index, taxels) = (0, vec![0.5; taxels]);
        let daemon = Daemon::start(clients, move |clients, host_us| {
            for _ in 0..rate {
                let t = Micros(u64::from(index) * 100);
                let normal_force_n = Some(index as f32 / 1e3);
                let sample = Sample { normal_force_n, ..Sample::stylus(t, index as f32 * 1e-6) };
                clients.take(&Item::Sample { host_us, index, sample: &sample, taxels: &taxels });
                index += 1;
            }
            wanted.store(clients.wants_samples(), Ordering::Relaxed);
            counted.store(u32::try_from(clients.subscribed()).unwrap(), Ordering::Relaxed);
        });
        Self { wants_samples, clients: count, _daemon: daemon }
    }

    fn wants_samples(&self) -> bool {
        self.wants_samples.load(Ordering::Relaxed)
    }
}

/// `gripfleet foxglove` for the daemon in a folder.
struct Server {
    program: Program,
    address: String,
}

impl Server {
    fn start(folder: &Path, args: &[&str]) -> Self {
        let place = format!("unix:{}", folder.join("gripd.sock").display());
        let fixed = ["foxglove", &place, "--listen", "127.0.0.1:0"];
        let program = running(folder, &[&fixed, args].concat());
        program.until_printed("\n");
        let line = program.printed();
        let address = line.trim_end().strip_prefix("Foxglove opens ws://").unwrap().to_owned();
        Self { program, address }
    }

    /// Ends it as a service manager does: its exit code and what it said.
    fn stop(self) -> (i32, String) {
        self.program.signal(Signal::TERM);
        let ended = self.program.ended();
        (ended.code, ended.err)
    }
}

/// What came from the server.
#[derive(Debug)]
enum Came {
    Json(Value),
    Data { subscription: u32, log_ns: u64, bytes: Vec<u8> },
    Close,
}

/// An app.
struct App(WebSocket<TcpStream>);

impl App {
    fn connect(server: &Server) -> Self {
        let stream = TcpStream::connect(&server.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let place = format!("ws://{}", server.address).parse().unwrap();
        let request = ClientRequestBuilder::new(place).with_sub_protocol("foxglove.sdk.v1");
        Self(tungstenite::client(request, stream).unwrap().0)
    }

    /// The next message.
    fn receive(&mut self) -> Came {
        match self.0.read().unwrap() {
            Message::Text(text) => Came::Json(serde_json::from_str(&text).unwrap()),
            Message::Binary(payload) => {
                assert_eq!(payload[0], 1, "{payload:?}");
                let subscription = u32::from_le_bytes(payload[1..5].try_into().unwrap());
                let log_ns = u64::from_le_bytes(payload[5..13].try_into().unwrap());
                Came::Data { subscription, log_ns, bytes: payload[13..].to_vec() }
            }
            Message::Close(_) => Came::Close,
            other => panic!("{other:?}"),
        }
    }

    fn send(&mut self, message: &Value) {
        self.0.send(Message::text(message.to_string())).unwrap();
    }

    /// The channels that the server has, in the order of their making.
    fn channels(&mut self) -> Vec<Value> {
        loop {
            if let Came::Json(message) = self.receive()
                && message["op"] == "advertise"
            {
                let mut channels = message["channels"].as_array().unwrap().clone();
                channels.sort_by_key(|channel| channel["id"].as_u64());
                return channels;
            }
        }
    }

    /// Subscribes under the number of the topic's place.
    fn subscribe(&mut self, channels: &[Value], topic: Topic) {
        let channel = channels.iter().find(|channel| channel["topic"] == topic.name()).unwrap();
        let wanted = json!({ "id": topic as u32, "channelId": channel["id"] });
        self.send(&json!({ "op": "subscribe", "subscriptions": [wanted] }));
    }

    /// The next message of a topic.
    fn next(&mut self, topic: Topic) -> (u64, Vec<u8>) {
        loop {
            if let Came::Data { subscription, log_ns, bytes } = self.receive()
                && subscription == topic as u32
            {
                return (log_ns, bytes);
            }
        }
    }

    /// Takes `count` samples and checks each, and that every second comes: number and log time of the last.
    fn samples(&mut self, count: usize) -> (u32, u64) {
        let topic = Topic::Sample.recorded().unwrap();
        let (mut last, mut taxels) = (None, Vec::new());
        for _ in 0..count {
            let (log_ns, bytes) = self.next(Topic::Sample);
            let record = Record::decode(topic, &bytes, &mut taxels).unwrap();
            let Record::Sample(record) = record else { panic!("{record:?}") };
            let (index, sample) = (record.index, record.sample);
            assert_eq!((sample.t.0, sample.stylus), (u64::from(index) * 100, index as f32 * 1e-6));
            assert_eq!((sample.normal_force_n, sample.travel_m), (Some(index as f32 / 1e3), None));
            assert_eq!(record.taxels, [0.5, 0.5]);
            if let Some((number, before_ns)) = last {
                assert_eq!(index, number + 2);
                assert!(log_ns >= before_ns);
            }
            last = Some((index, log_ns));
        }
        last.unwrap()
    }
}

#[track_caller]
fn becomes(is_so: impl FnMut() -> bool) {
    assert!(until(is_so));
}

#[test]
fn an_app_is_shown_what_it_looks_at_and_nothing_else_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let daemon = Sampled::start(folder.path(), 1, 2, 2);
    let server = Server::start(folder.path(), &["--every", "2"]);
    let mut app = App::connect(&server);
    let channels = app.channels();
    for (channel, topic) in channels.iter().zip(Topic::ALL) {
        assert_eq!(
            (&channel["topic"], &channel["encoding"]),
            (&topic.name().into(), &"cdr".into())
        );
        assert_eq!(channel["schemaName"], topic.schema());
        assert_eq!(channel["schemaEncoding"], "ros2msg");
        assert_eq!(channel["schema"], topic.definition());
    }
    assert_eq!(channels.len(), Topic::ALL.len());
    becomes(|| daemon.clients.load(Ordering::Relaxed) == 1);
    assert!(!daemon.wants_samples());
    app.subscribe(&channels, Topic::Event);
    let mut none = Vec::new();
    let (_, bytes) = app.next(Topic::Event);
    let record = Record::decode(Topic::Event.recorded().unwrap(), &bytes, &mut none).unwrap();
    let Record::Event(event) = record else { panic!("{record:?}") };
    assert_eq!((event.kind, event.t_s, event.duration_s), ("slip_end", 1.5, 0.25));
    assert_eq!(event.command_n, 4.5);
    assert!(!daemon.wants_samples());

    app.subscribe(&channels, Topic::Sample);
    app.samples(500);
    assert!(daemon.wants_samples());
    app.send(&json!({ "op": "unsubscribe", "subscriptionIds": [Topic::Sample as u32] }));
    becomes(|| !daemon.wants_samples());
    let (code, reported) = server.stop();
    assert_eq!(code, 0, "{reported}");
    while !matches!(app.receive(), Came::Close) {}
}

#[test]
fn a_daemon_may_go_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--every", "2"]);
    server.program.until_reported("no daemon answers");
    let daemon = Sampled::start(folder.path(), 1, 2, 2);
    let (mut app, mut other) = (App::connect(&server), App::connect(&server));
    let channels = app.channels();
    assert_eq!(other.channels(), channels);
    app.subscribe(&channels, Topic::Sample);
    let (_, before_ns) = app.samples(100);
    other.subscribe(&channels, Topic::Sample);
    other.samples(100);
    drop(daemon);
    server.program.until_reported("the daemon ends; trying again");
    let _second = Sampled::start(folder.path(), 2, 2, 2);
    other.subscribe(&channels, Topic::Link);
    let connected = || server.program.reported().matches("connected to gripd 9.9.9").count();
    becomes(|| connected() == 2);
    let (link_ns, _) = other.next(Topic::Link);
    assert!(link_ns > before_ns);
    // What came before that is the first daemon's.
    while app.next(Topic::Sample).0 < link_ns {}
    app.samples(100);
    let (code, reported) = server.stop();
    assert_eq!(code, 0, "{reported}");
}

#[test]
fn what_is_dropped_for_a_slow_app_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let _daemon = Sampled::start(folder.path(), 1, 20, 64);
    let server = Server::start(folder.path(), &["--every", "1"]);
    let mut app = App::connect(&server);
    let channels = app.channels();
    app.subscribe(&channels, Topic::Sample);
    // It takes nothing more.
    server.program.until_reported("an app takes less than comes");
    let (code, reported) = server.stop();
    assert_eq!(code, 3, "{reported}");
}

#[test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let here = Path::new(".");
    let run = |args: &[&str]| gripfleet(here, &[&["foxglove"], args].concat());
    let open = ["0.0.0.0:8765 is open to other computers", "--allow-remote"];
    run(&["--listen", "0.0.0.0:8765"]).refused(2, &open);
    run(&["off"]).refused(2, &["give the address where gripd listens"]);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    run(&["--listen", &address]).refused(1, &[&format!("cannot listen at {address}: ")]);
    for (args, word) in
        [(["--every", "0"], "--every"), (["--listen", "8765"], "--listen"), (["--every", "x"], "x")]
    {
        let ran = run(&args);
        assert!(ran.code == 2 && ran.err.contains(word) && ran.out.is_empty(), "{ran:?}");
    }
}
