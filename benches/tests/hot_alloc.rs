//! The hot thread of gripd never calls the heap, from waiting for its first line to its end, whatever happens meanwhile.
#![expect(clippy::unwrap_used, reason = "test code")]

use core::sync::atomic::{AtomicBool, Ordering};
use grip_daemon::{
    Item, LinkNote,
    hot::Settings,
    rings::{Sizes, rings},
};
use grip_link::host::LinkState;
use grip_port::Line;
use grip_session::{HostConfig, model};
use grip_sim::{VirtualMcu, mcu::SensorFault, scene};
use slip_benches::{
    daemon::{
        gripper::Gripper,
        rig::{Far, rig},
    },
    time,
};
use slip_core::ClientCommand;
use std::{
    os::{
        fd::{AsFd, OwnedFd},
        unix::net::UnixStream,
    },
    thread,
};

/// Looks of 2 ms until something must have happened, however busy the machine: a minute.
const PATIENCE: u32 = 30_000;

/// Allocations and frees of this thread while `work` runs.
fn heap_calls(work: impl FnOnce()) -> u64 {
    let seen = allocation_counter::measure(work);
    seen.count_total + seen.count_current.unsigned_abs()
}

/// What the other threads were informed of.
#[derive(Debug, Default)]
struct Reported {
    samples: u64,
    states: u64,
    events: u64,
    slips: u64,
    commands: u64,
    began: u64,
    obeyed: u64,
    lost_lines: u64,
    identified: u64,
    rebooted: bool,
    degraded: bool,
    recorded: u64,
}

impl Reported {
    fn take(&mut self, item: &Item<'_>) {
        match item {
            Item::Sample { .. } => self.samples += 1,
            Item::State(state) => {
                self.states += 1;
                self.slips += u64::from(state.statistic.unwrap_or(f32::NAN) > 1.0);
            }
            Item::Event { .. } => self.events += 1,
            Item::Command { .. } => self.commands += 1,
            Item::Began { .. } => self.began += 1,
            Item::Client { .. } => self.obeyed += 1,
            Item::Link { note, .. } => match note {
                LinkNote::PortLost => self.lost_lines += 1,
                LinkNote::Identified { rebooted, .. } => {
                    self.identified += 1;
                    self.rebooted |= rebooted;
                }
                LinkNote::State(LinkState::Degraded) => self.degraded = true,
                _ => {}
            },
            Item::Evidence { .. } | Item::Wire { .. } => {}
        }
    }
}

/// The threads around the hot one.
struct World {
    far: Far,
    reported: Reported,
    gripper: Gripper,
}

impl World {
    /// Plugs the gripper in until `enough`, then unplugs it.
    fn until(
        &mut self,
        clock: &(dyn Fn() -> u64 + Sync),
        enough: impl Fn(&Reported, &Far) -> bool,
    ) {
        let (near, device) = UnixStream::pair().unwrap();
        device.set_nonblocking(true).unwrap();
        self.far.lines.push(Line::from_fd(OwnedFd::from(near)).unwrap()).unwrap();
        let Self { far, reported, gripper } = self;
        let unplug = AtomicBool::new(false);
        thread::scope(|threads| {
            threads.spawn(|| gripper.live(device.as_fd(), &unplug, clock).unwrap());
            let looks = (0..PATIENCE).find(|_| {
                time::wait_ms(2);
                look(far, reported);
                enough(reported, far)
            });
            unplug.store(true, Ordering::Relaxed);
            assert!(looks.is_some(), "{reported:?}");
        });
        let lost_before = self.reported.lost_lines;
        drop(device);
        let noticed = (0..PATIENCE).find(|_| {
            time::wait_ms(2);
            look(&mut self.far, &mut self.reported);
            self.reported.lost_lines > lost_before
        });
        assert!(noticed.is_some(), "{:?}", self.reported);
        assert!(self.far.lost.pop().is_ok(), "the line comes back");
    }
}

fn look(far: &mut Far, reported: &mut Reported) {
    far.service.drain(&mut |item| reported.take(&item));
    let recorded = &mut reported.recorded;
    far.recorder.drain(&mut |item| *recorded += u64::from(matches!(item, Item::Sample { .. })));
    while far.pulses.pop().is_ok() {}
}

#[test]
fn a_whole_life_of_the_hot_thread_calls_no_heap() {
    let clock = time::clock();
    let (mut hot, far) = rig(HostConfig::default(), &clock).unwrap();
    let shared = far.shared.clone();
    shared.wants_samples.store(true, Ordering::Relaxed);
    let gripper = Gripper::new(VirtualMcu::new(&scene::load("default").unwrap(), 1).unwrap());
    let mut world = World { far, reported: Reported::default(), gripper };
    let heap = thread::scope(|threads| {
        let stop = shared.clone();
        let running = threads.spawn(|| heap_calls(|| hot.run().unwrap()));
        // Ended also where an assertion below fails: the scope would wait for ever.
        let ends = scopeguard(move || stop.stop.store(true, Ordering::Relaxed));
        live(&mut world, &clock);
        drop(ends);
        running.join().unwrap()
    });
    assert_eq!(heap, 0, "{:?}", world.reported);
    let Reported { samples, recorded, .. } = world.reported;
    let counted = hot.counters().samples;
    let dropped = hot.counters().service_dropped + hot.counters().recorder_dropped;
    assert!(samples <= recorded && recorded <= counted, "{:?} of {counted}", world.reported);
    assert!(dropped > 0 || recorded == counted, "{:?} of {counted}", world.reported);
}

/// Connect, learn, grip, slip, a client, other settings, unplugged and plugged in again, a restart, a broken stylus.
fn live(world: &mut World, clock: &(dyn Fn() -> u64 + Sync)) {
    world.until(clock, |reported, _| {
        reported.slips > 0 && reported.events > 0 && reported.commands > 100
    });
    let begun = world.reported.began;
    let estimator = model::default_estimator().unwrap();
    let mut config = HostConfig::default();
    config.grip.trial_force_n += 0.5;
    let settings = Settings { config, estimator, refused: None };
    world.far.settings.push(Box::new(settings)).unwrap();
    for command in [ClientCommand::AtLeast(6.0), ClientCommand::Release, ClientCommand::Grasp] {
        world.far.commands.push(command).unwrap();
    }
    let before = world.reported.samples;
    world.until(clock, |reported, far| {
        reported.obeyed == 3 && reported.samples > before + 5000 && !far.replaced.is_empty()
    });
    assert!(world.reported.began > begun, "{:?}", world.reported);
    let replaced = world.far.replaced.pop().unwrap();
    assert!(replaced.refused.is_none(), "{:?}", replaced.refused);
    world.gripper.mcu.reset();
    world.gripper.mcu.break_stylus(Some(SensorFault::Frozen));
    let before = world.reported.events;
    world.until(clock, |reported, _| reported.rebooted && reported.events > before);
    world.far.commands.push(ClientCommand::Stop).unwrap();
    world.until(clock, |reported, _| reported.obeyed == 4 && reported.identified >= 4);
}

/// Calls `end` when it is dropped.
fn scopeguard(end: impl Fn()) -> impl Drop {
    struct Guard<F: Fn()>(F);
    impl<F: Fn()> Drop for Guard<F> {
        fn drop(&mut self) {
            (self.0)();
        }
    }
    Guard(end)
}

#[test]
fn full_rings_count_and_neither_wait_nor_allocate() {
    let (mut outbox, mut inbox) = rings(Sizes { samples: 4, frames: 4, wire: 64 });
    let sample = slip_core::Sample::stylus(slip_core::units::Micros(7), 1e-6);
    let (mut reported, mut bytes) = (0, 0);
    let heap = heap_calls(|| {
        for index in 0..1000 {
            outbox.put(&Item::Sample { host_us: 1, index, sample: &sample, taxels: &[] });
            outbox.put(&Item::Wire { host_us: 1, to_device: false, bytes: &[1; 40] });
        }
        inbox.drain(&mut |item| match item {
            Item::Sample { .. } => reported += 1,
            Item::Wire { bytes: these, .. } => bytes += these.len(),
            _ => {}
        });
    });
    let dropped = inbox.drops().now();
    assert_eq!((heap, reported, bytes), (0, 4, 40));
    assert_eq!((dropped.samples, dropped.wire, dropped.states, dropped.others), (996, 999, 0, 0));
}
