//! A program, a folder and flags in; a running gripd that can be killed, stopped and read, out.

use crate::time;
use anyhow::{Context as _, Result, bail};
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process, prlimit};
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
};

/// Names of its outputs.
const PRINTED: &str = "out.json";
const LOG: &str = "log.txt";

/// A gripd of our own; killed and reaped when it goes out of scope.
#[derive(Debug)]
pub struct Daemon {
    child: Child,
    folder: PathBuf,
}

impl Daemon {
    /// Starts `program` in `folder`, where its outputs stay.
    ///
    /// # Errors
    /// Where it cannot be started.
    pub fn start(program: &Path, folder: &Path, args: &[&str]) -> Result<Self> {
        // Files, because a pipe that nobody empties would stop it.
        let create = |name| File::create(folder.join(name)).context("the output of gripd");
        let mut command = Command::new(program);
        command.current_dir(folder).env_clear().env("HOME", folder).args(args);
        command.stdin(Stdio::null()).stdout(create(PRINTED)?).stderr(create(LOG)?);
        let child = command.spawn().with_context(|| program.display().to_string())?;
        Ok(Self { child, folder: folder.to_owned() })
    }

    /// Its number.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal to our own child.
    ///
    /// # Errors
    /// Where it is gone.
    pub fn signal(&self, signal: Signal) -> Result<()> {
        Ok(kill_process(Pid::from_child(&self.child), signal)?)
    }

    /// Files that it writes end at so many bytes.
    ///
    /// # Errors
    /// Where the system does not allow that.
    pub fn limit_files(&self, bytes: u64) -> Result<()> {
        let limit = Rlimit { current: Some(bytes), maximum: Some(bytes) };
        prlimit(Some(Pid::from_child(&self.child)), Resource::Fsize, limit)?;
        Ok(())
    }

    /// kill -9; it is gone when this returns.
    ///
    /// # Errors
    /// Where it had ended before, which it must not.
    pub fn kill(&mut self) -> Result<()> {
        self.must_run()?;
        self.child.kill().and_then(|()| self.child.wait()).context("gripd")?;
        Ok(())
    }

    /// Whether it still runs.
    pub fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// An error where it has ended by itself.
    ///
    /// # Errors
    /// How it ended, and its log.
    pub fn must_run(&mut self) -> Result<()> {
        match self.child.try_wait().context("gripd")? {
            Some(status) => bail!("gripd ended by itself ({status}): {}", self.log()),
            None => Ok(()),
        }
    }

    /// SIGTERM: how it ended, within 20 s.
    ///
    /// # Errors
    /// Where it does not end.
    pub fn end(&mut self) -> Result<ExitStatus> {
        self.must_run()?;
        self.signal(Signal::TERM)?;
        let mut ended = None;
        time::until(20, || {
            ended = self.child.try_wait().ok().flatten();
            ended.is_some()
        });
        ended.with_context(|| format!("gripd does not end: {}", self.log()))
    }

    /// All that it said on standard error.
    #[must_use]
    pub fn log(&self) -> String {
        self.read(LOG)
    }

    /// All that it printed.
    #[must_use]
    pub fn printed(&self) -> String {
        self.read(PRINTED)
    }

    fn read(&self, name: &str) -> String {
        let bytes = fs::read(self.folder.join(name)).unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// How often it said this.
    #[must_use]
    pub fn times_stated(&self, text: &str) -> usize {
        self.log().matches(text).count()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may be gone already; a stopped process dies of SIGKILL too.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}
