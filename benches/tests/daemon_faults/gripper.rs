//! A gripper simulated from a scene in real time behind a port name; it can be unplugged, exchanged, restarted and disturbed.

use super::judge::{Judge, Limits, Present};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    message::{DeviceState, Kind, SamplesHeader},
};
use grip_sim::{Pty, Scene, VirtualMcu, pty::PtyError};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use slip_benches::time;
use slip_core::units::Micros;
use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread::{self, JoinHandle},
    time::Instant,
};

/// Longest step of the gripper's time (us): a machine that stood still did not age it.
const LONGEST_STEP_US: u64 = 2_000;
/// A gripper that held keeps at least this share of its force.
const KEPT: f64 = 0.9;

/// Rows that the gripper has sent.
#[derive(Debug)]
struct Sent {
    tap: Decoder,
    /// Number of the row after the newest; counts since the gripper started.
    next: u32,
    /// What `next` was when the newest settings came.
    at_config: u32,
}

impl Sent {
    fn new() -> Self {
        Self { tap: Decoder::new(Role::Tap), next: 0, at_config: 0 }
    }

    fn receive(&mut self, mut bytes: &[u8]) {
        while let Some(verdict) = self.tap.next(&mut bytes) {
            let Verdict::Frame(frame) = verdict else { continue };
            if frame.header.kind == Kind::SAMPLES
                && let Ok(header) = SamplesHeader::parse(frame.payload)
            {
                self.next = header.first_index.wrapping_add(u32::from(header.rows));
            }
        }
    }
}

/// The gripper, its line and its judge, one turn at a time.
#[derive(Debug)]
pub(crate) struct Bench {
    /// The gripper at the port.
    pub(crate) mcu: VirtualMcu,
    /// The gripper that belongs there, while another one stands in its place.
    away: Option<(VirtualMcu, Judge)>,
    /// Listens to every command.
    pub(crate) judge: Judge,
    link: PathBuf,
    limits: Limits,
    pty: Option<Pty>,
    unsent: Vec<u8>,
    sent: Sent,
    noise: Option<ChaCha8Rng>,
    /// What the gripper sends stays in the line.
    held_back: bool,
    /// The object that is held must stay so: least force (N).
    least_n: Option<f64>,
    now: Micros,
    seen: Instant,
    /// Longest time between two turns (us): the machine had no time for this thread.
    stalled_us: u64,
}

impl Bench {
    fn turn(&mut self) -> Result<(), PtyError> {
        let real = time::now();
        let passed = u64::try_from(real.duration_since(self.seen).as_micros()).unwrap_or(0);
        self.seen = real;
        self.stalled_us = self.stalled_us.max(passed);
        self.now = self.now.plus(Micros(passed.clamp(1, LONGEST_STEP_US)));
        if let Some((mcu, _)) = &mut self.away {
            mcu.advance(self.now);
        }
        self.exchange()?;
        self.watch();
        Ok(())
    }

    /// Takes what the line has and gives it what is due; a frame that it does not take whole goes on later.
    fn exchange(&mut self) -> Result<(), PtyError> {
        let mut input = [0; 4096];
        let count = self.pty.as_ref().map_or(Ok(0), |pty| pty.read(&mut input))?;
        let bytes = input.get_mut(..count).unwrap_or(&mut []);
        if let Some(noise) = &mut self.noise {
            hit(noise, bytes);
        }
        let (present, configs) = (self.present(), self.judge.configs);
        self.judge.receive(bytes, &present);
        if self.judge.configs > configs {
            self.sent.at_config = self.sent.next;
        }
        self.mcu.receive(self.now, bytes);
        if self.unsent.is_empty() || self.held_back {
            self.mcu.transmit(self.now, &mut self.unsent);
            self.sent.receive(&self.unsent);
            if let Some(noise) = &mut self.noise {
                hit(noise, &mut self.unsent);
                babble(noise, &mut self.unsent);
            }
        }
        match &self.pty {
            Some(_) if self.held_back => {}
            Some(pty) => {
                let taken = pty.write(&self.unsent)?;
                self.unsent.drain(..taken);
            }
            None => self.unsent.clear(),
        }
        Ok(())
    }

    fn present(&self) -> Present {
        let config = self.mcu.link().in_force().copied();
        Present { config, drive_mn: milli(self.mcu.commanded_n()), rows: self.sent.next }
    }

    /// What must be true of the gripper after every turn.
    fn watch(&mut self) {
        let (mcu, judge) = match &mut self.away {
            Some((mcu, judge)) => (&*mcu, judge),
            None => (&self.mcu, &mut self.judge),
        };
        let (force_n, state) = (mcu.commanded_n(), mcu.link().state());
        if milli(force_n) > self.limits.force_max_mn {
            judge.violation(format!("the drive is at {force_n} N"));
        }
        let clamped = mcu.link().clamp_bits().0;
        // Force, slew, life or a rejection: the gripper had to correct a command. Without its object it has a fault and rejects all.
        if clamped & 0b1111 != 0 && !mcu.truth().dropped() {
            judge.violation(format!("the gripper had to correct a command ({clamped:#b})"));
        }
        if let Some(least_n) = self.least_n.filter(|least_n| force_n < *least_n) {
            judge.violation(format!("let go to {force_n} N of at least {least_n} N in {state:?}"));
            self.least_n = None;
        }
        if self.least_n.is_some() && mcu.truth().dropped() {
            judge.violation("the object was dropped".to_owned());
            self.least_n = None;
        }
    }

    /// Restarts the gripper in the middle of whatever it does; its rows count from 0 again.
    pub(crate) fn reboot(&mut self) {
        self.mcu.reset();
        self.judge.restarted();
        self.sent = Sent::new();
    }

    /// Closes the port: the name is gone, and whoever had it open is informed.
    pub(crate) fn unplug(&mut self) {
        self.pty = None;
        self.unsent.clear();
    }

    /// Opens another port under the old name.
    pub(crate) fn plug(&mut self) {
        self.pty = Some(Pty::open(Some(&self.link)).unwrap());
    }

    /// Puts another gripper at the port; the right one goes on living without a line.
    pub(crate) fn exchange_for(&mut self, other: &Scene) {
        let stranger = VirtualMcu::new(other, 77).unwrap();
        let right = core::mem::replace(&mut self.mcu, stranger);
        let judge = core::mem::replace(&mut self.judge, Judge::new(self.limits, true));
        self.sent = Sent::new();
        self.away = Some((right, judge));
        self.plug();
    }

    /// Puts the right gripper back; gives the stranger and its judge.
    pub(crate) fn bring_back(&mut self) -> (VirtualMcu, Judge) {
        self.unplug();
        self.sent = Sent::new();
        let (mcu, judge) = self.away.take().unwrap();
        let stranger = core::mem::replace(&mut self.mcu, mcu);
        let judge = core::mem::replace(&mut self.judge, judge);
        self.plug();
        (stranger, judge)
    }

    /// From now on the line holds back what the gripper sends, or delivers all of it.
    pub(crate) fn hold_back(&mut self, hold: bool) {
        self.held_back = hold;
    }

    /// From now on bytes are changed and added on both ways, or no more.
    pub(crate) fn disturb(&mut self, seed: Option<u64>) {
        self.noise = seed.map(ChaCha8Rng::seed_from_u64);
    }

    /// From now on the force must not fall below what it is, nor the object; or it may.
    pub(crate) fn must_hold(&mut self, hold: bool) {
        self.least_n = hold.then(|| KEPT * self.mcu.commanded_n());
    }

    /// The gripper follows fresh commands.
    pub(crate) fn is_active(&self) -> bool {
        self.mcu.link().state() == DeviceState::Active
    }

    /// Number of the row after the newest that was sent, and what it was when the newest settings came.
    pub(crate) fn rows_sent(&self) -> (u32, u32) {
        (self.sent.next, self.sent.at_config)
    }

    /// Longest time (us) for which the machine let the gripper's thread wait since this was asked last.
    pub(crate) fn take_stall_us(&mut self) -> u64 {
        core::mem::take(&mut self.stalled_us)
    }

    /// Time of the gripper (us).
    pub(crate) fn now_us(&self) -> u64 {
        self.now.0
    }
}

/// Changes a byte in some of the pieces.
fn hit(noise: &mut ChaCha8Rng, bytes: &mut [u8]) {
    let Some(last) = bytes.len().checked_sub(1) else { return };
    if noise.next_u32().is_multiple_of(4) {
        let place = noise.next_u32() as usize % (last + 1);
        if let Some(byte) = bytes.get_mut(place) {
            *byte ^= 1 << (noise.next_u32() % 8);
        }
    }
}

/// Adds bytes that nobody sent.
fn babble(noise: &mut ChaCha8Rng, bytes: &mut Vec<u8>) {
    if noise.next_u32().is_multiple_of(4) {
        let from = bytes.len();
        bytes.resize(from + noise.next_u32() as usize % 64, 0);
        noise.fill_bytes(bytes.get_mut(from..).unwrap_or(&mut []));
    }
}

#[expect(clippy::cast_possible_truncation, reason = "forces stay below 1e5 N")]
fn milli(newtons: f64) -> i32 {
    (newtons * 1000.0).round() as i32
}

/// A gripper in a thread; it ends with this.
#[derive(Debug)]
pub(crate) struct Gripper {
    bench: Arc<Mutex<Bench>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Gripper {
    /// A gripper with an open hand at the port `link`.
    pub(crate) fn start(scene: &Scene, link: &Path, limits: Limits) -> Self {
        let mcu = VirtualMcu::new(scene, 1).unwrap();
        let bench = Arc::new(Mutex::new(Bench {
            mcu,
            away: None,
            judge: Judge::new(limits, false),
            link: link.to_owned(),
            limits,
            pty: Some(Pty::open(Some(link)).unwrap()),
            unsent: Vec::new(),
            sent: Sent::new(),
            noise: None,
            held_back: false,
            least_n: None,
            now: Micros(0),
            seen: time::now(),
            stalled_us: 0,
        }));
        let stop = Arc::new(AtomicBool::new(false));
        let (inside, over) = (Arc::clone(&bench), Arc::clone(&stop));
        let thread = thread::Builder::new()
            .name("gripper".to_owned())
            .spawn(move || live(&inside, &over))
            .unwrap();
        Self { bench, stop, thread: Some(thread) }
    }

    /// The gripper between two turns; time stands still for it meanwhile.
    pub(crate) fn bench(&self) -> MutexGuard<'_, Bench> {
        self.bench.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The gripper is pressed on the object and follows fresh commands.
    pub(crate) fn until_gripped(&self) -> bool {
        time::until(120, || {
            let bench = self.bench();
            bench.is_active() && bench.mcu.commanded_n() > 1.5
        })
    }
}

impl Drop for Gripper {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has printed why; the run then fails by what it did not do.
            drop(thread.join());
        }
    }
}

fn live(bench: &Mutex<Bench>, over: &AtomicBool) {
    while !over.load(Ordering::Relaxed) {
        {
            let mut bench = bench.lock().unwrap_or_else(PoisonError::into_inner);
            let failed = bench.turn().err().map(|error| format!("the line failed: {error}"));
            if let Some(failed) = failed {
                bench.judge.violation(failed);
                return;
            }
        }
        time::wait_us(400);
    }
}
