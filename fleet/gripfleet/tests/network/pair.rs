//! Pair of a gripd on the simulator and its gripfleet, which read the same configuration in a folder.

use std::{fs, path::Path};
use stories::{Program, Signal, until};

/// Runs of which one must hold its object.
const TRIES: u32 = 5;

/// Both programs.
pub(crate) struct Pair {
    pub(crate) gripd: Program,
    pub(crate) fleet: Program,
}

/// gripfleet in `folder`.
pub(crate) fn gripfleet(folder: &Path, args: &[&str]) -> Program {
    Program::start(Path::new(env!("CARGO_BIN_EXE_gripfleet")), folder, args)
}

/// Writes the configuration that both read; `top` stands before its tables.
pub(crate) fn configure(folder: &Path, endpoint: &str, top: &str, fleet: &str) {
    let text = format!(
        "listen = \"unix:{}\"\n{top}\n[fleet]\nsite = \"hall\"\nrouter = \"{endpoint}\"\n{fleet}\n",
        folder.join("gripd.sock").display()
    );
    fs::write(folder.join("gripd.toml"), text).unwrap();
}

impl Pair {
    /// Starts both, on the default scene where `args` name no port.
    pub(crate) fn start(folder: &Path, args: &[&str]) -> Self {
        let port = if args.contains(&"--port") { &[][..] } else { &["--port", "sim"] };
        let fleet = gripfleet(folder, &[]);
        fleet.until_reported("; waiting for it");
        Self { gripd: Program::gripd(folder, &[port, &["--json"], args].concat()), fleet }
    }

    /// One that has had a slip and holds the object. Where it was dropped, it may begin again, without a recording of that.
    pub(crate) fn holding(folder: &Path, args: &[&str]) -> Self {
        for _ in 0..TRIES {
            match Self::start(folder, args).until_held() {
                Ok(pair) => return pair,
                Err(pair) => drop(pair.stop()),
            }
            for recording in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if recording.extension().is_some_and(|extension| extension == "mcap") {
                    fs::remove_file(recording).unwrap();
                }
            }
        }
        panic!("the object was not held in {TRIES} runs");
    }

    /// The same, beside a gripfleet that runs already.
    pub(crate) fn holding_beside(folder: &Path, fleet: Program) -> Self {
        let gripd = Program::gripd(folder, &["--port", "sim", "--json"]);
        Self { gripd, fleet }.until_held().unwrap_or_else(|_| panic!("the object was not held"))
    }

    /// Itself; what it is where the object has fallen, which a machine that stops gripd for longer than that takes does.
    fn until_held(self) -> Result<Self, Self> {
        let held = || self.gripd.printed().contains("\"slip_end\"");
        let fallen = || self.gripd.reported().contains("the object is gone");
        assert!(until(|| held() || fallen()), "{}", self.gripd.reported());
        if fallen() { Err(self) } else { Ok(self) }
    }

    /// The gripper's name, as soon as it is on the network.
    pub(crate) fn name(&self) -> String {
        self.fleet.until_reported("this gripper is there as hall/");
        let reported = self.fleet.reported();
        let name = reported.split("this gripper is there as ").nth(1).unwrap();
        let is_of_it = |c: &char| *c == '/' || c.is_ascii_alphanumeric();
        name.chars().take_while(is_of_it).collect()
    }

    pub(crate) fn reload(&self) {
        self.gripd.signal(Signal::HUP);
    }

    /// Ends both as Ctrl-C does: what gripd said.
    pub(crate) fn stop(self) -> String {
        let fleet = self.fleet.interrupted();
        assert_eq!(fleet.code, 0, "{fleet:?}");
        self.gripd.interrupted().done().err
    }
}
