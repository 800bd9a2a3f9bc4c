//! A kind of object in; a folder with a gripper, its configuration and a gripd in it, out.

use super::{
    gripper::Gripper,
    judge::Limits,
    outcome::Outcome,
    recordings::{self, Found},
};
use crate::{daemon::process::Daemon, time};
use anyhow::{Context as _, Result, bail};
use core::net::SocketAddr;
use grip_sim::Scene;
use std::{
    fs,
    net::TcpListener,
    path::{Path, PathBuf},
    process::ExitStatus,
};
use tempfile::TempDir;

/// Limits of the configuration, below those of the gripper.
pub(super) const LIMITS: Limits = Limits { force_max_mn: 30_000, slew_mn_s: 500_000 };

/// What all kinds of faults share.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The program.
    pub gripd: &'a Path,
    /// Seed of everything that is random.
    pub seed: u64,
    /// What a recording may lack beyond what is promised (ms), on a machine that is busy with other tests.
    pub slack_ms: u64,
}

/// The object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Object {
    /// In the air as soon as the fingers have closed, however long that takes; the trial force holds it.
    Lifted,
    /// On its support for a minute.
    Supported,
    /// Slips when its load comes: the trial force of 1.2 N is a fifth of what it needs.
    Slipping,
}

impl Object {
    pub(super) fn scene(self, seed: u64) -> Result<Scene> {
        let lift_s = if self == Self::Slipping { 0.3 } else { 60.0 };
        let (mass_kg, friction) = if self == Self::Slipping { (0.4, 0.35) } else { (0.04, 0.4) };
        let text = format!(
            "name = \"faults\"\nseed = {seed}\nmass_kg = {mass_kg:?}\nfriction = {friction:?}\nroughness_ra_um = 1.6\nlift_at_s = {lift_s:?}\n"
        );
        Ok(Scene::from_toml(&text)?)
    }
}

/// A folder, a gripper and the address of its daemon.
#[derive(Debug)]
pub(super) struct Rig<'a> {
    pub(super) setup: Setup<'a>,
    object: Object,
    pub(super) folder: TempDir,
    pub(super) gripper: Gripper,
    pub(super) address: SocketAddr,
    trial_n: f64,
}

impl<'a> Rig<'a> {
    /// A gripper with `object`, and no daemon yet.
    pub(super) fn new(setup: &Setup<'a>, object: Object) -> Result<Self> {
        Self::with(setup, object, 1, 2.0)
    }

    /// A gripper with an object that slips when its load comes.
    pub(super) fn slipping(setup: &Setup<'a>, seed: u64) -> Result<Self> {
        Self::with(setup, Object::Slipping, seed, 1.2)
    }

    fn with(setup: &Setup<'a>, object: Object, seed: u64, trial_n: f64) -> Result<Self> {
        let folder = tempfile::tempdir().context("a folder")?;
        let scene = object.scene(seed)?;
        let gripper = Gripper::start(&scene, &folder.path().join("gripper"), LIMITS)?;
        let address = free_address()?;
        let rig = Self { setup: *setup, object, folder, gripper, address, trial_n };
        rig.configure("backoff_n_s = 20.0")?;
        Ok(rig)
    }

    /// Writes the configuration, with one more line about the grip. Nothing is searched, so a force that falls is a fault.
    pub(super) fn configure(&self, grip: &str) -> Result<()> {
        let file = self.folder.path().join("gripd.toml");
        let Limits { force_max_mn, slew_mn_s } = LIMITS;
        let text = format!(
            "listen = \"tcp:{}\"\nallow_commands = true\n[grip]\nf_max_n = {:?}\nslew_n_s = {:?}\ntrial_force_n = {:?}\nrelax_per_s = 0.0\n{grip}\n",
            self.address,
            f64::from(force_max_mn) / 1e3,
            f64::from(slew_mn_s) / 1e3,
            self.trial_n
        );
        fs::write(&file, text).with_context(|| file.display().to_string())
    }

    /// gripd with these flags beside those of the rig.
    pub(super) fn daemon(&self, args: &[&str]) -> Result<Daemon> {
        let fixed = ["--config", "gripd.toml", "--port", "./gripper", "--wait"];
        Daemon::start(self.setup.gripd, self.folder.path(), &[&fixed[..], args].concat())
    }

    /// gripd that has closed the fingers and lifted what is to be lifted; from now on the force must not fall.
    pub(super) fn gripping(&self, args: &[&str]) -> Result<Daemon> {
        let daemon = self.daemon(args)?;
        self.until_held(&daemon)?;
        Ok(daemon)
    }

    pub(super) fn until_held(&self, daemon: &Daemon) -> Result<()> {
        let gripped = self.gripper.until_gripped();
        self.missed(gripped, "the object is not gripped", daemon)?;
        if self.object == Object::Lifted {
            self.gripper.bench().mcu.lift();
        }
        time::wait_ms(600 + self.setup.slack_ms);
        self.gripper.bench().must_hold(true);
        Ok(())
    }

    /// An error unless `happened`.
    pub(super) fn missed(&self, happened: bool, what: &'static str, daemon: &Daemon) -> Result<()> {
        if happened {
            return Ok(());
        }
        let bench = self.gripper.bench();
        let state = format!("{:?} at {} N", bench.mcu.link().state(), bench.mcu.commanded_n());
        bail!("{what}; gripd said: {} (gripper: {state})", daemon.log())
    }

    /// The daemon goes on commanding a gripper that follows it.
    pub(super) fn commands_again(&self, daemon: &Daemon) -> Result<()> {
        let before = self.gripper.bench().judge.commands;
        let again = time::until(30, || {
            let bench = self.gripper.bench();
            bench.judge.commands > before + 200 && bench.is_active()
        });
        self.missed(again, "the daemon does not command any more", daemon)
    }

    /// Ends gripd as a service manager does; all promises are judged.
    pub(super) fn finish(&self, daemon: &mut Daemon, outcome: &mut Outcome) -> Result<()> {
        let status = daemon.end()?;
        outcome.require(is_orderly(status), || format!("gripd ended with {status}"));
        outcome.require(!daemon.log().contains("panicked"), || daemon.log());
        outcome.receive(&self.gripper);
        outcome.recordings += self.recordings()?.len() as u64;
        Ok(())
    }

    /// All recordings of the rig, read or recovered.
    pub(super) fn recordings(&self) -> Result<Vec<(PathBuf, Found)>> {
        recordings::read_all(self.folder.path())
    }
}

/// Done, or done with a loss of data that was reported.
fn is_orderly(status: ExitStatus) -> bool {
    matches!(status.code(), Some(0 | 3))
}

/// A port of the loopback that nobody uses.
fn free_address() -> Result<SocketAddr> {
    let listening = TcpListener::bind("127.0.0.1:0");
    listening.and_then(|listener| listener.local_addr()).context("a free port")
}
