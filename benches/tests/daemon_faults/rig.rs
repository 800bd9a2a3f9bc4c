//! Test rig: a folder with a gripper that holds a kind of object, its configuration and a gripd.

use super::{
    gripper::Gripper,
    judge::Limits,
    recordings::{self, Found},
};
use core::net::SocketAddr;
use grip_sim::Scene;
use slip_benches::time;
use std::{
    fs,
    net::TcpListener,
    path::PathBuf,
    sync::{Mutex, MutexGuard, PoisonError},
};
use stories::{Program, Signal};
use tempfile::TempDir;

/// Limits of the configuration, below those of the gripper.
const LIMITS: Limits = Limits { force_max_mn: 30_000, slew_mn_s: 500_000 };
/// What a recording may lack beyond what is promised (ms): other tests run beside.
pub(crate) const SLACK_MS: u64 = 500;

/// A gripper at 10 kHz lives in real time: several of them at once would be too much for two processors.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// The object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Object {
    /// In the air as soon as the fingers have closed, however long that takes; the trial force holds it.
    Lifted,
    /// On its support for a minute.
    Supported,
    /// Slips when its load comes: the trial force of 1.2 N is a fifth of what it needs.
    Slipping,
}

impl Object {
    pub(crate) fn scene(self, seed: u64) -> Scene {
        let lift_s = if self == Self::Slipping { 0.3 } else { 60.0 };
        let (mass_kg, friction) = if self == Self::Slipping { (0.4, 0.35) } else { (0.04, 0.4) };
        let text = format!(
            "name = \"faults\"\nseed = {seed}\nmass_kg = {mass_kg:?}\nfriction = {friction:?}\nroughness_ra_um = 1.6\nlift_at_s = {lift_s:?}\n"
        );
        Scene::from_toml(&text).unwrap()
    }
}

/// A folder, a gripper and the address of its daemon.
pub(crate) struct Rig {
    object: Object,
    pub(crate) folder: TempDir,
    pub(crate) gripper: Gripper,
    pub(crate) address: SocketAddr,
    _alone: MutexGuard<'static, ()>,
}

impl Rig {
    /// A gripper with `object`, and no daemon yet.
    pub(crate) fn new(object: Object) -> Self {
        Self::seeded(object, 1)
    }

    pub(crate) fn seeded(object: Object, seed: u64) -> Self {
        // One that failed shows nothing of the others.
        let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = tempfile::tempdir().unwrap();
        let gripper = Gripper::start(&object.scene(seed), &folder.path().join("gripper"), LIMITS);
        // A port of the loopback that nobody uses.
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let rig = Self { object, folder, gripper, address, _alone };
        rig.configure();
        rig
    }

    /// Writes the configuration. Nothing is searched, so a force that falls is a fault.
    fn configure(&self) {
        let Limits { force_max_mn, slew_mn_s } = LIMITS;
        let trial_n = if self.object == Object::Slipping { 1.2 } else { 2.0 };
        let text = format!(
            "listen = \"tcp:{}\"\nallow_commands = true\n[grip]\nf_max_n = {:?}\nslew_n_s = {:?}\ntrial_force_n = {trial_n:?}\nrelax_per_s = 0.0\nbackoff_n_s = 20.0\n",
            self.address,
            f64::from(force_max_mn) / 1e3,
            f64::from(slew_mn_s) / 1e3,
        );
        fs::write(self.folder.path().join("gripd.toml"), text).unwrap();
    }

    /// gripd with these flags beside those of the rig.
    pub(crate) fn daemon(&self, args: &[&str]) -> Program {
        let fixed = ["--config", "gripd.toml", "--port", "./gripper", "--wait"];
        Program::gripd(self.folder.path(), &[&fixed[..], args].concat())
    }

    /// gripd that has closed the fingers and lifted what is to be lifted; from now on the force must not fall.
    pub(crate) fn gripping(&self, args: &[&str]) -> Program {
        let daemon = self.daemon(args);
        self.until_held(&daemon);
        daemon
    }

    pub(crate) fn until_held(&self, daemon: &Program) {
        self.must(self.gripper.until_gripped(), "the object is not gripped", daemon);
        if self.object == Object::Lifted {
            self.gripper.bench().mcu.lift();
        }
        time::wait_ms(600 + SLACK_MS);
        self.gripper.bench().must_hold(true);
    }

    /// Panics unless it `happened`.
    #[track_caller]
    pub(crate) fn must(&self, happened: bool, what: &str, daemon: &Program) {
        let (state, force_n) = {
            let bench = self.gripper.bench();
            (bench.mcu.link().state(), bench.mcu.commanded_n())
        };
        let stated = daemon.reported();
        assert!(happened, "{what}; gripd said: {stated} (gripper: {state:?} at {force_n} N)");
    }

    /// The daemon goes on commanding a gripper that follows it.
    #[track_caller]
    pub(crate) fn commands_again(&self, daemon: &Program, more: u64) {
        let before = self.gripper.bench().judge.commands;
        let again = time::until(30, || {
            let bench = self.gripper.bench();
            bench.judge.commands > before + more && bench.is_active()
        });
        self.must(again, "the daemon does not command any more", daemon);
    }

    /// Ends gripd as a service manager does, done or with a loss of data that was reported; all promises are judged.
    pub(crate) fn finish(&self, daemon: Program) {
        daemon.signal(Signal::TERM);
        let _done = daemon.ended().done();
        self.gripper.bench().judge.must_be_kept();
        let recordings = self.recordings();
        println!("{} recordings read or recovered", recordings.len());
        assert!(!recordings.is_empty() && self.gripper.bench().judge.commands > 100);
    }

    /// All recordings of the rig, read or recovered.
    pub(crate) fn recordings(&self) -> Vec<(PathBuf, Found)> {
        recordings::read_all(self.folder.path())
    }
}

/// How often a program has stated this on standard error.
pub(crate) fn times_stated(daemon: &Program, text: &str) -> usize {
    daemon.reported().matches(text).count()
}
