//! A port that goes and comes back, with the right gripper behind it or with another one.

use super::{
    outcome::Outcome,
    rig::{Object, Rig, Setup},
};
use crate::{daemon::process::Daemon, time};
use anyhow::Result;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

/// Longest time that the port is away (ms).
const LONGEST_AWAY_MS: u64 = 300;
/// A replugged gripper is commanded again within this time (s), on a busy machine too.
const FOUND_S: u64 = 20;
/// A stranger stands at the port for this long (ms).
const STRANGER_MS: u64 = 3_000;

/// Unplugs and replugs the same gripper.
pub(super) fn again(setup: &Setup<'_>, times: u64) -> Result<Outcome> {
    let mut outcome = Outcome { times, ..Outcome::default() };
    let rig = Rig::new(setup, Object::Lifted)?;
    let mut daemon = rig.gripping(&["--record", "plug.mcap"])?;
    let mut random = ChaCha8Rng::seed_from_u64(setup.seed);
    let mut found_ms = Vec::new();
    for _ in 0..times {
        rig.gripper.bench().unplug();
        time::wait_ms(20 + random.next_u64() % LONGEST_AWAY_MS);
        let plugged = time::now();
        rig.gripper.bench().plug()?;
        commanded_again(&rig, &daemon)?;
        found_ms.push(u64::try_from(plugged.elapsed().as_millis()).unwrap_or(u64::MAX));
        time::wait_ms(random.next_u64() % 400);
    }
    outcome.spread("from the plug to the first command", found_ms, "ms");
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}

/// Waits until commands reach the gripper again.
fn commanded_again(rig: &Rig<'_>, daemon: &Daemon) -> Result<()> {
    let before = rig.gripper.bench().judge.commands;
    let found = time::until(FOUND_S, || {
        let bench = rig.gripper.bench();
        bench.judge.commands > before && bench.is_active()
    });
    rig.missed(found, "the replugged gripper is not commanded", daemon)
}

/// Puts another gripper at the port for a while.
pub(super) fn stranger(setup: &Setup<'_>) -> Result<Outcome> {
    const REPORTED: &str = "another gripper answered and was left alone";
    let mut outcome = Outcome { times: 1, ..Outcome::default() };
    let rig = Rig::new(setup, Object::Lifted)?;
    let mut daemon = rig.gripping(&["--record", "stranger.mcap"])?;
    let other = Object::Supported.scene(2)?;
    rig.gripper.bench().unplug();
    time::wait_ms(100);
    rig.gripper.bench().exchange_for(&other)?;
    let reported = time::until(FOUND_S, || daemon.times_stated(REPORTED) > 0);
    rig.missed(reported, "the stranger was not reported", &daemon)?;
    time::wait_ms(STRANGER_MS);
    let Some((stranger, judge)) = rig.gripper.bench().bring_back()? else {
        return Ok(Outcome::failed("there was no stranger".to_owned()));
    };
    outcome.require(judge.sessions > 0, || "the stranger was never asked who it is".to_owned());
    outcome.require(stranger.commanded_n() <= 0.0 && stranger.link().in_force().is_none(), || {
        format!("the stranger was not left alone: {} N", stranger.commanded_n())
    });
    outcome.judged(&judge);
    outcome.figure(format!("asked {} times, no settings, no commands", judge.sessions));
    commanded_again(&rig, &daemon)?;
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}
