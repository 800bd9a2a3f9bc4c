//! Check of a port: whether this user may open it, who holds it, and what its bus and converter do to the timing.

use super::{System, finding::Finding, processes::Processes};
use grip_port::{PortInfo, describe};
use rustix::{
    fs::{Access as Rights, Gid, access},
    process::{getegid, geteuid, getgroups},
};
use std::{
    fs,
    os::unix::fs::MetadataExt as _,
    path::{Path, PathBuf},
};

/// What was found about a port.
#[derive(Debug)]
pub(crate) struct Access {
    pub(crate) findings: Vec<Finding>,
    /// Whether it may be opened, and nobody holds it.
    pub(crate) free: bool,
}

impl Access {
    pub(crate) fn look(system: &System, processes: &Processes, path: &Path) -> Self {
        let mut findings = Vec::new();
        let node = match fs::canonicalize(path) {
            Ok(node) => node,
            Err(error) => {
                let text = format!("{}: {error}", path.display());
                findings.push(Finding::fault("port", text, "gripctl ports".to_owned()));
                return Self { findings, free: false };
            }
        };
        let info = system.places.look_up(path);
        if info.is_none() && !node.starts_with("/dev/pts") {
            let text = format!("{} is no serial port", node.display());
            let remedy = if node.is_file() {
                format!("for a recording: gripctl doctor --sensor {}", path.display())
            } else {
                "gripctl ports".to_owned()
            };
            findings.push(Finding::fault("port", text, remedy));
            return Self { findings, free: false };
        }
        findings.push(named(path, info.as_ref()));
        let (allowed, finding) = permission(system, &node);
        findings.push(finding);
        let (held, finding) = holder(processes, &node);
        findings.push(finding);
        findings.extend(info.as_ref().and_then(bus));
        findings.extend(latency_timer(system, path));
        Self { findings, free: allowed && !held }
    }
}

fn named(path: &Path, info: Option<&PortInfo>) -> Finding {
    let text = info.map_or_else(|| path.display().to_string(), describe);
    Finding::ok("port", text)
}

fn permission(system: &System, node: &PathBuf) -> (bool, Finding) {
    let check = "permissions";
    let shown = node.display();
    let meta = match fs::metadata(node) {
        Ok(meta) => meta,
        Err(error) => {
            let finding =
                Finding::fault(check, format!("{shown}: {error}"), "gripctl ports".to_owned());
            return (false, finding);
        }
    };
    let group = group_name(system, meta.gid());
    let mode = meta.mode() & 0o777;
    let allowed = access(node, Rights::READ_OK | Rights::WRITE_OK).is_ok();
    if allowed {
        let text = format!("{shown} may be read and written (mode {mode:o}, group {group})");
        return (true, Finding::ok(check, text));
    }
    let text = format!("{shown} may not be read and written (mode {mode:o}, group {group})");
    let remedy = way_in(&shown.to_string(), &group, is_member(meta.gid()), mode);
    (false, Finding::fault(check, text, remedy))
}

/// Groups that give serial ports and nothing else.
const GROUPS: [&str; 3] = ["dialout", "uucp", "plugdev"];

/// What lets this user open `port` of `group` with these rights. Nobody is sent into a group that gives more than ports: that of root,
/// as the ports of WSL and of containers have.
fn way_in(port: &str, group: &str, member: bool, mode: u32) -> String {
    let open = mode & 0o060 == 0o060;
    match (GROUPS.contains(&group), member) {
        (true, false) if open => format!("sudo usermod -aG {group} \"$USER\", then log in again"),
        (true, true) if !open => {
            format!("sudo chmod g+rw {port}, or install the udev rule of the package")
        }
        _ => format!(
            "sudo chgrp dialout {port} && sudo chmod g+rw {port}, and sudo usermod -aG dialout \"$USER\", then log in again; \
             the udev rule of the package does the first two for good, a container wants --device and --group-add dialout"
        ),
    }
}

fn is_member(group: u32) -> bool {
    let group = Gid::from_raw(group);
    geteuid().is_root()
        || getegid() == group
        || getgroups().is_ok_and(|groups| groups.contains(&group))
}

/// The name of a group, or its number where it has none.
fn group_name(system: &System, gid: u32) -> String {
    let groups = fs::read_to_string(system.at("etc/group")).unwrap_or_default();
    let name = groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, number) = (fields.next()?, fields.nth(1)?);
        (number.parse() == Ok(gid)).then(|| name.to_owned())
    });
    name.unwrap_or_else(|| gid.to_string())
}

fn holder(processes: &Processes, node: &Path) -> (bool, Finding) {
    let check = "held by";
    let holders = processes.holding(node);
    let names: Vec<String> =
        holders.iter().map(|holder| format!("{} (process {})", holder.name, holder.pid)).collect();
    if let Some(first) = holders.first() {
        let text = format!("{} is held by {}", node.display(), names.join(", "));
        if first.name == "gripd" {
            let text = format!("{text}: the daemon at work, so nothing is measured here");
            return (true, Finding::ok(check, text));
        }
        // A simulator keeps the host's side of its own terminal open; whoever uses it has locked it.
        if node.starts_with("/dev/pts") {
            return (false, Finding::ok(check, format!("{text}, at the other end or at this one")));
        }
        let remedy = format!("end it: sudo kill {}", first.pid);
        return (true, Finding::fault(check, text, remedy));
    }
    let finding = match processes.hidden() {
        0 => Finding::ok(check, "nobody".to_owned()),
        hidden => {
            let text = format!("nobody that is seen; {hidden} processes of other users are hidden");
            Finding::ok(check, text)
        }
    };
    (false, finding)
}

fn bus(info: &PortInfo) -> Option<Finding> {
    let usb = info.usb.as_ref()?;
    let speed = usb.speed_mbit?;
    let driver = info.driver.as_deref().unwrap_or("unknown");
    let text = format!("{speed} Mbit/s, driver {driver}, socket {}", usb.socket);
    let remedy = "another cable or socket: 1.5 Mbit/s carries no sample stream";
    Some(Finding::judge(speed >= 12.0, "usb", text, remedy))
}

fn latency_timer(system: &System, path: &Path) -> Option<Finding> {
    let file = system.places.latency_timer(path)?;
    let ms: u16 = fs::read_to_string(&file).ok()?.trim().parse().ok()?;
    let text = format!("the FTDI converter holds bytes back for {ms} ms");
    let remedy = format!(
        "echo 1 | sudo tee {}; the udev rule of the package does it for good",
        file.display()
    );
    Some(Finding::judge(ms <= 1, "latency timer", text, &remedy))
}

#[cfg(test)]
mod tests {
    use super::{Access, group_name, way_in};
    use crate::commands::doctor::{System, finding::Verdict, processes::Processes};
    use grip_port::Places;
    use std::{fs, os::unix::fs::symlink, path::Path};

    fn system(root: &Path) -> System {
        System { root: root.to_owned(), places: Places::under(root) }
    }

    #[test]
    fn a_slow_converter_and_a_stranger_are_named_with_what_helps() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let system = system(root);
        let device = root.join("sys/class/tty/ttyUSB0/device");
        fs::create_dir_all(&device).unwrap();
        fs::create_dir_all(root.join("dev")).unwrap();
        fs::write(device.join("latency_timer"), "16\n").unwrap();
        let port = root.join("dev/ttyUSB0");
        symlink("/dev/null", &port).unwrap();
        let fds = root.join("proc/4000000001/fd");
        fs::create_dir_all(&fds).unwrap();
        fs::write(root.join("proc/4000000001/comm"), "minicom\n").unwrap();
        symlink("/dev/null", fds.join("5")).unwrap();
        let access = Access::look(&system, &Processes::read(&system), &port);
        assert!(!access.free);
        let find = |check: &str| access.findings.iter().find(|found| found.check == check).unwrap();
        assert_eq!(find("permissions").verdict, Verdict::Ok, "everybody may use the null device");
        assert_eq!(find("held by").verdict, Verdict::Fault);
        assert!(find("held by").text.contains("minicom (process 4000000001)"));
        assert!(find("held by").remedy.as_ref().unwrap().contains("kill 4000000001"));
        assert_eq!(find("latency timer").verdict, Verdict::Warning);
        assert!(find("latency timer").remedy.as_ref().unwrap().contains("tee"));
    }

    #[test]
    fn absent_ports_and_files_are_faults() {
        let folder = tempfile::tempdir().unwrap();
        let system = system(folder.path());
        let file = folder.path().join("file");
        let processes = Processes::read(&system);
        let absent = Access::look(&system, &processes, &file);
        assert!(!absent.free && absent.findings[0].verdict == Verdict::Fault);
        fs::write(&file, "").unwrap();
        let plain = Access::look(&system, &processes, &file);
        let [.., finding] = plain.findings.as_slice() else { panic!("no finding") };
        assert!(!plain.free && finding.text.contains("no serial port"));
        assert!(finding.remedy.as_ref().is_some_and(|remedy| remedy.contains("doctor --sensor")));
    }

    #[test]
    fn nobody_is_sent_into_a_group_that_gives_more_than_ports() {
        let port = "/dev/ttyUSB0";
        assert_eq!(
            way_in(port, "dialout", false, 0o660),
            "sudo usermod -aG dialout \"$USER\", then log in again"
        );
        assert!(way_in(port, "uucp", true, 0o600).starts_with("sudo chmod g+rw /dev/ttyUSB0"));
        for (group, mode) in [("root", 0o600), ("root", 0o660), ("disk", 0o660), ("tty", 0o620)] {
            for member in [false, true] {
                let remedy = way_in(port, group, member, mode);
                assert!(!remedy.contains(&format!("-aG {group}")), "{remedy}");
                assert!(remedy.contains("chgrp dialout /dev/ttyUSB0"), "{remedy}");
            }
        }
    }

    #[test]
    fn groups_have_names() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("etc")).unwrap();
        fs::write(folder.path().join("etc/group"), "root:x:0:\ndialout:x:20:me,you\n").unwrap();
        let system = system(folder.path());
        assert_eq!(
            (group_name(&system, 20), group_name(&system, 77)),
            ("dialout".into(), "77".into())
        );
    }
}
