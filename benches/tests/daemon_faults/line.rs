//! A gripper that restarts, a line full of noise, a daemon that stands still.

use super::{
    rig::{Object, Rig, times_stated},
    spread, times,
};
use slip_benches::time;
use stories::{Program, Signal};

/// A daemon stands still for this long (ms).
const PAUSE_MS: u64 = 300;
/// Whatever is waited for happens within this time (s), on a busy machine too.
const PATIENCE_S: u64 = 30;

#[test]
fn a_restarted_gripper_is_passive_until_it_is_armed_and_gripped_again() {
    let rig = Rig::new(Object::Supported);
    let daemon = rig.gripping(&["--record", "reboots.mcap"]);
    let mut again_ms = Vec::new();
    for _ in 0..times(1) {
        let configs = {
            let mut bench = rig.gripper.bench();
            bench.must_hold(false);
            bench.reboot();
            bench.judge.configs
        };
        let from = time::now();
        let mut early_n = 0.0_f64;
        let armed = time::until(PATIENCE_S, || {
            let bench = rig.gripper.bench();
            let armed = bench.judge.configs > configs;
            if !armed {
                early_n = early_n.max(bench.mcu.commanded_n());
            }
            armed
        });
        rig.must(armed, "the restarted gripper gets no settings", &daemon);
        assert!(early_n <= 0.0, "{early_n} N before it was armed again");
        rig.must(rig.gripper.until_gripped(), "the restarted gripper does not grip", &daemon);
        again_ms.push(u64::try_from(from.elapsed().as_millis()).unwrap());
    }
    assert!(times_stated(&daemon, "the gripper has restarted") > 0, "{}", daemon.reported());
    spread("from the restart to the grip", again_ms);
    rig.finish(daemon);
}

#[test]
fn noise_both_ways_and_a_daemon_that_stands_still_again_and_again() {
    let rig = Rig::new(Object::Lifted);
    let daemon = rig.daemon(&["--record", "noise.mcap"]);
    // Where it has reason to raise the force when it goes on: the judge sees on what samples.
    let closing = time::until(PATIENCE_S, || rig.gripper.bench().mcu.commanded_n() > 0.5);
    rig.must(closing, "the fingers do not close", &daemon);
    pause(&rig, &daemon);
    rig.until_held(&daemon);
    let before = rig.gripper.bench().judge.commands;
    rig.gripper.bench().disturb(Some(2));
    time::wait_ms(1000 * times(2));
    rig.gripper.bench().disturb(None);
    let bad = rig.gripper.bench().mcu.link().counters().bad_blocks();
    assert!(bad > 0, "the noise did not reach the gripper");
    let commands = rig.gripper.bench().judge.commands - before;
    println!("noise: {bad} bad blocks refused by the gripper, {commands} commands got through");
    rig.commands_again(&daemon, 200);
    for _ in 0..times(2) {
        let rise_n = pause(&rig, &daemon);
        assert!(rise_n <= 0.1, "the force rose by {rise_n} N in a pause");
        rig.commands_again(&daemon, 200);
    }
    println!("the force was raised on samples up to {} rows old", {
        rig.gripper.bench().judge.oldest_rise_rows
    });
    rig.finish(daemon);
}

/// SIGSTOP and SIGCONT; by how much the force was higher in between than before (N).
fn pause(rig: &Rig, daemon: &Program) -> f64 {
    daemon.signal(Signal::STOP);
    let before_n = rig.gripper.bench().mcu.commanded_n();
    time::wait_ms(PAUSE_MS);
    let most_n = rig.gripper.bench().mcu.commanded_n();
    daemon.signal(Signal::CONT);
    most_n - before_n
}
