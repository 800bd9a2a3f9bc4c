//! Disks that are full: the recording stops, is reported once and counted, and the grip goes on.

use super::{
    outcome::Outcome,
    rig::{Object, Rig, Setup},
};
use crate::{daemon::process::Daemon, time};
use anyhow::Result;
use std::process::Command;

/// Room for a recording (bytes): about a second of it.
const ROOM: u64 = 1 << 20;
/// What the daemon reports when a recording stops.
const REPORTED: &str = "the object is held without a recording";

/// A disk that is full where one may be mounted, and files that may not grow.
pub(super) fn run(setup: &Setup<'_>) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    match Disk::mount() {
        Some(disk) => {
            let file = disk.0.path().join("full.mcap").display().to_string();
            one(setup, &mut outcome, &file, |_| Ok(()))?;
            // What fitted on the disk is readable.
            outcome.recordings += super::recordings::read_all(disk.0.path())?.len() as u64;
            outcome.figure("a file system of 1 MiB filled up".to_owned());
        }
        None => outcome.figure("a full file system: not tried, only root may mount one".to_owned()),
    }
    one(setup, &mut outcome, "limited.mcap", |daemon| daemon.limit_files(ROOM))?;
    outcome.figure("RLIMIT_FSIZE of 1 MiB reached".to_owned());
    Ok(outcome)
}

fn one(
    setup: &Setup<'_>,
    outcome: &mut Outcome,
    file: &str,
    limit: impl FnOnce(&Daemon) -> Result<()>,
) -> Result<()> {
    outcome.times += 1;
    let rig = Rig::new(setup, Object::Lifted)?;
    let mut daemon = rig.daemon(&["--record", file])?;
    limit(&daemon)?;
    rig.until_held(&daemon)?;
    let stopped = time::until(60, || !daemon.is_running() || daemon.times_stated(REPORTED) > 0);
    daemon.must_run()?;
    rig.missed(stopped, "the recording does not stop", &daemon)?;
    rig.commands_again(&daemon)?;
    let status = daemon.end()?;
    outcome.require(status.code() == Some(3), || {
        format!("lost samples are not reported at the end: {status}, {}", daemon.log())
    });
    let reported = daemon.times_stated(REPORTED);
    outcome.require(reported == 1, || format!("reported {reported} times: {}", daemon.log()));
    outcome.require(!daemon.log().contains("panicked"), || daemon.log());
    outcome.receive(&rig.gripper);
    outcome.recordings += rig.recordings()?.len() as u64;
    Ok(())
}

/// A small file system in a folder; both go with this.
struct Disk(tempfile::TempDir);

impl Disk {
    /// `None` where that is not allowed.
    fn mount() -> Option<Self> {
        let folder = tempfile::tempdir().ok()?;
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={ROOM}"), "tmpfs"])
            .arg(folder.path())
            .output()
            .is_ok_and(|made| made.status.success());
        mounted.then(|| Self(folder))
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // Lazily: nothing may keep the folder; what stays mounted goes with the machine.
        drop(Command::new("umount").arg("-l").arg(self.0.path()).output());
    }
}
