//! The board that a header is to the host.

use super::{BoardOptions, gripper::shows_force};
use crate::rows::header::Header;
use grip_link::{
    device::DeviceConfig,
    message::{Channel, ChannelKind, Ident, Limits, Reaction, SampleFormat},
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
    let channels: Vec<Channel> = header.channels.iter().copied().chain(own).collect();
    let limits = Limits {
        rate_max_hz,
        force_max_mn,
        slew_max_mn_s,
        hold_cap_mn: force_max_mn,
        travel_min_um: 0,
        travel_max_um: 0,
    };
    let ident = Ident::new(*b"rows of samples ", 1, limits, &channels);
    DeviceConfig { ident, estop: Reaction::Hold }
}
