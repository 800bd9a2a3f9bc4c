//! The detectors that `gripctl score --detectors` can put side by side.
//!
//! `default` is the pipeline as configured; `stylus` (its tests fused), `energy`, `cusum` and `glrt` hear the stylus alone; `fused`
//! joins the three methods. One more is one more line in [`DETECTORS`].

use slip_core::{
    PipelineConfig,
    detector::{DetectorConfig, TestKind},
    methods::{Method, Methods},
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
}

/// Every detector.
pub const DETECTORS: [Detector; 8] = [
    Detector { name: "default", companions: false, change: |config| config },
    Detector {
        name: "stylus",
        companions: false,
        change: |config| stylus(config, TestKind::Fused),
    },
    Detector {
        name: "energy",
        companions: false,
        change: |config| stylus(config, TestKind::Energy),
    },
    Detector { name: "cusum", companions: false, change: |config| stylus(config, TestKind::Cusum) },
    Detector { name: "glrt", companions: false, change: |config| stylus(config, TestKind::Glrt) },
    Detector { name: "travel", companions: true, change: |config| only(config, Method::Travel) },
    Detector {
        name: "pressure",
        companions: true,
        change: |config| only(config, Method::Pressure),
    },
    Detector {
        name: "fused",
        companions: true,
        change: |config| PipelineConfig { methods: Methods::ALL, ..config },
    },
];

impl Detector {
    /// The pipeline as configured, on the recording's own columns.
    pub const DEFAULT: Self = DETECTORS[0];

    /// The detector of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        DETECTORS.into_iter().find(|detector| detector.name == name)
    }
}

fn only(config: PipelineConfig, method: Method) -> PipelineConfig {
    PipelineConfig { methods: Methods::only(method), ..config }
}

fn stylus(config: PipelineConfig, test: TestKind) -> PipelineConfig {
    let detector = DetectorConfig { test, ..config.detector };
    PipelineConfig { detector, ..only(config, Method::Stylus) }
}
