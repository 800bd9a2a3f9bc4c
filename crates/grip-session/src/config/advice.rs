//! Warnings about a configuration that is legal: what looks unintended about it.

use super::{HostConfig, address::Listen, keys::RealtimeMode, layers::Setting};

/// More than this (N) is rarely meant for one finger.
const STRONG_N: f32 = 200.0;

/// One sentence for everything that a person should look at again. `set` are the values that somebody set.
#[must_use]
pub fn warnings(config: &HostConfig, set: &[Setting]) -> Vec<String> {
    let is_set = |key: &str| {
        set.iter().any(|setting| {
            setting
                .key
                .strip_prefix(key)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    };
    let mut warnings = Vec::new();
    let mut warn = |when: bool, text: &str| {
        if when {
            warnings.push(text.to_owned());
        }
    };
    sockets(config, &mut warn);
    ports(config, &mut warn);
    let grip = &config.grip;
    warn(grip.f_max_n > STRONG_N, "grip.f_max_n is more than 200 N for one finger");
    warn(
        grip.trial_force_n > 0.5 * grip.f_max_n,
        "grip.trial_force_n is more than half of grip.f_max_n: the first grasp is no longer light",
    );
    warn(
        config.record.is_none() && is_set("recording"),
        "[recording] says how to record, but nothing is recorded: record is not set",
    );
    warn(
        config.realtime.mode == RealtimeMode::Off && is_set("realtime"),
        "[realtime] is set, but nothing is asked of the system: realtime.mode is \"off\"",
    );
    warn(
        config.realtime.mode == RealtimeMode::Warn && config.realtime.spin_us > 0,
        "realtime.spin_us is set, but realtime.mode is \"warn\": the hot thread sleeps until a frame is there",
    );
    warn(
        config.fleet.site.is_none() && is_set("fleet"),
        "[fleet] is set, but nothing is published: fleet.site is not set",
    );
    warn(
        config.fleet.commands && !config.allow_commands,
        "fleet.commands is set, but nobody may command the gripper: allow_commands is not set",
    );
    warn(
        config.fleet.models.is_some() && !config.allow_models,
        "fleet.models is set, but nobody may bring a model: allow_models is not set",
    );
    warn(
        config.fleet.site.is_some() && config.listen == Listen::Off,
        "fleet.site is set, but gripfleet cannot connect: listen is \"off\"",
    );
    let calibrated = ["detector.interval_s", "detector.slack_still", "detector.slack_moving"]
        .into_iter()
        .find(|key| is_set(key));
    if let (Some(_), Some(key)) = (config.stylus_calibration(), calibrated) {
        warn(true, &format!("{key} is set, but the calibration decides it"));
    }
    warnings
}

fn sockets(config: &HostConfig, warn: &mut dyn FnMut(bool, &str)) {
    warn(
        config.allow_commands && config.listen.is_remote(),
        "every computer of the network may command the gripper: allow_commands and allow_remote are both set, and nothing is encrypted",
    );
    warn(
        config.allow_commands && config.listen == Listen::Off,
        "allow_commands is set, but no client can connect: listen is \"off\"",
    );
    let remote_metrics =
        config.metrics.is_some_and(|metrics| !metrics.ip().to_canonical().is_loopback());
    warn(
        config.allow_remote && !config.listen.is_remote() && !remote_metrics,
        "allow_remote is set, but no address is open to other computers",
    );
    let same = matches!(config.listen, Listen::Tcp(listen) if Some(listen) == config.metrics && listen.port() != 0);
    warn(same, "listen and metrics are the same address: the second one will fail");
}

fn ports(config: &HostConfig, warn: &mut dyn FnMut(bool, &str)) {
    let port = config.port.as_deref();
    let named = port.is_some_and(|port| port != "auto");
    warn(
        named && config.usb != super::UsbFilter::ANY,
        "[usb] chooses among ports only where port = \"auto\"",
    );
    let simulated = port.is_some_and(|port| port == "sim" || port.starts_with("sim:"));
    warn(simulated && config.uid.is_some(), "uid is set, but the gripper is simulated");
}
