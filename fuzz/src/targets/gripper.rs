//! The gripper that all targets and all peers play: stylus, normal force and a pressure array of four.

use grip_link::cobs;
use grip_link::device::{DeviceConfig, DeviceLink};
use grip_link::frame::{Direction, Frame, Header, MAX_PAYLOAD, MAX_WIRE, encode};
use grip_link::message::{
    Channel, ChannelKind, Config, DeviceState, Firmware, Grip, GripMode, Hello, Ident, Kind,
    Limits, LossAction, PayloadError, Reaction, SampleFormat, Versions,
};

/// Session of the targets.
pub const SESSION: u16 = 0xBEEF;
/// Largest force of the gripper (mN).
pub const FORCE_MAX_MN: i32 = 20_000;

/// Its description.
pub fn ident(boot_id: u32) -> Ident {
    let limits = Limits {
        rate_max_hz: 20_000,
        force_max_mn: FORCE_MAX_MN,
        slew_max_mn_s: 400_000,
        hold_cap_mn: 15_000,
        travel_min_um: 0,
        travel_max_um: 50_000,
    };
    let channels = [
        Channel::single(ChannelKind::Stylus, 1e-8),
        Channel::single(ChannelKind::NormalForce, 1e-3),
        Channel { count: 4, ..Channel::single(ChannelKind::PressureArray, 10.0) },
    ];
    let firmware = Firmware { major: 1, minor: 2, patch: 3 };
    let ident = Ident::new(*b"grip-link-test-1", boot_id, limits, &channels);
    Ident { firmware, state: DeviceState::Idle, ..ident }
}

/// In state BOOT.
pub fn device(boot_id: u32) -> DeviceLink {
    DeviceLink::new(DeviceConfig { ident: ident(boot_id), estop: Reaction::Hold }).unwrap()
}

/// In state IDLE.
pub fn idle(boot_id: u32) -> DeviceLink {
    let mut device = device(boot_id);
    device.ready(0);
    device
}

/// All frames that a device has to send now: type and payload.
pub fn sent(device: &mut DeviceLink, tick: u64) -> Vec<(Kind, Vec<u8>)> {
    let mut out = [0; MAX_WIRE];
    let mut frames = Vec::new();
    while let Some(len) = device.poll_transmit(tick, &mut out) {
        let body = cobs::decode_in_place(&mut out[1..len - 1]).unwrap();
        let frame = Frame::from_body(body).unwrap();
        frames.push((frame.header.kind, frame.payload.to_vec()));
    }
    frames
}

/// 5 kHz, five rows a batch, stylus and force as i16, up to 10 N at 200 N/s, 8 N held, 50 ms of life.
pub const CONFIG: Config = Config {
    sample_rate_hz: 5_000,
    batch: 5,
    format: SampleFormat::I16,
    ttl_ms: 50,
    channel_mask: 0b011,
    force_max_mn: 10_000,
    slew_mn_s: 200_000,
    hold_cap_mn: 8_000,
    loss_after_ms: 1_000,
    loss_action: LossAction::Hold,
};

/// The wire bytes of a frame.
pub fn wire(header: &Header, payload: &[u8]) -> Vec<u8> {
    let mut out = [0; MAX_WIRE];
    let len = encode(header, payload, &mut out).unwrap();
    out[..len].to_vec()
}

/// The payload of a HELLO.
pub fn hello(versions: Versions, time_us: u64) -> [u8; Hello::SIZE] {
    let mut payload = [0; Hello::SIZE];
    Hello { versions, max_rx: 480, caps: 0, time_us }.write(&mut payload).unwrap();
    payload
}

/// A command of this force, for as long and as fast as CONFIG states.
pub const fn press(cmd_id: u32, force_mn: i32) -> Grip {
    let mode = GripMode::Force.code();
    Grip { cmd_id, mode, flags: 0, ttl_ms: 0, force_mn, slew_mn_s: 0, cause_sample: 0 }
}

/// The payload that a message writes.
pub fn written(write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>) -> Vec<u8> {
    let mut bytes = [0xAA; MAX_PAYLOAD];
    let len = write(&mut bytes).unwrap();
    bytes[..len].to_vec()
}

/// HELLO, CONFIG and START with the sequence numbers 65533 to 65535.
pub fn greeting() -> Vec<u8> {
    let header = |kind, seq| Header {
        ack_req: true,
        ..Header::new(Direction::ToDevice, kind, seq, SESSION)
    };
    [
        wire(&header(Kind::HELLO, 65_533), &hello(Versions::OURS, 0)),
        wire(&header(Kind::CONFIG, 65_534), &CONFIG.to_bytes()),
        wire(&header(Kind::START, 65_535), &[]),
    ]
    .concat()
}
