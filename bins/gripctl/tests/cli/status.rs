//! `gripctl status` at a daemon's socket, at somebody else's, and at none.

use crate::daemon::{Daemon, listening};
use crate::run::gripctl;
use grip_daemon::clients::Listen;
use grip_daemon::{Item, LinkNote};
use grip_link::host::LinkState;
use grip_link::message::Firmware;
use grip_link::message::daemon::Health;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::path::Path;
use std::thread;

fn here() -> &'static Path {
    Path::new(".")
}

/// A daemon whose gripper was identified.
fn served() -> (Daemon, Listen) {
    let mut clients = listening("tcp:127.0.0.1:0", 3, 0.02);
    let place = clients.place().unwrap();
    let firmware = Firmware { major: 1, minor: 2, patch: 3 };
    let (uid, boot_id, rebooted) = ([0xAB; 16], 7, false);
    let note = LinkNote::Identified { uid, boot_id, firmware, rebooted };
    clients.take(&Item::Link { host_us: 1, note: &note });
    clients.take(&Item::Link { host_us: 1, note: &LinkNote::State(LinkState::Stream) });
    clients.health(&Health { samples: 1234, ..Health::default() });
    (Daemon::start(clients, |_, _| {}), place)
}

#[test]
fn a_daemon_is_described_for_people_and_for_machines() {
    let (_daemon, place) = served();
    let place = place.to_string();
    let reported = gripctl(here(), format!("status {place}")).done().out;
    for word in [
        "gripd 9.9.9",
        "read only for clients",
        "abababab",
        "link stream",
        "1234",
        "4.50 N",
        "20.0 ms",
    ] {
        assert!(reported.contains(word), "no {word:?} in {reported}");
    }
    let json = gripctl(here(), format!("status {place} --json")).done().json();
    assert_eq!((json.len(), &json[0]["daemon"]), (1, &"gripd 9.9.9".into()));
    assert_eq!(json[0]["health"]["samples"], 1234);
    assert_eq!(json[0]["gripper"]["uid"], "ab".repeat(16));
    assert_eq!((&json[0]["events"][0]["type"], &json[0]["state"]), (&"slip".into(), &().into()));
}

#[test]
fn nobody_there_is_reported_in_a_sentence() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let place = format!("tcp:127.0.0.1:{port}");
    gripctl(here(), format!("status {place}")).refused(1, &["no daemon answers at tcp:127.0.0.1"]);
}

/// What `gripctl status` states of a program that sends `answer` after the first bytes that come.
fn of_another_program(answer: &'static [u8]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = format!("tcp:{}", listener.local_addr().unwrap());
    let other = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut bytes = [0; 100];
        let _greeting = stream.read(&mut bytes).unwrap();
        stream.write_all(answer).unwrap();
        while stream.read(&mut bytes).is_ok_and(|count| count > 0) {}
    });
    let reported = gripctl(here(), format!("status {place}")).refused(1, &[]).err;
    other.join().unwrap();
    reported
}

#[test]
fn another_program_at_the_port_is_recognised() {
    assert!(of_another_program(b"SSH-2.0-x\r\n\0\0").contains("no frames"));
    assert!(of_another_program(b"").contains("no answer of a gripd"));
}
