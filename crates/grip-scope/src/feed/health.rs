//! Figures of a daemon: rates, losses, latency, stages.

use grip_link::message::daemon::{BadFrames, LinkState, Recording};

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
