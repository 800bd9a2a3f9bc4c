//! Flags, environment and configuration file, in this order, made into settings.

use crate::cli::Cli;
use grip_host::{HostConfig, HostEstimator, ModelError, exit::WrongArgument, model};
use grip_port::{DEFAULT_BAUD, PortArgs};
use std::path::PathBuf;

/// What the daemon runs with.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) config: HostConfig,
    pub(crate) port: String,
    pub(crate) baud: u32,
    pub(crate) seed: Option<u64>,
    file: Option<PathBuf>,
    model: Option<PathBuf>,
}

impl Settings {
    pub(crate) fn new(cli: &Cli) -> anyhow::Result<Self> {
        let user = std::env::var_os("XDG_CONFIG_HOME")
            .map(PathBuf::from)
            .or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".config")));
        let file = cli.config.clone().or_else(|| HostConfig::find(user.as_deref()));
        let mut config =
            file.as_deref().map_or_else(|| Ok(HostConfig::default()), HostConfig::read)?;
        config.observation.esc = cli.esc.unwrap_or(config.observation.esc);
        let model = cli.model.clone().or_else(|| config.model.clone());
        let port = cli.port.clone().or_else(|| config.port.clone());
        let settings = Self {
            port: port.unwrap_or_default(),
            baud: cli.baud.or(config.baud).unwrap_or(DEFAULT_BAUD),
            seed: cli.seed,
            file,
            model,
            config,
        };
        if cli.check_config {
            settings.estimator()?;
        } else if settings.port.is_empty() {
            let message = "no port: say --port /dev/ttyACM0, --port auto, or --port sim for the built-in simulator";
            return Err(WrongArgument(message.to_owned()).into());
        }
        if let Some(record) = &cli.record
            && record.extension().is_none_or(|extension| extension != "csv")
        {
            let message = format!("--record {}: recordings are written as .csv", record.display());
            return Err(WrongArgument(message).into());
        }
        Ok(settings)
    }

    pub(crate) fn estimator(&self) -> Result<HostEstimator, ModelError> {
        self.model.as_deref().map_or_else(model::default_estimator, model::read_estimator)
    }

    /// Where the settings come from, for --check-config.
    pub(crate) fn origin(&self) -> String {
        let file = self.file.as_ref().map_or_else(
            || "no configuration file: all defaults".to_owned(),
            |file| format!("{}: valid", file.display()),
        );
        let model = self
            .model
            .as_ref()
            .map_or_else(|| "embedded model".to_owned(), |model| model.display().to_string());
        format!("{file}\nmodel: {model}")
    }

    /// The port and what belongs to it.
    pub(crate) fn port_args(&self) -> PortArgs<'_> {
        PortArgs { name: &self.port, baud: self.baud, seed: self.seed, usb: &self.config.usb }
    }
}
