//! A program that runs in a folder with arguments while the story goes on.

use crate::{build, looked, until};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::{
    env,
    fs::{self, File},
    io::Write as _,
    path::Path,
    process::{Child, Command, Stdio},
    thread,
};
use tempfile::TempDir;

/// Longer than any run, however busy the machine (ms).
const ENDING_MS: u32 = 300_000;

/// A program of ours; killed when it goes out of scope.
#[derive(Debug)]
pub struct Program {
    child: Child,
    /// What it prints goes there.
    output: TempDir,
}

/// One that has ended.
#[derive(Debug)]
pub struct Ended {
    /// Its exit code.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

/// The call of a program in `folder`, unaware of the settings of whoever runs the tests.
#[must_use]
pub fn command(program: impl AsRef<Path>, folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(program.as_ref());
    let path = env::var_os("PATH").unwrap_or_default();
    command.current_dir(folder).env_clear().env("HOME", folder).env("PATH", path).args(args);
    command
}

impl Program {
    /// Starts gripd in `folder`, unaware of the settings of whoever runs the stories.
    #[must_use]
    pub fn gripd(folder: &Path, args: &[&str]) -> Self {
        Self::start(build::program("gripd"), folder, args)
    }

    /// Starts gripctl in `folder`.
    #[must_use]
    pub fn gripctl(folder: &Path, args: &[&str]) -> Self {
        Self::start(build::program("gripctl"), folder, args)
    }

    /// Starts the program of this file in `folder`.
    #[must_use]
    pub fn start(program: &Path, folder: &Path, args: &[&str]) -> Self {
        Self::of(command(program, folder, args))
    }

    /// Starts what is called.
    #[must_use]
    pub fn of(mut command: Command) -> Self {
        let output = tempfile::tempdir().unwrap();
        let file = |name: &str| File::create(output.path().join(name)).unwrap();
        let child = command.stdout(file("out")).stderr(file("err")).spawn().unwrap();
        Self { child, output }
    }

    /// Starts what is called, with `input` on its standard input.
    #[must_use]
    pub fn fed(mut command: Command, input: Vec<u8>) -> Self {
        command.stdin(Stdio::piped());
        let mut program = Self::of(command);
        let mut stdin = program.child.stdin.take().unwrap();
        // Whoever has read enough closes it.
        thread::spawn(move || stdin.write_all(&input).unwrap_or_default());
        program
    }

    /// What it printed so far.
    #[must_use]
    pub fn printed(&self) -> String {
        fs::read_to_string(self.output.path().join("out")).unwrap()
    }

    /// What it said on standard error so far.
    #[must_use]
    pub fn reported(&self) -> String {
        fs::read_to_string(self.output.path().join("err")).unwrap()
    }

    /// The whole lines that it printed so far, as JSON.
    #[must_use]
    pub fn lines(&self) -> Vec<Value> {
        let printed = self.printed();
        json(&printed[..printed.rfind('\n').map_or(0, |end| end + 1)])
    }

    /// Waits until `what` is printed.
    #[track_caller]
    pub fn until_printed(&self, what: &str) {
        let there = until(|| self.printed().contains(what));
        assert!(there, "no {what:?} in {}{}", self.printed(), self.reported());
    }

    /// Waits until `what` stands on standard error.
    #[track_caller]
    pub fn until_reported(&self, what: &str) {
        assert!(until(|| self.reported().contains(what)), "no {what:?} in {}", self.reported());
    }

    /// Its number.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether it still runs.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// kill -9; it is gone when this returns.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ends it as Ctrl-C does, and waits for it.
    #[must_use]
    pub fn interrupted(self) -> Ended {
        self.signal(Signal::INT);
        self.ended()
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Waits for its end; a panic or a signal is none.
    #[must_use]
    pub fn ended(mut self) -> Ended {
        let mut status = None;
        looked(ENDING_MS, || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        let (out, err) = (self.printed(), self.reported());
        assert!(!err.contains("panicked"), "{err}");
        let code = status.and_then(|status| status.code());
        Ended { code: code.unwrap_or_else(|| panic!("no end: {status:?} {out}{err}")), out, err }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Of one that has ended there is nothing to kill.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

impl Ended {
    /// Done, or done with the loss of data that a busy machine may cause.
    #[track_caller]
    pub fn done(self) -> Self {
        assert!([0, 3].contains(&self.code), "{self:?}");
        self
    }

    /// Ended with `code`, said each of `words` and nothing twice, and printed no result.
    #[track_caller]
    pub fn refused(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, code, "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "no {word:?} in {}", self.err);
        }
        let longest = self.err.lines().max_by_key(|line| line.len()).unwrap_or_default();
        let reported = longest.split_once(": ").map_or(longest, |(_, text)| text);
        assert_eq!(self.err.matches(reported).count(), 1, "reported twice: {}", self.err);
        assert!(self.out.is_empty(), "{self:?}");
        self
    }

    /// The lines of standard output as JSON.
    #[must_use]
    pub fn lines(&self) -> Vec<Value> {
        json(&self.out)
    }

    /// The last of them.
    #[must_use]
    pub fn summary(&self) -> Value {
        self.lines().pop().unwrap_or_else(|| panic!("nothing was printed: {self:?}"))
    }
}

fn json(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}
