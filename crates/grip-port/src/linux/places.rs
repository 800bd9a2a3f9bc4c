//! The folders of the system in; its serial ports with what the kernel and udev add to `serialport`'s list, and the timers of
//! converters out. Nothing is opened or written to, so that looking at ports disturbs no device.

use crate::{PortInfo, UsbPort, list};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Where the system keeps its ports. Tests build a tree of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// Device nodes: `/dev`.
    pub dev: PathBuf,
    /// What the kernel states of terminals: `/sys/class/tty`.
    pub class_tty: PathBuf,
    /// Links whose names stay the same, made by udev: `/dev/serial/by-id`.
    pub by_id: PathBuf,
}

impl Default for Places {
    fn default() -> Self {
        Self::under(Path::new("/"))
    }
}

impl Places {
    /// Those of a system whose root is elsewhere.
    #[must_use]
    pub fn under(root: &Path) -> Self {
        let at = |path: &str| root.join(path);
        Self { dev: at("dev"), class_tty: at("sys/class/tty"), by_id: at("dev/serial/by-id") }
    }

    /// All ports with a device behind them, in the order of their names.
    ///
    /// # Errors
    /// Where the system's list cannot be read.
    pub fn ports(&self) -> io::Result<Vec<PortInfo>> {
        self.join(&listed()?)
    }

    /// The ports in the kernel's folder, described by `listed` as far as that knows them. What stands only in `listed` is of another
    /// tree, or has no device.
    fn join(&self, listed: &[PortInfo]) -> io::Result<Vec<PortInfo>> {
        let entries = match fs::read_dir(&self.class_tty) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut ports: Vec<PortInfo> = entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| self.is_port(name))
            .map(|name| self.port(&name, listed))
            .collect();
        list::sort(&mut ports);
        Ok(ports)
    }

    /// Virtual consoles have no device, and UARTs that were never found have the type 0.
    fn is_port(&self, name: &str) -> bool {
        let folder = self.class_tty.join(name);
        folder.join("device").exists() && text(&folder.join("type")).as_deref() != Some("0")
    }

    fn port(&self, name: &str, listed: &[PortInfo]) -> PortInfo {
        let path = self.dev.join(name);
        let device = self.class_tty.join(name).join("device");
        let driver = fs::canonicalize(device.join("driver")).ok();
        let kernel = fs::canonicalize(device).ok().and_then(|device| usb_port(&device));
        let listed = listed.iter().find(|port| port.path == path);
        PortInfo {
            path,
            by_id: self.link_to(name),
            driver: driver.as_deref().and_then(file_name),
            usb: both(listed.and_then(|port| port.usb.clone()), kernel),
        }
    }

    /// The link in `by_id` that leads to the node `name`.
    fn link_to(&self, name: &str) -> Option<PathBuf> {
        let links = fs::read_dir(&self.by_id).ok()?;
        let mut links: Vec<PathBuf> = links.filter_map(|entry| Some(entry.ok()?.path())).collect();
        links.sort();
        links.into_iter().find(|link| self.name_of(link).as_deref() == Some(name))
    }

    /// Name of the terminal that `path` leads to, over any number of links: `ttyACM0`; `None` where it leads elsewhere.
    #[must_use]
    pub fn name_of(&self, path: &Path) -> Option<String> {
        let mut path = path.to_owned();
        for _ in 0..8 {
            let name = file_name(&path)?;
            if path.parent().is_some_and(|folder| same_folder(folder, &self.dev))
                && self.class_tty.join(&name).exists()
            {
                return Some(name);
            }
            let target = fs::read_link(&path).ok()?;
            path = path.parent()?.join(target);
        }
        None
    }

    /// What the kernel states of the port that `path` leads to.
    #[must_use]
    pub fn look_up(&self, path: &Path) -> Option<PortInfo> {
        let name = self.name_of(path)?;
        Some(self.port(&name, &listed().ok()?))
    }

    /// The file with the latency timer of an FTDI converter.
    #[must_use]
    pub fn latency_timer(&self, path: &Path) -> Option<PathBuf> {
        let file = self.class_tty.join(self.name_of(path)?).join("device/latency_timer");
        file.is_file().then_some(file)
    }
}

/// The list of `serialport`, which reads `/sys/class/tty` whatever tree is asked for, and panics where it cannot.
fn listed() -> io::Result<Vec<PortInfo>> {
    match fs::read_dir("/sys/class/tty") {
        Ok(_) => list::listed(),
        Err(_) => Ok(Vec::new()),
    }
}

/// What `serialport` states of a device, and what only the kernel's files state: the speed, and words that are no UTF-8.
fn both(listed: Option<UsbPort>, kernel: Option<UsbPort>) -> Option<UsbPort> {
    let (listed, kernel) = match (listed, kernel) {
        (Some(listed), Some(kernel)) => (listed, kernel),
        (listed, kernel) => return listed.or(kernel),
    };
    Some(UsbPort {
        serial: listed.serial.or(kernel.serial),
        product: listed.product.or(kernel.product),
        manufacturer: listed.manufacturer.or(kernel.manufacturer),
        speed_mbit: kernel.speed_mbit,
        ..listed
    })
}

/// A number in a file of the kernel.
pub(super) fn number(file: &Path) -> Option<u16> {
    text(file)?.parse().ok()
}

fn same_folder(a: &Path, b: &Path) -> bool {
    a == b || fs::canonicalize(a).ok().zip(fs::canonicalize(b).ok()).is_some_and(|(a, b)| a == b)
}

fn file_name(path: &Path) -> Option<String> {
    path.file_name()?.to_str().map(str::to_owned)
}

/// A line of text in a file of the kernel; `None` where it is absent or empty.
fn text(file: &Path) -> Option<String> {
    let bytes = fs::read(file).ok()?;
    let text = String::from_utf8_lossy(&bytes).trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// Walks up from the folder of a terminal's device to that of its USB device.
fn usb_port(device: &Path) -> Option<UsbPort> {
    let hex = |file: PathBuf| u16::from_str_radix(&text(&file)?, 16).ok();
    let mut interface = None;
    for folder in device.ancestors() {
        if interface.is_none() {
            interface = hex(folder.join("bInterfaceNumber")).and_then(|n| u8::try_from(n).ok());
        }
        if let Some(vid) = hex(folder.join("idVendor")) {
            return Some(UsbPort {
                vid,
                pid: hex(folder.join("idProduct"))?,
                serial: text(&folder.join("serial")),
                product: text(&folder.join("product")),
                manufacturer: text(&folder.join("manufacturer")),
                interface,
                socket: file_name(folder)?,
                speed_mbit: text(&folder.join("speed")).and_then(|speed| speed.parse().ok()),
            });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::Places;
    use crate::{PortInfo, UsbPort};
    use std::{
        fs::{create_dir_all, write},
        os::unix::fs::symlink,
        path::Path,
    };

    /// A tree with a port on USB, a UART that was found and one that was not.
    fn tree(root: &Path) -> Places {
        let at = |path: &str| root.join(path);
        let places = Places::under(root);
        let interface = at("sys/devices/1-2.3/1-2.3:1.1");
        let class = places.class_tty.join("ttyACM0");
        for folder in [&places.by_id, &interface, &class] {
            create_dir_all(folder).unwrap();
        }
        symlink(&interface, class.join("device")).unwrap();
        write(interface.join("bInterfaceNumber"), "01\n").unwrap();
        let facts: [(&str, &[u8]); 6] = [
            ("idVendor", b"2341\n"),
            ("idProduct", b"0043\n"),
            ("serial", b"GRIP-0042\n"),
            ("product", b"Gripper \xFF\n"),
            ("manufacturer", b"\n"),
            ("speed", b"480\n"),
        ];
        for (file, value) in facts {
            write(at("sys/devices/1-2.3").join(file), value).unwrap();
        }
        for (name, kind) in [("ttyS0", "4\n"), ("ttyS1", "0\n")] {
            create_dir_all(places.class_tty.join(name).join("device")).unwrap();
            write(places.class_tty.join(name).join("type"), kind).unwrap();
        }
        places
    }

    #[test]
    fn the_ports_of_this_computer_are_those_that_the_kernel_alone_reports() {
        let places = Places::default();
        let ports = places.ports().unwrap();
        assert_eq!(ports, places.join(&[]).unwrap());
        for port in &ports {
            assert_eq!(places.look_up(&port.path).as_ref(), Some(port));
        }
    }

    #[test]
    fn what_the_library_states_changes_no_port_and_adds_none() {
        let folder = tempfile::tempdir().unwrap();
        let places = tree(folder.path());
        let alone = places.join(&[]).unwrap();
        let names: Vec<_> = alone.iter().map(|port| port.path.file_name().unwrap()).collect();
        assert_eq!(names, ["ttyS0", "ttyACM0"]);
        // As `serialport` gives it: no word that is no UTF-8, no speed.
        let usb = UsbPort {
            vid: 0x2341,
            pid: 0x43,
            serial: Some("GRIP-0042".to_owned()),
            product: None,
            manufacturer: None,
            interface: Some(1),
            socket: "1-2.3".to_owned(),
            speed_mbit: None,
        };
        let port = |name: &str, usb: Option<&UsbPort>| PortInfo {
            path: places.dev.join(name),
            by_id: None,
            driver: None,
            usb: usb.cloned(),
        };
        let elsewhere = PortInfo { path: "/dev/rfcomm0".into(), ..port("rfcomm0", None) };
        let listed =
            [port("ttyACM0", Some(&usb)), port("ttyS0", None), port("ttyS1", None), elsewhere];
        assert_eq!(places.join(&listed).unwrap(), alone);
        assert!(alone[1].usb.as_ref().unwrap().product.as_ref().unwrap().starts_with("Gripper"));
        // Where both report, the library is believed.
        let other = UsbPort { serial: Some("OTHER".to_owned()), ..usb };
        let believed = places.join(&[port("ttyACM0", Some(&other))]).unwrap();
        assert_eq!(believed[1].usb.as_ref().unwrap().serial.as_deref(), Some("OTHER"));
        assert_eq!(believed[1].usb.as_ref().unwrap().speed_mbit, Some(480.0));
    }
}
