//! The command line of gripmon. The names are a contract.

use clap::{Args, Parser};
use grip_scope::SourceSpec;
use grip_scope::source::SpecError;
use grip_session::exit::fleet_program;
use std::path::PathBuf;

/// Where gripd listens by default.
pub const USUAL: &str = "tcp:127.0.0.1:7747";

/// Shows what a gripper feels and does: signals, events, health, live or from a recording.
///
/// Without a source it looks for a gripd on this computer and goes on looking. Press ? in the window for its keys.
///
/// Exit codes: 0 done, 1 failed, 2 wrong arguments or configuration.
#[derive(Clone, Debug, Parser)]
#[command(name = "gripmon", version)]
pub struct Cli {
    /// A running gripd (tcp:HOST:PORT or unix:PATH), a recording (.mcap or .csv), the report of a study (.json), or demo:SCENE.
    #[arg(value_name = "SOURCE", default_value = USUAL)]
    pub source: String,
    /// Show the built-in simulator.
    #[arg(long, conflicts_with = "source")]
    pub demo: bool,
    /// Seed of the simulator; other sources take none.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Write a report of a recording to this file (.html), and end: no window is opened. A file that is there stays.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["view", "layout", "demo"])]
    pub report: Option<PathBuf>,
    /// The window.
    #[command(flatten)]
    pub window: WindowArgs,
}

/// What a window begins with.
#[derive(Clone, Debug, Args)]
pub struct WindowArgs {
    /// Remember the arrangement of the window in this file, instead of gripmon/layout.toml among your configurations.
    #[arg(long, value_name = "FILE")]
    pub layout: Option<PathBuf>,
    /// Begin with the arrangement and the place that this file describes (docs/monitor.md); nothing is remembered then.
    #[arg(long, value_name = "FILE", conflicts_with = "layout")]
    pub view: Option<PathBuf>,
    /// Write a picture of the window to this file as soon as what --view asks for is there, and end.
    #[arg(long, value_name = "FILE", requires = "view")]
    pub picture: Option<PathBuf>,
    /// Most memory for the history, in MB; the oldest samples go first.
    #[arg(long, value_name = "MB", default_value_t = 600, value_parser = clap::value_parser!(u32).range(16..=65_536))]
    pub memory: u32,
}

/// Why no source was found in the arguments.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The source is none.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// A seed for something that takes none.
    #[error("--seed is for the simulator: {0} takes none; add --demo, or name demo:SCENE")]
    Seed(SourceSpec),
    /// A report of something that does not end.
    #[error(
        "--report is for a recording (.mcap or .csv): {0} is none; Shift S in its window writes one"
    )]
    Report(SourceSpec),
    /// A network of many, which another program shows.
    #[error("{0}: `gripmon-fleet ENDPOINT` shows a network: {program}", program = fleet_program("gripmon-fleet"))]
    Fleet(String),
}

impl Cli {
    /// The source that is asked for.
    ///
    /// # Errors
    /// [`SourceError`], a sentence.
    pub fn source(&self) -> Result<SourceSpec, SourceError> {
        let source = self.source.trim();
        if source == "fleet" || source.starts_with("fleet:") {
            return Err(SourceError::Fleet(source.to_owned()));
        }
        let text = if self.demo { "demo" } else { &self.source };
        let spec = SourceSpec::parse(text)?;
        match (spec, self.seed) {
            (SourceSpec::Demo { scene, .. }, Some(seed)) => Ok(SourceSpec::Demo { scene, seed }),
            (spec, Some(_)) => Err(SourceError::Seed(spec)),
            (spec, None) => Ok(spec),
        }
    }
}

impl WindowArgs {
    /// Bytes for the history.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        usize::try_from(self.memory).unwrap_or(usize::MAX).saturating_mul(1_000_000)
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::Parser as _;

    #[test]
    fn sources_are_what_they_seem() {
        let source = |words: &[&str]| {
            let words = ["gripmon"].iter().chain(words);
            Cli::try_parse_from(words).unwrap().source().map(|spec| spec.to_string())
        };
        assert_eq!(source(&[]).unwrap(), "tcp:127.0.0.1:7747");
        assert_eq!(source(&["--demo", "--seed", "7"]).unwrap(), "demo:default");
        assert_eq!(source(&["run.mcap"]).unwrap(), "run.mcap");
        assert!(source(&["notes.pdf"]).is_err());
        for text in ["fleet:tcp/x:1", " fleet "] {
            assert!(source(&[text]).unwrap_err().to_string().contains("`gripmon-fleet ENDPOINT`"));
        }
        let reported = source(&["run.mcap", "--seed", "7"]).unwrap_err().to_string();
        assert!(
            reported.starts_with("--seed is for the simulator: run.mcap takes none"),
            "{reported}"
        );
        assert!(source(&["--seed", "7"]).is_err());
        assert!(Cli::try_parse_from(["gripmon", "--picture", "a.png"]).is_err());
    }
}
