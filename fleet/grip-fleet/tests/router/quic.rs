//! The example of a router with QUIC and access control, on loopback with keys made now: each does what it is there for and nothing else.

use super::{ROOM, rig::Played};
use core::time::Duration;
use grip_fleet::{
    EventId, EventLog, Member, Part, Selector, Since,
    net::{self, Ask, NetError, Network, Reported, Session, Watch, ask},
};
use std::{
    env, fs,
    io::ErrorKind,
    net::UdpSocket,
    path::{Path, PathBuf},
    process::Command,
};

const PATIENCE: Duration = Duration::from_secs(5);
/// Looks of 20 ms before a test gives up.
const MOST: usize = 1500;
const LOOK: Duration = Duration::from_millis(20);

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// Keys for everybody in the example; `false`, and reported, where there is no openssl.
fn keys(folder: &Path) -> bool {
    match Command::new("openssl").arg("version").output() {
        Err(error) if error.kind() == ErrorKind::NotFound && env::var_os("CI").is_none() => {
            eprintln!("SKIPPED: no openssl to make keys with");
            return false;
        }
        found => assert!(found.unwrap().status.success()),
    }
    let mut script = Command::new("sh");
    script.arg(examples().join("certificates.sh")).arg(folder);
    script.args(["localhost", "127.0.0.1", "gripper-1", "gripper-2", "viewer", "operator"]);
    let made = script.output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    true
}

/// A file of the example, with its keys in `folder`.
fn example(name: &str, folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    let mut text = fs::read_to_string(examples().join(name)).unwrap();
    let keys = folder.to_str().unwrap();
    for (from, to) in [("/etc/grip/keys", keys)].iter().chain(changes) {
        assert!(text.contains(from), "no {from} in {name}");
        text = text.replace(from, to);
    }
    let file = folder.join(format!("{}-{name}", changes.last().map_or("", |change| change.1)));
    fs::write(&file, text).unwrap();
    file
}

/// A router as in the example, and sessions of people with their names.
struct Place {
    folder: tempfile::TempDir,
    endpoint: String,
    _router: Session,
}

impl Place {
    fn new() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        if !keys(folder.path()) {
            return None;
        }
        let file = example("router.json5", folder.path(), &[]);
        // Between two uses of a free port a connection of the other test may take it.
        let routed = |_| {
            let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
            let endpoint = format!("quic/127.0.0.1:{port}");
            let network = Network { router: Some(endpoint.clone()), file: Some(file.clone()) };
            net::router(&network).map(|router| (endpoint, router))
        };
        let (endpoint, router) = (0..5).map(routed).find(|tried| tried.is_ok()).unwrap().unwrap();
        Some(Self { endpoint, _router: router, folder })
    }

    fn network(&self, name: &str) -> Network {
        let file = example("client.json5", self.folder.path(), &[("gripper-1", name)]);
        Network { router: Some(self.endpoint.clone()), file: Some(file) }
    }

    fn session(&self, name: &str) -> Session {
        self.network(name).open().unwrap()
    }
}

fn member(uid: &str) -> Member {
    format!("hall-2/{uid}").parse().unwrap()
}

const ONE: &str = "00112233445566778899aabbccddeeff";
const TWO: &str = "ffeeddccbbaa99887766554433221100";

/// Reports `about`, takes commands, and publishes an event a turn.
fn play(session: &Session, member: &Member) -> Played {
    let log = EventLog::new(1, ROOM);
    let parts = [Part::About, Part::Command];
    Played::new(session.clone(), member, &parts, move |announced| {
        announced.publish(Part::Events, EventId::default(), &[0, 1, 1, 0]);
        announced.answer(&|use_it| use_it(&log), &[[0; 0]; 0], "");
        while let Some(question) = announced.question() {
            question.reply(question.part().name().as_bytes()).unwrap();
        }
    })
}

fn asked(session: &Session, member: &Member, part: Part) -> Result<String, NetError> {
    let question = Ask { member, part, parameters: &[], payload: b"", patience: PATIENCE };
    let parts = ask(session, &question)?;
    Ok(String::from_utf8(parts[0].clone()).unwrap())
}

/// Whose publications come within the patience; that bytes cannot be read does not matter here.
fn received(session: Session) -> Vec<String> {
    let mut watch = Watch::new(session, &Selector::default(), Since::Now, &[]).unwrap();
    let mut names = Vec::new();
    for _ in 0..MOST / 10 {
        match watch.next(LOOK).unwrap() {
            Some(Reported::Came(member)) => names.push(format!("came {member}")),
            Some(Reported::Unreadable { key }) => names.push(key),
            _ => {}
        }
    }
    names.sort();
    names.dedup();
    names
}

#[test]
fn each_does_what_it_is_there_for_and_nothing_else() {
    let Some(place) = Place::new() else { return };
    let (one, two) = (member(ONE), member(TWO));
    let [first, second] = ["gripper-1", "gripper-2"].map(|name| place.session(name));
    // It has the key of another gripper than the one it claims to be.
    let false_one = member("0000000000000000000000000000dead");
    let both = [play(&first, &one), play(&second, &false_one)];
    let viewer = place.session("viewer");
    let (came, key) = (format!("came {one}"), one.key(Part::Events));
    assert_eq!(received(viewer.clone()), [came, key]);
    assert_eq!(asked(&viewer, &one, Part::About).unwrap(), "about");
    let refused = asked(&viewer, &one, Part::Command).unwrap_err();
    assert!(matches!(refused, NetError::Silent { .. }), "{refused}");
    let operator = place.session("operator");
    assert_eq!(asked(&operator, &one, Part::Command).unwrap(), "command");
    // A gripper may not look at others.
    let refused = asked(&second, &one, Part::About).unwrap_err();
    assert!(matches!(refused, NetError::Silent { .. }), "{refused}");
    drop(both);
    // The second gripper under its own name.
    let _second = play(&second, &two);
    let answer = (0..10).find_map(|_| asked(&operator, &two, Part::About).ok());
    assert_eq!(answer.as_deref(), Some("about"));
}

#[test]
fn nobody_comes_in_without_a_key_of_the_authority() {
    let Some(place) = Place::new() else { return };
    let refused = |network: &Network| match network.open() {
        Ok(_) => panic!("{network:?} came in"),
        Err(error) => error.to_string(),
    };
    // The port is UDP's: there is nobody to speak to without encryption.
    let plain = place.endpoint.replace("quic/", "tcp/");
    let text = refused(&Network { router: Some(plain.clone()), file: None });
    assert!(text.starts_with(&format!("no router answers at {plain}")), "{text}");
    // Encrypted, but nobody's key.
    let trust = format!(
        "{{ transport: {{ link: {{ tls: {{ root_ca_certificate: {:?} }} }} }} }}",
        place.folder.path().join("authority.pem")
    );
    let file = place.folder.path().join("stranger.json5");
    fs::write(&file, trust).unwrap();
    let text = refused(&Network { router: Some(place.endpoint.clone()), file: Some(file) });
    assert!(text.starts_with(&format!("no router answers at {}", place.endpoint)), "{text}");
    // A key of another authority.
    let other = tempfile::tempdir().unwrap();
    assert!(keys(other.path()));
    fs::copy(place.folder.path().join("authority.pem"), other.path().join("trusted.pem")).unwrap();
    let changes = [("authority.pem", "trusted.pem"), ("gripper-1", "viewer")];
    let file = example("client.json5", other.path(), &changes);
    let text = refused(&Network { router: Some(place.endpoint.clone()), file: Some(file) });
    assert!(text.starts_with(&format!("no router answers at {}", place.endpoint)), "{text}");
}
