//! A folder and arguments in, a gripd that runs while the test talks to it out.

use crate::run::{Ran, command};
use core::time::Duration;
use grip_daemon::client::Client;
use grip_link::message::{
    Versions,
    daemon::{Subscribe, ToClient, Topics},
};
use rustix::process::{Pid, Signal, kill_process};
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::Child,
    thread,
};

/// Looks of 20 ms after which something that should happen has not.
const LOOKS: u32 = 3000;
/// Runs of which one must hold its object.
const TRIES: u32 = 5;

/// gripd on the simulator, with its socket at `gripd.sock` in its folder; killed when it goes out of scope.
pub(crate) struct Running {
    child: Child,
    folder: PathBuf,
}

/// What the subscriber receives: everything but rows.
pub(crate) const UPDATES: Subscribe =
    Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 0, state_ms: 100 };

impl Running {
    /// Starts it, on the default scene where `args` name no port. What it prints goes to files.
    pub(crate) fn start(folder: &Path, args: &[&str]) -> Self {
        let socket = format!("unix:{}", folder.join("gripd.sock").display());
        let port = if args.contains(&"--port") { &[][..] } else { &["--port", "sim"] };
        let args = [port, &["--json", "--listen", &socket], args].concat();
        let child = command(folder, &args)
            .stdout(File::create(folder.join("out.txt")).unwrap())
            .stderr(File::create(folder.join("err.txt")).unwrap())
            .spawn()
            .unwrap();
        Self { child, folder: folder.to_owned() }
    }

    /// One that has had a slip and holds the object. A machine that stops it for longer than the object takes to fall drops it: it may
    /// begin again, without a recording of what was dropped.
    pub(crate) fn holding(folder: &Path, args: &[&str]) -> Self {
        for _ in 0..TRIES {
            let running = Self::start(folder, args);
            let held = || running.printed().contains("\"slip_end\"");
            let fallen = || running.reported().contains("the object is gone");
            assert!(until(|| held() || fallen()), "{}", running.reported());
            if !fallen() {
                return running;
            }
            eprintln!("not held: {}", running.stop().err);
            for recording in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if recording.extension().is_some_and(|extension| extension == "mcap") {
                    fs::remove_file(recording).unwrap();
                }
            }
        }
        panic!("the object was not held in {TRIES} runs");
    }

    /// What it said on standard error so far.
    pub(crate) fn reported(&self) -> String {
        fs::read_to_string(self.folder.join("err.txt")).unwrap()
    }

    /// What it printed so far.
    pub(crate) fn printed(&self) -> String {
        fs::read_to_string(self.folder.join("out.txt")).unwrap()
    }

    /// Waits until `what` stands on standard error.
    #[track_caller]
    pub(crate) fn wait_for(&self, what: &str) {
        assert!(until(|| self.reported().contains(what)), "no {what:?} in {}", self.reported());
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// A client that wants `wanted`, once the daemon is there.
    pub(crate) fn client(&self, nonce: u16, wanted: Subscribe) -> Client {
        let place = format!("unix:{}", self.folder.join("gripd.sock").display()).parse().unwrap();
        let mut client = None;
        let connected = until(|| {
            client = Client::connect(&place, nonce, wanted, Duration::from_secs(5)).ok();
            client.is_some()
        });
        assert!(connected, "{}", self.reported());
        client.unwrap()
    }

    /// Ends it as Ctrl-C does, and waits for it.
    pub(crate) fn stop(mut self) -> Ran {
        self.signal(Signal::INT);
        let status = self.child.wait().unwrap();
        let (out, err) = (self.printed(), self.reported());
        assert!(!err.contains("panicked"), "{err}");
        Ran { code: status.code().unwrap(), out, err }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Of one that has ended there is nothing to kill.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Looks until it is so; `false` where it does not become so.
pub(crate) fn until(mut is_so: impl FnMut() -> bool) -> bool {
    (0..LOOKS).any(|_| is_so() || pause())
}

#[expect(clippy::disallowed_methods, reason = "a test may wait for another program")]
fn pause() -> bool {
    thread::sleep(Duration::from_millis(20));
    false
}

/// Receives messages until `done`, which sees each.
#[track_caller]
pub(crate) fn receive(client: &mut Client, mut done: impl FnMut(&ToClient<'_>) -> bool) {
    let mut over = false;
    for _ in 0..LOOKS {
        client.wait(Duration::from_millis(20), &mut |message| over |= done(message)).unwrap();
        if over {
            return;
        }
    }
    panic!("what was waited for was not heard");
}
