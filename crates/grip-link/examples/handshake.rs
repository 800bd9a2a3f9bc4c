//! Host and gripper in one program, with arrays for a line: handshake, samples, a force: `cargo run -p grip-link --example handshake`.
#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "an example: what fails is to be seen"
)]

use grip_link::{
    device::{DeviceConfig, DeviceLink},
    frame::MAX_WIRE,
    host::{GripCommand, HostConfig, HostEvent, HostLink, LinkState},
    message::{
        Channel, ChannelKind, Config, DeviceState, Ident, Limits, LossAction, Reaction,
        SampleFormat,
    },
};

fn ident() -> Ident {
    let limits = Limits {
        rate_max_hz: 10_000,
        force_max_mn: 20_000,
        slew_max_mn_s: 400_000,
        hold_cap_mn: 15_000,
        travel_min_um: 0,
        travel_max_um: 50_000,
    };
    let channels = [
        Channel::single(ChannelKind::Stylus, 1e-8),
        Channel::single(ChannelKind::NormalForce, 1e-3),
    ];
    Ident { state: DeviceState::Idle, ..Ident::new(*b"an-example-of-it", 1, limits, &channels) }
}

pub(crate) fn main() {
    let config = Config {
        sample_rate_hz: 1000,
        batch: 1,
        format: SampleFormat::F32,
        ttl_ms: 50,
        channel_mask: 0b11,
        force_max_mn: 10_000,
        slew_mn_s: 200_000,
        hold_cap_mn: 8_000,
        loss_after_ms: 1_000,
        loss_action: LossAction::Hold,
    };
    let mut device =
        DeviceLink::new(DeviceConfig { ident: ident(), estop: Reaction::Hold }).unwrap();
    device.ready(0);
    let mut host = HostLink::new(HostConfig::new(config)).unwrap();
    host.open(0, 0xBEEF).unwrap();

    let (mut rows, mut out) = (0, [0; MAX_WIRE]);
    for now_us in (0..500_000).step_by(1000) {
        // Both clocks begin at 0 here; in general the host estimates the other one.
        let mut line = Vec::new();
        while let Some(length) = host.poll_transmit(now_us, &mut out) {
            line.extend_from_slice(&out[..length]);
        }
        if host.state() == LinkState::Stream {
            let command = GripCommand::newtons(3.0).unwrap();
            let length = host.grip(now_us, &command, &mut out).unwrap();
            line.extend_from_slice(&out[..length]);
        }
        let mut input = line.as_slice();
        while device.receive(now_us, &mut input).is_some() {}

        let force_mn = device.drive(now_us).force_mn();
        if device.in_force().is_some() {
            // Refused until START has come.
            let _ =
                device.push_f32(now_us, &[0.0, 1e-3 * f32::from(i16::try_from(force_mn).unwrap())]);
        }
        line.clear();
        while let Some(length) = device.poll_transmit(now_us, &mut out) {
            line.extend_from_slice(&out[..length]);
        }
        let mut input = line.as_slice();
        while let Some(event) = host.receive(now_us, &mut input) {
            match event {
                HostEvent::State { from, to } => println!("{now_us} us: {from} to {to}"),
                HostEvent::Samples { header, .. } => {
                    rows += host.samples(header).unwrap().rows().count()
                }
                _ => {}
            }
        }
    }
    let force_mn = device.drive(500_000).force_mn();
    println!("{rows} rows, the gripper presses with {force_mn} mN");
    assert!(rows > 300 && force_mn == 3000, "the link did not come up");
}
