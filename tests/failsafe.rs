//! A host that fails. gripd holds an object when it is killed, stopped, disturbed or outlived; one test a rule that a process can break.
//!
//! The gripper's time follows the clock of the machine but never jumps. Once gripd is dead or stopped its time goes on as fast as the story
//! likes. The table of all rules and their tests stands in `crates/grip-sim/tests/failsafe/main.rs`.
#![expect(clippy::unwrap_used, reason = "test code")]

use grip_link::message::DeviceState;
use stories::{Gripper, Program, Signal, folder};

const OBJECT: &str =
    "name = \"t\"\nmass_kg = 0.02\nfriction = 0.3\nroughness_ra_um = 1.6\nlift_at_s = 60.0\n";
/// A force that stands, whatever the object needs.
const SETTINGS: &str = "[grip]\ntrial_force_n = 2.0\nrelax_per_s = 0.0\n";

fn gripd(folder: &tempfile::TempDir) -> Program {
    Program::gripd(folder.path(), &["--port", "gripper"])
}

fn until_gripped(gripper: &mut Gripper) {
    gripper.watch("gripd grips", |mcu| {
        mcu.link().state() == DeviceState::Active && mcu.commanded_n() > 1.5
    });
    gripper.live(200);
}

fn gripping() -> (tempfile::TempDir, Gripper, Program) {
    let folder = folder();
    std::fs::write(folder.path().join("gripd.toml"), SETTINGS).unwrap();
    let mut gripper = Gripper::plugged_in(folder.path(), OBJECT);
    let gripd = gripd(&folder);
    until_gripped(&mut gripper);
    (folder, gripper, gripd)
}

/// Ends it as the service manager does.
fn end(mut gripd: Program, gripper: &mut Gripper) {
    gripd.signal(Signal::TERM);
    gripper.watch("gripd ends", |_| !gripd.is_running());
    let _ended = gripd.ended().done();
}

/// Lives for some time, in which the force stays above `least_n` and within the limit.
fn serve(gripper: &mut Gripper, ms: u64, least_n: f64) {
    let end_us = gripper.mcu.grasp().now().0 + 1000 * ms;
    gripper.watch("some time passes", |mcu| {
        assert!((least_n..=60.0).contains(&mcu.commanded_n()), "{} N", mcu.commanded_n());
        mcu.grasp().now().0 >= end_us
    });
}

/// After 50 ms nothing rises; nothing is ever let go.
fn held(forces: &[f64], before_n: f64) {
    let settled = &forces[60..];
    assert!(settled.windows(2).all(|pair| pair[1] <= pair[0]), "the force rose without a host");
    assert!(settled.iter().all(|n| *n > 0.9 * before_n), "{:?} of {before_n} N", settled.last());
}

#[test]
fn r2_kill_9_of_gripd_holds_the_object_and_the_next_one_takes_over() {
    let (folder, mut gripper, gripd) = gripping();
    gripd.kill();
    gripper.drain();
    let before_n = gripper.force_n();
    held(&gripper.alone(200), before_n);
    assert_eq!(gripper.state(), DeviceState::Hold);
    held(&gripper.alone(10_000), before_n);
    assert_eq!(gripper.state(), DeviceState::LossAction);
    let next = self::gripd(&folder);
    let mut least_n = gripper.force_n();
    gripper.watch("the next gripd takes over", |mcu| {
        least_n = least_n.min(mcu.commanded_n());
        mcu.link().state() == DeviceState::Active
    });
    assert!(least_n > 0.9 * before_n, "let go to {least_n} of {before_n} N in between");
    end(next, &mut gripper);
    assert!(gripper.force_n() > 0.9 * before_n, "an orderly end lets nothing go either");
}

#[test]
fn r1_a_stopped_gripd_raises_nothing() {
    let (_folder, mut gripper, mut gripd) = gripping();
    gripd.stop();
    gripper.drain();
    let before_n = gripper.force_n();
    let forces = gripper.alone(400);
    held(&forces, before_n);
    assert_eq!(gripper.state(), DeviceState::Hold);
    gripd.signal(Signal::CONT);
    let mut most_n = 0.0_f64;
    gripper.watch("gripd goes on", |mcu| {
        most_n = most_n.max(mcu.commanded_n());
        mcu.link().state() == DeviceState::Active
    });
    assert!(most_n <= before_n + 0.1, "{before_n} -> {most_n} N before the first fresh command");
    serve(&mut gripper, 300, 0.5 * before_n);
    assert!(gripd.is_running());
}

#[test]
fn r3_a_gripd_stopped_beyond_the_loss_delay_takes_over_again() {
    let (_folder, mut gripper, mut gripd) = gripping();
    gripd.stop();
    gripper.drain();
    let before_n = gripper.force_n();
    held(&gripper.alone(3_000), before_n);
    assert_eq!(gripper.state(), DeviceState::LossAction);
    gripd.signal(Signal::CONT);
    gripper.watch("gripd commands again", |mcu| {
        assert!((0.9 * before_n..=before_n + 0.1).contains(&mcu.commanded_n()));
        mcu.link().state() == DeviceState::Active
    });
    assert!(gripd.is_running());
}

#[test]
fn r5_a_reboot_under_gripd_is_passive_until_armed_again() {
    let (_folder, mut gripper, mut gripd) = gripping();
    let boot_id = gripper.mcu.boot_id();
    gripper.mcu.reset();
    assert!(gripper.force_n() <= 0.0, "torque off at once");
    gripper.watch("gripd arms again", |mcu| {
        let state = mcu.link().state();
        let armed = state == DeviceState::Active;
        assert!(armed || mcu.commanded_n() <= 0.0, "{state:?}: {} N", mcu.commanded_n());
        armed
    });
    assert_ne!(gripper.mcu.boot_id(), boot_id);
    until_gripped(&mut gripper);
    assert!(gripd.is_running());
}

#[test]
fn r1_echo_and_modem_commands_do_not_disturb_gripd() {
    let (_folder, mut gripper, gripd) = gripping();
    let before_n = gripper.force_n();
    gripper.noisy = true;
    serve(&mut gripper, 1_500, 0.5 * before_n);
    gripper.watch("still gripping", |mcu| mcu.link().state() == DeviceState::Active);
    assert!(gripper.mcu.link().counters().bad_blocks() > 0, "the modem commands were seen");
    gripper.noisy = false;
    end(gripd, &mut gripper);
}
