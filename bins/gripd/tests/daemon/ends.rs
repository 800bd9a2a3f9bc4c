//! A sensor on one line and a gripper on another, both boards that speak the link.

use crate::running::gripd;
use core::sync::atomic::{AtomicU64, Ordering};
use grip_sim::port::Simulator;
use std::sync::Arc;
use stories::until;

/// A simulated board whose clock runs `ppm` fast.
#[expect(clippy::disallowed_methods, reason = "a board lives in real time")]
fn board(ppm: u64) -> (Simulator, Arc<AtomicU64>) {
    let (begin, seen) = (std::time::Instant::now(), Arc::new(AtomicU64::new(0)));
    let shown = Arc::clone(&seen);
    let clock = move || {
        let us = u64::try_from(begin.elapsed().as_micros()).unwrap();
        let now = us + us * ppm / 1_000_000;
        shown.store(now, Ordering::Relaxed);
        now
    };
    (Simulator::at("sim", Some(1), clock).unwrap().unwrap(), seen)
}

#[test]
fn the_board_on_the_other_line_grips_and_that_of_the_sensor_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let ((sensor, _), (gripper, alive)) = (board(0), board(500));
    assert!(until(|| alive.load(Ordering::Relaxed) > 0));
    let args = [
        "--sensor",
        sensor.port(),
        "--gripper",
        gripper.port(),
        "--listen",
        "off",
        "--json",
        "--duration",
        "3",
    ];
    let ran = gripd(folder.path(), &args).done();
    let summary = ran.lines().pop().unwrap();
    assert!(summary["commands"].as_u64().unwrap() > 100, "{summary} {}", ran.err);
    assert!(summary["rows"]["taken"].as_u64().unwrap() > 4000, "{summary}");
    assert_eq!((&summary["rows"]["bad"], &summary["rows"]["late"]), (&0.into(), &0.into()));
    // The sensor feels nothing of the object, which falls at the lift: the fault of its gripper is reported, and rows are missing.
    assert!(ran.err.contains("fault 0x0201; nothing is commanded"), "{}", ran.err);
    assert!(summary["rows"]["missing"].as_u64().unwrap() > 4000, "{summary}");
    for (end, words) in [("sensor on", sensor.port()), ("gripper on", gripper.port())] {
        assert!(ran.err.contains(&format!("{end} {words}: found")), "{}", ran.err);
    }
    let (sensor, gripper) = (sensor.stop().unwrap(), gripper.stop().unwrap());
    assert!(gripper.force_peak_n > 0.1, "{gripper:?}");
    assert!(sensor.force_peak_n <= 0.0, "{sensor:?}");
}

#[test]
fn what_cannot_be_two_ends_is_refused_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &[&str]); 5] = [
        (&["--sensor", "sim", "--gripper", "/dev/null"], &["--sensor sim", "leave --gripper out"]),
        (&["--sensor", "rows:-", "--gripper", "sim"], &["--gripper sim", "--port"]),
        (&["--sensor", "tsf85:x,finger=9"], &["finger=0 to finger=3"]),
        (&["--sensor", "rows:-", "--gripper", "robotiq:3f:x"], &["2f-85, 2f-140 or hand-e"]),
        (&["--sensor", "rows:-", "--gripper", "robotiq:2f-85:x,open"], &["is no setting"]),
    ];
    for (args, words) in cases {
        gripd(folder.path(), args).refused(2, words);
    }
    let absent = ["--sensor", "tsf85:/nowhere/tty", "--listen", "off"];
    gripd(folder.path(), &absent).refused(1, &["TSF-85 on /nowhere/tty", "no such port"]);
}
