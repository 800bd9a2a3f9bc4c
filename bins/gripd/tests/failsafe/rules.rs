//! One test a rule that a process can break.

use crate::daemon::{Daemon, Rig};
use grip_link::message::DeviceState;
use rustix::process::Signal;

fn gripping() -> (tempfile::TempDir, Rig, Daemon) {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = Rig::new();
    let daemon = Daemon::start(folder.path(), rig.pty.port());
    rig.until_gripped();
    (folder, rig, daemon)
}

/// After 50 ms nothing rises; nothing is ever let go.
fn held(forces: &[f64], before_n: f64) {
    let settled = &forces[60..];
    assert!(settled.windows(2).all(|pair| pair[1] <= pair[0]), "the force rose without a host");
    assert!(settled.iter().all(|n| *n > 0.9 * before_n), "{:?} of {before_n} N", settled.last());
}

#[test]
fn r2_kill_9_of_gripd_holds_the_object_and_the_next_one_takes_over() {
    let (folder, mut rig, daemon) = gripping();
    daemon.kill();
    rig.drain();
    let before_n = rig.force_n();
    held(&rig.alone(200), before_n);
    assert_eq!(rig.state(), DeviceState::Hold);
    held(&rig.alone(10_000), before_n);
    assert_eq!(rig.state(), DeviceState::LossAction);
    let next = Daemon::start(folder.path(), rig.pty.port());
    let mut least_n = rig.force_n();
    rig.until("the next gripd takes over", |mcu| {
        least_n = least_n.min(mcu.commanded_n());
        mcu.link().state() == DeviceState::Active
    });
    assert!(least_n > 0.9 * before_n, "let go to {least_n} of {before_n} N in between");
    let status = next.end(&mut rig);
    assert!([Some(0), Some(3)].contains(&status.code()), "{status}");
    assert!(rig.force_n() > 0.9 * before_n, "an orderly end lets nothing go either");
}

#[test]
fn r1_a_stopped_gripd_raises_nothing() {
    let (_folder, mut rig, mut daemon) = gripping();
    daemon.stop();
    rig.drain();
    let before_n = rig.force_n();
    let forces = rig.alone(400);
    held(&forces, before_n);
    assert_eq!(rig.state(), DeviceState::Hold);
    daemon.signal(Signal::CONT);
    let mut most_n = 0.0_f64;
    rig.until("gripd goes on", |mcu| {
        most_n = most_n.max(mcu.commanded_n());
        mcu.link().state() == DeviceState::Active
    });
    assert!(most_n <= before_n + 0.1, "{before_n} -> {most_n} N before the first fresh command");
    rig.serve(300, |mcu| assert!(mcu.commanded_n() > 0.5 * before_n && mcu.commanded_n() <= 60.0));
    assert!(daemon.is_running());
}

#[test]
fn r3_a_gripd_stopped_beyond_the_loss_delay_takes_over_again() {
    let (_folder, mut rig, mut daemon) = gripping();
    daemon.stop();
    rig.drain();
    let before_n = rig.force_n();
    held(&rig.alone(3_000), before_n);
    assert_eq!(rig.state(), DeviceState::LossAction);
    daemon.signal(Signal::CONT);
    rig.until("gripd commands again", |mcu| {
        assert!((0.9 * before_n..=before_n + 0.1).contains(&mcu.commanded_n()));
        mcu.link().state() == DeviceState::Active
    });
    assert!(daemon.is_running());
}

#[test]
fn r5_a_reboot_under_gripd_is_passive_until_armed_again() {
    let (_folder, mut rig, mut daemon) = gripping();
    let boot_id = rig.mcu.boot_id();
    rig.mcu.reset();
    assert!(rig.force_n() <= 0.0, "torque off at once");
    rig.until("gripd arms again", |mcu| {
        let state = mcu.link().state();
        let armed = state == DeviceState::Active;
        assert!(armed || mcu.commanded_n() <= 0.0, "{state:?}: {} N", mcu.commanded_n());
        armed
    });
    assert_ne!(rig.mcu.boot_id(), boot_id);
    rig.until_gripped();
    assert!(daemon.is_running());
}

#[test]
fn r1_echo_and_modem_commands_do_not_disturb_gripd() {
    let (_folder, mut rig, daemon) = gripping();
    let before_n = rig.force_n();
    rig.noisy = true;
    rig.serve(1_500, |mcu| {
        assert!((0.5 * before_n..=60.0).contains(&mcu.commanded_n()), "{}", mcu.commanded_n());
    });
    rig.until("still gripping", |mcu| mcu.link().state() == DeviceState::Active);
    assert!(rig.mcu.link().counters().bad_blocks() > 0, "the modem commands were seen");
    rig.noisy = false;
    let status = daemon.end(&mut rig);
    assert!([Some(0), Some(3)].contains(&status.code()), "{status}");
}
