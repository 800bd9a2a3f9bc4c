//! Results of single recordings, and their sums with intervals.

use super::{
    Alarm, CauseScore, Chance, Detector, Point, Quantiles,
    causes::Causes,
    chance::chance,
    curve::{self, Trace},
    interval::{self, Interval, QuantileIntervals},
};
use serde::Serialize;
use slip_core::detector::BANDS;

/// Where the noise of a recording is known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FloorFrom {
    /// From a calibration, the configuration, or the rest of recordings of other materials.
    Known,
    /// From its own earlier samples alone, as live.
    Own,
}

/// One recording's result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingScore {
    /// The detector.
    pub detector: &'static str,
    /// Its name.
    pub recording: String,
    /// Which slip of it, from 1 on. Alarms and length of the recording stand at its first one.
    pub slip: u32,
    /// `onset`, `steady` or `rest`.
    pub kind: &'static str,
    /// What the surface was.
    pub material: String,
    /// Labelled onset (s).
    pub onset_s: Option<f64>,
    /// The first alarm of all, or the one that counts of a further slip (s).
    pub alarm_s: Option<f64>,
    /// From the onset, or from the start of a steady recording, to the alarm that counts (ms).
    pub latency_ms: Option<f64>,
    /// A slip that was not found.
    pub missed: bool,
    /// A slip that began while an alarm of before went on: neither found nor missed.
    pub inside: bool,
    /// An alarm before onset - guard.
    pub early: bool,
    /// Travel at the alarm that counts (mm), where a companion reports it.
    pub travel_mm: Option<f64>,
    /// Alarms in all.
    pub alarms: u32,
    /// Each of them.
    pub alarms_at: Vec<Alarm>,
    /// Time in which an alarm finds the slip (s); 0 at rest.
    pub window_s: f64,
    /// Samples a second.
    pub rate_hz: f32,
    /// Where its noise is known from.
    pub floor_from: FloorFrom,
    /// Whether it ended before its noise floor was learned, so that the signal shows no slip.
    pub learning: bool,
    /// Time in which there were samples (s).
    pub length_s: f64,
    /// Of it with a slip, or with a floor that never saw rest (s).
    pub reported_s: f64,
    /// Of it in alarm (s).
    pub in_alarm_s: f64,
    /// What is odd about its file.
    #[serde(skip)]
    pub file: FileNotes,
}

/// What is odd about the file of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileNotes {
    /// Rows that were placed or left out. Stands at the first slip.
    pub remarks: Vec<String>,
    /// Whether rows at its end are lost.
    pub cut: bool,
}

impl RecordingScore {
    /// Of a further slip: what stands at the first one is not counted again.
    pub(super) fn without_alarms(&self) -> Self {
        let (alarms, alarms_at) = (0, Vec::new());
        Self {
            file: FileNotes { remarks: Vec::new(), ..self.file },
            early: false,
            alarms,
            alarms_at,
            length_s: 0.0,
            reported_s: 0.0,
            in_alarm_s: 0.0,
            ..self.clone()
        }
    }

    /// Share of the recording in which a slip is reported, or that no rest was seen.
    fn reported_share(&self) -> f64 {
        if self.length_s > 0.0 { self.reported_s / self.length_s } else { 0.0 }
    }
}

/// The results of a folder with one detector.
#[derive(Clone, Debug)]
pub struct Score {
    /// The detector.
    pub detector: Detector,
    /// One per recording, in the order of the labels; one per slip, where several are labelled.
    pub recordings: Vec<RecordingScore>,
    /// One rate for each set of recordings whose rest was pooled: they are alike in rate and stylus.
    pub rates_hz: Vec<f32>,
    /// The calibrated floor, or that of the labelled rest of all materials: energy of each band (signal unit squared). Each recording was
    /// scored with that of the *other* materials. Of several sets that with the most rest.
    pub floor: Option<[f32; BANDS]>,
    /// Rest it was measured on (s).
    pub floor_s: f64,
    /// The same for the noise of the taxels (rms), where there is an array.
    pub taxel_rms: Option<f32>,
    /// And for the largest mean range of a taxel beside the shape (`pressure.known_range`).
    pub taxel_range: Option<f32>,
    /// Time for a sample (ns) in the recording where that is shortest, so that other work on the machine counts least: the whole
    /// pipeline, and the test beside it where there is one; without training. `None` where no clock was given.
    pub ns_per_sample: Option<f64>,
    pub(super) traces: Vec<Trace>,
    pub(super) causes: Causes,
}

/// The total line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "total")]
pub struct Total {
    /// The detector.
    pub detector: &'static str,
    /// Labelled onsets.
    pub onsets: usize,
    /// Of these not found.
    pub missed: usize,
    /// Of these inside an alarm that went on since before: neither found nor missed.
    pub inside: usize,
    /// Recordings with an alarm before the first of them.
    pub early: usize,
    /// Interval of the share missed of those that no alarm of before covers.
    pub missed_ci: Interval,
    /// Interval of the share of recordings with an alarm too early.
    pub early_ci: Interval,
    /// What as many alarms as there are in all recordings would find, thrown into them at random. `null` where that says
    /// nothing: nothing was found, most onsets lie inside alarms, or most rest is in alarm.
    pub onsets_chance: Option<Chance>,
    /// Latency from the onset.
    pub latency_ms: Quantiles,
    /// Its intervals.
    pub latency_ms_ci: QuantileIntervals,
    /// Travel at the alarm, where known (mm).
    pub travel_mm: Quantiles,
    /// Recordings that slip all the time.
    pub steady: usize,
    /// Of these without any alarm.
    pub steady_missed: usize,
    /// What chance would find of them; `null` where most rest is in alarm, or there is none.
    pub steady_chance: Option<Chance>,
    /// Share of its time in which a slip is reported, or that no rest was seen, of the recording with the least.
    pub steady_share: Option<f64>,
    /// Delay of the first alarm in these.
    pub steady_ms: Quantiles,
    /// Time in alarm, in all recordings (s).
    pub in_alarm_s: f64,
    /// Its share of their length; `null` of nothing.
    pub in_alarm_share: Option<f64>,
    /// Length of the recordings that never slip (s).
    pub rest_s: f64,
    /// Alarms in these.
    pub rest_alarms: u32,
    /// Time in alarm in these (s).
    pub rest_in_alarm_s: f64,
    /// Interval of their rate (1/h).
    pub rest_alarms_per_hour_ci: Interval,
    /// Rest the floor was measured on (s).
    pub floor_s: f64,
    /// Rates of the recordings (Hz), one for each set whose rest was pooled apart: sets differ in rate or stylus.
    pub rates_hz: Vec<f32>,
    /// Recordings whose noise was learned from their own earlier samples alone.
    pub own_floors: usize,
    /// Guard before each onset (ms).
    pub guard_ms: f64,
    /// Run time for a sample (ns), where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ns_per_sample: Option<f64>,
}

impl Score {
    /// False alarms, misses and latency at thresholds from 1/8 to 32 times the configured ones.
    #[must_use]
    pub fn curve(&self) -> Vec<Point> {
        curve::curve(&self.traces)
    }

    /// The alarms in all time without slip, before each onset too, by cause.
    #[must_use]
    pub fn causes(&self) -> Vec<CauseScore> {
        self.causes.rows(self.detector.name)
    }

    /// What the alarms of all recordings would find of a `kind`, thrown at random. Slips inside a running alarm are left
    /// out.
    fn chance(&self, kind: &'static str) -> Option<Chance> {
        let alarms = self.recordings.iter().map(|r| r.alarms).sum();
        let total_s = self.recordings.iter().map(|r| r.length_s).sum();
        let of = || self.recordings.iter().filter(move |r| r.kind == kind);
        let outside = || of().filter(|r| !r.inside);
        let found = outside().filter(|r| !r.missed).count();
        let comparable =
            found > 0 && self.causes.distinguishes() && 2 * outside().count() >= of().count();
        let windows_s = comparable.then(|| outside().map(|r| r.window_s))?;
        chance(windows_s, alarms, total_s, found)
    }

    /// The sums over all recordings.
    #[must_use]
    pub fn total(&self, guard_ms: f64) -> Total {
        let of = |kind: &'static str| self.recordings.iter().filter(move |r| r.kind == kind);
        let latencies = |kind| Quantiles::of(of(kind).filter_map(|r| r.latency_ms).collect());
        let onsets = of("onset").count();
        let missed = of("onset").filter(|r| r.missed).count();
        let inside = of("onset").filter(|r| r.inside).count();
        let early = of("onset").filter(|r| r.early).count();
        let first = of("onset").filter(|r| r.slip == 1).count();
        let found = of("onset").filter_map(|r| Some((r.material.as_str(), r.latency_ms?)));
        // The sum of nothing is -0.
        let sum = |each: &mut dyn Iterator<Item = f64>| each.sum::<f64>() + 0.0;
        let rest_s = sum(&mut of("rest").map(|r| r.length_s));
        let length_s = sum(&mut self.recordings.iter().map(|r| r.length_s));
        let in_alarm_s = sum(&mut self.recordings.iter().map(|r| r.in_alarm_s));
        let rest_alarms = of("rest").map(|r| r.alarms).sum();
        Total {
            detector: self.detector.name,
            onsets,
            missed,
            inside,
            early,
            missed_ci: interval::share(missed, onsets - inside),
            early_ci: interval::share(early, first),
            onsets_chance: self.chance("onset"),
            latency_ms: latencies("onset"),
            latency_ms_ci: interval::quantiles(&found.collect::<Vec<_>>()),
            travel_mm: Quantiles::of(of("onset").filter_map(|r| r.travel_mm).collect()),
            steady: of("steady").count(),
            steady_missed: of("steady").filter(|r| r.missed).count(),
            steady_chance: self.chance("steady"),
            steady_share: of("steady").map(RecordingScore::reported_share).reduce(f64::min),
            steady_ms: latencies("steady"),
            in_alarm_s,
            in_alarm_share: (length_s > 0.0).then(|| in_alarm_s / length_s),
            rest_s,
            rest_alarms,
            rest_in_alarm_s: sum(&mut of("rest").map(|r| r.in_alarm_s)),
            rest_alarms_per_hour_ci: interval::rate(rest_alarms, rest_s / 3600.0),
            floor_s: self.floor_s,
            rates_hz: self.rates_hz.clone(),
            own_floors: self
                .recordings
                .iter()
                .filter(|r| r.slip == 1 && r.floor_from == FloorFrom::Own)
                .count(),
            guard_ms,
            ns_per_sample: self.ns_per_sample,
        }
    }
}
