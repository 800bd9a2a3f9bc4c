//! Scores by material: one row for each, from the scores of single recordings.

use super::{Quantiles, RecordingScore, Score};
use serde::Serialize;
use std::collections::BTreeMap;

/// What became of the recordings of one material.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "material")]
pub struct MaterialScore {
    /// The detector.
    pub detector: &'static str,
    /// The material, in the folder's own words.
    pub material: String,
    /// Labelled onsets.
    pub onsets: usize,
    /// Of these not found.
    pub missed: usize,
    /// Of these inside an alarm that went on since before: neither found nor missed.
    pub inside: usize,
    /// Recordings with an alarm before the first of them.
    pub early: usize,
    /// Latency from the onset.
    pub latency_ms: Quantiles,
    /// Recordings that slip all the time.
    pub steady: usize,
    /// Of these without any alarm.
    pub steady_missed: usize,
    /// Delay of the first alarm in these.
    pub steady_ms: Quantiles,
}

impl Score {
    /// One row a material, ordered by name.
    #[must_use]
    pub fn materials(&self) -> Vec<MaterialScore> {
        let mut by_name: BTreeMap<&str, Vec<&RecordingScore>> = BTreeMap::new();
        for recording in &self.recordings {
            by_name.entry(&recording.material).or_default().push(recording);
        }
        let rows = by_name.into_iter().map(|(material, all)| {
            let of = |kind: &'static str| all.iter().filter(move |r| r.kind == kind);
            let latencies = |kind| Quantiles::of(of(kind).filter_map(|r| r.latency_ms).collect());
            MaterialScore {
                detector: self.detector.name,
                material: material.to_owned(),
                onsets: of("onset").count(),
                missed: of("onset").filter(|r| r.missed).count(),
                inside: of("onset").filter(|r| r.inside).count(),
                early: of("onset").filter(|r| r.early).count(),
                latency_ms: latencies("onset"),
                steady: of("steady").count(),
                steady_missed: of("steady").filter(|r| r.missed).count(),
                steady_ms: latencies("steady"),
            }
        });
        rows.collect()
    }
}
