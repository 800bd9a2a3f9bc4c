//! A header in; the board that it is to the host, out.

use super::{BoardOptions, gripper::shows_force};
use crate::rows::header::Header;
use grip_link::{
    device::DeviceConfig,
    message::{
        Channel, ChannelKind, DeviceState, FaultCode, Firmware, Ident, Limits, MAX_CHANNELS,
        Reaction, ResetReason, SampleFormat, Versions,
    },
};

/// `value` in thousandths.
pub(super) fn milli(value: f32) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let milli = (1e3 * f64::from(value)).round().clamp(0.0, 2e9) as u32;
    milli
}

/// What the rows are to the host: a board with these channels at this rate.
pub(super) fn device_config(header: &Header, options: &BoardOptions) -> DeviceConfig {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "50 to 20000")]
    let rate_max_hz = header.rate_hz.round() as u32;
    let force_max_mn =
        options.actuator.map_or(0, |actuator| milli(actuator.force_max_n)).cast_signed();
    let slew_max_mn_s = options.actuator.map_or(1, |actuator| milli(actuator.slew_n_s).max(1));
    let own = shows_force(header, options).then_some(Channel {
        formats: 1 << SampleFormat::F32.code(),
        ..Channel::single(ChannelKind::NormalForce, 1e-3)
    });
    let mut channels = [Ident::NO_CHANNEL; MAX_CHANNELS];
    let given = header.channels.iter().copied().chain(own).take(MAX_CHANNELS);
    let channel_count = given.clone().count();
    for (slot, channel) in channels.iter_mut().zip(given) {
        *slot = channel;
    }
    let ident = Ident {
        versions: Versions::OURS,
        max_rx: 480,
        caps: 0,
        uid: *b"rows of samples ",
        boot_id: 1,
        tick_hz: 1_000_000,
        limits: Limits {
            rate_max_hz,
            force_max_mn,
            slew_max_mn_s,
            hold_cap_mn: force_max_mn,
            travel_min_um: 0,
            travel_max_um: 0,
        },
        firmware: Firmware { major: 0, minor: 1, patch: 0 },
        reset: ResetReason::PowerOn,
        state: DeviceState::Boot,
        fault: FaultCode::NONE,
        channels,
        channel_count: u8::try_from(channel_count).unwrap_or(0),
    };
    DeviceConfig { ident, estop: Reaction::Hold }
}
