//! Difference of two configurations: the keys that differ, and which of them a running gripd can take over.

use super::{HostConfig, error::HostConfigError, error::Place, error::ValueError};
use core::fmt;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

macro_rules! needs_restart {
    ($($key:ident)+) => {
        /// Keys and tables that a running gripd does not change: they name ports, sockets and files that are open, privileges that
        /// were asked for once, and what the gripper was asked for when it was attached.
        pub const NEEDS_RESTART: [&str; [$(stringify!($key)),+].len()] = [$(stringify!($key)),+];

        /// `new`, but for what needs a restart.
        fn with_kept(old: HostConfig, new: &HostConfig) -> HostConfig {
            HostConfig { $($key: old.$key,)+ ..new.clone() }
        }
    };
}

needs_restart! {
    port baud uid usb listen allow_commands allow_models allow_remote max_clients metrics record recording realtime dump_dir memory
    link fleet
}

/// A key whose value differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Its name, dotted.
    pub key: String,
    /// The value before, as TOML; absent where there was none.
    pub old: Option<String>,
    /// The value now.
    pub new: Option<String>,
}

impl Change {
    /// The entry of [`NEEDS_RESTART`] that holds it back.
    #[must_use]
    pub fn needs_restart(&self) -> Option<&'static str> {
        NEEDS_RESTART.into_iter().find(|name| {
            self.key.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |value: &Option<String>| value.clone().unwrap_or_else(|| "nothing".to_owned());
        write!(f, "{}: {} -> {}", self.key, word(&self.old), word(&self.new))
    }
}

impl HostConfig {
    /// The keys whose values differ in `new`, in the order of their names. A calibration file of the same name and another
    /// content is a change of `calibration`.
    #[must_use]
    pub fn diff(&self, new: &Self) -> Vec<Change> {
        let (before, now) = (self.flat(), new.flat());
        let keys: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
        let mut changes: Vec<Change> = keys
            .into_iter()
            .map(|key| Change {
                key: key.clone(),
                old: before.get(key).cloned(),
                new: now.get(key).cloned(),
            })
            .filter(|change| change.old != change.new)
            .collect();
        let named = changes.iter().any(|change| change.key == "calibration");
        if !named && self.calibrated != new.calibrated {
            let content = |word: &str| Some(format!("{word} content"));
            let (old, new) = (content("the old"), content("the new"));
            changes.push(Change { key: "calibration".to_owned(), old, new });
        }
        changes
    }

    /// `new` as far as a running gripd can take it over: what [`NEEDS_RESTART`] names stays as it is here.
    ///
    /// # Errors
    /// Where the new values do not fit those that stay.
    pub fn taking(&self, new: &Self) -> Result<Self, HostConfigError> {
        let taken = with_kept(self.clone(), new);
        taken.check().map_err(|(_, source): (&str, ValueError)| {
            let source_name = "the new configuration beside what needs a restart".to_owned();
            let place = Place { source: source_name, at: None };
            HostConfigError::Value { place, inherited: false, source }
        })?;
        Ok(taken)
    }

    fn flat(&self) -> BTreeMap<String, String> {
        let shown =
            |path: &Option<PathBuf>| path.as_ref().map(|p| p.to_string_lossy().as_ref().into());
        // The only thing that TOML cannot hold is a path that is not UTF-8, and these begin with folders that no file has named.
        let (model, calibration) = (shown(&self.model), shown(&self.calibration));
        let table = toml::Table::try_from(Self { model, calibration, ..self.clone() });
        let mut flat = BTreeMap::new();
        let mut open = vec![(String::new(), table.unwrap_or_default())];
        while let Some((path, table)) = open.pop() {
            for (key, value) in table {
                let name = format!("{path}{key}");
                match value {
                    toml::Value::Table(inner) => open.push((format!("{name}."), inner)),
                    toml::Value::Float(value) => drop(flat.insert(name, short(value))),
                    value => drop(flat.insert(name, value.to_string())),
                }
            }
        }
        flat
    }
}

/// A value of single precision with as many digits as were written.
fn short(value: f64) -> String {
    #[expect(clippy::cast_possible_truncation, reason = "compared with what it was")]
    let single = value as f32;
    if f64::from(single) == value { format!("{single:?}") } else { format!("{value:?}") }
}

/// The names of [`NEEDS_RESTART`] that differ, each once.
#[must_use]
pub fn needs_restart(old: &HostConfig, new: &HostConfig) -> Vec<&'static str> {
    let mut names: Vec<&'static str> =
        old.diff(new).iter().filter_map(Change::needs_restart).collect();
    names.dedup();
    names
}

#[cfg(test)]
mod tests {
    use super::{NEEDS_RESTART, needs_restart};
    use crate::config::HostConfig;
    use std::path::Path;

    fn config(text: &str) -> HostConfig {
        HostConfig::parse(Path::new("x"), text).unwrap()
    }

    #[test]
    fn changes_are_reported_by_key() {
        let (old, new) =
            (config("baud = 9600\n[grip]\nf_max_n = 9.0\n"), config("[grip]\nf_max_n = 8.1\n"));
        let reported: Vec<String> = old.diff(&new).iter().map(ToString::to_string).collect();
        assert_eq!(reported, ["baud: 9600 -> nothing", "grip.f_max_n: 9.0 -> 8.1"]);
        assert_eq!(needs_restart(&old, &new), ["baud"]);
        assert!(old.diff(&old).is_empty());
    }

    #[test]
    fn what_needs_a_restart_stays_and_the_rest_is_taken() {
        let old = config("baud = 9600\n");
        let text = r#"
            port = "auto"
            uid = "00112233445566778899aabbccddeeff"
            listen = "tcp:0.0.0.0:1"
            allow_commands = true
            allow_models = true
            allow_remote = true
            max_clients = 3
            metrics = "127.0.0.1:2"
            record = "x.mcap"
            recording.max_mib = 7
            realtime.mode = "warn"
            dump_dir = "x"
            memory.object = "x"
            link.batch = 5
            fleet.spool_mib = 5
            usb.vid = 1
            log_level = "debug"
            grip.f_max_n = 30.0
            detector.gross = 26.0
        "#;
        let new = config(text);
        assert_eq!(needs_restart(&old, &new).len(), NEEDS_RESTART.len());
        let taken = old.taking(&new).unwrap();
        assert!(needs_restart(&old, &taken).is_empty());
        let left: Vec<String> = old.diff(&taken).into_iter().map(|change| change.key).collect();
        assert_eq!(left, ["detector.gross", "grip.f_max_n", "log_level"]);
        assert_eq!(needs_restart(&taken, &new).len(), NEEDS_RESTART.len());
    }

    #[test]
    #[cfg(unix)]
    fn a_path_that_is_no_text_hides_no_change() {
        use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};
        let model = Some(OsStr::from_bytes(b"/\xFF/m.json").into());
        let (old, new) = (HostConfig { model, ..config("") }, config("baud = 1\n"));
        assert_eq!(old.diff(&new).len(), 2);
    }

    #[test]
    fn new_values_that_do_not_fit_what_stays_are_refused() {
        // 20 kHz carry a shear band up to 5 kHz, the 2 kHz in force do not.
        let old = config("link.sample_rate_hz = 2000\n");
        let new = config(
            "link.sample_rate_hz = 20000\ndetector.shear.low_hz = 2000.0\ndetector.shear.high_hz = 5000.0\n",
        );
        let reported = old.taking(&new).unwrap_err().to_string();
        assert!(reported.contains("beside what needs a restart: "), "{reported}");
    }
}
