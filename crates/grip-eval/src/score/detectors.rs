//! The detectors that `gripctl score --detectors` can put side by side.
//!
//! `default` is the pipeline as configured; `stylus` receives the stylus alone; `fused` joins the three methods. `esc`, `esc_literal`
//! and `nn` are what the source study detects slips with: tests beside the pipeline, which gives them its floors. `own` are the alarms
//! that the folder brings in its alarms.csv. One more is one more line in [`DETECTORS`].

use slip_core::{
    PipelineConfig,
    alarm::{Method, Methods},
    esc::Reading,
};

/// A way to look for slips in a recording.
#[derive(Clone, Copy, Debug)]
pub struct Detector {
    /// Its name on the command line and in JSON.
    pub name: &'static str,
    /// Whether the files beside a recording, `NAME_pose.csv` and `NAME_taxels.csv` or `NAME_electrodes.csv`, serve as its
    /// travel channel and taxel array.
    pub companions: bool,
    /// From the configured pipeline to that of this detector.
    pub change: fn(PipelineConfig) -> PipelineConfig,
    /// What decides.
    pub decides: Decides,
}

/// What decides whether an object slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decides {
    /// The pipeline.
    Pipeline,
    /// The scattered energy of the last milliseconds, by this reading ([`EscTest`](super::EscTest)).
    Esc(Reading),
    /// A network that has learned the labelled slips of other materials ([`NetworkTest`](super::NetworkTest)).
    Network,
    /// The alarms of a detector of one's own, which the folder brings in its alarms.csv.
    Own,
}

/// Every detector.
pub const DETECTORS: [Detector; 9] = [
    Detector::alone("default", |config| config),
    Detector::alone("stylus", |config| only(config, Method::Stylus)),
    Detector::beside("esc", Decides::Esc(Reading::SlopePower)),
    Detector::beside("esc_literal", Decides::Esc(Reading::Literal)),
    Detector::beside("nn", Decides::Network),
    Detector::joined("travel", |config| only(config, Method::Travel)),
    Detector::joined("pressure", |config| only(config, Method::Pressure)),
    Detector::joined("fused", |config| PipelineConfig { methods: Methods::ALL, ..config }),
    Detector { decides: Decides::Own, ..Detector::alone("own", |config| config) },
];

impl Detector {
    /// The pipeline as configured, on the recording's own columns.
    pub const DEFAULT: Self = DETECTORS[0];

    const fn alone(name: &'static str, change: fn(PipelineConfig) -> PipelineConfig) -> Self {
        Self { name, companions: false, change, decides: Decides::Pipeline }
    }

    const fn joined(name: &'static str, change: fn(PipelineConfig) -> PipelineConfig) -> Self {
        Self { companions: true, ..Self::alone(name, change) }
    }

    /// Beside the pipeline of the stylus, which measures the floors.
    const fn beside(name: &'static str, decides: Decides) -> Self {
        Self { decides, ..Self::alone(name, |config| only(config, Method::Stylus)) }
    }

    /// The detector of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        DETECTORS.into_iter().find(|detector| detector.name == name)
    }
}

fn only(config: PipelineConfig, method: Method) -> PipelineConfig {
    PipelineConfig { methods: Methods::only(method), ..config }
}
