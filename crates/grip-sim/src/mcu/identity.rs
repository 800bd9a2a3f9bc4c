//! What the device of a scene reports about itself: channels, scales, limits, identity.

use crate::scene::{ACCELERATION_SPAN_M_S2, STYLUS_SPAN_M, Scene, SceneConfig};
use grip_link::device::DeviceConfig;
use grip_link::message::{Channel, ChannelKind, Ident, Limits, Reaction, ResetReason, Unit};

/// Ticks are microseconds, as the time stamps of samples are.
pub(super) const TICK_HZ: u32 = 1_000_000;
/// Fastest sampling the virtual device offers, whatever the scene prefers (Hz).
const RATE_MAX_HZ: u32 = 20_000;
/// A channel of the virtual device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    Stylus,
    NormalForce,
    Travel,
    Reference,
    SecondStylus,
    TangentialForce,
}

/// The channels in the order of IDENT; the stylus comes first.
pub(super) fn readings(config: &SceneConfig) -> Vec<Reading> {
    let channels = config.channels;
    let optional = [
        (channels.force, Reading::NormalForce),
        (channels.travel, Reading::Travel),
        (channels.reference, Reading::Reference),
        (config.second_stylus_mm.is_some(), Reading::SecondStylus),
        (channels.tangential, Reading::TangentialForce),
    ];
    let present = optional.into_iter().filter_map(|(present, reading)| present.then_some(reading));
    core::iter::once(Reading::Stylus).chain(present).collect()
}

/// Unit of one step of an i16: the span of the channel over 32000 steps.
pub(super) fn scale(reading: Reading, config: &SceneConfig) -> f32 {
    let span = match reading {
        Reading::Stylus if config.vibration.is_some() => ACCELERATION_SPAN_M_S2,
        Reading::Stylus | Reading::Reference | Reading::SecondStylus => STYLUS_SPAN_M,
        // Friction above the normal force is rare.
        Reading::NormalForce | Reading::TangentialForce => 1.25 * config.drive.force_max_n,
        Reading::Travel => 1.25e-3 * config.finger_length_mm,
    };
    crate::grasp::narrow(span / 32_000.0)
}

pub(super) fn device_config(scene: &Scene, boot_id: u32, reset: ResetReason) -> DeviceConfig {
    let config = scene.config();
    let channel = |&reading: &Reading| channel(reading, config);
    let channels: Vec<Channel> = readings(config).iter().map(channel).collect();
    let force_max_mn = milli_i32(config.drive.force_max_n);
    let limits = Limits {
        rate_max_hz: RATE_MAX_HZ,
        force_max_mn,
        slew_max_mn_s: milli_i32(config.drive.slew_max_n_s).unsigned_abs(),
        hold_cap_mn: force_max_mn,
        travel_min_um: 0,
        travel_max_um: 100_000,
    };
    let ident = Ident::new(uid(config.seed), boot_id, limits, &channels);
    let ident = Ident { tick_hz: TICK_HZ, reset, ..ident };
    DeviceConfig { ident, estop: Reaction::Hold }
}

/// The reference is a stylus in the air: metres, not the usual acceleration.
fn channel(reading: Reading, config: &SceneConfig) -> Channel {
    let (kind, unit) = match reading {
        Reading::Stylus if config.vibration.is_some() => {
            (ChannelKind::Stylus, Unit::MetrePerSecond2)
        }
        Reading::Stylus => (ChannelKind::Stylus, Unit::Metre),
        Reading::NormalForce => (ChannelKind::NormalForce, Unit::Newton),
        Reading::Travel => (ChannelKind::Travel, Unit::Metre),
        Reading::Reference => (ChannelKind::Reference, Unit::Metre),
        Reading::SecondStylus => (ChannelKind::SecondStylus, Unit::Metre),
        Reading::TangentialForce => (ChannelKind::TangentialForce, Unit::Newton),
    };
    Channel { unit, ..Channel::single(kind, scale(reading, config)) }
}

/// "grip-sim" and the seed: two scenes of the same seed are the same gripper.
fn uid(seed: u64) -> [u8; 16] {
    let mut uid = [0; 16];
    for (slot, byte) in uid.iter_mut().zip(b"grip-sim".iter().copied().chain(seed.to_le_bytes())) {
        *slot = byte;
    }
    uid
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a checked scene stays below 1e5 N and 1e5 N/s: 1e8 in milli"
)]
fn milli_i32(value: f64) -> i32 {
    (value * 1e3).round() as i32
}
