//! What is wrong with a configuration, and where it stands.

use super::{HostConfig, address::Listen};
use crate::signature::KeyError;
use core::{fmt, net::SocketAddr, ops::Range};
use slip_core::ConfigError;
use std::path::PathBuf;

/// Where a value stands: a file with line and column, or what gave it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// A file, or `--port or GRIPD_PORT`.
    pub source: String,
    /// Line and column, from 1; absent for what is no file, and for values that are defaults.
    pub at: Option<(usize, usize)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some((line, column)) => write!(f, "{}:{line}:{column}", self.source),
            None => write!(f, "{}", self.source),
        }
    }
}

/// Why a value cannot be, though it is of the right type.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ValueError {
    /// Outside its range.
    #[error(transparent)]
    Range(#[from] ConfigError),
    /// See [`BOOT_LOADER_BAUD`](super::BOOT_LOADER_BAUD).
    #[error(
        "baud {} is not used: it makes many boards restart into their boot loader",
        super::BOOT_LOADER_BAUD
    )]
    BootLoader,
    /// Clients could connect from other computers.
    #[error("listen = {0} is open to other computers; allow_remote = true says that this is meant")]
    ListenRemote(Listen),
    /// Metrics could be read from other computers.
    #[error(
        "metrics = {0} is open to other computers; allow_remote = true says that this is meant"
    )]
    MetricsRemote(SocketAddr),
    /// A key that is none.
    #[error(transparent)]
    ModelKey(#[from] KeyError),
    /// Only signed models, and nobody to sign them.
    #[error(
        "allow_unsigned_models = false takes signed models only, but model_keys names no key: no model but the built-in ones would be taken"
    )]
    NoModelKey,
    /// A site without a way to it.
    #[error(
        "fleet.site is set, but neither fleet.router nor fleet.network says where the router is"
    )]
    FleetNowhere,
}

/// Why a configuration is refused.
#[derive(Debug, thiserror::Error)]
pub enum HostConfigError {
    /// The file cannot be read.
    #[error("{}: the {what} cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// `configuration` or `calibration`.
        what: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong type.
    #[error("{place}: {message}{excerpt}")]
    Parse {
        /// Where.
        place: Place,
        /// What is wrong.
        message: String,
        /// The line with a mark below it, after a line break; empty where there is none.
        excerpt: String,
    },
    /// A value that cannot be.
    #[error("{place}: {source}{}", if *inherited { " (a default, which does not fit what is set)" } else { "" })]
    Value {
        /// Where the value in force stands.
        place: Place,
        /// Whether the value itself is a default, and the place that of its table.
        inherited: bool,
        /// The value and what it may be.
        source: ValueError,
    },
    /// The calibration was made for another sample rate or another kind of stylus.
    #[error(
        "the calibration holds for {made_hz} Hz and {}, not for {rate_hz} Hz and {}: calibrate again",
        stylus_name(*made_vibration),
        stylus_name(*vibration)
    )]
    OtherSignal {
        /// Rate it was made at.
        made_hz: f32,
        /// Whether it was made for uncalibrated vibration.
        made_vibration: bool,
        /// Rate it is to be used at.
        rate_hz: f32,
        /// Whether it is to be used for uncalibrated vibration.
        vibration: bool,
    },
}

fn stylus_name(vibration: bool) -> &'static str {
    if vibration { "vibration" } else { "displacement" }
}

impl HostConfigError {
    /// What the TOML reader states of `text`, with the place in `file` and the line.
    pub(super) fn of_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let span = error.span().unwrap_or(0..0);
        let (line, column) = line_and_column(text, span.start);
        Self::Parse {
            place: Place { source: file.to_owned(), at: Some((line, column)) },
            message: unknown(error.message())
                .unwrap_or_else(|| error.message().trim_end().replace('\n', ", ")),
            excerpt: excerpt(text, &span, line, column),
        }
    }
}

/// Keys of the detectors of older versions, which had thresholds.
pub(crate) const THRESHOLDS: [&str; 7] =
    ["test", "threshold", "cusum_threshold", "cusum_ratio", "glrt_threshold", "tail", "release"];

/// Keys of the force controller of older versions, which had rules where the needed force now has a distribution.
pub(crate) const FORCE_RULES: [&str; 7] =
    ["reflex_step", "measured_tau_ms", "brake_gain", "margin_sigmas", "lead", "ahead", "confirm_m"];

/// What an unknown field was meant to be: a key of another table, or one that is spelt alike.
fn unknown(message: &str) -> Option<String> {
    let mut names = message.split('`').skip(1).step_by(2);
    let name = names.next().filter(|_| message.starts_with("unknown field"))?;
    let advice = |advice| format!("unknown field `{name}`{advice}");
    let of_detector = message.contains("`interval_s`") || message.contains("`low_hz`");
    if of_detector && THRESHOLDS.contains(&name) {
        return Some(advice(
            ": the detector has one threshold, detector.interval_s; leave it out".to_owned(),
        ));
    }
    if message.contains("`f_max_n`") && FORCE_RULES.contains(&name) {
        return Some(advice(
            ": the force follows what slips show to be needed, without it; leave it out".to_owned(),
        ));
    }
    let all = toml::Table::try_from(HostConfig::default()).unwrap_or_default();
    let holds = |value: &toml::Value| value.as_table().is_some_and(|keys| keys.contains_key(name));
    if let Some((table, _)) = all.iter().find(|(_, value)| holds(value)) {
        return Some(advice(format!(", which belongs under [{table}]")));
    }
    let alike = names.map(|known| (strsim::normalized_damerau_levenshtein(name, known), known));
    let (_, known) =
        alike.filter(|(alike, _)| *alike >= ALIKE).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(advice(format!("; is `{known}` meant?")))
}

/// Names that share this much of their letters may be meant for each other.
const ALIKE: f64 = 0.7;

/// Line and column of a byte, from 1; columns are characters.
pub(super) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let mut end = byte.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = text.get(..end).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    (line, before.chars().rev().take_while(|c| *c != '\n').count() + 1)
}

/// The longest line that is shown (characters).
const LONGEST: usize = 120;

/// The line at fault with its number, and marks below what is meant.
fn excerpt(text: &str, span: &Range<usize>, line: usize, column: usize) -> String {
    let Some(shown) = text.lines().nth(line - 1).filter(|shown| shown.chars().count() <= LONGEST)
    else {
        return String::new();
    };
    let meant = text
        .get(span.clone())
        .map_or(1, |meant| meant.chars().take_while(|c| *c != '\n').count().max(1));
    let margin = line.to_string().len() + 2 + column;
    format!("\n{line} | {shown}\n{:margin$}{}", "", "^".repeat(meant))
}

#[cfg(test)]
mod tests {
    use super::{excerpt, line_and_column};

    #[test]
    fn columns_count_characters() {
        let text = "a = 1\n# größe\nb = \"ü\" x\n";
        let at = text.find('x').unwrap();
        assert_eq!(line_and_column(text, at), (3, 9));
        assert_eq!(excerpt(text, &(at..at + 1), 3, 9), "\n3 | b = \"ü\" x\n            ^");
        assert_eq!(line_and_column("", 7), (1, 1));
        assert_eq!(line_and_column("ü", 1), (1, 1), "inside a character");
    }
}
