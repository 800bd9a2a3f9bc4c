//! Source of a simulated scene, by its name: grasps in real time, one after the other, each with another object.
//!
//! The simulated gripper and the session that gripd has exchange their bytes in this thread; only the line and the daemon's threads are
//! left out. Device times go on from grasp to grasp, as if one gripper took one object after the other.

mod grasp;
mod tally;

use super::outlet::Outlet;
use super::reception::shipped;
use super::reported;
use super::stream::Stream;
use crate::feed::{DaemonInfo, EventKind, EventMark, Feed, ObserverSettings, SourceStatus};
use core::time::Duration;
use grasp::Grasp;
use grip_link::device::Peer;
use grip_link::message::daemon::RealTime;
use grip_session::{HostConfig, model::default_estimator};
use slip_core::{ClientCommand, Signal};
use std::sync::mpsc::Receiver;
use tally::Tally;

/// How long each object is held (us), unless the gripper is stopped.
const GRASP_US: u64 = 4_000_000;
/// From letting go to the next object (us).
const BETWEEN_US: u64 = 500_000;
/// From one delivery to the next.
const TURN: Duration = Duration::from_millis(8);
/// After a longer pause of this program the simulation goes on where it was (us).
const ASLEEP_US: u64 = 500_000;

/// Makes the gripper of a scene with the object of a seed and the number of its start, and states something about the object; or why there
/// is none. The program brings it along, so that the scope needs no simulator.
pub type Grippers = fn(&str, u64, u32) -> Result<(Box<dyn Peer>, String), String>;

/// Runs grasps until the scope lets go.
pub(super) fn run(
    grippers: Grippers,
    scene: &str,
    seed: u64,
    outlet: &mut Outlet,
    orders: &Receiver<ClientCommand>,
) {
    if let Err(sentence) = grasps(grippers, scene, seed, outlet, orders) {
        outlet.status(SourceStatus::Failed { sentence });
    }
}

/// What goes on from grasp to grasp.
struct World {
    config: HostConfig,
    tally: Tally,
    stream: Stream,
    /// Device time at which the present grasp began (us).
    start_us: u64,
}

fn grasps(
    grippers: Grippers,
    name: &str,
    seed: u64,
    outlet: &mut Outlet,
    orders: &Receiver<ClientCommand>,
) -> Result<(), String> {
    let config = HostConfig::default();
    let mut stream = Stream::default();
    if let Some(why) = stream
        .observe(shipped(Signal::Displacement, config.link.sample_rate_hz), default_estimator())
    {
        outlet.offer(why);
    }
    let mut world = World { config, tally: Tally::default(), stream, start_us: 0 };
    let mut lag_us = 0;
    let mut made = grippers(name, seed, 1)?;
    greet(name, outlet);
    let interval_s = world.config.detector.interval_s;
    outlet.offer(Feed::Observes(ObserverSettings::Source { interval_s }));
    for number in 1.. {
        let (gripper, object) = made;
        let mut grasp = Grasp::new(gripper, number, &world.config)?;
        outlet.offer(Feed::Event(EventMark::plain(f64::NAN, EventKind::Reload, object)));
        while grasp.goes_on() {
            if outlet.stops() {
                return Ok(());
            }
            let begun_us = world.start_us + grasp.now_us();
            let behind_us = outlet.clock.now_us().saturating_sub(lag_us + begun_us);
            lag_us += if behind_us > ASLEEP_US { behind_us } else { 0 };
            let now_us = outlet.clock.now_us().saturating_sub(lag_us + world.start_us);
            grasp.run_until(now_us, &mut world, outlet)?;
            obey(&mut grasp, orders, outlet);
            deliver(&mut world, &grasp, outlet);
            outlet.clock.wait(TURN);
        }
        world.tally.end(&grasp.session);
        world.start_us += grasp.now_us();
        world.stream.restart();
        outlet.offer(Feed::Restart);
        made = grippers(name, seed.wrapping_add(number.into()), number.saturating_add(1))?;
    }
    Ok(())
}

fn greet(name: &str, outlet: &mut Outlet) {
    outlet.offer(Feed::Welcome(DaemonInfo {
        name: format!("simulated grasps, scene {name}"),
        place: "this program".to_owned(),
        may_command: true,
        dry_run: false,
        real_time: RealTime::NotAsked,
        every_nth: 1,
    }));
    outlet.status(SourceStatus::Live);
}

fn deliver(world: &mut World, grasp: &Grasp, outlet: &mut Outlet) {
    world.stream.take().into_iter().for_each(|feed| outlet.offer(feed));
    let now_us = world.start_us + grasp.now_us();
    if let Some(health) = world.tally.health(now_us, &grasp.session) {
        outlet.offer(Feed::Gripper(grasp.about()));
        outlet.offer(Feed::Health(Box::new(health)));
    }
    outlet.wake();
}

/// Carries out what a person asks for.
fn obey(grasp: &mut Grasp, orders: &Receiver<ClientCommand>, outlet: &mut Outlet) {
    while let Ok(action) = orders.try_recv() {
        let text = grasp.obey(action);
        reported::answer(text).into_iter().for_each(|feed| outlet.offer(feed));
    }
}
