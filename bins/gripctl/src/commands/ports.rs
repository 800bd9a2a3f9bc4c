//! `gripctl ports`: the serial ports of this computer.

use crate::{cli::PortsArgs, output};
use anyhow::Context as _;
use grip_host::exit::Exit;
use serde::Serialize;
use serialport::SerialPortType;

#[derive(Serialize)]
struct Port {
    port: String,
    kind: &'static str,
    vid: Option<String>,
    pid: Option<String>,
    serial_number: Option<String>,
    product: Option<String>,
    manufacturer: Option<String>,
}

pub(crate) fn run(args: &PortsArgs) -> anyhow::Result<Exit> {
    let ports = serialport::available_ports().context("cannot list the serial ports")?;
    if ports.is_empty() && !args.json {
        eprintln!("no serial port found");
    }
    for port in ports {
        let port = describe(port);
        if args.json {
            output::json(&port)?;
        } else {
            let id = port
                .vid
                .zip(port.pid)
                .map_or_else(String::new, |(vid, pid)| format!(" {vid}:{pid}"));
            let words = [port.manufacturer, port.product, port.serial_number];
            let words: Vec<String> = words.into_iter().flatten().collect();
            output::line(&format!("{:20} {}{id} {}", port.port, port.kind, words.join(" ")))?;
        }
    }
    Ok(Exit::Done)
}

fn describe(info: serialport::SerialPortInfo) -> Port {
    let mut port = Port {
        port: info.port_name,
        kind: "unknown",
        vid: None,
        pid: None,
        serial_number: None,
        product: None,
        manufacturer: None,
    };
    match info.port_type {
        SerialPortType::UsbPort(usb) => {
            port.kind = "usb";
            port.vid = Some(format!("{:04x}", usb.vid));
            port.pid = Some(format!("{:04x}", usb.pid));
            port.serial_number = usb.serial_number;
            port.product = usb.product;
            port.manufacturer = usb.manufacturer;
        }
        SerialPortType::PciPort => port.kind = "pci",
        SerialPortType::BluetoothPort => port.kind = "bluetooth",
        SerialPortType::Unknown => {}
    }
    port
}
