//! A device and a host to ask, and frames to ask with.

use grip_link::cobs;
use grip_link::device::{DeviceConfig, DeviceLink};
use grip_link::frame::{Direction, Frame, Header, MAX_PAYLOAD, MAX_WIRE, encode};
use grip_link::message::{
    Channel, ChannelKind, Config, DeviceState, FaultCode, Firmware, Hello, Ident, Kind, Limits,
    LossAction, MAX_CHANNELS, PayloadError, Reaction, ResetReason, SampleFormat, Versions,
};

/// Session of the examples.
pub(crate) const SESSION: u16 = 0xBEEF;

/// The CONFIG of the examples.
pub(crate) fn config() -> Config {
    Config {
        sample_rate_hz: 5_000,
        batch: 5,
        format: SampleFormat::I16,
        ttl_ms: 50,
        channel_mask: 0b11,
        force_max_mn: 10_000,
        slew_mn_s: 200_000,
        hold_cap_mn: 8_000,
        loss_after_ms: 1_000,
        loss_action: LossAction::Hold,
    }
}

/// The gripper of the examples: 1 000 000 ticks a second, stylus and normal force.
pub(crate) fn ident() -> Ident {
    let mut channels = [Ident::NO_CHANNEL; MAX_CHANNELS];
    channels[0] = Channel::single(ChannelKind::Stylus, 1e-8);
    channels[1] = Channel::single(ChannelKind::NormalForce, 1e-3);
    Ident {
        versions: Versions::OURS,
        max_rx: 480,
        caps: 0,
        uid: *b"grip-link-test-1",
        boot_id: 0xB007,
        tick_hz: 1_000_000,
        limits: Limits {
            rate_max_hz: 20_000,
            force_max_mn: 20_000,
            slew_max_mn_s: 400_000,
            hold_cap_mn: 15_000,
            travel_min_um: 0,
            travel_max_um: 50_000,
        },
        firmware: Firmware { major: 1, minor: 2, patch: 3 },
        reset: ResetReason::PowerOn,
        state: DeviceState::Linked,
        fault: FaultCode::NONE,
        channels,
        channel_count: 2,
    }
}

pub(crate) fn hello() -> Hello {
    Hello { versions: Versions::OURS, max_rx: 480, caps: 0, time_us: 0 }
}

/// The payload that a message writes.
pub(crate) fn written(write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>) -> Vec<u8> {
    let mut bytes = [0; MAX_PAYLOAD];
    let len = write(&mut bytes).unwrap();
    bytes[..len].to_vec()
}

pub(crate) fn wire(header: &Header, payload: &[u8]) -> Vec<u8> {
    let mut out = [0; MAX_WIRE];
    let len = encode(header, payload, &mut out).unwrap();
    out[..len].to_vec()
}

/// A device in IDLE.
pub(crate) fn device() -> DeviceLink {
    let mut device =
        DeviceLink::new(DeviceConfig { ident: ident(), estop: Reaction::Hold }).unwrap();
    device.ready(0);
    device
}

/// Hands a frame of the example session to a device.
pub(crate) fn tell(device: &mut DeviceLink, tick: u64, kind: Kind, seq: u16, payload: &[u8]) {
    let header = Header { ack_req: true, ..Header::new(Direction::ToDevice, kind, seq, SESSION) };
    let bytes = wire(&header, payload);
    let mut input = &bytes[..];
    while device.receive(tick, &mut input).is_some() {}
}

/// All frames that a device has to send now: type and payload.
pub(crate) fn sent(device: &mut DeviceLink, tick: u64) -> Vec<(Kind, Vec<u8>)> {
    let mut out = [0; MAX_WIRE];
    let mut frames = Vec::new();
    while let Some(len) = device.poll_transmit(tick, &mut out) {
        let body = cobs::decode_in_place(&mut out[1..len - 1]).unwrap();
        let frame = Frame::from_body(body).unwrap();
        frames.push((frame.header.kind, frame.payload.to_vec()));
    }
    frames
}
