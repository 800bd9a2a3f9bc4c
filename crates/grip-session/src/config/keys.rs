//! The tables of `gripd.toml` that concern the daemon, not the pipeline.

use super::address::Site;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What is asked of the microcontroller when the link is set up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinkConfig {
    /// Samples per second, 1000 to 20000.
    pub sample_rate_hz: u32,
    /// Samples per frame, 1 to 32.
    pub batch: u8,
    /// How long a command stays valid on the device (ms), 20 to 100.
    pub ttl_ms: u16,
}

impl Default for LinkConfig {
    fn default() -> Self {
        Self { sample_rate_hz: 10_000, batch: 10, ttl_ms: 50 }
    }
}

/// When a recording goes on in another file, and how much of it a crash may cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecordingConfig {
    /// Size at which the next file begins (MiB), 1 to 1048576.
    pub max_mib: u32,
    /// Age at which the next file begins (s), 1 to 31536000.
    pub max_age_s: u32,
    /// Time between two flushes (ms), 50 to 10000: what a crash may cost.
    pub flush_ms: u32,
    /// Size (MiB) of all files of this run together above which the oldest of them are deleted, `max_mib` to 1,073,741,824; none is, where absent.
    pub keep_mib: Option<u32>,
}

impl Default for RecordingConfig {
    fn default() -> Self {
        Self { max_mib: 1024, max_age_s: 300, flush_ms: 250, keep_mib: None }
    }
}

/// What is remembered of objects.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MemoryConfig {
    /// The file that keeps what is known of objects; nothing is remembered, where absent.
    pub file: Option<PathBuf>,
    /// Name of every object that no client names; without a name, where absent.
    pub object: Option<String>,
}

slip_core::named! {
    /// Whether the hot thread asks the system for real-time privileges, and what a refusal means.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum RealtimeMode {
        fn name: "The name used in files and flags.";
    }
    #[default]
    Off: "No.", "off";
    Warn: "Yes; what is not granted is logged, and gripd goes on without.", "warn";
    Strict: "Yes; what is not granted ends gripd.", "strict";
}

/// What the hot thread asks of the scheduler.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    default,
    deny_unknown_fields,
    expecting = "a table: [realtime] with mode = \"off\", \"warn\" or \"strict\""
)]
pub struct RealtimeConfig {
    /// Whether it asks at all.
    pub mode: RealtimeMode,
    /// `SCHED_FIFO` priority, 1 to 99; 50 is that of the threads of interrupts.
    pub priority: u8,
    /// The processor it is bound to; any, where absent.
    pub cpu: Option<u16>,
    /// It asks the line again and again so long (us) before and after the next frame is due, 0 to 500 and at most a quarter of the time
    /// between two frames, and does not sleep; never for 0. Only in the mode `strict`, and on another processor than the interrupts of the line.
    pub spin_us: u16,
}

impl RealtimeConfig {
    /// How long it does not sleep around a frame (us); 0 without the mode for it.
    #[must_use]
    pub const fn spins_us(&self) -> u16 {
        if matches!(self.mode, RealtimeMode::Strict) { self.spin_us } else { 0 }
    }
}

impl Default for RealtimeConfig {
    fn default() -> Self {
        Self { mode: RealtimeMode::Off, priority: 50, cpu: None, spin_us: 0 }
    }
}

/// Where and how the gripper is seen beside many others; gripfleet reads that, which runs beside gripd.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FleetConfig {
    /// The name of the place; where it is absent, nothing leaves this computer.
    pub site: Option<Site>,
    /// Where a Zenoh router listens, such as `tcp/10.0.0.1:7447`; what `network` states, where absent.
    pub router: Option<String>,
    /// Zenoh configuration file, for names, retries and the rest.
    pub network: Option<PathBuf>,
    /// The folder that keeps events until they were fetched, also over an end of gripfleet; memory, where absent.
    pub spool: Option<PathBuf>,
    /// Room for events (MiB), 1 to 1024; the oldest go first.
    pub spool_mib: u16,
    /// The folder that keeps models which come over the network, where `allow_models` lets clients bring one; none is taken, where absent.
    pub models: Option<PathBuf>,
    /// Every n-th sample is published; none for 0.
    pub samples_every: u16,
    /// Whether commands for the fingers are taken from the network too, where `allow_commands` lets clients command at all.
    pub commands: bool,
    /// Whether recordings are given to whoever asks for them.
    pub recordings: bool,
    /// The domain of ROS 2 (`ROS_DOMAIN_ID`), 0 to 232, in which the gripper is a node too; none, where absent.
    pub ros_domain: Option<u16>,
}

impl Default for FleetConfig {
    fn default() -> Self {
        Self {
            site: None,
            router: None,
            network: None,
            spool: None,
            spool_mib: 16,
            models: None,
            samples_every: 0,
            commands: false,
            recordings: false,
            ros_domain: None,
        }
    }
}

/// Which USB serial port `auto` means; what is absent fits every port.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UsbFilter {
    /// Vendor.
    pub vid: Option<u16>,
    /// Product.
    pub pid: Option<u16>,
    /// Serial number; `*` stands for any characters.
    pub serial: Option<String>,
    /// Name of the product; `*` stands for any characters.
    pub product: Option<String>,
}

impl UsbFilter {
    /// Fits every USB serial port.
    pub const ANY: Self = Self { vid: None, pid: None, serial: None, product: None };
}

slip_core::named! {
    /// How much gripd reports on standard error, from the least to the most.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum LogLevel {
        fn name: "The name used in files, flags and lines.";
    }
    Error: "What failed.", "error";
    Warn: "And what is odd.", "warn";
    #[default]
    Info: "And what is good to know.", "info";
    Debug: "And what helps to find a mistake.", "debug";
}
