//! gripfleet beside a router in the test: whoever watches the fleet gets each slip once, whatever becomes of router, daemon and gripfleet.

use crate::{
    pair::{Pair, configure, gripfleet},
    rig::{endpoint, patient, router},
};
use core::time::Duration;
use grip_fleet::{
    About, EventId, Member, Part, Selector, Since,
    net::{Ask, NetError, Network, Reported, Session, Watch, ask, list},
    recordings::{Piece, Recording},
};
use grip_link::message::daemon::{Command, NoticeKind, Operation, ToClient};
use std::{collections::HashSet, fs, path::Path};
use stories::{Program, until};

/// Looks of 20 ms.
const LOOK: Duration = Duration::from_millis(20);

/// A router's address, and a folder with a configuration that names it.
fn place(folder: &Path) -> (String, Network) {
    let router = endpoint();
    configure(folder, &router, "", "network = \"zenoh.json5\"\nspool = \"spool\"");
    let network = patient(folder, &router);
    (router, network)
}

/// Slips as they came: the number of each event and that of the slip in it.
fn slips(watch: &mut Watch, into: &mut Vec<(EventId, u32)>) {
    while let Some(reported) = watch.next(LOOK).unwrap() {
        let Reported::Event { id, message, missing, .. } = reported else { continue };
        assert_eq!(missing, 0, "{id}");
        if let Ok(ToClient::Slip(slip)) = message.read() {
            into.push((id, slip.number));
        }
    }
}

/// Lines about slips that were printed.
fn printed(gripd: &Program) -> usize {
    gripd.printed().lines().filter(|line| line.contains("\"type\":\"slip")).count()
}

#[test]
fn every_slip_is_reported_once_though_router_daemon_and_gripfleet_end() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, network) = place(folder.path());
    let here = router(&endpoint);
    let Pair { gripd: first, fleet } = Pair::holding(folder.path(), &[]);
    fleet.until_reported("this gripper is there as hall/");
    let session = network.open().unwrap();
    let mut watch = Watch::new(session, &Selector::default(), Since::Start, &[]).unwrap();
    let mut got = Vec::new();
    assert!(until(|| {
        slips(&mut watch, &mut got);
        got.len() >= printed(&first)
    }));
    drop(here);
    let before = printed(&first);
    // Killed without a goodbye, while gripfleet stays.
    first.kill();
    fleet.until_reported("gripd has closed the connection");
    let _router = router(&endpoint);
    let second = Pair::holding_beside(folder.path(), fleet);
    let reported = || second.fleet.reported();
    assert!(
        until(|| {
            slips(&mut watch, &mut got);
            got.len() >= before + printed(&second.gripd)
        }),
        "{}",
        reported()
    );
    // Another gripfleet goes on with the same spool, and shows nothing twice.
    let Pair { gripd, fleet } = second;
    fleet.kill();
    let fleet = gripfleet(folder.path(), &[]);
    fleet.until_reported("this gripper is there as hall/");
    slips(&mut watch, &mut got);
    Pair { gripd, fleet }.stop();
    let ids: HashSet<EventId> = got.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids.len(), got.len(), "one came twice");
    for numbers in got.chunk_by(|a, b| a.0.run == b.0.run).take(2) {
        let numbers: Vec<u32> = numbers.iter().map(|(_, number)| *number).collect();
        let wanted: Vec<u32> = (1..).take(numbers.len()).collect();
        assert_eq!(numbers, wanted);
    }
}

/// The only gripper, as soon as it is there.
fn member(watch: &mut Watch) -> Member {
    let mut member = None;
    assert!(until(|| {
        if let Some(Reported::Came(came)) = watch.next(LOOK).unwrap() {
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
    for (above, below) in [("allow_commands = true", ""), ("", "commands = true")] {
        configure(folder.path(), &endpoint, above, below);
        let selector = Selector::default();
        let mut watch = Watch::new(session.clone(), &selector, Since::Now, &[]).unwrap();
        let running = Pair::start(folder.path(), &[]);
        let member = member(&mut watch);
        let refused = command(&session, &member, &grasp).unwrap_err();
        assert!(refused.contains("allow_commands and fleet.commands"), "{refused}");
        running.stop();
    }
    configure(folder.path(), &endpoint, "allow_commands = true", "commands = true");
    let mut watch = Watch::new(session.clone(), &Selector::default(), Since::Now, &[]).unwrap();
    let running = Pair::holding(folder.path(), &[]);
    let member = member(&mut watch);
    let mut about = About::default();
    assert!(until(|| {
        let text = asked(&session, &member, Part::About, &[]).unwrap();
        about = serde_json::from_str(&text).unwrap_or_default();
        about.firmware.is_some()
    }));
    assert!(about.program.starts_with("gripd ") && about.model.is_some(), "{about:?}");
    // The token is for those who may ask for commands, and only they reach this name.
    let about = asked(&session, &member, Part::About, &[]).unwrap();
    assert!(!about.contains("token"), "{about}");
    let token: u32 = asked(&session, &member, Part::Command, &[]).unwrap().parse().unwrap();
    assert_eq!(command(&session, &member, &grasp).as_deref(), Ok("taken"));
    let refused = command(&session, &member, &Command { force_mn: 1_000_000_000, ..grasp });
    let words = "1000000 N is more than the ";
    assert!(refused.as_ref().is_err_and(|reason| reason.starts_with(words)), "{refused:?}");
    let release = Command { token: token ^ 1, ..Command::new(Operation::Release) };
    let refused = command(&session, &member, &release).unwrap_err();
    assert!(refused.contains("token"), "{refused}");
    assert_eq!(
        asked(&session, &member, Part::Command, b"open!").unwrap_err(),
        "this is no command"
    );
    let release = Command { token, ..release };
    assert_eq!(command(&session, &member, &release).as_deref(), Ok("taken"));
    let mut reported = Vec::new();
    assert!(until(|| {
        if let Some(Reported::Event { message, .. }) = watch.next(LOOK).unwrap()
            && let Ok(ToClient::Notice(notice)) = message.read()
            && notice.kind == NoticeKind::Client
        {
            reported.push(notice.as_str().to_owned());
        }
        reported.len() >= 2
    }));
    assert!(reported[0].contains("5.00 N") && reported[1].contains("release"), "{reported:?}");
    running.stop();
}

/// What this gripper answers, when it is asked for its recordings with these words.
fn lent(
    session: &Session,
    member: &Member,
    parameters: &[(&str, String)],
) -> Result<Vec<Vec<u8>>, NetError> {
    let (part, patience) = (Part::Recordings, Duration::from_secs(20));
    ask(session, &Ask { member, part, parameters, payload: &[], patience })
}

fn shelf(session: &Session, member: &Member) -> Vec<Recording> {
    let parts = lent(session, member, &[]).unwrap();
    parts.iter().flat_map(|part| serde_json::from_slice::<Vec<Recording>>(part).unwrap()).collect()
}

#[test]
fn finished_recordings_are_given_away_where_that_is_allowed_and_nothing_else_is() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, network) = place(folder.path());
    let _router = router(&endpoint);
    let run = folder.path().join("run.mcap");
    let record = format!("record = {run:?}");
    configure(folder.path(), &endpoint, &record, "");
    let there = |running: &Pair| {
        running.fleet.until_reported("this gripper is there as hall/");
        let session = network.open().unwrap();
        let member = list(&session, &Selector::default()).unwrap().into_keys().next().unwrap();
        (session, member)
    };
    let first = Pair::holding(folder.path(), &[]);
    let (session, member) = there(&first);
    let refused = lent(&session, &member, &[]).unwrap_err().to_string();
    assert!(refused.contains("recordings are not given away here"), "{refused}");
    first.stop();

    configure(folder.path(), &endpoint, &record, "recordings = true");
    let second = Pair::holding(folder.path(), &[]);
    let (session, member) = there(&second);
    let mut reported = Vec::new();
    assert!(until(|| {
        reported = shelf(&session, &member);
        reported.len() == 2
    }));
    let state: Vec<(&str, bool)> = reported.iter().map(|one| (&*one.name, one.growing)).collect();
    assert_eq!(state, [("run-0001.mcap", true), ("run.mcap", false)]);
    let words =
        [("name", "spool"), ("from", "0"), ("bytes", "9"), ("size", "9"), ("modified", "0")]
            .map(|(name, value)| (name, value.to_owned()));
    let refused = lent(&session, &member, &words).unwrap_err().to_string();
    assert!(refused.ends_with("no recording of that name"), "{refused}");
    let words = reported[1].question(0, 8);
    let piece = lent(&session, &member, &words).unwrap().concat();
    assert_eq!(Piece::read(&piece).unwrap().bytes, &fs::read(&run).unwrap()[..8]);
    second.stop();
}

#[test]
fn who_waits_for_the_spool_of_another_is_there_when_that_one_has_ended() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (endpoint, _) = place(one.path());
    let spool = format!("spool = {:?}", one.path().join("spool"));
    configure(two.path(), &endpoint, "", &spool);
    let _router = router(&endpoint);
    let first = Pair::start(one.path(), &[]);
    first.fleet.until_reported("this gripper is there as hall/");
    let second = Pair::start(two.path(), &[]);
    second.fleet.until_reported("is not published until that one ends");
    first.stop();
    second.fleet.until_reported("this gripper is there as hall/");
    second.stop();
}
