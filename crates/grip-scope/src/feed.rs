//! What a source tells, one item after the other: the only thing that passes from its thread to the model.

use crate::channel::Channel;
use grip_link::message::DeviceState;
use grip_link::message::daemon::{
    BadFrames, EscKind, GripStage, Gripper, LinkState, Method, RealTime, Recording, SceneCode,
    SensorHealth, SpeedSource,
};
use slip_core::detector::BANDS;
use std::path::PathBuf;

/// One item. All times are device times (s) as the source has them; the model puts them on its axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Feed {
    /// How the source is; told on every change.
    Status(SourceStatus),
    /// A conversation with a daemon begins.
    Welcome(DaemonInfo),
    /// What comes next is another run of the source: nothing joins it to what came before.
    Restart,
    /// Samples.
    Rows(RowBlock),
    /// Samples from somewhere later in a recording that is still being loaded, for a first picture.
    Preview(RowBlock),
    /// What the pipeline thinks.
    State(StatePoint),
    /// What the scope's own observer makes of the samples.
    Derived(Box<DerivedBlock>),
    /// Something happened.
    Event(EventMark),
    /// Figures of the daemon.
    Health(Box<HealthPoint>),
    /// Which gripper it is.
    Gripper(Gripper),
    /// A line for people.
    Notice(NoticeLine),
    /// Curves of a study.
    Study(Box<StudyCurves>),
    /// Where a recording begins and ends (device time, s), before all of it is loaded; what file it is.
    Extent {
        /// Its first sample (s).
        from_s: f64,
        /// Its last one (s).
        to_s: f64,
        /// The file.
        file: PathBuf,
    },
}

/// How a source is.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SourceStatus {
    /// Nothing was asked for yet.
    #[default]
    Idle,
    /// It is being opened.
    Connecting {
        /// What is being opened.
        what: String,
        /// Why the attempt before was of no use, a sentence; empty for the first one.
        before: String,
    },
    /// Data come as they are made.
    Live,
    /// A file is being read.
    Loading {
        /// Share done (0 to 1).
        done: f32,
    },
    /// A file has been read.
    Complete {
        /// What was odd about it, a sentence; empty where nothing was.
        note: String,
    },
    /// It is gone and will be tried again.
    Waiting {
        /// Why, a sentence.
        reason: String,
        /// When (s from now).
        again_in_s: f32,
    },
    /// It is there, and nothing comes.
    Stalled {
        /// For how long (s).
        for_s: f32,
    },
    /// It cannot be used.
    Failed {
        /// Why, a sentence.
        sentence: String,
    },
}

impl SourceStatus {
    /// One line for a status bar.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self {
            Self::Idle => "no source".to_owned(),
            Self::Connecting { what, before } if before.is_empty() => {
                format!("connecting to {what}")
            }
            Self::Connecting { before, .. } => format!("{before}; trying again"),
            Self::Live => "live".to_owned(),
            Self::Loading { done } => format!("loading, {:.0} %", 100.0 * done),
            Self::Complete { note } if note.is_empty() => "loaded".to_owned(),
            Self::Complete { note } => format!("loaded; {note}"),
            Self::Waiting { reason, again_in_s } => {
                format!("{reason}; trying again in {again_in_s:.1} s")
            }
            Self::Stalled { for_s } => format!("no samples for {for_s:.1} s"),
            Self::Failed { sentence } => sentence.clone(),
        }
    }

    /// Whether nobody is there who could take a command. A stream that stalls has its connection still.
    #[must_use]
    pub const fn is_disconnected(&self) -> bool {
        match self {
            Self::Connecting { .. } | Self::Waiting { .. } | Self::Failed { .. } => true,
            Self::Idle
            | Self::Live
            | Self::Loading { .. }
            | Self::Complete { .. }
            | Self::Stalled { .. } => false,
        }
    }

    /// Whether something is wrong.
    #[must_use]
    pub const fn is_trouble(&self) -> bool {
        match self {
            Self::Waiting { .. } | Self::Stalled { .. } | Self::Failed { .. } => true,
            Self::Connecting { before, .. } => !before.is_empty(),
            Self::Idle | Self::Live | Self::Loading { .. } | Self::Complete { .. } => false,
        }
    }
}

/// Who a daemon is.
#[derive(Clone, Debug, PartialEq)]
pub struct DaemonInfo {
    /// Its name and version.
    pub name: String,
    /// Where it was found.
    pub place: String,
    /// Whether it takes commands.
    pub may_command: bool,
    /// Whether it only observes.
    pub dry_run: bool,
    /// Whether it was asked to record.
    pub records: bool,
    /// What of real-time operation was granted.
    pub real_time: RealTime,
    /// Every how manieth sample comes; 1: all.
    pub every_nth: u16,
}

/// Samples in order of time, column by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowBlock {
    /// Times (us of the device), one for each row; a row that is not later than the one before begins a new run.
    pub times_us: Vec<u64>,
    /// Values of each channel, one for each row; NaN: no reading.
    pub columns: Vec<(Channel, Vec<f32>)>,
    /// Whether rows are missing before the first one.
    pub broken: bool,
    /// Rows that are missing there, where that is known.
    pub lost: u32,
    /// The array's frames, where there is one.
    pub taxels: Option<TaxelBlock>,
}

/// Frames of the taxel array, one for each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TaxelBlock {
    /// Taxels of a frame.
    pub count: usize,
    /// Readings, frame by frame.
    pub values: Vec<f32>,
}

/// The pipeline after a frame of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatePoint {
    /// Device time (s).
    pub t_s: f64,
    /// What the grasp is doing.
    pub scene: SceneCode,
    /// What the force controller does.
    pub grip: GripStage,
    /// Stylus, travel, pressure, reference.
    pub sensors: [SensorHealth; 4],
    /// State of the gripper, where it is known.
    pub device: Option<DeviceState>,
    /// Its latched fault; 0 where there is none.
    pub fault: u16,
    /// Statistic over its threshold.
    pub statistic: Option<f32>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
    /// Measured force (N).
    pub applied_n: Option<f32>,
    /// Estimate of the adequate force (N).
    pub estimate_n: Option<f32>,
    /// Whether it lies outside what the network was trained on.
    pub extrapolated: bool,
    /// The last E_sc.
    pub esc: Option<EscPoint>,
    /// Largest force of the controller (N).
    pub limit_n: Option<f32>,
    /// Sample rate in force (Hz).
    pub rate_hz: u32,
    /// Rows lost so far.
    pub lost: u64,
}

/// A value of E_sc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EscPoint {
    /// Which reading.
    pub kind: EscKind,
    /// Its value (W or J).
    pub value: f32,
    /// The exact value is not below this; NaN where no enclosure is known, minus infinity where a pole may be inside.
    pub low: f32,
    /// The exact value is not above this.
    pub high: f32,
    /// b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
    pub flags: u8,
}

impl EscPoint {
    /// Names of the flags that are set.
    #[must_use]
    pub fn flag_names(flags: u8) -> Vec<&'static str> {
        let names = ["pole inside", "sign unknown", "no information", "degenerate"];
        let set = names.into_iter().enumerate().filter(|(bit, _)| flags >> bit & 1 == 1);
        set.map(|(_, name)| name).collect()
    }
}

/// What the observer makes of some milliseconds of samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DerivedBlock {
    /// Band energies, a point for each few milliseconds.
    pub bands: Vec<BandPoint>,
    /// Peaks and valleys of the stylus.
    pub turns: Vec<Turn>,
    /// E_sc, estimate and slip speed while an object slips.
    pub evidence: Vec<EvidencePoint>,
    /// Spectra of the stylus.
    pub spectra: Vec<SpectrumColumn>,
    /// Whether what comes does not join what came before.
    pub broken: bool,
}

/// The highest of some milliseconds of what the detector sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandPoint {
    /// Device time of their end (s).
    pub t_s: f64,
    /// Energy of each band over its floor; NaN while the floor is learned.
    pub energy: [f32; BANDS],
    /// Energy over floor at which it is a slip; infinity where the band is not asked.
    pub threshold: [f32; BANDS],
    /// The statistic over its threshold.
    pub statistic: f32,
}

/// A peak or a valley of the stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// When (s).
    pub t_s: f64,
    /// How high (unit of the stylus).
    pub height: f32,
    /// Whether it is a peak.
    pub is_peak: bool,
}

/// What is known of a slip that goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvidencePoint {
    /// Device time (s).
    pub t_s: f64,
    /// E_sc with its enclosure.
    pub esc: Option<EscPoint>,
    /// Slip speed and its standard deviation (m/s).
    pub speed: Option<(f32, f32)>,
    /// Estimate (N), and the estimates one deviation of the acceleration away: value, low, high.
    pub estimate: Option<[f32; 3]>,
}

/// One spectrum of the stylus.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumColumn {
    /// Device times of its first and last sample (s).
    pub span: [f64; 2],
    /// Highest frequency (Hz); bins are spread evenly from 0 to it.
    pub top_hz: f32,
    /// Power of each bin (dB over one unit of the stylus squared per bin), in steps of [`DB_STEP`](crate::model::DB_STEP) above
    /// [`DB_BASE`](crate::model::DB_BASE).
    pub bins: Box<[u8]>,
}

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum EventKind {
    /// Shear and first movements.
    Incipient,
    /// The object slides.
    Gross,
    /// A slip has ended.
    Ended,
    /// The force was raised to stop a slip.
    Reflex,
    /// Samples are missing.
    Gap,
    /// A sensor or the gripper reports a fault.
    Fault,
    /// The fault is over.
    Recovered,
    /// A pipeline begins, with other settings or another gripper.
    Reload,
    /// The device's time went backwards or leapt.
    Clock,
    /// A client's command.
    Client,
    /// The link changed.
    Link,
    /// A mark of the user.
    Marker,
}

impl EventKind {
    /// Every kind.
    pub const ALL: [Self; 12] = [
        Self::Incipient,
        Self::Gross,
        Self::Ended,
        Self::Reflex,
        Self::Gap,
        Self::Fault,
        Self::Recovered,
        Self::Reload,
        Self::Clock,
        Self::Client,
        Self::Link,
        Self::Marker,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Incipient => "incipient slip",
            Self::Gross => "gross slip",
            Self::Ended => "slip ended",
            Self::Reflex => "reflex",
            Self::Gap => "gap",
            Self::Fault => "fault",
            Self::Recovered => "recovered",
            Self::Reload => "pipeline begins",
            Self::Clock => "clock",
            Self::Client => "client",
            Self::Link => "link",
            Self::Marker => "marker",
        }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct EventMark {
    /// Device time (s); NaN where only "now" is known.
    pub t_s: f64,
    /// What.
    pub kind: EventKind,
    /// A line for people.
    pub text: String,
    /// What is known of a slip.
    pub slip: Option<SlipFacts>,
}

impl EventMark {
    /// An event that is no slip.
    #[must_use]
    pub fn plain(t_s: f64, kind: EventKind, text: impl Into<String>) -> Self {
        Self { t_s, kind, text: text.into(), slip: None }
    }
}

/// What an event tells of a slip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlipFacts {
    /// Which method noticed it.
    pub method: Option<Method>,
    /// Statistic over its threshold.
    pub statistic: Option<f32>,
    /// Probability that noise alone would not reach it (0 to 1).
    pub confidence: Option<f32>,
    /// Slip speed (m/s).
    pub speed_m_s: Option<f32>,
    /// Its standard deviation (m/s).
    pub speed_sigma_m_s: Option<f32>,
    /// Where the speed comes from.
    pub speed_source: Option<SpeedSource>,
    /// Distance moved (m).
    pub moved_m: Option<f32>,
    /// Irregularities passed.
    pub irregularities: Option<u32>,
    /// E_sc as printed (W).
    pub esc_w: Option<f32>,
    /// Estimate (N).
    pub estimate_n: Option<f32>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
    /// How long it lasted (s).
    pub duration_s: Option<f32>,
}

impl SlipFacts {
    /// The confidence for people (`confidence 76 %`), never rounded up to certainty.
    #[must_use]
    pub fn sure(&self) -> Option<String> {
        self.confidence.map(|sure| match sure {
            0.999.. => "confidence > 99.9 %".to_owned(),
            _ => format!("confidence {:.0} %", (100.0 * sure).floor()),
        })
    }
}

/// Figures of a daemon, or of what runs in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct HealthPoint {
    /// Time since the daemon's start (s).
    pub host_s: f64,
    /// Sample rate measured (Hz).
    pub rate_hz: Option<f32>,
    /// Samples.
    pub samples: u64,
    /// Rows lost.
    pub lost: u64,
    /// Frames of the gripper that were no good.
    pub bad: BadFrames,
    /// Items dropped before the service thread, before the recorder, and frames dropped for clients.
    pub dropped: [u64; 3],
    /// Clients connected.
    pub clients: u16,
    /// State of the link.
    pub link: LinkState,
    /// State of the recording.
    pub recording: Recording,
    /// Bytes recorded.
    pub recorded_bytes: u64,
    /// From the last byte of a frame to the command.
    pub latency: LatencyFigures,
    /// Samples through bands, gate, methods, observation.
    pub stages: [u64; 4],
    /// Slips.
    pub slips: u32,
    /// Lines opened after the first.
    pub reconnects: u32,
    /// Force commands written.
    pub commands: u64,
    /// Offset of the gripper's clock against the host's, and half the width of what it may be (us).
    pub clock_us: Option<(f64, f64)>,
}

/// Quantiles (us), and the histogram where the source has one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LatencyFigures {
    /// Half were faster.
    pub p50_us: Option<f32>,
    /// 99 of 100 were faster.
    pub p99_us: Option<f32>,
    /// 999 of 1000 were faster.
    pub p999_us: Option<f32>,
    /// The slowest.
    pub max_us: Option<f32>,
    /// Upper bound (us) and count of each bucket; empty where the source tells none.
    pub histogram: Vec<(f32, u64)>,
}

/// A line for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoticeLine {
    /// How loud.
    pub level: Level,
    /// The sentence.
    pub text: String,
}

/// How loud a notice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Good to know.
    Info,
    /// Something is lost or odd.
    Warning,
    /// Something does not work.
    Error,
}

/// Learning curves of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyCurves {
    /// What the study is called.
    pub title: String,
    /// Its plots.
    pub plots: Vec<StudyPlot>,
    /// Sentences beside them.
    pub notes: Vec<String>,
}

/// One plot of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyPlot {
    /// Title.
    pub title: String,
    /// What x is.
    pub x_label: String,
    /// What y is.
    pub y_label: String,
    /// Whether y is to be drawn on a logarithmic axis.
    pub log_y: bool,
    /// Its curves.
    pub curves: Vec<StudyCurve>,
}

/// One curve of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyCurve {
    /// What the legend says.
    pub name: String,
    /// Points.
    pub points: Vec<[f64; 2]>,
}
