//! Settings of gripfleet, from flags, environment and the configuration files of gripd.

use crate::cli::Cli;
use grip_fleet::{Site, net::Network};
use grip_session::{
    HostConfig,
    config::{FleetConfig, Layers, Listen},
    exit::WrongArgument,
};

/// The place of this gripper, and the configuration.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) site: Site,
    pub(crate) config: HostConfig,
}

impl Settings {
    /// Reads and checks everything.
    pub(crate) fn new(cli: &Cli) -> anyhow::Result<Self> {
        let mut layers = Layers::of_user(cli.config.as_deref())?;
        let record = cli.record.as_deref().map(|file| file.to_string_lossy().into_owned());
        for (from, key, value) in [
            ("--listen or GRIPD_LISTEN", "listen", &cli.listen),
            ("--record or GRIPD_RECORD", "record", &record),
            ("--log-level or GRIPD_LOG", "log_level", &cli.log_level),
        ] {
            if let Some(value) = value {
                layers.set(from, key, value.clone());
            }
        }
        let config = layers.resolve()?;
        let at = |key: &str, trouble: String| -> anyhow::Result<WrongArgument> {
            let set = layers.settings()?;
            let place = set.iter().find(|setting| setting.key == key);
            let place = place.map_or_else(String::new, |setting| format!("{}: ", setting.place));
            Ok(WrongArgument(place + &trouble))
        };
        let Some(site) = config.fleet.site.clone() else {
            let text =
                "nothing is published: fleet.site is not set, in gripd.toml or where --config says";
            return Err(WrongArgument(text.to_owned()).into());
        };
        if config.listen == Listen::Off {
            let text = "gripfleet connects to gripd, but listen is \"off\"".to_owned();
            return Err(at("listen", text)?.into());
        }
        if let Err(error) = network(&config.fleet).check() {
            let router = config.fleet.router.is_some();
            let key = if router { "fleet.router" } else { "fleet.network" };
            return Err(at(key, error.to_string())?.into());
        }
        Ok(Self { site, config })
    }
}

/// The network that the configuration names.
pub(crate) fn network(config: &FleetConfig) -> Network {
    Network { router: config.router.clone(), file: config.network.clone() }
}
