//! Check of merged settings: the first value that cannot be.

use super::{HostConfig, LinkConfig, RecordingConfig, error::ValueError};
use slip_core::{ConfigError, Signal, units::Hertz};

/// Many boards take this speed as the order to enter their boot loader.
pub const BOOT_LOADER_BAUD: u32 = 1200;

impl HostConfig {
    /// The first value that cannot be, by its key.
    pub(super) fn check(&self) -> Result<(), (&'static str, ValueError)> {
        self.check_ranges().map_err(|source| {
            let key = match source {
                ConfigError::Range { name, .. } => name,
                ConfigError::Corner(_) => "detector",
            };
            (key, source.into())
        })?;
        if self.baud == Some(BOOT_LOADER_BAUD) {
            return Err(("baud", ValueError::BootLoader));
        }
        if self.listen.is_remote() && !self.allow_remote {
            return Err(("listen", ValueError::ListenRemote(self.listen.clone())));
        }
        self.keys().map_err(|error| ("model_keys", error.into()))?;
        if self.model_keys.is_empty() && self.allow_unsigned_models == Some(false) {
            return Err(("allow_unsigned_models", ValueError::NoModelKey));
        }
        let fleet = &self.fleet;
        if fleet.site.is_some() && fleet.router.is_none() && fleet.network.is_none() {
            return Err(("fleet.site", ValueError::FleetNowhere));
        }
        match self.metrics {
            Some(address) if !address.ip().to_canonical().is_loopback() && !self.allow_remote => {
                Err(("metrics", ValueError::MetricsRemote(address)))
            }
            _ => Ok(()),
        }
    }

    fn check_ranges(&self) -> Result<(), ConfigError> {
        let LinkConfig { sample_rate_hz, batch, ttl_ms } = self.link;
        let RecordingConfig { max_mib, max_age_s, flush_ms, keep_mib } = self.recording;
        let rate = shown(sample_rate_hz);
        ConfigError::within("baud", self.baud.map_or(1.0, shown), 1.0, 1e9)?;
        ConfigError::within("max_clients", f32::from(self.max_clients), 1.0, 1024.0)?;
        ConfigError::within("link.sample_rate_hz", rate, 1000.0, 20_000.0)?;
        ConfigError::within("link.batch", f32::from(batch), 1.0, 32.0)?;
        ConfigError::within("link.ttl_ms", f32::from(ttl_ms), 20.0, 100.0)?;
        ConfigError::within("recording.max_mib", shown(max_mib), 1.0, 1_048_576.0)?;
        if let Some(keep_mib) = keep_mib {
            ConfigError::within("recording.keep_mib", shown(keep_mib), shown(max_mib), 1.074e9)?;
        }
        ConfigError::within("recording.max_age_s", shown(max_age_s), 1.0, 31_536_000.0)?;
        ConfigError::within("recording.flush_ms", shown(flush_ms), 50.0, 10_000.0)?;
        ConfigError::within("realtime.priority", f32::from(self.realtime.priority), 1.0, 99.0)?;
        let spool_mib = f32::from(self.fleet.spool_mib);
        ConfigError::within("fleet.spool_mib", spool_mib, 1.0, 1024.0)?;
        let ros_domain = f32::from(self.fleet.ros_domain.unwrap_or(0));
        ConfigError::within("fleet.ros_domain", ros_domain, 0.0, 232.0)?;
        let cpu = f32::from(self.realtime.cpu.unwrap_or(0));
        ConfigError::within("realtime.cpu", cpu, 0.0, 1023.0)?;
        ConfigError::within("realtime.spin_us", f32::from(self.realtime.spin_us), 0.0, 500.0)?;
        self.pipeline(Signal::Displacement, Hertz(rate)).check()
    }
}

fn shown(number: u32) -> f32 {
    number as f32
}
