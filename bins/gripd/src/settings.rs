//! Flags, environment and configuration files, in this order, made into settings; and made again on a reload.

use crate::{accepted::Accepted, cli::Cli};
use anyhow::Context as _;
use grip_daemon::{
    board,
    clients::{self, Brought, ClientsConfig, Setup},
    dump,
    ends::{AddressError, GripperAddress, SensorAddress},
    rows::RowsAddress,
};
use grip_link::message::daemon::RealTime;
use grip_port::DEFAULT_BAUD;
use grip_record::{files, mcap::Attached};
use grip_session::{
    HostConfig, HostConfigError, HostEstimator, ModelError,
    config::{Change, Layers, RealtimeConfig, Setting, advice, needs_restart},
    exit::{WrongArgument, message},
    model,
    recording::{CALIBRATION_NAME, CONFIG_NAME, MODEL_NAME},
    rows::Actuator,
    signature::{ModelKeys, Provenance},
};
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// Name and version.
pub(crate) const PROGRAM: &str = concat!("gripd ", env!("CARGO_PKG_VERSION"));
/// The fastest rate of the link (Hz).
const FASTEST_HZ: u32 = 20_000;
/// The longest value that --check-config shows (characters).
const LONGEST: usize = 60;

/// What the daemon runs with.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) config: HostConfig,
    pub(crate) port: String,
    pub(crate) baud: u32,
    pub(crate) json: bool,
    /// Nothing is commanded: there is a sensor alone, or nobody wants more.
    pub(crate) observe: bool,
    /// What measures, where that is not the board on the port alone.
    pub(crate) sensor: Option<SensorAddress>,
    /// What grips, where it has a line of its own.
    pub(crate) gripper: Option<GripperAddress>,
    /// The flags, which stand over every file that is read again.
    cli: Cli,
    layers: Layers,
    /// The model of the configuration, as it was when it was read: a file that is changed or removed since closes no way back.
    configured: Loaded,
    /// The model that a client has brought, where it is in force.
    pub(crate) loaded: Option<Loaded>,
}

/// A model that a client has brought, or that of the configuration.
#[derive(Clone, Debug)]
pub(crate) struct Loaded {
    sha256: [u8; 32],
    text: Cow<'static, str>,
    estimator: HostEstimator,
    signed: Option<Provenance>,
}

impl Loaded {
    /// Reads one of a client; or the reason why it is none for this gripper. One that was in force here needs no signature.
    pub(crate) fn new(
        Brought { sha256, bytes }: Brought,
        keys: &ModelKeys,
        accepted: &Accepted,
    ) -> Result<Self, String> {
        if model::digest(&bytes) != sha256 {
            return Err("what came is not what was announced: it has another SHA-256".to_owned());
        }
        let text = String::from_utf8(bytes).map_err(|error| error.to_string())?;
        let signed = match keys.check(&text) {
            Ok(signed) => signed,
            Err(_) if accepted.knows(&sha256) => None,
            Err(fault) => return Err(format!("{fault}; {}", fault.remedy("MODEL.json"))),
        };
        let estimator = model::parse_estimator(&client_model(&sha256), &text);
        let estimator = estimator.map_err(|error| message(&error))?;
        Ok(Self { sha256, text: text.into(), estimator, signed })
    }

    /// Reads that of the configuration. A built-in model is a part of the program and needs no signature.
    fn configured(config: &HostConfig) -> anyhow::Result<Self> {
        let keys = config.keys()?;
        let (text, estimator, signed) = match &config.model {
            None => (model::default_text().into(), model::default_estimator()?, None),
            Some(file) => {
                let text = model::read_signed(file)?;
                let name = file.display().to_string();
                let estimator = model::parse_estimator(&name, &text)?;
                let is_built_in = model::built_in(file).is_some();
                let signed = if is_built_in { Ok(None) } else { keys.check(&text) };
                let fault = |source| ModelError::Signature { file: name, source };
                (text, estimator, signed.map_err(fault)?)
            }
        };
        Ok(Self { sha256: model::digest(text.as_bytes()), text, estimator, signed })
    }

    /// How people know one of a client.
    pub(crate) fn name(&self) -> String {
        client_model(&self.sha256)
    }

    /// Who has signed it, behind its name.
    pub(crate) fn signer(&self) -> String {
        self.signed.as_ref().map_or_else(String::new, |signed| format!(" ({signed})"))
    }

    /// SHA-256 of its text.
    pub(crate) const fn sha256(&self) -> [u8; 32] {
        self.sha256
    }

    /// What it runs as.
    pub(crate) fn into_estimator(self) -> HostEstimator {
        self.estimator
    }
}

/// How people know a model of a client.
fn client_model([a, b, c, d, ..]: &[u8; 32]) -> String {
    format!("{a:02x}{b:02x}{c:02x}{d:02x} of a client")
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
    /// Reads and checks everything.
    pub(crate) fn new(cli: &Cli) -> anyhow::Result<Self> {
        let layers = layers(cli)?;
        let settings = Self::of(layers.resolve()?, layers, cli.clone())?;
        if !cli.check_config && settings.port.is_empty() {
            let message = if cli.gripper.is_some() {
                "no sensor: --gripper alone feels nothing; name what feels the slip with --sensor (/dev/ttyACM0, rows:-, tsf85:PORT)"
            } else {
                "no port: say --port /dev/ttyACM0, --port auto, or --port sim for the built-in simulator"
            };
            return Err(WrongArgument(message.to_owned()).into());
        }
        Ok(settings)
    }

    fn of(config: HostConfig, layers: Layers, cli: Cli) -> anyhow::Result<Self> {
        let port = config.port.clone().unwrap_or_default();
        let wrong = |error: AddressError| WrongArgument(error.to_string());
        let sensor = SensorAddress::parse(&port).map_err(wrong)?;
        let is_rows = matches!(sensor, SensorAddress::Rows(_));
        let wanted = wanted_gripper(&cli, &port, is_rows)?;
        let observe = wanted == WantedGripper::None
            || (wanted == WantedGripper::Same && matches!(sensor, SensorAddress::Tsf85 { .. }));
        let gripper = match wanted {
            WantedGripper::Other(name) => Some(GripperAddress::parse(name).map_err(wrong)?),
            WantedGripper::None | WantedGripper::Same => None,
        };
        if let Some(gripper) = &gripper {
            gripper.check(config.grip.f_max_n).map_err(wrong)?;
        }
        if let SensorAddress::Rows(address) = &sensor {
            check_rows(address, &config, cli.json || observe || gripper.is_some())?;
        }
        if gripper.is_some() {
            check_gripper(&port)?;
        }
        let sensor = match sensor {
            SensorAddress::Board { .. } if gripper.is_none() => None,
            sensor => Some(sensor),
        };
        Ok(Self {
            observe,
            sensor,
            gripper,
            port,
            baud: config.baud.unwrap_or(DEFAULT_BAUD),
            json: cli.json,
            cli,
            layers,
            configured: Loaded::configured(&config)?,
            config,
            loaded: None,
        })
    }

    /// What the session works with: rows come at the rate of their header, which is the fastest they offer.
    pub(crate) fn live(&self) -> HostConfig {
        let mut config = self.config.clone();
        if self.sensor.is_some() {
            config.link.sample_rate_hz = FASTEST_HZ;
        }
        if let Some(sensor) = &self.sensor {
            sensor.limit(&mut config.health);
        }
        if let Some(spec) = self.gripper.as_ref().and_then(GripperAddress::spec) {
            spec.limit(&mut config.grip);
        }
        config
    }

    /// What the gripper may be asked for that follows the commands beside rows.
    pub(crate) fn actuator(&self) -> Option<Actuator> {
        let grip = self.live().grip;
        let actuator = Actuator {
            force_max_n: grip.f_max_n,
            slew_n_s: grip.slew_n_s,
            holds_n: 0.0,
            shows_force: self.gripper.is_some(),
        };
        Some(actuator).filter(|_| !self.observe)
    }

    /// Reads everything again. On an error the settings in force stay as they are.
    pub(crate) fn reload(&self) -> anyhow::Result<Reload> {
        let layers = layers(&self.cli)?;
        let new = layers.resolve()?;
        let config = self.config.taking(&new)?;
        let (changes, restart) = (self.config.diff(&new), needs_restart(&self.config, &new));
        // The model also where another one is in force: it is what that one gives way to.
        let mut settings = Self::of(config, layers, self.cli.clone())?;
        settings.loaded.clone_from(&self.loaded);
        Ok(Reload { estimator: settings.estimator(), settings, changes, restart })
    }

    /// The network in force: one of a client, or that of the configuration.
    pub(crate) fn estimator(&self) -> HostEstimator {
        self.estimator_with(self.loaded.as_ref())
    }

    /// The network with this model of a client, or that of the configuration.
    pub(crate) fn estimator_with(&self, loaded: Option<&Loaded>) -> HostEstimator {
        loaded.unwrap_or(&self.configured).estimator.clone()
    }

    /// Whose models are taken.
    pub(crate) fn keys(&self) -> Result<ModelKeys, String> {
        self.config.keys().map_err(|error| error.to_string())
    }

    /// What clients are sent of models and settings; `reloads` is the number of reloads so far.
    pub(crate) fn setup(&self, reloads: u64) -> Setup {
        let name = self.config.model.as_deref().and_then(Path::file_name);
        Setup {
            settings: u32::try_from(reloads).unwrap_or(u32::MAX),
            in_force: self.loaded.as_ref().unwrap_or(&self.configured).sha256,
            configured: self.configured.sha256,
            name: name.unwrap_or("default".as_ref()).to_string_lossy().into_owned(),
        }
    }

    /// What a user should know of the model.
    pub(crate) fn weakness(&self) -> Option<String> {
        let weakness = model::weakness(&self.estimator());
        weakness.map(|text| format!("model {}: {text}", self.model_name()))
    }

    pub(crate) fn model_name(&self) -> Cow<'_, str> {
        if let Some(loaded) = &self.loaded {
            return client_model(&loaded.sha256).into();
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
        warnings.extend(self.weakness());
        let warnings = warnings.iter().map(|warning| format!("\nwarning: {warning}"));
        let set = table(&set);
        let signer = self.configured.signer();
        let warnings: String = warnings.collect();
        Ok(format!("{}model: {model}{signer}{set}{warnings}", files.concat()))
    }

    /// What runs, for the board; `run_id` differs from start to start.
    pub(crate) fn about(&self, run_id: u32) -> board::About {
        let mut files: Vec<PathBuf> = self.layers.files().map(Path::to_owned).collect();
        files.reverse();
        board::About {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            port: self.port.clone(),
            config_files: files,
            dry_run: self.cli.dry_run || self.observe,
            run_id,
            ..board::About::default()
        }
    }

    /// What clients are sent when they come; `run_id` differs from start to start.
    pub(crate) fn client_about(&self, run_id: u32) -> clients::About {
        clients::About {
            name: PROGRAM.to_owned(),
            run_id,
            dry_run: self.cli.dry_run || self.observe,
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
            // A flag stands over every client.
            allow_models: self.config.allow_models && self.cli.model.is_none(),
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
        files.push(model_file(self.model_text(self.loaded.as_ref())));
        if let Some(calibration) = &self.config.calibration {
            files.push(file(CALIBRATION_NAME, "application/toml", read(calibration)?));
        }
        Ok(files)
    }

    /// The file of this model of a client, or that of the configuration.
    pub(crate) fn model_text(&self, loaded: Option<&Loaded>) -> Vec<u8> {
        // Also the embedded one: a later gripctl may have another.
        loaded.unwrap_or(&self.configured).text.as_bytes().to_vec()
    }
}

/// A model, for a recording.
pub(crate) fn model_file(data: Vec<u8>) -> Attached {
    let (name, media_type) = (MODEL_NAME.to_owned(), "application/json".to_owned());
    Attached { name, media_type, data }
}

/// What is to grip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WantedGripper<'a> {
    /// Nothing.
    None,
    /// What also measures.
    Same,
    /// Something on another line.
    Other(&'a str),
}

fn wanted_gripper<'a>(
    cli: &'a Cli,
    port: &str,
    rows: bool,
) -> Result<WantedGripper<'a>, WrongArgument> {
    match cli.gripper.as_deref() {
        None if cli.sensor.is_some() => Ok(WantedGripper::None),
        None => Ok(WantedGripper::Same),
        Some("none") => Ok(WantedGripper::None),
        Some("rows") if rows => Ok(WantedGripper::Same),
        Some(gripper) if gripper == port => Ok(WantedGripper::Same),
        Some("rows") => {
            let message = "--gripper rows: only rows have a way back for commands; see --sensor";
            Err(WrongArgument(message.to_owned()))
        }
        Some(name) if name == "sim" || name.starts_with("sim:") || name.starts_with("rows:") => {
            Err(WrongArgument(format!(
                "--gripper {name}: a simulated gripper, or that of a program, takes its commands where its samples come from; name it with --port"
            )))
        }
        Some(name) => Ok(WantedGripper::Other(name)),
    }
}

/// Whether rows may come from there.
fn check_rows(
    address: &RowsAddress,
    config: &HostConfig,
    quiet: bool,
) -> Result<(), WrongArgument> {
    if address.is_remote() && !config.allow_remote {
        return Err(WrongArgument(format!(
            "rows from {address}: other computers could send them; set allow_remote to true if they shall"
        )));
    }
    if *address == RowsAddress::Stdin && !quiet {
        let message = "rows:- with a gripper prints commands on standard output: add --json, or --gripper none";
        return Err(WrongArgument(message.to_owned()));
    }
    Ok(())
}

/// Whether a gripper on another line can be had beside this port.
fn check_gripper(port: &str) -> Result<(), WrongArgument> {
    if port == "sim" || port.starts_with("sim:") {
        let message =
            "--sensor sim: a simulated sensor moves with its own gripper; leave --gripper out";
        return Err(WrongArgument(message.to_owned()));
    }
    Ok(())
}

fn read(file: &Path) -> anyhow::Result<Vec<u8>> {
    files::read(file, files::MOST_MODEL).with_context(|| format!("cannot read {}", file.display()))
}

/// The files, and the flags and variables on top of them.
fn layers(cli: &Cli) -> Result<Layers, HostConfigError> {
    let mut layers = Layers::of_user(cli.config.as_deref())?;
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let given: [(&str, &str, Option<toml::Value>); 10] = [
        ("--port or GRIPD_PORT", "port", cli.port.clone().map(Into::into)),
        ("--sensor or GRIPD_SENSOR", "port", cli.sensor.clone().map(Into::into)),
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
