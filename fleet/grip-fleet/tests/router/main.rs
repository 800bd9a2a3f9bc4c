//! A real router in this process, grippers and receivers, on loopback: routers stop, daemons start again, and every event arrives once; each does what
//! its key is for; and ROS 2 has the grippers too.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod json;
mod quic;
#[path = "../rig/mod.rs"]
mod rig;
mod ros;

use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_fleet::{
    EventId, EventLog, Member, Part, Selector, Since, Spool, Uid,
    net::{self, Announced, Ask, NetError, Network, Reported, Session, Watch, ask, list},
    wire,
};
use grip_link::message::{
    Kind,
    daemon::{Gripper as Ident, Health, ToClient},
};
use rig::{announced, at, endpoint, member, notice, patient, router};
use std::{
    collections::BTreeMap,
    fs,
    io::{Read as _, Write as _},
    net::{TcpListener, TcpStream},
    path::Path,
    sync::Arc,
    thread,
};
use zenoh::{Wait as _, qos::CongestionControl};

const STEP: Duration = Duration::from_millis(2);
/// Looks at the network before a test gives up: more than a minute.
const MOST: usize = 40_000;
const ROOM: usize = 1 << 20;

/// A daemon with its gripper.
struct Daemon {
    member: Member,
    spool: Spool,
    announced: Announced,
    _session: Session,
    /// Events so far: the text of each is its number.
    sent: u32,
}

impl Daemon {
    fn start(folder: &Path, network: &Network, uid: u8, run: u32) -> Self {
        Self::on(network.open().unwrap(), folder, uid, run)
    }

    fn on(session: Session, folder: &Path, uid: u8, run: u32) -> Self {
        let member = member(uid);
        let spool = Spool::open(folder, member.uid, run, ROOM).unwrap();
        let announced = announced(&session, &member, &[]);
        Self { member, spool, announced, _session: session, sent: 0 }
    }

    fn report(&mut self) {
        self.sent += 1;
        let wire = notice(&self.sent.to_string());
        let id = self.spool.append(wire.clone());
        assert!(self.spool.trouble().is_none());
        self.announced.publish(Part::Events, id, &wire);
    }

    /// What a daemon does all the time.
    fn turn(&mut self, at: usize) {
        let head = self.spool.log().head();
        let health = wire(Kind::HEALTH, |out| Health::default().write(out).unwrap());
        if at.is_multiple_of(50) {
            self.announced.publish(Part::Health, head, &health);
        }
        let ident = Ident { uid: self.member.uid.0, boot_id: 7, ..Ident::NONE };
        let ident = wire(Kind::GRIPPER, |out| ident.write(out).unwrap());
        let with_log = |use_it: &mut dyn FnMut(&EventLog)| use_it(self.spool.log());
        self.announced.answer(&with_log, &[&ident, &health], "baud = 1\n");
    }

    /// Turns until `done`, with the number of the turn, or too many.
    fn turn_until(&mut self, mut done: impl FnMut(&mut Self, usize) -> bool) {
        for at in 0..MOST {
            self.turn(at);
            if done(self, at) {
                return;
            }
            thread::park_timeout(STEP);
        }
    }
}

/// A receiver, and what it got: numbers of the texts, by gripper.
struct Receiver {
    watch: Watch,
    got: BTreeMap<Member, Vec<u32>>,
    ids: Vec<(Member, EventId)>,
    /// HEALTH that came.
    figures: usize,
    /// Most grippers that were asked at once.
    most_asked: usize,
}

impl Receiver {
    fn new(network: &Network, since: Since) -> Self {
        let session = network.open().unwrap();
        let watch = Watch::new(session, &Selector::default(), since, &[Part::Health]).unwrap();
        Self { watch, got: BTreeMap::new(), ids: Vec::new(), figures: 0, most_asked: 0 }
    }

    fn turn(&mut self, patience: Duration) {
        let mut patience = patience;
        while let Some(reported) = self.watch.next(patience).unwrap() {
            patience = Duration::ZERO;
            self.most_asked = self.most_asked.max(self.watch.asking());
            self.figures += usize::from(matches!(reported, Reported::Telemetry { .. }));
            let Reported::Event { member, id, message, missing, .. } = reported else { continue };
            assert_eq!(missing, 0, "{member} {id}");
            let ToClient::Notice(notice) = message.read().unwrap() else { panic!("{message:?}") };
            let number = core::str::from_utf8(notice.text).unwrap().parse().unwrap();
            self.ids.push((member.clone(), id));
            self.got.entry(member).or_default().push(number);
        }
    }

    /// Whether it has got the last event of all.
    fn has_all(&self, daemons: &[Daemon]) -> bool {
        daemons.iter().all(|daemon| {
            self.got.get(&daemon.member).is_some_and(|got| got.last() == Some(&daemon.sent))
        })
    }

    fn check(&self, daemons: &[Daemon]) {
        for daemon in daemons {
            let wanted: Vec<u32> = (1..=daemon.sent).collect();
            assert_eq!(self.got.get(&daemon.member), Some(&wanted), "{}", daemon.member);
        }
    }
}

fn turn(daemons: &mut [Daemon], receivers: &mut [Receiver], at: usize) {
    daemons.iter_mut().for_each(|daemon| daemon.turn(at));
    receivers.iter_mut().for_each(|receiver| receiver.turn(STEP));
}

/// Goes on until everybody has everything; then a little longer, for what comes twice.
fn settle(daemons: &mut [Daemon], receivers: &mut [Receiver]) {
    let mut calm = 0;
    for at in 0..MOST {
        turn(daemons, receivers, at);
        calm += usize::from(receivers.iter().all(|receiver| receiver.has_all(daemons)));
        if calm > 300 {
            break;
        }
    }
    receivers.iter().for_each(|receiver| receiver.check(daemons));
}

#[test]
fn a_router_that_stops_and_starts_again_costs_no_event_and_doubles_none() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let mut running = Some(router(&endpoint));
    let mut daemons = [1, 2].map(|uid| Daemon::start(folder.path(), &network, uid, 1));
    let mut receivers = vec![Receiver::new(&network, Since::Start)];
    for at in 0..900 {
        match at {
            200 => running.take().unwrap().close().wait().unwrap(),
            500 => running = Some(router(&endpoint)),
            _ => {}
        }
        if at % 3 == 0 {
            daemons.iter_mut().for_each(Daemon::report);
        }
        turn(&mut daemons, &mut receivers, at);
    }
    settle(&mut daemons, &mut receivers);
    assert_eq!(daemons[0].sent, 300);
    // Who comes late and wants everything gets the same.
    let mut late = [Receiver::new(&network, Since::Start)];
    settle(&mut daemons, &mut late);
    drop(running);
}

/// A line to the router that can be cut: nothing passes, and nobody is informed. What was under way then is lost.
struct Line {
    endpoint: String,
    cut: Arc<AtomicBool>,
}

impl Line {
    fn to(router: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp/{}", listener.local_addr().unwrap());
        let line = Self { endpoint, cut: Arc::default() };
        let (cut, router) = (Arc::clone(&line.cut), router.replace("tcp/", ""));
        thread::spawn(move || {
            while let Ok((near, _)) = listener.accept() {
                let Ok(far) = TcpStream::connect(&router) else { continue };
                let (near_too, far_too) = (near.try_clone().unwrap(), far.try_clone().unwrap());
                let (one, other) = (Arc::clone(&cut), Arc::clone(&cut));
                thread::spawn(move || pass(near, far_too, &one));
                thread::spawn(move || pass(far, near_too, &other));
            }
        });
        line
    }

    fn cut(&self, is: bool) {
        self.cut.store(is, Ordering::SeqCst);
    }
}

/// Passes bytes on; a connection that saw the cut ends with it.
fn pass(mut from: TcpStream, mut to: TcpStream, cut: &AtomicBool) {
    from.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
    let (mut bytes, mut saw) = ([0; 4096], false);
    loop {
        let is_cut = cut.load(Ordering::SeqCst);
        saw |= is_cut;
        let count = match from.read(&mut bytes) {
            Ok(0) => break,
            Ok(count) => count,
            Err(_) if saw && !is_cut => break,
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => continue,
            Err(_) => break,
        };
        if saw && !is_cut || !saw && to.write_all(&bytes[..count]).is_err() {
            break;
        }
    }
    // The other direction ends too; of one that has ended there is nothing to close.
    let _gone = from.shutdown(std::net::Shutdown::Both);
    let _gone = to.shutdown(std::net::Shutdown::Both);
}

#[test]
fn a_line_that_is_cut_for_a_while_costs_no_event_and_doubles_none() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let _router = router(&endpoint);
    let line = Line::to(&endpoint);
    let through = patient(folder.path(), &line.endpoint);
    let mut daemons = [Daemon::start(folder.path(), &through, 1, 1)];
    let direct = patient(folder.path(), &endpoint);
    let mut receivers = [Receiver::new(&direct, Since::Start), Receiver::new(&through, Since::Now)];
    // Who wants only what is new must have received something of the gripper before.
    for at in 0..MOST {
        turn(&mut daemons, &mut receivers, at);
        if receivers[1].figures > 0 {
            break;
        }
    }
    for at in 1..1500 {
        match at {
            300 => line.cut(true),
            900 => line.cut(false),
            _ => {}
        }
        if at % 5 == 0 {
            daemons[0].report();
        }
        turn(&mut daemons, &mut receivers, at);
    }
    settle(&mut daemons, &mut receivers);
}

/// More grippers than are asked at once; and more events than may wait for a receiver.
#[test]
fn a_receiver_that_comes_late_and_does_not_look_for_a_while_gets_everything_once() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _router = router(&endpoint);
    let session = network.open().unwrap();
    let new = |uid| Daemon::on(session.clone(), folder.path(), uid, 1);
    let mut daemons: Vec<Daemon> = (1..=70).map(new).collect();
    for daemon in &mut daemons {
        (0..3).for_each(|_| daemon.report());
    }
    let mut receivers = [Receiver::new(&network, Since::Start)];
    settle(&mut daemons, &mut receivers);
    assert_eq!(receivers[0].most_asked, 32);
    (0..6000).for_each(|_| daemons[0].report());
    for at in 0..100 {
        turn(&mut daemons, &mut [], at);
        thread::park_timeout(STEP);
    }
    let waiting = receivers[0].watch.waiting();
    assert!((1..=4097).contains(&waiting), "{waiting}");
    settle(&mut daemons, &mut receivers);
    assert_eq!(receivers[0].ids.len(), 70 * 3 + 6000);
}

/// More runs that were kept in memory only than a receiver names, between two that were kept on disk: the log knows none of those named, and more than a
/// page of what it reports then was reported before.
#[test]
fn a_log_that_has_forgotten_many_runs_is_read_past_what_is_known() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _router = router(&endpoint);
    let mut receivers = [Receiver::new(&network, Since::Start)];
    let mut sent = 0;
    let forgotten = 11..20;
    for run in 10..=20 {
        let count = if run == 10 { 700 } else { 2 };
        let mut daemons = [Daemon::start(folder.path(), &network, 4, run)];
        daemons[0].sent = sent;
        if forgotten.contains(&run) {
            daemons[0].spool = Spool::in_memory(run, ROOM);
        }
        (0..count).for_each(|_| daemons[0].report());
        settle(&mut daemons, &mut receivers);
        sent = daemons[0].sent;
    }
    assert_eq!((sent, receivers[0].ids.len()), (720, 720));
}

/// A client that asks as Zenoh's pages state, with what is set by default: it keeps one answer of each name.
#[test]
fn a_plain_client_gets_every_event_and_a_question_that_is_wrong_is_refused() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let _router = router(&endpoint);
    let network = patient(folder.path(), &endpoint);
    let mut daemon = Daemon::start(folder.path(), &network, 1, 7);
    (0..60).for_each(|_| daemon.report());
    let session = network.open().unwrap();
    let name = daemon.member.key(Part::Events);
    let status = daemon.member.key(Part::Status);
    let mut asked = |question: &str| {
        let answers = session.get(question).wait().unwrap();
        let (mut came, mut refused) = (Vec::new(), String::new());
        for at in 0..MOST {
            daemon.turn(at);
            match answers.try_recv() {
                Ok(Some(reply)) => match reply.into_result() {
                    Ok(sample) => came.push(sample.key_expr().to_string()),
                    Err(error) => {
                        refused = String::from_utf8_lossy(&error.payload().to_bytes()).into_owned();
                    }
                },
                Ok(None) => thread::park_timeout(STEP),
                Err(_) => break,
            }
        }
        (came, refused)
    };
    let (came, refused) = asked(&format!("{name}/**"));
    assert_eq!((came.len(), refused.as_str()), (60, ""));
    // Zenoh's default gives them in no order.
    assert!(came.contains(&format!("{name}/00000007/60")), "{came:?}");
    let (came, _) = asked(&format!("{name}/**?after=00000007.57"));
    assert_eq!(came.len(), 3);
    assert_eq!(asked(&format!("{status}/**")).0.len(), 2);
    for (question, words) in [
        (format!("{name}/**?after=7.57"), "after=7.57: expected RUN.NUMBER, RUN as eight"),
        (format!("{name}/**?after=nonsense"), "after=nonsense: expected"),
        (format!("{name}/**?after=00000007.1;most=x"), "most=x: expected a count"),
        (format!("{name}/**?since=ever"), "since=ever: expected now"),
        (name.clone(), "events/**: each answer has a name of its own"),
        (status, "status/**: each answer has a name of its own"),
    ] {
        let (came, refused) = asked(&question);
        assert!(came.is_empty() && refused.contains(words), "{question}: {came:?} {refused}");
    }
}

/// More than fit into Zenoh's own queue of answers (256).
#[test]
fn three_hundred_are_listed_with_what_they_say() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _router = router(&endpoint);
    let (asking, plant) = (network.open().unwrap(), network.open().unwrap());
    let members = (0..300_u16).map(|number| {
        let mut uid = Uid([0; 16]);
        uid.0[..2].copy_from_slice(&number.to_le_bytes());
        Member { uid, ..member(0) }
    });
    let mut hands: Vec<_> = members
        .map(|member| (Announced::new(&plant, &member, &[Part::About]).unwrap(), member))
        .collect();
    let listing = thread::spawn(move || list(&asking, &Selector::default()).unwrap());
    let log = EventLog::new(1, ROOM);
    let about = br#"{"program":"gripd 1"}"#;
    let health = wire(Kind::HEALTH, |out| Health::default().write(out).unwrap());
    let mut reported = 0;
    for _ in 0..MOST {
        for (number, (announced, member)) in hands.iter_mut().enumerate() {
            // The last one is slow to report anything: what the others show must not stop its words.
            if number == 299 && reported < 299 {
                continue;
            }
            let ident = Ident { uid: member.uid.0, boot_id: 7, ..Ident::NONE };
            let ident = wire(Kind::GRIPPER, |out| ident.write(out).unwrap());
            announced.answer(&|use_it| use_it(&log), &[&ident, &health], "");
            while let Some(question) = announced.question() {
                question.reply(about).unwrap();
                reported += 1;
            }
        }
        if listing.is_finished() {
            break;
        }
        thread::park_timeout(STEP);
    }
    let listed = listing.join().unwrap();
    assert_eq!(listed.len(), 300);
    for (member, listed) in &listed {
        assert!(listed.about.is_some() && listed.health.is_some(), "{member}");
        assert_eq!(listed.gripper.map(|ident| ident.uid), Some(member.uid.0), "{member}");
    }
}

#[test]
fn two_of_one_name_are_not_there_together() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _router = router(&endpoint);
    let first = Daemon::start(folder.path(), &network, 4, 1);
    let session = network.open().unwrap();
    // The router may know of the first one some time after it has begun.
    let refused = || {
        let second = Announced::new(&session, &first.member, &[]);
        second.err().or_else(|| {
            thread::park_timeout(Duration::from_millis(100));
            None
        })
    };
    let second = (0..100).find_map(|_| refused()).unwrap().to_string();
    assert_eq!(second, format!("another gripd is there as {}", first.member));
}

#[test]
fn a_gripper_is_asked_and_answers_in_parts_or_states_why_not() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _router = router(&endpoint);
    let (asking, session) = (network.open().unwrap(), network.open().unwrap());
    let member = member(6);
    let mut announced = Announced::new(&session, &member, &[Part::About]).unwrap();
    let asked = |part, count: &'static str, payload: &'static [u8]| {
        let (session, member) = (asking.clone(), member.clone());
        thread::spawn(move || {
            let parameters = [("count", count.to_owned())];
            let patience = Duration::from_secs(20);
            let question =
                Ask { member: &member, part, parameters: &parameters, payload, patience };
            ask(&session, &question)
        })
    };
    let answer = |announced: &mut Announced| {
        let log = EventLog::new(1, ROOM);
        for _ in 0..MOST {
            announced.answer(&|use_it| use_it(&log), &[[0; 0]; 0], "");
            if let Some(question) = announced.question() {
                assert_eq!(question.part(), Part::About);
                let count = question.parameter("count").unwrap().parse::<usize>();
                let Ok(count) = count else { return question.refuse("no number").unwrap() };
                let payload = question.payload();
                return (0..count).for_each(|_| question.reply(&payload).unwrap());
            }
            thread::park_timeout(STEP);
        }
        panic!("nothing was asked");
    };
    let three = asked(Part::About, "3", b"bytes");
    answer(&mut announced);
    assert_eq!(three.join().unwrap().unwrap(), [b"bytes"; 3]);
    let declined = asked(Part::About, "x", b"");
    answer(&mut announced);
    let declined = declined.join().unwrap().unwrap_err().to_string();
    assert_eq!(declined, format!("{member}: no number"));
    let silent = asked(Part::Model, "1", b"").join().unwrap().unwrap_err().to_string();
    assert_eq!(silent, format!("{member} does not answer"));
    // It is asked, and hangs.
    let patience = Duration::from_millis(200);
    let (part, parameters) = (Part::About, &[][..]);
    let question = Ask { member: &member, part, parameters, payload: b"", patience };
    let silent = ask(&asking, &question).unwrap_err().to_string();
    assert_eq!(silent, format!("{member} does not answer"));
}

#[test]
fn a_network_that_cannot_be_is_reported_in_a_sentence() {
    let text = |network: Network| match network.open() {
        Ok(_) => panic!("{network:?}"),
        Err(error) => error.to_string(),
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zenoh.json5");
    fs::write(&file, "{ connect: 5 }").unwrap();
    let reported = text(Network { router: None, file: Some(file.clone()) });
    assert!(
        reported.starts_with(&format!("{}: no Zenoh configuration: ", file.display())),
        "{reported}"
    );
    assert!(text(Network::default()).starts_with("no router: "));
    let reported = text(at("somewhere"));
    assert!(
        reported.starts_with("router = somewhere: ") && !reported.contains(".rs"),
        "{reported}"
    );
    let reported = text(at("udp/10.0.0.1:7447"));
    assert!(reported.contains("udp is not built in"), "{reported}");
    let reported = text(at("tls/10.0.0.1:7447"));
    let refused = "write quic/ in its place";
    assert!(
        reported.starts_with("tls/10.0.0.1:7447: ") && reported.contains(refused),
        "{reported}"
    );
    for endpoints in [r#"["tls/10.0.0.1:7447"]"#, r#"{ client: ["tls/10.0.0.1:7447"] }"#] {
        fs::write(&file, format!("{{ connect: {{ endpoints: {endpoints} }} }}")).unwrap();
        let reported = text(Network { router: None, file: Some(file.clone()) });
        assert!(reported.contains(refused), "{reported}");
    }
    // A router that listens, or that goes on to another one, so.
    for (kind, router) in [("listen", None), ("connect", Some("tcp/127.0.0.1:0".to_owned()))] {
        fs::write(&file, format!("{{ {kind}: {{ endpoints: [\"tls/127.0.0.1:1\"] }} }}")).unwrap();
        let Err(error) = net::router(&Network { router, file: Some(file.clone()) }) else {
            panic!("a router that speaks TLS")
        };
        assert!(error.to_string().contains(refused), "{error}");
    }
    let router = endpoint();
    let network = at(&router);
    let Err(error @ NetError::NoRouter { .. }) = network.open() else { panic!("{network:?}") };
    let reported = error.to_string();
    assert!(reported.starts_with(&format!("no router answers at {router}: ")), "{reported}");
    assert!(!reported.contains(".rs") && !reported.contains("Single"), "{reported}");
    let _router = net::router(&network).unwrap();
    let Err(error @ NetError::Listen { .. }) = net::router(&network) else { panic!("{network:?}") };
    let reported = error.to_string();
    assert!(reported.starts_with(&format!("a router cannot listen at {router}: ")), "{reported}");
    assert!(!reported.contains(".rs") && !reported.contains("expected an endpoint"), "{reported}");
    assert!(reported.contains("in use") && !reported.contains('['), "{reported}");
}

/// A stranger under one of our names.
#[test]
fn a_message_that_is_much_too_large_reaches_nobody_and_costs_no_event() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _router = router(&endpoint);
    let mut daemons = [Daemon::start(folder.path(), &network, 1, 1)];
    let mut receivers = [Receiver::new(&network, Since::Start)];
    daemons[0].report();
    settle(&mut daemons, &mut receivers);
    let mut other = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"client\"".to_owned()),
        ("scouting/multicast/enabled", "false".to_owned()),
        ("connect/endpoints", format!("[{endpoint:?}]")),
    ] {
        other.insert_json5(key, &value).unwrap();
    }
    let stranger = zenoh::open(other).wait().unwrap();
    let key = daemons[0].member.key(Part::Health);
    for len in [6 << 20, 600] {
        // A busy machine would drop the second behind the first.
        let put = stranger.put(&key, vec![7_u8; len]);
        put.congestion_control(CongestionControl::Block).wait().unwrap();
    }
    // What fits is reported as something that cannot be read.
    let mut unreadable = 0;
    for _ in 0..MOST {
        let reported = receivers[0].watch.next(STEP).unwrap();
        unreadable += usize::from(matches!(reported, Some(Reported::Unreadable { .. })));
        if unreadable > 0 {
            break;
        }
    }
    assert_eq!(unreadable, 1, "the large one would have come before");
    assert!((0..100).all(|_| receivers[0].watch.next(STEP).unwrap().is_none()));
    daemons[0].report();
    settle(&mut daemons, &mut receivers);
}
