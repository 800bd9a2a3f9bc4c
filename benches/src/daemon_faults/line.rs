//! A gripper that restarts, a stylus that fails, a line full of noise, a daemon that stands still, settings that change.

use super::{
    outcome::Outcome,
    rig::{Object, Rig, Setup},
};
use crate::{daemon::process::Daemon, time};
use anyhow::Result;
use grip_sim::mcu::{Sensor, SensorFault};
use rustix::process::Signal;

/// A daemon stands still for this long (ms).
const PAUSE_MS: u64 = 300;
/// Whatever is waited for happens within this time (s), on a busy machine too.
const PATIENCE_S: u64 = 30;

/// The gripper restarts while it grips: passive until it is armed again, then gripped again.
pub(super) fn reboots(setup: &Setup<'_>, times: u64) -> Result<Outcome> {
    let mut outcome = Outcome { times, ..Outcome::default() };
    let rig = Rig::new(setup, Object::Supported)?;
    let mut daemon = rig.gripping(&["--record", "reboots.mcap"])?;
    let mut again_ms = Vec::new();
    for _ in 0..times {
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
        rig.missed(armed, "the restarted gripper gets no settings", &daemon)?;
        outcome.require(early_n <= 0.0, || format!("{early_n} N before it was armed again"));
        let gripped = rig.gripper.until_gripped();
        rig.missed(gripped, "the restarted gripper does not grip", &daemon)?;
        again_ms.push(u64::try_from(from.elapsed().as_millis()).unwrap_or(u64::MAX));
    }
    let reported = daemon.times_stated("the gripper has restarted");
    outcome.require(reported > 0, || format!("no restart was reported: {}", daemon.log()));
    outcome.spread("from the restart to the grip", again_ms, "ms");
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}

/// The stylus breaks or sticks while the object is in the air: reported by its name, and the force does not fall.
pub(super) fn styluses(setup: &Setup<'_>) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    for (fault, health) in [(SensorFault::Dead, "failed"), (SensorFault::Stuck, "frozen")] {
        outcome.times += 1;
        let rig = Rig::new(setup, Object::Lifted)?;
        let mut daemon = rig.gripping(&["--json", "--record", "stylus.mcap"])?;
        rig.gripper.bench().mcu.break_sensor(Sensor::Stylus, Some(fault));
        let is_reported = |line: &str| {
            [r#""type":"health""#, r#""channel":"stylus""#, health]
                .iter()
                .all(|it| line.contains(it))
        };
        let reported = time::until(PATIENCE_S, || daemon.printed().lines().any(is_reported));
        rig.missed(reported, "the stylus is not reported", &daemon)?;
        time::wait_ms(1000);
        rig.commands_again(&daemon)?;
        rig.finish(&mut daemon, &mut outcome)?;
    }
    outcome.figure("broken and stuck: reported, the force stays".to_owned());
    Ok(outcome)
}

/// Noise both ways, then a daemon that stands still again and again.
pub(super) fn noise(setup: &Setup<'_>, noise_s: u64, pauses: u64) -> Result<Outcome> {
    let mut outcome = Outcome { times: 1 + pauses, ..Outcome::default() };
    let rig = Rig::new(setup, Object::Lifted)?;
    let mut daemon = rig.daemon(&["--record", "noise.mcap"])?;
    pause_while_closing(&rig, &daemon)?;
    rig.until_held(&daemon)?;
    let before = rig.gripper.bench().judge.commands;
    rig.gripper.bench().disturb(Some(setup.seed));
    time::wait_ms(1000 * noise_s);
    rig.gripper.bench().disturb(None);
    let bad = rig.gripper.bench().mcu.link().counters().bad_blocks();
    let commands = rig.gripper.bench().judge.commands - before;
    outcome.require(bad > 0, || "the noise did not reach the gripper".to_owned());
    outcome.figure(format!(
        "{noise_s} s of noise: {bad} bad blocks refused by the gripper, {commands} commands got through"
    ));
    rig.commands_again(&daemon)?;
    let mut rises_n = 0.0_f64;
    for _ in 0..pauses {
        rises_n = rises_n.max(pause(&rig, &daemon)?);
        rig.commands_again(&daemon)?;
    }
    outcome.require(rises_n <= 0.1, || format!("the force rose by {rises_n} N in a pause"));
    outcome.figure(format!(
        "{pauses} pauses of {PAUSE_MS} ms: the force rose by {rises_n:.3} N at most"
    ));
    let rate_hz = rig.gripper.bench().mcu.link().in_force().map_or(1, |c| c.sample_rate_hz.max(1));
    let oldest_ms =
        u64::from(rig.gripper.bench().judge.oldest_rise_rows) * 1000 / u64::from(rate_hz);
    outcome.figure(format!(
        "after a pause while the fingers closed the force was raised on samples up to {oldest_ms} ms old"
    ));
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}

/// Stops the daemon while it closes the fingers, where it has reason to raise the force when it goes on: the judge sees on what samples.
fn pause_while_closing(rig: &Rig<'_>, daemon: &Daemon) -> Result<()> {
    let closing = time::until(PATIENCE_S, || rig.gripper.bench().mcu.commanded_n() > 0.5);
    rig.missed(closing, "the fingers do not close", daemon)?;
    pause(rig, daemon)?;
    Ok(())
}

/// SIGSTOP and SIGCONT; by how much the force was higher in between than before (N).
fn pause(rig: &Rig<'_>, daemon: &Daemon) -> Result<f64> {
    daemon.signal(Signal::STOP)?;
    let before_n = rig.gripper.bench().mcu.commanded_n();
    time::wait_ms(PAUSE_MS);
    let most_n = rig.gripper.bench().mcu.commanded_n();
    daemon.signal(Signal::CONT)?;
    Ok(most_n - before_n)
}

/// SIGHUP with a broken file, then with a good one.
pub(super) fn reloads(setup: &Setup<'_>, times: u64) -> Result<Outcome> {
    let mut outcome = Outcome { times: 2 * times, ..Outcome::default() };
    let rig = Rig::new(setup, Object::Lifted)?;
    let mut daemon = rig.gripping(&["--record", "reload.mcap"])?;
    for index in 0..times {
        rig.configure(if index % 2 == 0 { "backoff_n_s = [" } else { "backoff_n_s = -1.0" })?;
        reload(&rig, &daemon, "the settings in force stay")?;
        rig.configure(&format!("backoff_n_s = {}.0", 5 + index % 2))?;
        reload(&rig, &daemon, "the new settings are in force")?;
        rig.commands_again(&daemon)?;
    }
    outcome.figure(
        "broken files reported with their place, good ones in force, the object held".to_owned(),
    );
    let placed = daemon.times_stated("gripd.toml");
    outcome.require(placed >= usize::try_from(times).unwrap_or(usize::MAX), || daemon.log());
    rig.finish(&mut daemon, &mut outcome)?;
    Ok(outcome)
}

fn reload(rig: &Rig<'_>, daemon: &Daemon, reported: &str) -> Result<()> {
    let before = daemon.times_stated(reported);
    daemon.signal(Signal::HUP)?;
    let received = time::until(PATIENCE_S, || daemon.times_stated(reported) > before);
    rig.missed(received, "what became of the settings was not reported", daemon)
}
