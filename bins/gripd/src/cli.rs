//! The command line of gripd. The names are a contract.

use clap::Parser;
use std::path::PathBuf;

/// Feels an object slip in a gripper and holds it with just enough force.
///
/// gripd closes the fingers to the trial force as soon as it has learned the sensor's noise; use
/// --dry-run to only watch. A software stop is not a safety function.
///
/// Exit codes: 0 done, 1 failed, 2 wrong arguments or configuration, 3 done with loss of data.
#[derive(Clone, Debug, Parser)]
#[expect(clippy::struct_excessive_bools, reason = "flags of a command line")]
#[command(name = "gripd", version)]
pub(crate) struct Cli {
    /// Sensor and gripper: a serial device such as /dev/ttyACM0, `auto` for the only USB serial port, `sim` with an
    /// optional `:SCENE` (a built-in scene or a .toml file), or rows of another program, as for --sensor.
    #[arg(long, env = "GRIPD_PORT", value_name = "PORT")]
    pub(crate) port: Option<String>,
    /// A sensor alone, named as for --port, rows of samples of another program: rows:- (standard input),
    /// rows:tcp:IP:PORT, rows:unix:PATH or rows:udp:IP:PORT, or tsf85:PORT for Robotiq's fingertips. Nothing is
    /// commanded unless --gripper names one.
    #[arg(long, env = "GRIPD_SENSOR", value_name = "PORT", conflicts_with = "port")]
    pub(crate) sensor: Option<String>,
    /// `none` only observes; `rows`, or the name of the sensor again, sends the commands where the samples come from; a
    /// serial device is a board on another line, robotiq:2f-85:PORT (2f-140, hand-e) a gripper of Robotiq, also with
    /// tcp:HOST:PORT as its PORT.
    #[arg(long, env = "GRIPD_GRIPPER", value_name = "PORT")]
    pub(crate) gripper: Option<String>,
    /// Bits per second of the serial line; USB devices ignore it.
    #[arg(long, env = "GRIPD_BAUD", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) baud: Option<u32>,
    /// Configuration file; ./gripd.toml, the user's and /etc/gripd/gripd.toml are not read then.
    #[arg(long, env = "GRIPD_CONFIG", value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Built-in model (default, or paper: that of the source study) or model file.
    #[arg(long, env = "GRIPD_MODEL", value_name = "FILE")]
    pub(crate) model: Option<PathBuf>,
    /// Show this reading of E_sc beside the literal one: literal, arc_cot, slope_power, lift_work or viscous_work.
    #[arg(long, value_name = "NAME", value_parser = grip_session::config::esc_reading)]
    pub(crate) esc: Option<slip_core::esc::Reading>,
    /// Where clients may connect: tcp:IP:PORT, unix:PATH or off.
    #[arg(long, env = "GRIPD_LISTEN", value_name = "ADDRESS")]
    pub(crate) listen: Option<String>,
    /// Where a browser and Prometheus may read, as IP:PORT; nowhere unless asked for.
    #[arg(long, env = "GRIPD_METRICS", value_name = "ADDRESS")]
    pub(crate) metrics: Option<String>,
    /// Ask for real-time privileges: off, warn (go on without what is not granted) or strict.
    #[arg(long, env = "GRIPD_REALTIME", value_name = "MODE")]
    pub(crate) realtime: Option<String>,
    /// How much to report on standard error: error, warn, info or debug.
    #[arg(long, env = "GRIPD_LOG", value_name = "LEVEL")]
    pub(crate) log_level: Option<String>,
    /// Record everything (.mcap) or the samples (.csv); `gripctl replay` gives the same events from it.
    #[arg(long, env = "GRIPD_RECORD", value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Wait for a gripper that is not there yet, instead of giving up; so does a daemon that a service manager starts. A gripper that
    /// was attached once is always waited for.
    #[arg(long, env = "GRIPD_WAIT")]
    pub(crate) wait: bool,
    /// Never send a force command.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Run every stage of the pipeline in every scene; the decisions are the same.
    #[arg(long)]
    pub(crate) no_skip: bool,
    /// Stop after this time (s); otherwise at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
    /// Seed of the simulated scene.
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Events and summary as JSON, one object a line.
    #[arg(long)]
    pub(crate) json: bool,
    /// Check the configuration and stop.
    #[arg(long)]
    pub(crate) check_config: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e9 => Ok(value),
        _ => Err("expected seconds, more than 0".to_owned()),
    }
}
