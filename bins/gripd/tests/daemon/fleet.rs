//! gripd beside a router in the test: whoever watches the fleet gets each slip once, whatever becomes of router and daemon.

use crate::running::{Running, until};
use core::time::Duration;
use grip_fleet::{
    About, EventId, Member, Part, Selector, Since,
    net::{self, Ask, NetError, Network, Session, Told, Watch, ask, list},
    recordings::{FetchError, Fetched, Recording, fetch},
};
use grip_link::message::daemon::{Command, NoticeKind, Operation, ToClient};
use std::{collections::HashSet, fs, net::TcpListener, path::Path};

/// Looks of 20 ms.
const LOOK: Duration = Duration::from_millis(20);

/// A router's address, and a folder with a configuration that names it.
fn place(folder: &Path) -> (String, Network) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let router = format!("tcp/127.0.0.1:{port}");
    let retry = "{ connect: { retry: { period_init_ms: 200, period_max_ms: 200 } } }";
    let file = folder.join("zenoh.json5");
    fs::write(&file, retry).unwrap();
    let text = format!(
        "[fleet]\nsite = \"hall\"\nrouter = \"{router}\"\nnetwork = \"zenoh.json5\"\nspool = \"spool\"\n"
    );
    fs::write(folder.join("gripd.toml"), text).unwrap();
    (router.clone(), Network { router: Some(router), file: Some(file) })
}

fn router(endpoint: &str) -> Session {
    net::router(&Network { router: Some(endpoint.to_owned()), file: None }).unwrap()
}

/// Slips as they came: the number of each event and that of the slip in it.
fn slips(watch: &mut Watch, into: &mut Vec<(EventId, u32)>) {
    while let Some(told) = watch.next(LOOK).unwrap() {
        let Told::Event { id, message, missing, .. } = told else { continue };
        assert_eq!(missing, 0, "{id}");
        if let Ok(ToClient::Slip(slip)) = message.read() {
            into.push((id, slip.number));
        }
    }
}

/// Lines about slips that were printed.
fn printed(running: &Running) -> usize {
    running.printed().lines().filter(|line| line.contains("\"type\":\"slip")).count()
}

#[test]
fn every_slip_is_told_once_though_router_and_daemon_end() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, network) = place(folder.path());
    let here = router(&endpoint);
    let first = Running::holding(folder.path(), &[]);
    first.wait_for("this gripper is there as hall/");
    let session = network.open().unwrap();
    let mut watch = Watch::new(session, &Selector::default(), Since::Start, &[]).unwrap();
    let mut got = Vec::new();
    assert!(until(|| {
        slips(&mut watch, &mut got);
        got.len() >= printed(&first)
    }));
    drop(here);
    let before = printed(&first);
    // Killed without a goodbye.
    drop(first);
    let _router = router(&endpoint);
    let second = Running::holding(folder.path(), &[]);
    let told = || second.told();
    assert!(
        until(|| {
            slips(&mut watch, &mut got);
            got.len() >= before + printed(&second)
        }),
        "{}",
        told()
    );
    second.stop();
    let ids: HashSet<EventId> = got.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids.len(), got.len(), "one came twice");
    for numbers in got.chunk_by(|a, b| a.0.run == b.0.run) {
        let numbers: Vec<u32> = numbers.iter().map(|(_, number)| *number).collect();
        let wanted: Vec<u32> = (1..).take(numbers.len()).collect();
        assert_eq!(numbers, wanted);
    }
}

/// The only gripper, as soon as it is there.
fn member(watch: &mut Watch) -> Member {
    let mut member = None;
    assert!(until(|| {
        if let Some(Told::Came(came)) = watch.next(LOOK).unwrap() {
            member = Some(came);
        }
        member.is_some()
    }));
    member.unwrap()
}

/// What the gripper answers: the first part of it, or the reason against it.
fn asked(session: &Session, member: &Member, part: Part, payload: &[u8]) -> Result<String, String> {
    let patience = Duration::from_secs(20);
    match ask(session, &Ask { member, part, parameters: &[], payload, patience }) {
        Ok(parts) => Ok(String::from_utf8(parts[0].clone()).unwrap()),
        Err(error) => Err(error.to_string().replace(&format!("{member}: "), "")),
    }
}

fn command(session: &Session, member: &Member, command: &Command) -> Result<String, String> {
    let mut payload = [0; Command::SIZE];
    command.write(&mut payload).unwrap();
    asked(session, member, Part::Command, &payload)
}

#[test]
fn the_fleet_may_command_only_where_both_keys_say_so_and_with_the_token() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, network) = place(folder.path());
    let _router = router(&endpoint);
    let session = network.open().unwrap();
    let grasp = Command { force_mn: 5000, ..Command::new(Operation::AtLeast) };
    let file = folder.path().join("gripd.toml");
    let text = fs::read_to_string(&file).unwrap();
    for (above, below) in [("allow_commands = true\n", ""), ("", "commands = true\n")] {
        fs::write(&file, format!("{above}{text}{below}")).unwrap();
        let selector = Selector::default();
        let mut watch = Watch::new(session.clone(), &selector, Since::Now, &[]).unwrap();
        let running = Running::start(folder.path(), &[]);
        let member = member(&mut watch);
        let refused = command(&session, &member, &grasp).unwrap_err();
        assert!(refused.contains("allow_commands and fleet.commands"), "{refused}");
        running.stop();
    }
    fs::write(&file, format!("allow_commands = true\n{text}commands = true\n")).unwrap();
    let mut watch = Watch::new(session.clone(), &Selector::default(), Since::Now, &[]).unwrap();
    let running = Running::holding(folder.path(), &[]);
    let member = member(&mut watch);
    let mut about = About::default();
    assert!(until(|| {
        let text = asked(&session, &member, Part::About, &[]).unwrap();
        about = About::from_json(text.as_bytes()).unwrap_or_default();
        about.firmware.is_some()
    }));
    assert!(about.program.starts_with("gripd ") && about.model.is_some(), "{about:?}");
    let token = about.token.unwrap();
    assert_eq!(command(&session, &member, &grasp).as_deref(), Ok("taken"));
    let release = Command { token: token ^ 1, ..Command::new(Operation::Release) };
    let refused = command(&session, &member, &release).unwrap_err();
    assert!(refused.contains("token"), "{refused}");
    assert_eq!(
        asked(&session, &member, Part::Command, b"open!").unwrap_err(),
        "this is no command"
    );
    let release = Command { token, ..release };
    assert_eq!(command(&session, &member, &release).as_deref(), Ok("taken"));
    let mut told = Vec::new();
    assert!(until(|| {
        if let Some(Told::Event { message, .. }) = watch.next(LOOK).unwrap()
            && let Ok(ToClient::Notice(notice)) = message.read()
            && notice.kind == NoticeKind::Client
        {
            told.push(notice.as_str().to_owned());
        }
        told.len() >= 2
    }));
    assert!(told[0].contains("5.00 N") && told[1].contains("release"), "{told:?}");
    running.stop();
}

/// What this gripper answers, when it is asked for its recordings with these words.
fn lent(
    session: &Session,
    member: &Member,
    parameters: &[(&str, &str)],
) -> Result<Vec<Vec<u8>>, NetError> {
    let (part, patience) = (Part::Recordings, Duration::from_secs(20));
    ask(session, &Ask { member, part, parameters, payload: &[], patience })
}

fn shelf(session: &Session, member: &Member) -> Vec<Recording> {
    let parts = lent(session, member, &[]).unwrap();
    parts.iter().flat_map(|part| serde_json::from_slice::<Vec<Recording>>(part).unwrap()).collect()
}

/// The bytes of one as `gripctl fleet collect` gets them.
fn fetched(
    (session, member): (&Session, &Member),
    recording: &Recording,
    folder: &Path,
) -> Result<Fetched, FetchError<NetError>> {
    fetch(recording, folder, &mut |from, bytes| {
        let question = recording.question(from, bytes);
        lent(session, member, &question.each_ref().map(|(name, value)| (*name, value.as_str())))
    })
}

#[test]
fn finished_recordings_are_given_away_where_that_is_allowed_and_nothing_else_is() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, network) = place(folder.path());
    let _router = router(&endpoint);
    let run = folder.path().join("run.mcap");
    let record = ["--record", run.to_str().unwrap()];
    let there = |running: &Running| {
        running.wait_for("this gripper is there as hall/");
        let session = network.open().unwrap();
        let member = list(&session, &Selector::default()).unwrap().into_keys().next().unwrap();
        (session, member)
    };
    let first = Running::holding(folder.path(), &record);
    let (session, member) = there(&first);
    let refused = lent(&session, &member, &[]).unwrap_err().to_string();
    assert!(refused.contains("recordings are not given away here"), "{refused}");
    first.stop();

    let config = folder.path().join("gripd.toml");
    let allowed = fs::read_to_string(&config).unwrap() + "recordings = true\n";
    fs::write(&config, allowed).unwrap();
    let second = Running::holding(folder.path(), &record);
    let (session, member) = there(&second);
    let mut told = Vec::new();
    assert!(until(|| {
        told = shelf(&session, &member);
        told.len() == 2
    }));
    let state: Vec<(&str, bool)> = told.iter().map(|one| (&*one.name, one.growing)).collect();
    assert_eq!(state, [("run-0001.mcap", true), ("run.mcap", false)]);
    for name in ["../../../../etc/passwd", "/etc/passwd", "gripd.toml", "spool", "..", "other.mcap"]
    {
        let words =
            [("name", name), ("from", "0"), ("bytes", "9"), ("size", "9"), ("modified", "0")];
        let refused = lent(&session, &member, &words).unwrap_err().to_string();
        assert!(refused.ends_with("no recording of that name"), "{name}: {refused}");
    }
    let here = tempfile::tempdir().unwrap();
    let growing = fetched((&session, &member), &told[0], here.path());
    assert!(matches!(growing, Err(FetchError::Growing(_))), "{growing:?}");
    fetched((&session, &member), &told[1], here.path()).unwrap();
    assert_eq!(fs::read(here.path().join("run.mcap")).unwrap(), fs::read(&run).unwrap());
    let changed = Recording { modified_ns: 1, name: "run.mcap".to_owned(), ..told[1].clone() };
    fs::remove_file(here.path().join("run.mcap")).unwrap();
    let refused = fetched((&session, &member), &changed, here.path()).unwrap_err().to_string();
    assert!(refused.ends_with("the recording has changed"), "{refused}");
    second.stop();
}

#[test]
fn who_waits_for_the_spool_of_another_is_there_when_that_one_has_ended() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (endpoint, _) = place(one.path());
    fs::copy(one.path().join("zenoh.json5"), two.path().join("zenoh.json5")).unwrap();
    let text = fs::read_to_string(one.path().join("gripd.toml")).unwrap();
    let spool = format!("spool = {:?}", one.path().join("spool"));
    fs::write(two.path().join("gripd.toml"), text.replace("spool = \"spool\"", &spool)).unwrap();
    let _router = router(&endpoint);
    let first = Running::start(one.path(), &[]);
    first.wait_for("this gripper is there as hall/");
    let second = Running::start(two.path(), &[]);
    second.wait_for("is told to nobody until that one ends");
    first.stop();
    second.wait_for("this gripper is there as hall/");
    second.stop();
}
