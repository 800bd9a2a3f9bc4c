//! The folders of the system in; its serial ports, what USB says of each, and the timers of converters out. Nothing is opened or written
//! to, so that looking at ports disturbs no device.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Where the system keeps its ports. Tests build a tree of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// Device nodes: `/dev`.
    pub dev: PathBuf,
    /// What the kernel says of terminals: `/sys/class/tty`.
    pub class_tty: PathBuf,
    /// Links whose names stay the same, made by udev: `/dev/serial/by-id`.
    pub by_id: PathBuf,
}

impl Default for Places {
    fn default() -> Self {
        Self {
            dev: "/dev".into(),
            class_tty: "/sys/class/tty".into(),
            by_id: "/dev/serial/by-id".into(),
        }
    }
}

/// What USB says of a port.
#[derive(Clone, Debug, PartialEq)]
pub struct UsbPort {
    /// Vendor.
    pub vid: u16,
    /// Product.
    pub pid: u16,
    /// Serial number, where the device has one.
    pub serial: Option<String>,
    /// Name of the product.
    pub product: Option<String>,
    /// Name of the vendor.
    pub manufacturer: Option<String>,
    /// Number of the interface: a device may have several ports.
    pub interface: Option<u8>,
    /// The socket it is plugged into, as the kernel names it: `1-2.3`.
    pub socket: String,
    /// Speed of the bus (Mbit/s): 12 is full speed, 480 high speed.
    pub speed_mbit: Option<f64>,
}

impl UsbPort {
    /// Whether `other` is the same port of the same device, in whatever socket. A device without a serial number is told from
    /// its twins by the socket alone.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        let device = (self.vid, self.pid, self.interface, &self.serial);
        device == (other.vid, other.pid, other.interface, &other.serial)
            && (self.serial.is_some() || self.socket == other.socket)
    }
}

/// A serial port of this computer.
#[derive(Clone, Debug, PartialEq)]
pub struct PortInfo {
    /// Its device node, such as `/dev/ttyACM0`.
    pub path: PathBuf,
    /// The link that leads to it and keeps its name, where there is one.
    pub by_id: Option<PathBuf>,
    /// Name of the driver, where the kernel tells it.
    pub driver: Option<String>,
    /// What USB says; `None` for a port that is not on USB.
    pub usb: Option<UsbPort>,
}

impl Places {
    /// All ports with a device behind them, in the order of their names.
    ///
    /// # Errors
    /// Where the kernel's list cannot be read.
    pub fn ports(&self) -> io::Result<Vec<PortInfo>> {
        let entries = match fs::read_dir(&self.class_tty) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut names: Vec<String> = entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| self.is_port(name))
            .collect();
        names.sort_by_key(|name| (name.len(), name.clone()));
        Ok(names.iter().map(|name| self.port(name)).collect())
    }

    /// Virtual consoles have no device, and UARTs that were never found have the type 0.
    fn is_port(&self, name: &str) -> bool {
        let folder = self.class_tty.join(name);
        folder.join("device").exists() && text(&folder.join("type")).as_deref() != Some("0")
    }

    fn port(&self, name: &str) -> PortInfo {
        let device = self.class_tty.join(name).join("device");
        let driver = fs::canonicalize(device.join("driver")).ok();
        PortInfo {
            path: self.dev.join(name),
            by_id: self.link_to(name),
            driver: driver.as_deref().and_then(file_name),
            usb: fs::canonicalize(device).ok().and_then(|device| usb_port(&device)),
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

    /// What the kernel says of the port that `path` leads to.
    #[must_use]
    pub fn look_up(&self, path: &Path) -> Option<PortInfo> {
        self.name_of(path).map(|name| self.port(&name))
    }

    /// The file with the latency timer of an FTDI converter.
    #[must_use]
    pub fn latency_timer(&self, path: &Path) -> Option<PathBuf> {
        let file = self.class_tty.join(self.name_of(path)?).join("device/latency_timer");
        file.is_file().then_some(file)
    }
}

/// A number in a file of the kernel.
pub(crate) fn number(file: &Path) -> Option<u16> {
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
