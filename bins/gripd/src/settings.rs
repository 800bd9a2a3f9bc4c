//! Flags, environment and configuration files, in this order, made into settings; and made again on a reload.

use crate::cli::Cli;
use anyhow::Context as _;
use grip_daemon::{
    board,
    clients::{self, ClientsConfig},
    dump,
};
use grip_link::message::daemon::RealTime;
use grip_port::DEFAULT_BAUD;
use grip_record::{files, mcap::Attached};
use grip_session::{
    HostConfig, HostConfigError, HostEstimator, ModelError,
    config::{Change, Layers, RealtimeConfig, Setting, advice, needs_restart},
    exit::WrongArgument,
    model,
    recording::{CALIBRATION_NAME, CONFIG_NAME, MODEL_NAME},
};
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// Name and version.
pub(crate) const PROGRAM: &str = concat!("gripd ", env!("CARGO_PKG_VERSION"));
/// The longest value that --check-config shows (characters).
const LONGEST: usize = 60;

/// What the daemon runs with.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) config: HostConfig,
    pub(crate) port: String,
    pub(crate) baud: u32,
    pub(crate) json: bool,
    /// The flags, which stand over every file that is read again.
    cli: Cli,
    layers: Layers,
    /// The model that came over the network, where one is in force.
    #[cfg(feature = "fleet")]
    pub(crate) deployed: Option<grip_fleet::deploy::Examined>,
    /// Why the models that came over the network cannot be used.
    #[cfg(feature = "fleet")]
    pub(crate) models_trouble: Option<String>,
}

/// Settings that a running daemon can take over, and what became of the rest.
#[derive(Debug)]
pub(crate) struct Reload {
    /// The new settings; what needs a restart has its old value.
    pub(crate) settings: Settings,
    /// The network of the new settings.
    pub(crate) estimator: HostEstimator,
    /// Every key that differs in the files, also those that need a restart.
    pub(crate) changes: Vec<Change>,
    /// Which of them need one.
    pub(crate) restart: Vec<&'static str>,
}

impl Settings {
    /// Reads and checks everything but the model.
    pub(crate) fn new(cli: &Cli) -> anyhow::Result<Self> {
        let layers = layers(cli)?;
        let settings = Self::of(layers.resolve()?, layers, cli.clone());
        settings.check_fleet()?;
        if cli.check_config {
            settings.estimator()?;
        } else if settings.port.is_empty() {
            let message = "no port: say --port /dev/ttyACM0, --port auto, or --port sim for the built-in simulator";
            return Err(WrongArgument(message.to_owned()).into());
        }
        Ok(settings)
    }

    fn of(config: HostConfig, layers: Layers, cli: Cli) -> Self {
        Self {
            port: config.port.clone().unwrap_or_default(),
            baud: config.baud.unwrap_or(DEFAULT_BAUD),
            json: cli.json,
            cli,
            layers,
            config,
            #[cfg(feature = "fleet")]
            deployed: None,
            #[cfg(feature = "fleet")]
            models_trouble: None,
        }
    }

    /// Reads everything again. On an error the settings in force stay as they are.
    pub(crate) fn reload(&self) -> anyhow::Result<Reload> {
        let layers = layers(&self.cli)?;
        let new = layers.resolve()?;
        let config = self.config.taking(&new)?;
        let (changes, restart) = (self.config.diff(&new), needs_restart(&self.config, &new));
        #[cfg_attr(not(feature = "fleet"), expect(unused_mut, reason = "no model comes there"))]
        let mut settings = Self::of(config, layers, self.cli.clone());
        // Also where another model is in force: it is what that one gives way to.
        #[cfg_attr(not(feature = "fleet"), expect(unused_mut, reason = "no model comes there"))]
        let mut estimator = settings.estimator()?;
        #[cfg(feature = "fleet")]
        if let Some(model) = &self.deployed {
            estimator = model.estimator.clone();
            settings.deployed = Some(model.clone());
        }
        Ok(Reload { estimator, settings, changes, restart })
    }

    /// What keeps this program from telling the fleet that the configuration names.
    fn check_fleet(&self) -> anyhow::Result<()> {
        if self.config.fleet.site.is_none() {
            return Ok(());
        }
        let Some((key, trouble)) = fleet_trouble(&self.config) else { return Ok(()) };
        let set = self.layers.settings()?;
        let place = set.iter().find(|setting| setting.key == key);
        let place = place.map_or_else(String::new, |setting| format!("{}: ", setting.place));
        Err(WrongArgument(format!("{place}{trouble}")).into())
    }

    /// The network in force: one that came over the network, or that of the configuration.
    pub(crate) fn estimator(&self) -> Result<HostEstimator, ModelError> {
        #[cfg(feature = "fleet")]
        if let Some(model) = &self.deployed {
            return Ok(model.estimator.clone());
        }
        self.config.model.as_deref().map_or_else(model::default_estimator, model::read_estimator)
    }

    /// What a user should know of the model.
    pub(crate) fn weakness(&self) -> Result<Option<String>, ModelError> {
        let weakness = model::weakness(&self.estimator()?);
        Ok(weakness.map(|text| format!("model {}: {text}", self.model_name())))
    }

    /// The model that the configuration names, and what stands in its file.
    #[cfg(feature = "fleet")]
    pub(crate) fn configured_model(&self) -> Result<grip_fleet::deploy::Examined, ModelError> {
        let file = self.config.model.as_deref();
        let name = file.and_then(Path::file_name).unwrap_or("default".as_ref()).to_string_lossy();
        let text = file.map_or_else(|| Ok(model::default_text().into()), model::read_text)?;
        let estimator = model::parse_estimator(&name, &text)?;
        let sha256 = grip_fleet::deploy::digest(text.as_bytes());
        let id = grip_fleet::deploy::ModelId { name: name.into_owned(), sha256 };
        Ok(grip_fleet::deploy::Examined { id, text: text.into_owned(), estimator })
    }

    /// Whether a flag names the model: no other one is taken then.
    #[cfg(feature = "fleet")]
    pub(crate) const fn model_is_fixed(&self) -> bool {
        self.cli.model.is_some()
    }

    pub(crate) fn model_name(&self) -> Cow<'_, str> {
        #[cfg(feature = "fleet")]
        if let Some(model) = &self.deployed {
            return format!("{} of the fleet", model.id.name).into();
        }
        self.config.model.as_deref().map_or("embedded model".into(), Path::to_string_lossy)
    }

    /// Where the settings come from and what looks unintended about them, for --check-config.
    pub(crate) fn origin(&self) -> anyhow::Result<String> {
        let mut files: Vec<String> =
            self.layers.files().map(|file| format!("{}: valid\n", file.display())).collect();
        files.reverse();
        if files.is_empty() {
            files.push("no configuration file\n".to_owned());
        }
        let model = self.model_name();
        let set = self.layers.settings()?;
        let mut warnings = advice::warnings(&self.config, &set);
        warnings.extend(self.weakness()?);
        let warnings = warnings.iter().map(|warning| format!("\nwarning: {warning}"));
        let set = table(&set);
        Ok(format!("{}model: {model}{set}{}", files.concat(), warnings.collect::<String>()))
    }

    /// What runs, for the board.
    pub(crate) fn about(&self) -> board::About {
        let mut files: Vec<PathBuf> = self.layers.files().map(Path::to_owned).collect();
        files.reverse();
        board::About {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            port: self.port.clone(),
            config_files: files,
            dry_run: self.cli.dry_run,
            ..board::About::default()
        }
    }

    /// What clients are told when they come; `run_id` differs from start to start.
    pub(crate) fn client_about(&self, run_id: u32) -> clients::About {
        clients::About {
            name: PROGRAM.to_owned(),
            run_id,
            dry_run: self.cli.dry_run,
            records: self.config.record.is_some(),
            real_time: RealTime::NotAsked,
        }
    }

    /// How clients are served, and whether somebody asked for it: an address that is taken is an error only then.
    pub(crate) fn clients(&self) -> anyhow::Result<(ClientsConfig, bool)> {
        let config = ClientsConfig {
            listen: self.config.listen.clone(),
            allow_remote: self.config.allow_remote,
            allow_commands: self.config.allow_commands,
            most: usize::from(self.config.max_clients),
            ..ClientsConfig::default()
        };
        let asked = self.layers.settings()?.iter().any(|setting| setting.key == "listen");
        Ok((config, asked))
    }

    /// What the hot thread asks the system for.
    pub(crate) fn realtime(&self) -> RealtimeConfig {
        self.config.realtime
    }

    /// Where dumps go, if anywhere.
    pub(crate) fn dump_folder(&self) -> Option<PathBuf> {
        let state = std::env::var_os("STATE_DIRECTORY");
        dump::folder(self.config.dump_dir.as_deref(), state.as_deref())
    }

    /// The file of a recording that begins at `start_s` (s since 1970), if one is wanted.
    pub(crate) fn record(&self, start_s: u64) -> Option<PathBuf> {
        self.config.record.as_ref().map(|template| template.file(start_s))
    }

    /// Configuration, model and calibration, for a recording.
    pub(crate) fn attachments(&self) -> anyhow::Result<Vec<Attached>> {
        let file = |name: &str, media_type: &str, data| Attached {
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data,
        };
        let config =
            toml::to_string(&self.config).context("the configuration cannot be written")?;
        let mut files = vec![file(CONFIG_NAME, "application/toml", config.into_bytes())];
        files.push(model_file(self.model_text()?));
        if let Some(calibration) = &self.config.calibration {
            files.push(file(CALIBRATION_NAME, "application/toml", read(calibration)?));
        }
        Ok(files)
    }

    /// The file of the model in force.
    fn model_text(&self) -> Result<Vec<u8>, ModelError> {
        #[cfg(feature = "fleet")]
        if let Some(model) = &self.deployed {
            return Ok(model.text.clone().into_bytes());
        }
        // Also the embedded one: a later gripctl may have another.
        match &self.config.model {
            Some(model) => Ok(model::read_text(model)?.into_owned().into_bytes()),
            None => Ok(model::default_text().as_bytes().to_vec()),
        }
    }
}

/// A model, for a recording.
pub(crate) fn model_file(data: Vec<u8>) -> Attached {
    let (name, media_type) = (MODEL_NAME.to_owned(), "application/json".to_owned());
    Attached { name, media_type, data }
}

/// The network that the configuration names.
#[cfg(feature = "fleet")]
pub(crate) fn network(config: &grip_session::config::FleetConfig) -> grip_fleet::net::Network {
    grip_fleet::net::Network { router: config.router.clone(), file: config.network.clone() }
}

/// The key at fault and what is wrong with it.
#[cfg(feature = "fleet")]
fn fleet_trouble(config: &HostConfig) -> Option<(&'static str, String)> {
    let key = if config.fleet.router.is_some() { "fleet.router" } else { "fleet.network" };
    network(&config.fleet).check().err().map(|error| (key, error.to_string()))
}

#[cfg(not(feature = "fleet"))]
fn fleet_trouble(_config: &HostConfig) -> Option<(&'static str, String)> {
    let text = "fleet.site is set, but this gripd was built without the fleet; build it with `cargo build --release -p gripd --features fleet`";
    Some(("fleet.site", text.to_owned()))
}

fn read(file: &Path) -> anyhow::Result<Vec<u8>> {
    files::read(file, files::MOST_MODEL).with_context(|| format!("cannot read {}", file.display()))
}

/// The files, and the flags and variables on top of them.
fn layers(cli: &Cli) -> Result<Layers, HostConfigError> {
    let mut layers = match &cli.config {
        Some(file) => Layers::file(file)?,
        None => Layers::search(user_directory().as_deref())?,
    };
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let given: [(&str, &str, Option<toml::Value>); 9] = [
        ("--port or GRIPD_PORT", "port", cli.port.clone().map(Into::into)),
        ("--baud or GRIPD_BAUD", "baud", cli.baud.map(|baud| i64::from(baud).into())),
        ("--model or GRIPD_MODEL", "model", cli.model.as_deref().map(|file| text(file).into())),
        ("--listen or GRIPD_LISTEN", "listen", cli.listen.clone().map(Into::into)),
        ("--metrics or GRIPD_METRICS", "metrics", cli.metrics.clone().map(Into::into)),
        ("--record or GRIPD_RECORD", "record", cli.record.as_deref().map(|file| text(file).into())),
        ("--realtime or GRIPD_REALTIME", "realtime.mode", cli.realtime.clone().map(Into::into)),
        ("--log-level or GRIPD_LOG", "log_level", cli.log_level.clone().map(Into::into)),
        ("--esc", "observation.esc", cli.esc.map(|reading| reading.name().into())),
    ];
    for (from, key, value) in given {
        if let Some(value) = value {
            layers.set(from, key, value);
        }
    }
    Ok(layers)
}

fn user_directory() -> Option<PathBuf> {
    std::env::var_os("XDG_CONFIG_HOME")
        .filter(|folder| !folder.is_empty())
        .map(PathBuf::from)
        .or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".config")))
}

/// A line for each value that is set: what it is, where it stands, what it replaces.
fn table(set: &[Setting]) -> String {
    let values: Vec<String> = set
        .iter()
        .map(|setting| {
            let shown: String = setting.value.chars().take(LONGEST).collect();
            let cut = if shown.len() < setting.value.len() { " ..." } else { "" };
            format!("{} = {shown}{cut}", setting.key)
        })
        .collect();
    let width = values.iter().map(|value| value.chars().count()).max().unwrap_or(0);
    let lines = values.iter().zip(set).map(|(value, setting)| {
        let replaces: Vec<String> = setting.replaces.iter().map(ToString::to_string).collect();
        let over = if replaces.is_empty() {
            String::new()
        } else {
            format!(", instead of {}", replaces.join(", "))
        };
        format!("\n  {value:width$}  {}{over}", setting.place)
    });
    lines.collect()
}
