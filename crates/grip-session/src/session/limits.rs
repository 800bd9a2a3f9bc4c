//! The configuration in; what is asked of a gripper, and what its answer leaves to the controller, out.

use crate::config::HostConfig;
use grip_link::message::{Config, LossAction, SampleFormat};
use slip_core::grip::GripConfig;

/// The controller within the limits that the gripper has put in force.
pub(super) fn limited(grip: GripConfig, given: &Config) -> GripConfig {
    #[expect(clippy::cast_precision_loss, reason = "limits need no more digits")]
    let (f_max_n, slew_n_s) = (given.force_max_mn as f32 / 1000.0, given.slew_mn_s as f32 / 1000.0);
    let slew_n_s = grip.slew_n_s.min(slew_n_s);
    let f_max_n = grip.f_max_n.min(f_max_n);
    GripConfig {
        f_max_n,
        slew_n_s,
        trial_force_n: grip.trial_force_n.min(f_max_n),
        least_force_n: grip.least_force_n.min(f_max_n),
        contact_n: grip.contact_n.min(0.5 * grip.least_force_n.min(f_max_n)),
        close_rate_n_s: grip.close_rate_n_s.min(slew_n_s),
        backoff_n_s: grip.backoff_n_s.min(slew_n_s),
        ..grip
    }
}

/// The CONFIG that asks a gripper for these settings.
pub(super) fn device_config(config: &HostConfig) -> Config {
    let milli = |newtons: f32| {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "checked: at most 1e9; the cast saturates"
        )]
        let value = (f64::from(newtons) * 1000.0).round() as i32;
        value
    };
    Config {
        sample_rate_hz: config.link.sample_rate_hz,
        batch: config.link.batch,
        format: SampleFormat::F32,
        ttl_ms: config.link.ttl_ms,
        channel_mask: u32::MAX,
        force_max_mn: milli(config.grip.f_max_n),
        slew_mn_s: u32::try_from(milli(config.grip.slew_n_s)).unwrap_or(1),
        hold_cap_mn: milli(config.grip.f_max_n),
        loss_after_ms: 1000,
        loss_action: LossAction::Hold,
    }
}
