//! A program, a folder and flags in; a running gripd that can be killed, stopped and asked what it said, out.

use crate::time;
use anyhow::{Context as _, Result, bail};
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process, prlimit};
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
};

/// A gripd of our own; killed and reaped when it goes out of scope.
#[derive(Debug)]
pub(super) struct Daemon {
    child: Child,
    said: PathBuf,
}

impl Daemon {
    /// Starts `program` in `folder` with the configuration `gripd.toml` there.
    ///
    /// # Errors
    /// Where it cannot be started.
    pub(super) fn start(program: &Path, folder: &Path, args: &[&str]) -> Result<Self> {
        let said = folder.join("said.txt");
        let file = File::create(&said).with_context(|| said.display().to_string())?;
        let mut command = Command::new(program);
        command.current_dir(folder).env_clear().env("HOME", folder);
        command.args(["--config", "gripd.toml", "--port", "./gripper", "--wait"]).args(args);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
        let child = command.spawn().with_context(|| program.display().to_string())?;
        Ok(Self { child, said })
    }

    /// Sends a signal to our own child.
    ///
    /// # Errors
    /// Where it is gone.
    pub(super) fn signal(&self, signal: Signal) -> Result<()> {
        Ok(kill_process(Pid::from_child(&self.child), signal)?)
    }

    /// Files that it writes end at so many bytes.
    ///
    /// # Errors
    /// Where the system does not allow that.
    pub(super) fn limit_files(&self, bytes: u64) -> Result<()> {
        let limit = Rlimit { current: Some(bytes), maximum: Some(bytes) };
        prlimit(Some(Pid::from_child(&self.child)), Resource::Fsize, limit)?;
        Ok(())
    }

    /// kill -9; it is gone when this returns.
    ///
    /// # Errors
    /// Where it had ended before, which it must not.
    pub(super) fn kill(&mut self) -> Result<()> {
        self.must_run()?;
        self.child
            .kill()
            .and_then(|()| self.child.wait())
            .with_context(|| self.said.display().to_string())?;
        Ok(())
    }

    /// Whether it still runs.
    pub(super) fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// An error where it has ended by itself.
    ///
    /// # Errors
    /// How it ended, and what it said.
    pub(super) fn must_run(&mut self) -> Result<()> {
        match self.child.try_wait().with_context(|| self.said.display().to_string())? {
            Some(status) => bail!("gripd ended by itself ({status}): {}", self.said()),
            None => Ok(()),
        }
    }

    /// SIGTERM: how it ended, within 20 s.
    ///
    /// # Errors
    /// Where it does not end.
    pub(super) fn end(&mut self) -> Result<ExitStatus> {
        self.must_run()?;
        self.signal(Signal::TERM)?;
        let mut ended = None;
        time::until(20, || {
            ended = self.child.try_wait().ok().flatten();
            ended.is_some()
        });
        ended.with_context(|| format!("gripd does not end: {}", self.said()))
    }

    /// All that it said on standard error.
    #[must_use]
    pub(super) fn said(&self) -> String {
        fs::read(&self.said)
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
            .unwrap_or_default()
    }

    /// How often it said this.
    #[must_use]
    pub(super) fn times_said(&self, text: &str) -> usize {
        self.said().matches(text).count()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may be gone already; a stopped process dies of SIGKILL too.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}
