//! `gripctl doctor`: findings about a port and this computer, each with the command that fixes it.

mod access;
mod finding;
mod gripper;
mod machine;
mod processes;
mod rate;
mod robotiq;
mod sensor;
mod storage;

use crate::{cli::DoctorArgs, output};
use access::Access;
use finding::{Finding, Verdict};
use grip_daemon::{ends::GripperAddress, port_manager::usb_filter};
use grip_port::{Finder, Places, Wanted, check_baud};
use grip_session::{
    HostConfig,
    config::Layers,
    exit::{Exit, WrongArgument, message},
};
use processes::Processes;
use std::path::{Path, PathBuf};

/// Where the unit of the package records.
const STATE_FOLDER: &str = "/var/lib/gripd";

/// The roots of the system's folders; tests build their own.
#[derive(Clone, Debug)]
pub(crate) struct System {
    pub(crate) root: PathBuf,
    pub(crate) places: Places,
}

impl Default for System {
    fn default() -> Self {
        Self { root: "/".into(), places: Places::default() }
    }
}

impl System {
    /// A path of the system, given without its leading slash.
    pub(crate) fn at(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }
}

pub(crate) fn run(args: &DoctorArgs) -> anyhow::Result<Exit> {
    let seconds = super::checked("--seconds", args.seconds, false)?.min(600.0);
    check_baud(args.baud.unwrap_or(1))?;
    let system = System::default();
    let processes = Processes::read(&system);
    let mut report = Report { json: args.json, counts: [0; 3] };
    let config = report.configuration(args)?;
    if let Some(file) = &args.sensor {
        let recording = super::recording(file, &args.csv)?;
        report.all(&sensor::findings(&recording, &config)?)?;
        return report.end();
    }
    report.all(&machine::findings(&system))?;
    let folder = args.folder.clone().unwrap_or_else(|| {
        let state = PathBuf::from(STATE_FOLDER);
        if state.is_dir() { state } else { ".".into() }
    });
    report.all(&storage::findings(&folder))?;
    report.all(&processes::findings(&system, &processes))?;
    report.port(args, &config, &Room { system, processes, seconds })?;
    report.end()
}

/// What the look at the port needs to know.
struct Room {
    system: System,
    processes: Processes,
    seconds: f64,
}

/// Prints findings as they come, and counts them.
struct Report {
    json: bool,
    counts: [u32; 3],
}

impl Report {
    fn add(&mut self, finding: &Finding) -> anyhow::Result<()> {
        let slot = match finding.verdict {
            Verdict::Ok => 0,
            Verdict::Warning => 1,
            Verdict::Fault => 2,
        };
        if let Some(count) = self.counts.get_mut(slot) {
            *count += 1;
        }
        if self.json { output::json(finding) } else { Ok(output::line(&finding.to_string())?) }
    }

    fn all(&mut self, findings: &[Finding]) -> anyhow::Result<()> {
        findings.iter().try_for_each(|finding| self.add(finding))
    }

    /// The configuration as gripd would find it; the defaults where it cannot be used.
    fn configuration(&mut self, args: &DoctorArgs) -> anyhow::Result<HostConfig> {
        let layers = Layers::of_user(args.config.as_deref());
        match layers.and_then(|layers| Ok((layers.resolve()?, layers))) {
            Ok((config, layers)) => {
                let files: Vec<String> =
                    layers.files().map(|file| file.display().to_string()).collect();
                let text = match files.as_slice() {
                    [] => "no file: all defaults".to_owned(),
                    files => format!("{}: valid", files.join(", ")),
                };
                self.add(&Finding::ok("configuration", text))?;
                Ok(config)
            }
            Err(error) => {
                let remedy = "edit it; `gripd --check-config` checks it again".to_owned();
                self.add(&Finding::fault("configuration", message(&error), remedy))?;
                Ok(HostConfig::default())
            }
        }
    }

    /// Looks at the port, and listens to the gripper where nobody else holds it.
    fn port(&mut self, args: &DoctorArgs, config: &HostConfig, room: &Room) -> anyhow::Result<()> {
        if let Some(name) = args.port.as_deref().filter(|name| name.starts_with("robotiq:")) {
            let address =
                GripperAddress::parse(name).map_err(|error| WrongArgument(error.to_string()))?;
            let GripperAddress::Robotiq { port, baud, config } = address else { return Ok(()) };
            // What a forwarder has no file of is held by nobody here.
            if !port.starts_with("tcp:") && !self.access(Path::new(&port), room)? {
                return Ok(());
            }
            return self.add(&robotiq::finding(name, &port, baud, config));
        }
        let name = args.port.clone().or_else(|| config.port.clone());
        let name = name.unwrap_or_else(|| "auto".to_owned());
        let is_simulated = name == "sim" || name.starts_with("sim:");
        if !is_simulated {
            let wanted = Wanted::new(&name, usb_filter(&config.usb));
            let path = match Finder::new(room.system.places.clone(), wanted).find() {
                Ok(path) => path,
                Err(error) => {
                    let remedy = "plug it in, or name the port: gripctl doctor /dev/ttyACM0";
                    return self.add(&Finding::fault("port", error.to_string(), remedy.to_owned()));
                }
            };
            let free = self.access(&path, room)?;
            if !free {
                return Ok(());
            }
        }
        let inquiry = gripper::Inquiry { name: &name, args, config, seconds: room.seconds };
        let findings = gripper::findings(&inquiry);
        self.all(&findings)
    }

    /// Whether the port may be opened, and nobody has it open.
    fn access(&mut self, path: &Path, room: &Room) -> anyhow::Result<bool> {
        let access = Access::look(&room.system, &room.processes, path);
        self.all(&access.findings)?;
        Ok(access.free)
    }

    fn end(&self) -> anyhow::Result<Exit> {
        let [ok, warnings, faults] = self.counts;
        if self.json {
            let counts = serde_json::json!({
                "type": "doctor", "ok": ok, "warnings": warnings, "faults": faults
            });
            output::json(&counts)?;
        } else {
            output::line(&format!("{ok} ok, {warnings} warnings, {faults} faults"))?;
        }
        Ok(if faults == 0 { Exit::Done } else { Exit::Failed })
    }
}
