//! An unplugged port. Somebody pulls the gripper's plug while gripd holds an object, and puts it in again.
//!
//! The gripper holds by itself meanwhile. gripd reports that the port is gone and waits; it finds the same gripper again and goes on holding, without
//! letting go for a moment. Where the gripper lost its power as well it has forgotten everything: gripd reports it and grips anew.
#![expect(clippy::unwrap_used, reason = "test code")]

use std::{fs, path::Path};
use stories::{Gripper, Program, folder, in_one_of_some_runs, until};

/// It lies on a table, so that only force is at stake.
const OBJECT: &str = "name = \"lying\"\nmass_kg = 0.1\nfriction = 0.4\nlift_at_s = 60.0\n";
/// A force that stands.
const SETTINGS: &str = "listen = \"off\"\n[grip]\ntrial_force_n = 2.0\nrelax_per_s = 0.0\n";

#[test]
fn a_plug_that_is_pulled_and_put_in_again_costs_no_force() {
    let folder = folder();
    fs::write(folder.path().join("gripd.toml"), SETTINGS).unwrap();
    let mut gripper = Gripper::plugged_in(folder.path(), OBJECT);
    let gripd = Program::gripd(folder.path(), &["--port", "./gripper", "--wait"]);
    gripper.until("gripd grips", |mcu| mcu.commanded_n() > 1.9);
    gripper.live(200);
    let before_n = gripper.force_n();

    gripper.unplug();
    let alone_n = gripper.live(300);
    gripd.until_reported("the port is gone; the gripper holds by itself until it is back");
    assert!(alone_n > 0.95 * before_n, "{alone_n} of {before_n} N without the computer");

    gripper.plug_in();
    let mut least_n = alone_n;
    gripper.until("gripd finds it again", |mcu| {
        least_n = least_n.min(mcu.commanded_n());
        gripd.reported().contains("gripper found again")
    });
    least_n = least_n.min(gripper.live(500));
    assert!(least_n > 0.95 * before_n, "{least_n} of {before_n} N in between");
    assert!(gripper.force_n() > 1.9, "{} N at the end", gripper.force_n());
}

/// A gripper with another object, as a program of its own.
fn powered(folder: &Path) -> Program {
    let gripper = Program::gripctl(folder, &["sim", "--scene", "light_rough", "--pty", "gripper"]);
    gripper.until_reported("scene light_rough is a gripper at gripper");
    gripper
}

/// Waits until gripd has answered more slips than `before`; how many it has, or that an object fell.
fn holds(gripd: &Program, before: usize) -> Result<usize, String> {
    let answered = || gripd.printed().matches("slip_end").count();
    let fallen = || gripd.reported().contains("the object is gone");
    assert!(until(|| answered() > before || fallen()), "{}", gripd.reported());
    if fallen() { Err(gripd.reported()) } else { Ok(answered()) }
}

/// gripd, while the gripper loses its power and gets it back.
fn the_power_fails() -> Result<(), String> {
    let folder = folder();
    // Nothing is plugged in yet: gripd is patient.
    let args = ["--port", "./gripper", "--wait", "--json", "--listen", "off"];
    let gripd = Program::gripd(folder.path(), &args);
    gripd.until_reported("waiting for it");
    let first = powered(folder.path());
    gripd.until_reported("gripper found");
    let answered = holds(&gripd, 0)?;

    first.kill();
    gripd.until_reported("the port is gone");
    let second = powered(folder.path());
    gripd.until_reported("the gripper has restarted");
    holds(&gripd, answered)?;

    let ended = gripd.interrupted().done();
    assert!(ended.summary()["reconnects"].as_u64().unwrap() >= 1, "{}", ended.out);
    // gripd has gone, and the gripper holds all the same.
    let truth = second.interrupted();
    assert!(truth.code == 0 && truth.err.contains("gripctl: force "), "{truth:?}");
    if truth.err.contains("dropped") { Err(truth.err) } else { Ok(()) }
}

#[test]
fn a_gripper_that_lost_its_power_is_found_and_grips_anew() {
    in_one_of_some_runs(the_power_fails);
}
