//! A port that goes and comes back, with the right gripper behind it or with another one.

use super::{
    rig::{Object, Rig},
    spread, times,
};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use slip_benches::time;

/// Longest time that the port is away (ms).
const LONGEST_AWAY_MS: u64 = 300;
/// A stranger stands at the port for this long (ms).
const STRANGER_MS: u64 = 3_000;

#[test]
fn the_same_gripper_is_commanded_again_after_each_plug() {
    let rig = Rig::new(Object::Lifted);
    let daemon = rig.gripping(&["--record", "plug.mcap"]);
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut found_ms = Vec::new();
    for _ in 0..times(3) {
        rig.gripper.bench().unplug();
        time::wait_ms(20 + random.next_u64() % LONGEST_AWAY_MS);
        let plugged = time::now();
        rig.gripper.bench().plug();
        rig.commands_again(&daemon, 0);
        found_ms.push(u64::try_from(plugged.elapsed().as_millis()).unwrap());
        time::wait_ms(random.next_u64() % 400);
    }
    spread("from the plug to the first command", found_ms);
    rig.finish(daemon);
}

#[test]
fn another_gripper_at_the_port_is_left_alone() {
    let rig = Rig::new(Object::Lifted);
    let daemon = rig.gripping(&["--record", "stranger.mcap"]);
    rig.gripper.bench().unplug();
    time::wait_ms(100);
    rig.gripper.bench().exchange_for(&Object::Supported.scene(2));
    daemon.until_reported("another gripper answered and was left alone");
    time::wait_ms(STRANGER_MS);
    let (stranger, judge) = rig.gripper.bench().bring_back();
    assert!(judge.sessions > 0, "the stranger was never asked who it is");
    assert!(stranger.commanded_n() <= 0.0 && stranger.link().in_force().is_none());
    judge.must_be_kept();
    println!("asked {} times, no settings, no commands", judge.sessions);
    rig.commands_again(&daemon, 0);
    rig.finish(daemon);
}
