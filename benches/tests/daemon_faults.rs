//! A few faults of each kind on a real gripd: no promise is broken. The program `daemon-faults` does the same with full counts.
#![expect(clippy::unwrap_used, reason = "test code")]

use slip_benches::daemon_faults::{Counts, Setup, names, run};
use std::{
    path::PathBuf,
    sync::{LazyLock, Mutex, PoisonError},
};
use stories::Build;

/// gripd of this build: only its own package's tests can name it.
static GRIPD: LazyLock<PathBuf> =
    LazyLock::new(|| Build::beside_tests(&["daemon"]).programs().unwrap()["gripd"].clone());

/// Times are loose here: other tests run beside.
const SLACK_MS: u64 = 500;

/// A gripper at 10 kHz lives in real time: several of them at once would be too much for two processors.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn check(name: &str, least_commands: u64) {
    // One that failed shows nothing of the others.
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let setup = Setup { gripd: &GRIPD, seed: 2, slack_ms: SLACK_MS };
    let outcome = run(name, &setup, Counts::QUICK).unwrap();
    assert!(outcome.broken == 0 && outcome.violations.is_empty(), "{outcome:#?}");
    assert!(outcome.times > 0 && outcome.recordings > 0, "{outcome:#?}");
    assert!(outcome.commands > least_commands, "{outcome:#?}");
}

macro_rules! kinds {
    ($($test:ident $name:literal;)*) => {
        $(#[test] fn $test() { check($name, 100); })*

        #[test]
        fn every_kind_is_tested() {
            assert_eq!(names().collect::<Vec<_>>(), [$($name),*]);
        }
    };
}

kinds! {
    killed "kill -9";
    unplugged "unplug, replug";
    exchanged "another gripper at the port";
    beset_by_clients "clients";
    reported_to_release "release by a client";
    out_of_disk "disk full";
    rebooted "reboot of the gripper";
    without_a_stylus "stylus broken, stuck";
    disturbed_and_paused "noise, SIGSTOP";
    failing_in_slips "faults in slips";
    reloaded "SIGHUP";
}
