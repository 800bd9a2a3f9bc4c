//! The serial ports of this computer and what USB states of each, as `serialport` knows them on every system. Nothing is
//! opened or written to, so that looking at ports disturbs no device.

use serialport::{SerialPortInfo, SerialPortType, UsbPortInfo, available_ports};
use std::{io, path::PathBuf};

/// What USB states of a port.
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
    /// The socket it is plugged into, as Linux names it: `1-2.3`. Where the system does not show it, the name of the port.
    pub socket: String,
    /// Speed of the bus (Mbit/s): 12 is full speed, 480 high speed. Only Linux reports it.
    pub speed_mbit: Option<f64>,
}

impl UsbPort {
    /// Whether `other` is the same port of the same device, in whatever socket. A device without a serial number is distinguished from
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
    /// Its name: a device node such as `/dev/ttyACM0`, or `COM3`.
    pub path: PathBuf,
    /// The link that leads to it and keeps its name, where there is one. Only Linux has them.
    pub by_id: Option<PathBuf>,
    /// Name of the driver, where the kernel reports it. Only Linux does.
    pub driver: Option<String>,
    /// What USB states; `None` for a port that is not on USB.
    pub usb: Option<UsbPort>,
}

/// All ports that `serialport` finds.
///
/// # Errors
/// Where the system's list cannot be read.
pub(crate) fn listed() -> io::Result<Vec<PortInfo>> {
    Ok(available_ports()?.into_iter().map(PortInfo::from).collect())
}

/// Shorter names first, so that `ttyACM10` comes after `ttyACM9`.
pub(crate) fn sort(ports: &mut [PortInfo]) {
    ports.sort_by_cached_key(|port| (port.path.as_os_str().len(), port.path.clone()));
}

impl From<SerialPortInfo> for PortInfo {
    fn from(port: SerialPortInfo) -> Self {
        let SerialPortInfo { port_name, port_type } = port;
        let usb = match port_type {
            SerialPortType::UsbPort(usb) => Some(described(usb, &port_name)),
            _ => None,
        };
        Self { path: port_name.into(), by_id: None, driver: None, usb }
    }
}

fn described(usb: UsbPortInfo, port: &str) -> UsbPort {
    let UsbPortInfo { vid, pid, serial_number, manufacturer, product, location, interface } = usb;
    let text = |value: Option<String>| value.filter(|value| !value.is_empty());
    UsbPort {
        vid,
        pid,
        serial: text(serial_number),
        product: text(product),
        manufacturer: text(manufacturer),
        interface,
        socket: location.map_or_else(|| port.to_owned(), |location| location.to_string()),
        speed_mbit: None,
    }
}

#[cfg(test)]
mod tests {
    use super::{PortInfo, sort};
    use serialport::{Location, SerialPortInfo, SerialPortType, UsbPortInfo};

    fn port(name: &str, usb: Option<UsbPortInfo>) -> PortInfo {
        let port_type = usb.map_or(SerialPortType::Unknown, SerialPortType::UsbPort);
        PortInfo::from(SerialPortInfo { port_name: name.to_owned(), port_type })
    }

    #[test]
    fn what_usb_states_is_taken_over_and_empty_words_are_none() {
        let usb = UsbPortInfo {
            vid: 0x2341,
            pid: 0x43,
            serial_number: Some("GRIP-0042".to_owned()),
            manufacturer: Some(String::new()),
            product: Some("Slip gripper".to_owned()),
            location: Some(Location::new("1".to_owned(), vec![2, 3])),
            interface: Some(0),
        };
        let known = port("COM3", Some(usb.clone())).usb.unwrap();
        assert_eq!((known.vid, known.pid, known.interface), (0x2341, 0x43, Some(0)));
        assert_eq!(known.serial.as_deref(), Some("GRIP-0042"));
        assert_eq!((known.manufacturer.as_deref(), known.socket.as_str()), (None, "1-2.3"));
        // Twins that report neither a serial number nor a place differ at least by name.
        let bare = UsbPortInfo { serial_number: None, location: None, ..usb };
        let twins = ["COM3", "COM4"].map(|name| port(name, Some(bare.clone())).usb.unwrap());
        assert!(!twins[0].is_same(&twins[1]) && twins[0].is_same(&twins[0]));
        assert!(port("COM1", None).usb.is_none());
    }

    #[test]
    fn ports_stand_in_the_order_of_their_numbers() {
        let mut ports = ["COM10", "COM9", "COM1"].map(|name| port(name, None));
        sort(&mut ports);
        let names = ports.map(|port| port.path.display().to_string());
        assert_eq!(names, ["COM1", "COM9", "COM10"]);
    }
}
