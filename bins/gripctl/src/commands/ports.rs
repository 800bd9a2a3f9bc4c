//! `gripctl ports`: the serial ports of this computer, as `--port auto` sees them.

use crate::{cli::PortsArgs, output};
use grip_port::{Places, PortError, PortInfo, describe};
use grip_session::exit::{Exit, escape};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Serialize)]
struct Port {
    port: PathBuf,
    by_id: Option<PathBuf>,
    kind: &'static str,
    driver: Option<String>,
    vid: Option<String>,
    pid: Option<String>,
    serial_number: Option<String>,
    product: Option<String>,
    manufacturer: Option<String>,
    socket: Option<String>,
    speed_mbit: Option<f64>,
}

pub(crate) fn run(args: &PortsArgs) -> anyhow::Result<Exit> {
    let ports = Places::default().ports().map_err(PortError::List)?;
    if ports.is_empty() && !args.json {
        eprintln!("no serial port found");
    }
    for port in ports {
        if args.json {
            output::json(&Port::from(port))?;
        } else {
            output::line(&escape(&describe(&port)))?;
        }
    }
    Ok(Exit::Done)
}

impl From<PortInfo> for Port {
    fn from(info: PortInfo) -> Self {
        let PortInfo { path, by_id, driver, usb } = info;
        let hex = |id: u16| format!("{id:04x}");
        Self {
            port: path,
            by_id,
            kind: if usb.is_some() { "usb" } else { "other" },
            driver,
            vid: usb.as_ref().map(|usb| hex(usb.vid)),
            pid: usb.as_ref().map(|usb| hex(usb.pid)),
            speed_mbit: usb.as_ref().and_then(|usb| usb.speed_mbit),
            socket: usb.as_ref().map(|usb| usb.socket.clone()),
            serial_number: usb.as_ref().and_then(|usb| usb.serial.clone()),
            product: usb.as_ref().and_then(|usb| usb.product.clone()),
            manufacturer: usb.and_then(|usb| usb.manufacturer),
        }
    }
}
