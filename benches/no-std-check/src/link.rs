//! Exported functions of the link, from bytes to messages and bytes: decoder, both ends of the link.

use grip_link::{
    decoder::{Decoder, Verdict},
    device::{DeviceConfig, DeviceConfigError, DeviceEvent, DeviceLink, Drive, RowError},
    frame::{EncodeError, Header, MAX_WIRE, encode},
    host::{GripCommand, HostConfig, HostConfigError, HostEvent, HostLink},
};

/// Frames among the bytes.
#[unsafe(no_mangle)]
pub fn decoder_next(decoder: &mut Decoder, mut bytes: &[u8]) -> usize {
    let mut payload = 0;
    while let Some(verdict) = decoder.next(&mut bytes) {
        if let Verdict::Frame(frame) = verdict {
            payload += frame.payload.len();
        }
    }
    payload
}

/// A frame onto the wire.
#[unsafe(no_mangle)]
pub fn frame_encode(header: &Header, payload: &[u8], out: &mut [u8]) -> Result<usize, EncodeError> {
    encode(header, payload, out)
}

/// The gripper's end.
#[unsafe(no_mangle)]
pub fn device_new(config: DeviceConfig) -> Result<DeviceLink, DeviceConfigError> {
    DeviceLink::new(config)
}

/// Bytes of the host.
#[unsafe(no_mangle)]
pub fn device_receive(link: &mut DeviceLink, tick: u64, bytes: &mut &[u8]) -> Option<DeviceEvent> {
    link.receive(tick, bytes)
}

/// A row of readings.
#[unsafe(no_mangle)]
pub fn device_push(link: &mut DeviceLink, tick: u64, row: &[f32]) -> Result<(), RowError> {
    link.push_f32(tick, row)
}

/// The force for the actuator.
#[unsafe(no_mangle)]
pub fn device_drive(link: &mut DeviceLink, tick: u64) -> Drive {
    link.drive(tick)
}

/// Bytes for the host.
#[unsafe(no_mangle)]
pub fn device_transmit(
    link: &mut DeviceLink,
    tick: u64,
    out: &mut [u8; MAX_WIRE],
) -> Option<usize> {
    link.poll_transmit(tick, out)
}

/// The computer's end.
#[unsafe(no_mangle)]
pub fn host_new(config: HostConfig) -> Result<HostLink, HostConfigError> {
    HostLink::new(config)
}

/// Bytes of the gripper: the sum over all readings, so that every row is read.
#[unsafe(no_mangle)]
pub fn host_receive(link: &mut HostLink, now_us: u64, mut bytes: &[u8]) -> f32 {
    let mut sum = 0.0;
    while let Some(event) = link.receive(now_us, &mut bytes) {
        if let HostEvent::Samples { header, .. } = event
            && let Some(samples) = link.samples(header)
        {
            for row in &samples {
                sum +=
                    samples.layout().columns().iter().filter_map(|c| row.read(c.kind)).sum::<f32>();
            }
        }
    }
    sum
}

/// A force command.
#[unsafe(no_mangle)]
pub fn host_grip(link: &mut HostLink, force_n: f32, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
    link.grip(0, &GripCommand::newtons(force_n)?, out)
}

/// Requests and clock sync.
#[unsafe(no_mangle)]
pub fn host_transmit(link: &mut HostLink, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
    link.poll_transmit(now_us, out)
}
