//! Processes in /proc: who runs, who holds a port, and who may write to it.

use super::{System, finding::Finding};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// A running program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Process {
    pub(crate) pid: u32,
    pub(crate) name: String,
    /// What it has open; `None` where that is not shown to this user.
    open: Option<Vec<PathBuf>>,
}

/// All programs that run.
#[derive(Clone, Debug)]
pub(crate) struct Processes(Vec<Process>);

impl Processes {
    pub(crate) fn read(system: &System) -> Self {
        let entries = fs::read_dir(system.at("proc")).into_iter().flatten().flatten();
        Self(entries.filter_map(|entry| process(&entry.path())).collect())
    }

    /// Whoever has the file at `path` open, this program left out.
    pub(crate) fn holding(&self, path: &Path) -> Vec<&Process> {
        let own = std::process::id();
        let holds = |process: &&Process| {
            process.pid != own
                && process.open.as_ref().is_some_and(|open| open.iter().any(|file| file == path))
        };
        self.0.iter().filter(holds).collect()
    }

    /// How many do not show what they have open.
    pub(crate) fn hidden(&self) -> usize {
        self.0.iter().filter(|process| process.open.is_none()).count()
    }

    pub(crate) fn named(&self, name: &str) -> Option<&Process> {
        self.0.iter().find(|process| process.name == name)
    }
}

fn process(folder: &Path) -> Option<Process> {
    let pid = folder.file_name()?.to_str()?.parse().ok()?;
    let name = fs::read_to_string(folder.join("comm")).ok()?.trim().to_owned();
    let open = fs::read_dir(folder.join("fd"))
        .ok()
        .map(|links| links.flatten().filter_map(|link| fs::read_link(link.path()).ok()).collect());
    Some(Process { pid, name, open })
}

/// The daemon, and the program that is known to write to strange ports.
pub(crate) fn findings(system: &System, processes: &Processes) -> Vec<Finding> {
    let daemon = processes.named("gripd").map_or_else(
        || "gripd does not run".to_owned(),
        |gripd| format!("gripd runs (process {})", gripd.pid),
    );
    vec![Finding::ok("daemon", daemon), modem_manager(system, processes)]
}

fn modem_manager(system: &System, processes: &Processes) -> Finding {
    let check = "modem manager";
    let rule = rule_file(system);
    let Some(process) = processes.named("ModemManager") else {
        return Finding::ok(check, "ModemManager does not run".to_owned());
    };
    match rule {
        Some(file) => {
            let text = format!("ModemManager runs, and {} keeps it off grippers", file.display());
            Finding::ok(check, text)
        }
        None => Finding::warning(
            check,
            format!(
                "ModemManager runs (process {}) and may write modem commands to the gripper when it is plugged in",
                process.pid
            ),
            "install the package of gripd (its udev rule stops that), or: sudo systemctl disable --now ModemManager".to_owned(),
        ),
    }
}

/// A udev rule about grippers that asks ModemManager to stay away.
fn rule_file(system: &System) -> Option<PathBuf> {
    let folders =
        ["etc/udev/rules.d", "run/udev/rules.d", "usr/lib/udev/rules.d", "lib/udev/rules.d"];
    folders
        .iter()
        .filter_map(|folder| fs::read_dir(system.at(folder)).ok())
        .flat_map(|files| files.flatten().map(|file| file.path()))
        .find(|file| {
            let named = file.to_str().is_some_and(|name| name.contains("grip"));
            named && fs::read_to_string(file).is_ok_and(|rule| rule.contains("ID_MM_DEVICE_IGNORE"))
        })
}

#[cfg(test)]
mod tests {
    use super::{super::System, Processes, findings};
    use crate::commands::doctor::finding::Verdict;
    use std::{fs, os::unix::fs::symlink, path::Path};

    fn run(root: &Path, pid: u32, name: &str, open: &str) {
        let folder = root.join(format!("proc/{pid}/fd"));
        fs::create_dir_all(&folder).unwrap();
        fs::write(root.join(format!("proc/{pid}/comm")), format!("{name}\n")).unwrap();
        symlink(open, folder.join("3")).unwrap();
    }

    #[test]
    fn who_holds_the_port_and_who_reaches_for_it() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let system = System { root: root.to_owned(), ..System::default() };
        run(root, 4_000_000_001, "minicom", "/dev/ttyACM0");
        run(root, 4_000_000_002, "gripd", "/dev/null");
        fs::create_dir_all(root.join("proc/self")).unwrap();
        let processes = Processes::read(&system);
        let port = Path::new("/dev/ttyACM0");
        let holders: Vec<&str> =
            processes.holding(port).iter().map(|holder| holder.name.as_str()).collect();
        assert_eq!(holders, ["minicom"]);
        assert!(processes.holding(Path::new("/dev/ttyACM1")).is_empty());
        assert_eq!(processes.hidden(), 0);
        let [daemon, modem] = &findings(&system, &processes)[..] else { panic!() };
        assert!(daemon.text.contains("4000000002"), "{daemon}");
        assert_eq!(modem.verdict, Verdict::Ok);
        run(root, 4_000_000_003, "ModemManager", "/dev/null");
        let verdict = || findings(&system, &Processes::read(&system))[1].verdict;
        assert_eq!(verdict(), Verdict::Warning);
        fs::create_dir_all(root.join("etc/udev/rules.d")).unwrap();
        let rule = root.join("etc/udev/rules.d/70-gripd.rules");
        fs::write(&rule, "ENV{ID_MM_DEVICE_IGNORE}=\"1\"\n").unwrap();
        assert_eq!(verdict(), Verdict::Ok);
    }
}
