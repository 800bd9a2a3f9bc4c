//! gripd in a folder: run to its end, or while a test talks to it.

use core::time::Duration;
use grip_daemon::client::Client;
use grip_link::message::{
    Versions,
    daemon::{Subscribe, ToClient, Topics},
};
use std::{fs, path::Path, process::Command};
use stories::{Ended, Program, until};

/// Looks of 20 ms after which a message has not come.
const LOOKS: u32 = 3000;
/// Runs of which one must hold its object.
const TRIES: u32 = 5;

/// What the subscriber receives: everything but rows.
pub(crate) const UPDATES: Subscribe =
    Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 0, state_ms: 100 };

pub(crate) fn command(folder: &Path, args: &[&str]) -> Command {
    stories::command(env!("CARGO_BIN_EXE_gripd"), folder, args)
}

/// Runs gripd in `folder` to its end.
pub(crate) fn gripd(folder: &Path, args: &[&str]) -> Ended {
    Program::of(command(folder, args)).ended()
}

fn socket(folder: &Path) -> String {
    format!("unix:{}", folder.join("gripd.sock").display())
}

/// Starts gripd, on the default scene where `args` name no port, with its socket at `gripd.sock` in its folder.
pub(crate) fn serving(folder: &Path, args: &[&str]) -> Program {
    let port = if args.contains(&"--port") { &[][..] } else { &["--port", "sim"] };
    let socket = socket(folder);
    Program::of(command(folder, &[port, &["--json", "--listen", &socket], args].concat()))
}

/// One that has had a slip and holds the object. A machine that stops it for longer than the object takes to fall drops it: it may
/// begin again, without a recording of what was dropped.
pub(crate) fn holding(folder: &Path, args: &[&str]) -> Program {
    for _ in 0..TRIES {
        let running = serving(folder, args);
        let held = || running.printed().contains("\"slip_end\"");
        let fallen = || running.reported().contains("the object is gone");
        assert!(until(|| held() || fallen()), "{}", running.reported());
        if !fallen() {
            return running;
        }
        eprintln!("not held: {}", running.interrupted().err);
        for recording in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if recording.extension().is_some_and(|extension| extension == "mcap") {
                fs::remove_file(recording).unwrap();
            }
        }
    }
    panic!("the object was not held in {TRIES} runs");
}

/// A client of the gripd in `folder` that wants `wanted`, once it is there.
pub(crate) fn client(folder: &Path, nonce: u16, wanted: Subscribe) -> Client {
    let place = socket(folder).parse().unwrap();
    let mut client = None;
    let connected = until(|| {
        client = Client::connect(&place, nonce, wanted, Duration::from_secs(5)).ok();
        client.is_some()
    });
    assert!(connected, "no gripd at {place}");
    client.unwrap()
}

/// Receives messages until `done`, which sees each.
#[track_caller]
pub(crate) fn receive(client: &mut Client, mut done: impl FnMut(&ToClient<'_>) -> bool) {
    let mut over = false;
    for _ in 0..LOOKS {
        client.wait(Duration::from_millis(20), &mut |message| over |= done(message)).unwrap();
        if over {
            return;
        }
    }
    panic!("what was waited for was not heard");
}
