//! A gripper that the story plays itself, so that it can be broken and unplugged: the virtual microcontroller behind a pseudo-terminal.
//!
//! Its time follows the clock of the machine but never jumps: a busy machine slows it down.

use grip_link::message::DeviceState;
use grip_sim::{Pty, Scene, VirtualMcu};
use slip_core::units::Micros;
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Longest step of the gripper's time (us).
const LONGEST_STEP_US: u64 = 2_000;
/// Gripper's time in which whatever is waited for must happen (us).
const PATIENCE_US: u64 = 60_000_000;
/// Turns between two looks of the story: some 10 ms.
const LOOK_TURNS: u32 = 20;

/// The gripper and its end of the line.
#[derive(Debug)]
pub struct Gripper {
    /// What is behind the port.
    pub mcu: VirtualMcu,
    link: PathBuf,
    pty: Option<Pty>,
    now: Micros,
    seen: Instant,
    /// Echoes what comes and lets a modem manager talk.
    pub noisy: bool,
    turns: u64,
}

impl Gripper {
    /// A gripper with the object of `scene`, at a port called `gripper` in `folder`.
    #[must_use]
    pub fn plugged_in(folder: &Path, scene: &str) -> Self {
        let mcu = VirtualMcu::new(&Scene::from_toml(scene).unwrap(), 1).unwrap();
        let link = folder.join("gripper");
        let pty = Some(Pty::open(Some(&link)).unwrap());
        Self { mcu, link, pty, now: Micros(0), seen: now(), noisy: false, turns: 0 }
    }

    /// Takes its plug out of the computer.
    pub fn unplug(&mut self) {
        self.pty = None;
    }

    /// Puts it in again.
    pub fn plug_in(&mut self) {
        self.pty = Some(Pty::open(Some(&self.link)).unwrap());
    }

    /// Force that it asks of its fingers (N).
    #[must_use]
    pub fn force_n(&self) -> f64 {
        self.mcu.commanded_n()
    }

    /// What its link is doing.
    #[must_use]
    pub fn state(&self) -> DeviceState {
        self.mcu.link().state()
    }

    /// Lives until `done`; it looks every few turns.
    #[track_caller]
    pub fn until(&mut self, what: &str, done: impl FnMut(&VirtualMcu) -> bool) {
        self.until_each(LOOK_TURNS, what, done);
    }

    /// Lives until `done`, which is asked after every turn.
    #[track_caller]
    pub fn watch(&mut self, what: &str, done: impl FnMut(&VirtualMcu) -> bool) {
        self.until_each(1, what, done);
    }

    #[track_caller]
    fn until_each(&mut self, turns: u32, what: &str, mut done: impl FnMut(&VirtualMcu) -> bool) {
        let from = self.now;
        while !done(&self.mcu) {
            (0..turns).for_each(|_| self.turn());
            let waited = self.now.since(from).0;
            assert!(waited < PATIENCE_US, "not within a minute: {what}; {:?}", self.mcu.truth());
        }
    }

    /// Lives for some time; the least force meanwhile (N).
    pub fn live(&mut self, ms: u64) -> f64 {
        let (end, mut least_n) = (self.now.plus(Micros(1000 * ms)), self.force_n());
        while self.now < end {
            self.turn();
            least_n = least_n.min(self.force_n());
        }
        least_n
    }

    /// Lets a time pass without any host; the forces after each millisecond (N).
    pub fn alone(&mut self, ms: u64) -> Vec<f64> {
        let step = |_| {
            self.now = self.now.plus(Micros(1000));
            self.mcu.advance(self.now);
            self.force_n()
        };
        (0..ms).map(step).collect()
    }

    /// Takes all that the host wrote before it was stopped.
    pub fn drain(&mut self) {
        while self.pty.as_ref().is_some_and(|pty| pty.wait(0, false).unwrap().read) {
            self.exchange();
        }
    }

    fn turn(&mut self) {
        self.turns += 1;
        match &self.pty {
            Some(pty) => drop(pty.wait(500, false).unwrap()),
            None => drop(crate::pause()),
        }
        let real = now();
        let passed = real.duration_since(self.seen).as_micros();
        self.seen = real;
        let step = u64::try_from(passed).unwrap_or(LONGEST_STEP_US).clamp(1, LONGEST_STEP_US);
        self.now = self.now.plus(Micros(step));
        self.exchange();
    }

    fn exchange(&mut self) {
        let (mut input, mut out) = ([0; 4096], Vec::new());
        let count = self.pty.as_ref().map_or(0, |pty| pty.read(&mut input).unwrap());
        let received = input.get(..count).unwrap_or_default();
        if self.noisy && self.turns.is_multiple_of(10) {
            self.mcu.receive(self.now, b"AT+GCAP\r\n");
        }
        self.mcu.receive(self.now, received);
        self.mcu.transmit(self.now, &mut out);
        if self.noisy {
            out.extend_from_slice(received);
        }
        if let Some(pty) = &self.pty {
            // What the line does not take is lost, as on a real wire.
            pty.write(&out).unwrap();
        }
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "a daemon lives in real time, and its gripper with it"
)]
fn now() -> Instant {
    Instant::now()
}
