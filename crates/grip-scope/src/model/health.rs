//! Figures of a daemon in, the last ones and how they went out.

use crate::feed::HealthPoint;
use std::collections::VecDeque;

/// Points kept: an hour and more of one a second.
const MOST: usize = 4000;

/// What is known of the link's health.
#[derive(Clone, Debug, Default)]
pub struct HealthBoard {
    latest: Option<Box<HealthPoint>>,
    history: VecDeque<HealthTrend>,
    lost_in_scope: u64,
    late_rows: u64,
    huge: u64,
    nan: u64,
    stray_states: u64,
}

/// What is kept of each point, for small plots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HealthTrend {
    /// Time on the axis (s).
    pub t_s: f64,
    /// Sample rate measured (Hz).
    pub rate_hz: Option<f32>,
    /// Latency (us): 99 of 100 were faster.
    pub p99_us: Option<f32>,
    /// Rows lost so far.
    pub lost: u64,
    /// Frames with a wrong checksum so far.
    pub crc: u32,
}

impl HealthBoard {
    pub(super) fn take(&mut self, t_s: f64, point: Box<HealthPoint>) {
        self.history.push_back(HealthTrend {
            t_s,
            rate_hz: point.rate_hz,
            p99_us: point.latency.p99_us,
            lost: point.lost,
            crc: point.bad.crc,
        });
        if self.history.len() > MOST {
            self.history.pop_front();
        }
        self.latest = Some(point);
    }

    pub(super) fn late_row(&mut self) {
        self.late_rows += 1;
    }

    pub(super) fn stray_state(&mut self) {
        self.stray_states += 1;
    }

    pub(super) fn set_unusable(&mut self, huge: u64, nan: u64) {
        (self.huge, self.nan) = (huge, nan);
    }

    pub(super) fn set_lost_in_scope(&mut self, dropped: u64) -> bool {
        core::mem::replace(&mut self.lost_in_scope, dropped) != dropped
    }

    /// The last figures.
    #[must_use]
    pub fn latest(&self) -> Option<&HealthPoint> {
        self.latest.as_deref()
    }

    /// How they went, in order of time.
    #[must_use]
    pub fn history(&self) -> impl ExactSizeIterator<Item = &HealthTrend> {
        self.history.iter()
    }

    /// Items that the scope itself had no room for: shown as gaps.
    #[must_use]
    pub const fn lost_in_scope(&self) -> u64 {
        self.lost_in_scope
    }

    /// Rows that were not later than the one before and are not shown.
    #[must_use]
    pub const fn late_rows(&self) -> u64 {
        self.late_rows
    }

    /// States whose time is far from that of the samples, not shown.
    #[must_use]
    pub const fn stray_states(&self) -> u64 {
        self.stray_states
    }

    /// Finite readings that no sensor of a gripper sends.
    #[must_use]
    pub const fn huge(&self) -> u64 {
        self.huge
    }

    /// Readings of the stylus that are no number.
    #[must_use]
    pub const fn nan(&self) -> u64 {
        self.nan
    }

    /// Bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let latest = self.latest.as_ref().map_or(0, |point| {
            size_of::<HealthPoint>() + point.latency.histogram.capacity() * size_of::<(f32, u64)>()
        });
        latest + self.history.capacity() * size_of::<HealthTrend>()
    }
}
