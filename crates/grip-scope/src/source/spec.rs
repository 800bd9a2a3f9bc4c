//! Specification of a source, parsed from what a person types.

use super::outlet::Outlet;
use core::fmt;
use grip_daemon::clients::Listen;
use slip_core::ClientCommand;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::Receiver;

/// A live source of another crate, on a thread of its own. Its name is shown.
pub trait Other: fmt::Debug + fmt::Display + Send + Sync {
    /// Offers what it has until the scope lets go, which may wait for as long as it takes; commands come in `orders`.
    fn run(&self, outlet: &mut Outlet, orders: &Receiver<ClientCommand>);
}

impl PartialEq for dyn Other {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}

impl Eq for dyn Other {}

/// Where data come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourceSpec {
    /// A running daemon.
    Daemon(Listen),
    /// A live source that another crate knows.
    Other(Arc<dyn Other>),
    /// A recording, MCAP or a table.
    Recording(PathBuf),
    /// The report of a study, JSON.
    Study(PathBuf),
    /// The built-in simulator.
    Demo {
        /// Name of a built-in scene, or path of one.
        scene: String,
        /// Seed of the first grasp.
        seed: u64,
    },
}

/// Why a text names no source.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    /// Nothing was said.
    #[error(
        "no source: give an address (tcp:127.0.0.1:7747, unix:PATH), a recording (.mcap, .csv), a study (.json) or demo"
    )]
    Empty,
    /// The address cannot be one.
    #[error(
        "{0:?} is no address: tcp:HOST:PORT, where HOST is localhost or a number as 127.0.0.1 or [::1] (names are not looked up), or unix:PATH"
    )]
    Address(String),
    /// The file is one that is imported first.
    #[error(
        "{0:?} is no recording of gripd: `gripctl import '{0}' -o '{0}.csv'` makes one of it, which opens here"
    )]
    Foreign(String),
    /// The file is of no kind that is known.
    #[error(
        "{0:?} is neither a recording (.mcap, .csv; `gripctl import FILE -o run.csv` makes one of .wav, .npy, .npz, .db3) nor the report \
          of a study (.json), and no address: those begin with tcp: or unix:"
    )]
    Kind(String),
}

impl SourceSpec {
    /// The source that a text names: `tcp:HOST:PORT`, `unix:PATH`, `FILE.mcap`, `FILE.csv`, `FILE.json`, `demo`, `demo:SCENE`.
    ///
    /// # Errors
    /// Where it names none; the sentence states what is possible.
    pub fn parse(text: &str) -> Result<Self, SpecError> {
        let text = text.trim();
        if text.is_empty() {
            return Err(SpecError::Empty);
        }
        if text == "demo" {
            return Ok(Self::Demo { scene: "default".to_owned(), seed: 1 });
        }
        if let Some(scene) = text.strip_prefix("demo:").filter(|scene| !scene.is_empty()) {
            return Ok(Self::Demo { scene: scene.to_owned(), seed: 1 });
        }
        if text.starts_with("tcp:") || text.starts_with("unix:") {
            let address = |_| SpecError::Address(text.to_owned());
            return text.parse().map(Self::Daemon).map_err(address);
        }
        // HOST:PORT without the kind is what people type.
        if let Ok(listen) = format!("tcp:{text}").parse() {
            return Ok(Self::Daemon(listen));
        }
        match extension(Path::new(text)).as_str() {
            "mcap" | "csv" | "tsv" | "txt" | "dat" | "asc" | "lvm" => {
                Ok(Self::Recording(text.into()))
            }
            "json" => Ok(Self::Study(text.into())),
            "wav" | "w64" | "npy" | "npz" | "db3" | "xlsx" => {
                Err(SpecError::Foreign(text.to_owned()))
            }
            _ => Err(SpecError::Kind(text.to_owned())),
        }
    }

    /// Whether data come for ever: then old ones make room for new ones, and nothing waits.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        !matches!(self, Self::Recording(_) | Self::Study(_))
    }
}

/// The ending of a file's name, in lower case.
pub(super) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

impl fmt::Display for SourceSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Daemon(listen) => listen.fmt(f),
            Self::Other(other) => other.fmt(f),
            Self::Recording(path) | Self::Study(path) => path.display().fmt(f),
            Self::Demo { scene, .. } => write!(f, "demo:{scene}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Listen, SourceSpec, SpecError};

    #[test]
    fn a_source_is_known_by_its_text() {
        let parsed = |text| SourceSpec::parse(text).unwrap();
        let address = || Listen::Tcp("127.0.0.1:7747".parse().unwrap());
        assert_eq!(parsed("tcp:localhost:7747"), SourceSpec::Daemon(address()));
        assert_eq!(parsed("127.0.0.1:7747"), SourceSpec::Daemon(address()));
        assert_eq!(parsed("unix:/run/gripd/socket").to_string(), "unix:/run/gripd/socket");
        assert_eq!(parsed(" a/Run.MCAP "), SourceSpec::Recording("a/Run.MCAP".into()));
        assert_eq!(parsed("study.json"), SourceSpec::Study("study.json".into()));
        assert_eq!(parsed("demo:shaken").to_string(), "demo:shaken");
    }

    #[test]
    fn what_is_none_is_reported_in_a_sentence() {
        let refused = |text| SourceSpec::parse(text).unwrap_err();
        assert_eq!(refused("  "), SpecError::Empty);
        assert_eq!(refused("tcp:nowhere"), SpecError::Address("tcp:nowhere".to_owned()));
        let name = refused("tcp:gripper.local:7747").to_string();
        assert!(name.contains("localhost") && name.contains("names are not looked up"), "{name}");
        assert!(refused("notes.pdf").to_string().contains(".mcap"));
        assert!(refused("a b.WAV").to_string().contains("import 'a b.WAV' -o 'a b.WAV.csv'"));
    }
}
