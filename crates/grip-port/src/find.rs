//! Finder of the one port that is asked for: its path, also after it was unplugged. No other port is ever opened.

use crate::{Line, Places, PortError, PortInfo, UsbPort};
use core::{fmt::Write as _, time::Duration};
use std::path::{Path, PathBuf};

/// Which USB serial port `auto` means; what is absent fits every port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UsbFilter {
    /// Vendor.
    pub vid: Option<u16>,
    /// Product.
    pub pid: Option<u16>,
    /// Serial number; `*` stands for any characters.
    pub serial: Option<String>,
    /// Name of the product; `*` stands for any characters.
    pub product: Option<String>,
}

/// Which port is wanted.
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// The one at this path: a device node, or a link to one.
    Path(PathBuf),
    /// The only USB serial port that fits.
    Auto(UsbFilter),
    /// What forwards a serial port at `HOST:PORT`, over TCP.
    Tcp(String),
}

/// Finds one port, and the same one again.
///
/// The first port that was opened is the chosen one. From then on only the same USB device counts, under whatever name it comes back;
/// another device that turns up at the old name is left alone. A port that is not on USB is known by its path.
#[derive(Debug)]
pub struct Finder {
    places: Places,
    wanted: Wanted,
    chosen: Option<UsbPort>,
}

impl Finder {
    /// Looks for nothing yet.
    #[must_use]
    pub fn new(places: Places, wanted: Wanted) -> Self {
        Self { places, wanted, chosen: None }
    }

    /// The path of the port that is wanted, or `HOST:PORT`. Opens nothing.
    ///
    /// # Errors
    /// [`PortError::Absent`] where it is not there (yet), [`PortError::Argument`] with a list where several fit.
    pub fn find(&self) -> Result<PathBuf, PortError> {
        match (&self.wanted, &self.chosen) {
            (Wanted::Path(path), None) => Ok(path.clone()),
            (Wanted::Path(path), Some(chosen)) => self.again(Some(path), chosen),
            (Wanted::Auto(_), Some(chosen)) => self.again(None, chosen),
            (Wanted::Auto(filter), None) => self.only(filter),
            (Wanted::Tcp(address), _) => match address.rsplit_once(':') {
                Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => {
                    Ok(address.into())
                }
                _ => Err(PortError::Argument(format!(
                    "`tcp:{address}`: expected tcp:HOST:PORT, such as tcp:192.168.1.10:54321"
                ))),
            },
        }
    }

    /// Finds and opens the port; it is the chosen one from now on.
    ///
    /// # Errors
    /// As [`Finder::find`] and [`Line::open`]. Where [`PortError::is_temporary`] holds, a later try may succeed; see [`Backoff`].
    pub fn open(&mut self, baud: u32) -> Result<Line, PortError> {
        let path = self.find()?;
        if let Wanted::Tcp(address) = &self.wanted {
            return Line::connect(address);
        }
        let info = self.places.look_up(&path);
        let line = Line::open_in(&self.places, &path, baud)?;
        if self.chosen.is_none() {
            self.chosen = info.and_then(|info| info.usb);
        }
        Ok(line)
    }

    /// What USB states of the chosen port, once there is one.
    #[must_use]
    pub fn chosen(&self) -> Option<&UsbPort> {
        self.chosen.as_ref()
    }

    fn only(&self, filter: &UsbFilter) -> Result<PathBuf, PortError> {
        let ports = self.places.ports().map_err(PortError::List)?;
        let mut fitting = ports.iter().filter(|port| fits(filter, port));
        let Some(first) = fitting.next() else {
            let others = ports.iter().filter(|port| port.usb.is_some()).count();
            return Err(PortError::Absent(absent(filter, others)));
        };
        if fitting.next().is_none() {
            return Ok(first.path.clone());
        }
        Err(PortError::Argument(several(ports.iter().filter(|port| fits(filter, port)))))
    }

    /// The port of the chosen device, by its identity; of twins the one in the same socket.
    fn again(&self, path: Option<&PathBuf>, chosen: &UsbPort) -> Result<PathBuf, PortError> {
        let ports = self.places.ports().map_err(PortError::List)?;
        let same = |port: &&PortInfo| port.usb.as_ref().is_some_and(|usb| usb.is_same(chosen));
        let found: Vec<&PortInfo> = ports.iter().filter(same).collect();
        let in_socket =
            |port: &&&PortInfo| port.usb.as_ref().is_some_and(|usb| usb.socket == chosen.socket);
        let found = match found.as_slice() {
            [one] => Some(*one),
            several => several.iter().find(in_socket).copied(),
        };
        if let Some(port) = found {
            return Ok(port.path.clone());
        }
        // Without a serial number a device in another socket is known only by the name that the user gave.
        if let Some(path) = path
            && let Some(usb) = self.places.look_up(path).and_then(|port| port.usb)
            && chosen.serial.is_none()
            && (UsbPort { socket: chosen.socket.clone(), ..usb }).is_same(chosen)
        {
            return Ok(path.clone());
        }
        Err(PortError::Absent(format!(
            "the gripper's port is gone ({}); plug it in again",
            describe_usb(chosen)
        )))
    }
}

fn fits(filter: &UsbFilter, port: &PortInfo) -> bool {
    let text = |pattern: &Option<String>, value: &Option<String>| match pattern {
        None => true,
        Some(pattern) => value.as_ref().is_some_and(|value| glob(pattern, value)),
    };
    port.usb.as_ref().is_some_and(|usb| {
        filter.vid.is_none_or(|vid| vid == usb.vid)
            && filter.pid.is_none_or(|pid| pid == usb.pid)
            && text(&filter.serial, &usb.serial)
            && text(&filter.product, &usb.product)
    })
}

/// Whether `text` fits `pattern`, in which `*` stands for any characters.
fn glob(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let Some(last) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        let Some((_, after)) = rest.split_once(part) else { return false };
        rest = after;
    }
    rest.ends_with(last)
}

fn absent(filter: &UsbFilter, others: usize) -> String {
    if others == 0 {
        return "--port auto: no USB serial port found; plug the gripper in, or name the port"
            .to_owned();
    }
    let UsbFilter { vid, pid, serial, product } = filter;
    let mut wanted = String::new();
    let ids =
        [("vid", vid), ("pid", pid)].map(|(name, id)| (name, id.map(|id| format!("{id:#06x}"))));
    let texts = [("serial", serial), ("product", product)].map(|(name, text)| (name, text.clone()));
    for (name, value) in ids.into_iter().chain(texts) {
        if let Some(value) = value {
            // Writing to a string does not fail.
            let _ = write!(wanted, " {name} {value}");
        }
    }
    format!(
        "--port auto: none of the {others} USB serial ports fits [usb]{wanted} of the configuration; `gripctl ports` shows what they say of themselves"
    )
}

fn several<'a>(ports: impl Iterator<Item = &'a PortInfo>) -> String {
    let lines: Vec<String> = ports.map(|port| format!("\n  {}", describe(port))).collect();
    format!(
        "--port auto: {} USB serial ports fit; name one with --port, or tell it apart under [usb] in the configuration:{}",
        lines.len(),
        lines.concat()
    )
}

/// One line that distinguishes a port from others: its paths, its ids, its names and where it is plugged in.
#[must_use]
pub fn describe(port: &PortInfo) -> String {
    let by_id = port.by_id.as_ref().map(|link| format!("  {}", link.display()));
    let usb = port.usb.as_ref().map(|usb| format!("  {}", describe_usb(usb)));
    format!("{}{}{}", port.path.display(), usb.unwrap_or_default(), by_id.unwrap_or_default())
}

/// The same of its USB side: ids, names, where it is plugged in.
#[must_use]
pub fn describe_usb(usb: &UsbPort) -> String {
    let words = [&usb.manufacturer, &usb.product];
    let words: String = words.into_iter().flatten().map(|word| format!(" {word}")).collect();
    let serial = usb
        .serial
        .as_ref()
        .map_or_else(|| ", no serial number".to_owned(), |serial| format!(", serial {serial}"));
    format!("{:04x}:{:04x}{words}{serial}, socket {}", usb.vid, usb.pid, usb.socket)
}

/// Pauses between tries, each twice as long as the one before; by default from 50 ms to 2 s.
#[derive(Clone, Copy, Debug)]
pub struct Backoff {
    first: Duration,
    longest: Duration,
    next: Duration,
}

impl Backoff {
    /// Pauses from `first` to `longest`.
    #[must_use]
    pub const fn new(first: Duration, longest: Duration) -> Self {
        Self { first, longest, next: first }
    }

    /// The pause before the next try.
    pub fn pause(&mut self) -> Duration {
        let pause = self.next;
        self.next = (2 * pause).min(self.longest);
        pause
    }

    /// It worked: the next pause is a short one again.
    pub fn reset(&mut self) {
        self.next = self.first;
    }
}

impl Default for Backoff {
    fn default() -> Self {
        Self::new(Duration::from_millis(50), Duration::from_secs(2))
    }
}

impl Wanted {
    /// What a user asks for: `auto` with what the configuration states of USB, `tcp:HOST:PORT`, or a path.
    #[must_use]
    pub fn new(name: &str, usb: UsbFilter) -> Self {
        match name.strip_prefix("tcp:") {
            _ if name == "auto" => Self::Auto(usb),
            Some(address) => Self::Tcp(address.to_owned()),
            None => Self::Path(Path::new(name).to_owned()),
        }
    }
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests;
