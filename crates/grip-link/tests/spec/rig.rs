//! A device and a host to ask, and frames to ask with.

use crate::targets::gripper::{self, SESSION, wire};
use grip_link::device::{DeviceConfig, DeviceLink};
use grip_link::frame::{Direction, Header};
use grip_link::message::{DeviceState, Ident, Kind, Reaction, Versions};

/// The gripper of the examples: as that of the other tests, but without its pressure array, and linked.
pub(crate) fn ident() -> Ident {
    let mut ident = gripper::ident(0xB007);
    ident.channels[2] = Ident::NO_CHANNEL;
    Ident { state: DeviceState::Linked, channel_count: 2, ..ident }
}

/// The payload of a HELLO.
pub(crate) fn hello() -> Vec<u8> {
    gripper::hello(Versions::OURS, 0).to_vec()
}

/// A device in IDLE.
pub(crate) fn device() -> DeviceLink {
    let mut device =
        DeviceLink::new(DeviceConfig { ident: ident(), estop: Reaction::Hold }).unwrap();
    device.ready(0);
    device
}

/// Hands a frame of the example session to a device.
pub(crate) fn report(device: &mut DeviceLink, tick: u64, kind: Kind, seq: u16, payload: &[u8]) {
    let header = Header { ack_req: true, ..Header::new(Direction::ToDevice, kind, seq, SESSION) };
    let bytes = wire(&header, payload);
    let mut input = &bytes[..];
    while device.receive(tick, &mut input).is_some() {}
}
