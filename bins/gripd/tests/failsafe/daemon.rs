//! A real gripd on one end of a pseudo-terminal, a virtual gripper on the other, served by the test itself.
//!
//! The gripper's time follows the clock of the machine but never jumps: a busy machine slows it down. Once gripd is dead or
//! stopped its time goes on as fast as the test likes.

use grip_link::message::DeviceState;
use grip_sim::{Pty, Scene, VirtualMcu};
use rustix::process::{Pid, Signal, kill_process};
use slip_core::units::Micros;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Instant;

/// Longest step of the gripper's time (us).
const LONGEST_STEP_US: u64 = 2_000;
/// Gripper's time in which whatever is waited for must happen (us).
const PATIENCE_US: u64 = 60_000_000;
/// Also waited for this many turns at least, should the machine's clock jump.
const LEAST_TURNS: u64 = 20_000;

/// The daemon; killed and reaped when it goes out of scope.
pub(crate) struct Daemon(Child);

impl Daemon {
    pub(crate) fn start(folder: &Path, port: &Path) -> Self {
        // A force that stands, whatever the object needs.
        let grip = "[grip]\ntrial_force_n = 2.0\nrelax_per_s = 0.0\n";
        std::fs::write(folder.join("gripd.toml"), grip).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_gripd"));
        command.current_dir(folder).env_clear().env("HOME", folder).arg("--port").arg(port);
        command.stdout(Stdio::null()).stderr(Stdio::inherit());
        Self(command.spawn().unwrap())
    }

    /// Only ever our own child.
    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
    }

    /// kill -9, and wait until it is gone.
    pub(crate) fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// SIGSTOP, and wait until nothing of it runs.
    pub(crate) fn stop(&self) {
        self.signal(Signal::STOP);
        let stat = format!("/proc/{}/stat", self.0.id());
        let stopped = || {
            let text = std::fs::read_to_string(&stat).unwrap();
            text.rsplit(')').next().is_some_and(|rest| rest.trim_start().starts_with('T'))
        };
        while !stopped() {
            std::thread::yield_now();
        }
    }

    pub(crate) fn is_running(&mut self) -> bool {
        self.0.try_wait().unwrap().is_none()
    }

    /// SIGTERM: how it ended.
    pub(crate) fn end(mut self, rig: &mut Rig) -> ExitStatus {
        self.signal(Signal::TERM);
        let mut status = None;
        rig.until("gripd ends", |_| {
            status = self.0.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may be gone already; a stopped process dies of SIGKILL too.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// The gripper and its end of the line.
pub(crate) struct Rig {
    pub(crate) pty: Pty,
    pub(crate) mcu: VirtualMcu,
    now: Micros,
    seen: Instant,
    /// Echoes what comes and lets a modem manager talk.
    pub(crate) noisy: bool,
    turns: u64,
}

impl Rig {
    pub(crate) fn new() -> Self {
        let text = "name = \"t\"\nmass_kg = 0.02\nfriction = 0.3\nroughness_ra_um = 1.6\nlift_at_s = 60.0\n";
        let mcu = VirtualMcu::new(&Scene::from_toml(text).unwrap(), 1).unwrap();
        let pty = Pty::open(None).unwrap();
        Self { pty, mcu, now: Micros(0), seen: now(), noisy: false, turns: 0 }
    }

    /// Serves the line until `done`, looking after every turn.
    pub(crate) fn until(&mut self, what: &str, mut done: impl FnMut(&VirtualMcu) -> bool) {
        let (from, turns) = (self.now, self.turns);
        loop {
            self.turn();
            if done(&self.mcu) {
                return;
            }
            let waited = self.now.since(from).0 > PATIENCE_US && self.turns - turns > LEAST_TURNS;
            assert!(!waited, "{what}: {:?}, {} N", self.state(), self.force_n());
        }
    }

    /// Serves the line for a time of the gripper.
    pub(crate) fn serve(&mut self, ms: u64, mut look: impl FnMut(&VirtualMcu)) {
        let end = self.now.plus(Micros(1000 * ms));
        while self.now < end {
            self.turn();
            look(&self.mcu);
        }
    }

    fn turn(&mut self) {
        self.turns += 1;
        self.pty.wait(500, false).unwrap();
        let real = now();
        let passed = real.duration_since(self.seen).as_micros();
        self.seen = real;
        let step = u64::try_from(passed).unwrap_or(LONGEST_STEP_US).clamp(1, LONGEST_STEP_US);
        self.now = self.now.plus(Micros(step));
        self.exchange();
    }

    fn exchange(&mut self) {
        let mut input = [0; 4096];
        let count = self.pty.read(&mut input).unwrap();
        if self.noisy && self.turns.is_multiple_of(10) {
            self.mcu.receive(self.now, b"AT+GCAP\r\n");
        }
        self.mcu.receive(self.now, &input[..count]);
        let mut out = Vec::new();
        self.mcu.transmit(self.now, &mut out);
        if self.noisy {
            out.extend_from_slice(&input[..count]);
        }
        // What the line does not take is lost, as on a real wire.
        self.pty.write(&out).unwrap();
    }

    /// Gives the gripper all that gripd wrote before it was stopped.
    pub(crate) fn drain(&mut self) {
        while self.pty.wait(0, false).unwrap().read {
            self.exchange();
        }
    }

    /// Lets a time of the gripper pass without any host; the forces after each millisecond (N).
    pub(crate) fn alone(&mut self, ms: u64) -> Vec<f64> {
        let step = |_| {
            self.now = self.now.plus(Micros(1000));
            self.mcu.advance(self.now);
            self.mcu.commanded_n()
        };
        (0..ms).map(step).collect()
    }

    pub(crate) fn state(&self) -> DeviceState {
        self.mcu.link().state()
    }

    pub(crate) fn force_n(&self) -> f64 {
        self.mcu.commanded_n()
    }

    /// gripd has closed the fingers and keeps commanding.
    pub(crate) fn until_gripped(&mut self) {
        self.until("gripd grips", |mcu| {
            mcu.link().state() == DeviceState::Active && mcu.commanded_n() > 1.5
        });
        self.serve(200, |_| {});
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "a daemon lives in real time, and its gripper with it"
)]
fn now() -> Instant {
    Instant::now()
}
