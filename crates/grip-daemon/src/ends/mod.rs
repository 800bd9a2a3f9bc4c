//! Two ends on two lines, a sensor and a gripper at their ports: rows and orders, as the thread of the rows knows them.
//!
//! Each end has a thread of its own, which speaks its protocol and reopens its line. A sensor sends rows as another program would, in
//! datagrams over a socket pair; a gripper takes orders and shows its state. The thread of the rows joins them to one board, so that
//! the hot loop knows one line.

mod address;
mod gripper_board;
mod line;
mod robotiq;
mod rows_address;
mod sensor_board;
mod tsf85;

pub use address::{AddressError, GripperAddress, SensorAddress};
pub use rows_address::{RowsAddress, RowsAddressError};

use crate::hot::Shared;
use core::sync::atomic::Ordering;
use grip_port::{PortError, Source, UsbFilter};
use grip_robotiq::gripper::Order;
use grip_session::{HostConfig, rows::GripperReading};
use line::{End, LineLoop};
use std::{
    io,
    os::unix::net::UnixDatagram,
    sync::{
        Arc,
        mpsc::{self, Receiver, Sender},
    },
    thread,
};

/// Stack of a thread (bytes).
const STACK: usize = 256 * 1024;

/// Why an end cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum EndFault {
    /// Its port.
    #[error("{end}: {source}")]
    Port {
        /// Which end.
        end: String,
        /// What is wrong.
        source: PortError,
    },
    /// What is at the other end of the line.
    #[error("{end}: {text}")]
    Device {
        /// Which end.
        end: String,
        /// What is wrong.
        text: String,
    },
    /// The system.
    #[error("{end}: {source}")]
    System {
        /// Which end.
        end: String,
        /// What it refuses.
        source: io::Error,
    },
}

/// A gripper, as its thread shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperUpdate {
    /// What it shows; `None` where it cannot be commanded.
    pub reading: Option<GripperReading>,
    /// Force (N) with which it held something when it was found first.
    pub holds_n: f32,
    /// The most that it allows, where that is known: force (N) and change of force (N/s).
    pub most: Option<[f32; 2]>,
    /// Others have opened the fingers since the last update.
    pub let_go: bool,
}

/// What every end works with.
#[derive(Debug)]
pub struct EndContext<C> {
    /// Microseconds since the start of the daemon.
    pub clock: C,
    /// What is shared with the other threads.
    pub shared: Arc<Shared>,
    /// Whether an end that is not there yet is waited for.
    pub patient: bool,
    /// What a board is asked for, and its bits per second.
    pub config: HostConfig,
    /// The same.
    pub baud: u32,
    /// What `auto` means.
    pub usb: UsbFilter,
    /// Sentences for people.
    pub reports: Sender<String>,
}

/// An end whose thread runs.
#[derive(Debug)]
pub struct Started<T> {
    /// What it is joined to the rows with.
    pub end: T,
    /// Why it ended, where it did before the program.
    pub fault: Receiver<EndFault>,
}

/// The way to a gripper.
#[derive(Debug)]
pub struct GripperEnds {
    /// What it is to do.
    pub orders: Sender<Order>,
    /// How it is.
    pub updates: Receiver<GripperUpdate>,
}

/// Starts the thread of a sensor; its rows come out of the socket.
///
/// # Errors
/// Where the choice of its port is a mistake.
pub fn start_sensor<C: Fn() -> u64 + Send + 'static>(
    address: &SensorAddress,
    context: EndContext<C>,
) -> Result<Option<Started<UnixDatagram>>, EndFault> {
    let Some((port, baud)) = address.line() else { return Ok(None) };
    let name = address.to_string();
    let system = |source| EndFault::System { end: address.to_string(), source };
    let (ours, theirs) = UnixDatagram::pair().map_err(system)?;
    ours.set_nonblocking(true).map_err(system)?;
    theirs.set_nonblocking(true).map_err(system)?;
    let source = source(&name, port, baud, &context)?;
    let fault = match address {
        SensorAddress::Tsf85 { config, .. } => spawn(
            "sensor",
            LineLoop::new(name, source, tsf85::Tsf85End::new(*config, ours), context),
        ),
        _ => {
            let end = sensor_board::SensorBoard::new(&context.config, ours)
                .map_err(|text| EndFault::Device { end: name.clone(), text })?;
            spawn("sensor", LineLoop::new(name, source, end, context))
        }
    };
    Ok(Some(Started { end: theirs, fault: fault.map_err(system)? }))
}

/// Starts the thread of a gripper.
///
/// # Errors
/// Where the choice of its port is a mistake.
pub fn start_gripper<C: Fn() -> u64 + Send + 'static>(
    address: &GripperAddress,
    context: EndContext<C>,
) -> Result<Started<GripperEnds>, EndFault> {
    let (name, (port, baud)) = (address.to_string(), address.line());
    let (order_in, orders) = mpsc::channel();
    let (update_in, updates) = mpsc::channel();
    let source = source(&name, port, baud, &context)?;
    let fault = match address {
        GripperAddress::Robotiq { config, .. } => {
            let spec = address.spec();
            let end = robotiq::RobotiqEnd::new(*config, spec, orders, update_in);
            spawn("gripper", LineLoop::new(name, source, end, context))
        }
        GripperAddress::Board { .. } => {
            let end = gripper_board::GripperBoard::new(&context.config, orders, update_in)
                .map_err(|text| EndFault::Device { end: name.clone(), text })?;
            spawn("gripper", LineLoop::new(name, source, end, context))
        }
    };
    let fault = fault.map_err(|source| EndFault::System { end: address.to_string(), source })?;
    Ok(Started { end: GripperEnds { orders: order_in, updates }, fault })
}

fn source<C>(
    name: &str,
    port: &str,
    baud: Option<u32>,
    context: &EndContext<C>,
) -> Result<Source, EndFault> {
    Source::open(port, baud.unwrap_or(context.baud), context.usb.clone())
        .map_err(|source| EndFault::Port { end: name.to_owned(), source })
}

/// Runs a loop in a thread of its own. Nobody joins it: it ends with the program, and has nothing to finish.
fn spawn<E: End + 'static, C: Fn() -> u64 + Send + 'static>(
    thread: &str,
    mut lines: LineLoop<E, C>,
) -> io::Result<Receiver<EndFault>> {
    let (fault_in, fault) = mpsc::channel();
    let run = move || {
        let shared = lines.shared();
        if let Err(error) = lines.run() {
            let _sent = fault_in.send(error);
            return;
        }
        // The other end of the channel knows by this that the thread ended with the program.
        debug_assert!(shared.stop.load(Ordering::Relaxed), "an end ends with the program");
    };
    let builder = thread::Builder::new().name(thread.to_owned()).stack_size(STACK);
    builder.spawn(run).map(|_thread| fault)
}
