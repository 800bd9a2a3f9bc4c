//! `gripctl sim`: a gripper on a pseudo-terminal that any host can grip with.

use core::time::Duration;
use grip_link::{
    frame::MAX_WIRE,
    host::{HostEvent, LinkState},
};
use grip_session::{HostConfig, Session, SessionOptions, Update, model};
use std::{
    io::{BufRead as _, BufReader, ErrorKind, Read as _, Write as _},
    path::Path,
    process::{Child, Command, Stdio},
    time::Instant,
};

/// Grips what is at `port` for `seconds`, as a daemon does.
#[expect(clippy::disallowed_methods, reason = "a host in real time has a clock")]
fn grip(port: &Path, seconds: f64) -> Session {
    let mut line = serialport::new(port.display().to_string(), 2_000_000)
        .timeout(Duration::from_millis(2))
        .open()
        .unwrap();
    let estimator = model::default_estimator().unwrap();
    let mut session =
        Session::new(HostConfig::default(), estimator, SessionOptions::default()).unwrap();
    let start = Instant::now();
    let now_us = || u64::try_from(start.elapsed().as_micros()).unwrap();
    session.open(now_us(), 77).unwrap();
    let (mut input, mut out) = ([0; 4096], [0; MAX_WIRE]);
    while start.elapsed().as_secs_f64() < seconds {
        while let Some(len) = session.poll_transmit(now_us(), &mut out) {
            line.write_all(&out[..len]).unwrap();
        }
        let count = match line.read(&mut input) {
            Ok(count) => count,
            Err(error) if [ErrorKind::TimedOut, ErrorKind::Interrupted].contains(&error.kind()) => {
                0
            }
            Err(error) => panic!("{error}"),
        };
        let (now, mut left) = (now_us(), &input[..count]);
        while let Some(updates) = session.receive(now, &mut left).unwrap() {
            if let Update::Link(HostEvent::Closed(reason)) = updates {
                panic!("{reason:?}");
            }
        }
        if let Some(len) = session.command(now, &mut out) {
            line.write_all(&out[..len]).unwrap();
        }
    }
    session
}

/// The simulator, asked to leave when a test fails.
struct Simulator(Child);

impl Drop for Simulator {
    fn drop(&mut self) {
        drop(self.0.kill());
    }
}

/// Starts the simulator, grips for two seconds and stops it as Ctrl-C does; gives what it said at the end.
fn simulate(folder: &Path) -> (Session, String) {
    let link = folder.join("gripper");
    let child = Command::new(env!("CARGO_BIN_EXE_gripctl"))
        .args(["sim", "--scene", "light_rough", "--pty", "gripper", "--duration", "60"])
        .current_dir(folder)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut simulator = Simulator(child);
    let mut err = BufReader::new(simulator.0.stderr.take().unwrap());
    let mut first = String::new();
    err.read_line(&mut first).unwrap();
    assert!(first.contains("light_rough") && first.contains("gripd --port gripper"), "{first}");
    let session = grip(&link, 2.5);
    let kill =
        Command::new("kill").args(["-TERM", &simulator.0.id().to_string()]).status().unwrap();
    assert!(kill.success() && simulator.0.wait().unwrap().success());
    assert!(link.symlink_metadata().is_err(), "the link is gone");
    let mut last = String::new();
    err.read_to_string(&mut last).unwrap();
    assert!(!last.contains("panicked"), "{last}");
    (session, last)
}

/// A machine that stops host or simulator for longer than the object takes to fall drops it: it may try again.
#[test]
fn a_host_holds_the_object_over_the_pseudo_terminal() {
    for _ in 0..3 {
        let folder = tempfile::tempdir().unwrap();
        let (session, last) = simulate(folder.path());
        let ident = session.link().ident().unwrap();
        assert_eq!(ident.versions.max, grip_link::PROTOCOL);
        assert!([LinkState::Stream, LinkState::Degraded].contains(&session.link().state()));
        assert!(session.counters().samples > 1000, "{:?}", session.counters());
        assert!(session.counters().commands > 10, "{:?}", session.counters());
        // "gripctl: force 4.31 N of 4.02 N needed, slipped 1.23 mm"
        let figures: Vec<f64> =
            last.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [force, needed, slipped] = figures[..] else { panic!("{last}") };
        if force > needed && slipped > 0.0 && !last.contains("dropped") {
            return;
        }
        eprintln!("not held: {last}");
    }
    panic!("the object was not held in three runs");
}

#[test]
fn the_time_it_lives_can_be_limited() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["sim", "--pty", "p", "--duration", "0.2", "--seed", "3"];
    let ran = crate::run::gripctl(folder.path(), &args).done();
    assert!(
        ran.err.contains("force 0.00 N") && folder.path().join("p").symlink_metadata().is_err(),
        "{ran:?}"
    );
}
