//! A fault. gripd holds an object in the air when the stylus dies: its cable breaks, or it sticks.
//!
//! Without its sense of touch gripd must not guess. The fault is reported, by the sensor's name. The force does not fall, the object stays in the fingers,
//! and gripd goes on watching.
#![expect(clippy::unwrap_used, reason = "test code")]

use grip_sim::mcu::{Sensor, SensorFault};
use stories::{Gripper, Program, folder, in_one_of_some_runs};

/// An object that slips when it is lifted, and bears a firm grip.
const OBJECT: &str = "name = \"held\"\nseed = 4\nmass_kg = 0.3\nfriction = 0.4\nroughness_ra_um = 1.6\ncrush_n = 100.0\n";
/// The force stands once the object is held, so that any fall is seen.
const SETTINGS: &str = "listen = \"off\"\n[grip]\nrelax_per_s = 0.0\n";

/// What becomes of a held object when the stylus fails like this: what gripd said of the stylus, or why the story could not begin.
fn the_stylus_fails(fault: SensorFault) -> Result<String, String> {
    let folder = folder();
    std::fs::write(folder.path().join("gripd.toml"), SETTINGS).unwrap();
    let mut gripper = Gripper::plugged_in(folder.path(), OBJECT);
    let gripd = Program::gripd(folder.path(), &["--port", "gripper", "--json"]);
    let mut held = false;
    gripper.until("the object is held", |mcu| {
        held = gripd.printed().contains("slip_end");
        held || mcu.truth().dropped()
    });
    gripper.live(500);
    if !held || gripper.mcu.truth().dropped() {
        return Err(format!("the object fell before the fault: {}", gripd.reported()));
    }

    let before_n = gripper.force_n();
    gripper.mcu.break_sensor(Sensor::Stylus, Some(fault));
    gripper.until("the fault is told", |_| stylus(&gripd).is_some());
    let least_n = gripper.live(1000);

    assert!(least_n > before_n - 0.1, "the force fell from {before_n} to {least_n} N");
    assert!(!gripper.mcu.truth().dropped(), "{:?}", gripper.mcu.truth());
    let reported = stylus(&gripd).unwrap();
    drop(gripper);
    drop(gripd);
    Ok(reported)
}

/// What was said of the health of the stylus.
fn stylus(gripd: &Program) -> Option<String> {
    let lines = gripd.lines();
    let reported =
        lines.iter().find(|line| line["type"] == "health" && line["channel"] == "stylus")?;
    reported["health"].as_str().map(str::to_owned)
}

#[test]
fn a_broken_cable_is_reported_and_the_object_stays() {
    let reported = in_one_of_some_runs(|| the_stylus_fails(SensorFault::Dead));
    assert_eq!(reported, "failed");
}

#[test]
fn a_stylus_that_sticks_is_reported_and_the_object_stays() {
    let reported = in_one_of_some_runs(|| the_stylus_fails(SensorFault::Stuck));
    assert_eq!(reported, "frozen");
}
