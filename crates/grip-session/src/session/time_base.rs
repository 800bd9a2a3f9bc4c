//! Pipeline time that only goes forward, from ticks and numbers of rows, and the state of the device's clock.
//!
//! Device time is followed as long as it is plausible beside the row numbers and the host's clock. A row whose tick does not follow, while
//! its number does, is timed by its number at the configured rate; ticks are followed again once they have run for [`RUN_US`]. A row
//! whose number does not follow either may be an old one that came again and is refused, for at most [`REFUSE_US`] in a row.

use crate::report::ClockHealth;
use slip_core::units::Micros;

/// Ticks have to run for so long (us of pipeline time) before they are followed again.
const RUN_US: u64 = 20_000;
/// Frames that begin within this time, at least.
const RUN_FRAMES: u32 = 2;
/// Rows are refused for at most so long (us of host time); ticks that have not run for so long count as stopped.
const REFUSE_US: u64 = 40_000;
/// A fault of the clock is over after so long (us of host time) without another one.
const SETTLE_US: u64 = 1_000_000;
/// Ticks may run ahead of row numbers and host by this (us): what a line may have delayed the row before.
const AHEAD_US: u64 = 100_000;
/// Row numbers may run ahead of the host by this (us).
const ROWS_AHEAD_US: u64 = 1_000_000;
/// Device times are kept below this (us), so that a tick counter can wrap.
const HORIZON_US: u64 = 1 << 62;
/// Rate error beyond which it is reported, and below which it is over.
const RATE_OFF: f64 = 0.01;
const RATE_GOOD: f64 = 0.008;

/// The time of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamp {
    /// Pipeline time: later than that of every usable row before, or that of the last one where the row is not usable.
    pub(super) t: Micros,
    /// Whether the row is a new one.
    pub(super) usable: bool,
}

/// Maps rows to pipeline time.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeBase {
    tick_hz: u64,
    rate_hz: u64,
    /// Tick and pipeline time (us) from which ticks count.
    base: (u64, u64),
    last: Option<Last>,
    by_rows: Option<ByRows>,
    /// Host time (us) of the present frame.
    host_us: u64,
    /// Host time (us) of the first of the refused rows.
    refused_us: Option<u64>,
    /// The last fault and the host time (us) at which it is over.
    fault: Option<(ClockHealth, u64)>,
    rate: ClockHealth,
    /// The relation of the clocks is to be learned again.
    resync: bool,
}

/// The last usable row.
#[derive(Clone, Copy, Debug)]
struct Last {
    tick: u64,
    index: u32,
    t_us: u64,
    host_us: u64,
}

/// Rows are timed by their numbers.
#[derive(Clone, Copy, Debug)]
struct ByRows {
    /// What the clock did first.
    fault: ClockHealth,
    since_us: u64,
    /// Pipeline time (us) from which rows count, and how many there were.
    base_us: u64,
    rows: u64,
    run: Run,
    stopped: bool,
}

/// Ticks that run.
#[derive(Clone, Copy, Debug)]
struct Run {
    tick: u64,
    t_us: u64,
    frames: u32,
}

impl TimeBase {
    /// For a device that counts `tick_hz` ticks a second and samples at `rate_hz`.
    pub(super) fn new(tick_hz: u64, rate_hz: u32) -> Self {
        Self {
            tick_hz: tick_hz.max(1),
            rate_hz: u64::from(rate_hz.max(1)),
            base: (0, 0),
            last: None,
            by_rows: None,
            host_us: 0,
            refused_us: None,
            fault: None,
            rate: ClockHealth::Good,
            resync: false,
        }
    }

    /// The same boot of the device goes on at another rate.
    pub(super) fn set_rate(&mut self, rate_hz: u32) {
        self.rate_hz = u64::from(rate_hz.max(1));
        if let (Some(last), Some(rows)) = (self.last, &mut self.by_rows) {
            (rows.base_us, rows.rows) = (last.t_us, 0);
        }
    }

    /// A frame of rows begins, complete at host time `host_us`.
    pub(super) fn frame(&mut self, host_us: u64) {
        self.host_us = host_us;
        if let Some(run) = self.by_rows.as_mut().map(|rows| &mut rows.run) {
            run.frames = run.frames.saturating_add(1);
        }
        if self.fault.is_some_and(|(_, over_us)| self.by_rows.is_none() && host_us >= over_us) {
            self.fault = None;
        }
    }

    /// The time of the row with this number and tick.
    #[inline]
    pub(super) fn row(&mut self, index: u32, tick: u64) -> Stamp {
        let Some(last) = self.last else { return self.first(index, tick) };
        let host_us = self.host_us;
        let waited_us = host_us.saturating_sub(last.host_us);
        let rows = index.wrapping_sub(last.index).cast_signed();
        let rows_us = self.rows_us(u64::from(rows.unsigned_abs()));
        let follows = rows > 0 && rows_us <= waited_us.saturating_add(ROWS_AHEAD_US);
        let expected_us = if follows { rows_us } else { self.rows_us(1) };
        let most_us = 2 * expected_us + waited_us + AHEAD_US;
        let by_tick = self.by_tick(&last, tick).filter(|t_us| t_us - last.t_us <= most_us);
        let t_us = match (self.by_rows, by_tick) {
            (None, Some(t_us)) => t_us,
            _ if follows => {
                self.next_row(&last, u64::from(rows.unsigned_abs()), tick, by_tick.is_some())
            }
            _ if host_us.saturating_sub(*self.refused_us.get_or_insert(host_us)) < REFUSE_US => {
                return Stamp { t: Micros(last.t_us), usable: false };
            }
            _ => self.afresh(
                &last,
                tick,
                waited_us.clamp(expected_us, ROWS_AHEAD_US.max(expected_us)),
            ),
        };
        self.refused_us = None;
        self.last = Some(Last { tick, index, t_us, host_us });
        Stamp { t: Micros(t_us), usable: true }
    }

    /// The first row is as late as its tick.
    fn first(&mut self, index: u32, tick: u64) -> Stamp {
        let t_us = micros(tick, self.tick_hz) & (HORIZON_US - 1);
        if t_us != micros(tick, self.tick_hz) {
            self.base = (tick, t_us);
        }
        self.last = Some(Last { tick, index, t_us, host_us: self.host_us });
        Stamp { t: Micros(t_us), usable: true }
    }

    /// Pipeline time (us) of a tick after `last`; `None` where it is not later.
    fn by_tick(&mut self, last: &Last, tick: u64) -> Option<u64> {
        if tick.wrapping_sub(last.tick).cast_signed() <= 0 {
            return None;
        }
        if self.by_rows.is_some() || tick < last.tick {
            // Counted from the last row: the counter has wrapped, or is not followed now.
            let t_us = last.t_us.checked_add(micros(tick.wrapping_sub(last.tick), self.tick_hz))?;
            if self.by_rows.is_none() {
                self.base = (last.tick, last.t_us);
            }
            return (t_us > last.t_us).then_some(t_us);
        }
        let t_us = self.base.1.checked_add(micros(tick.wrapping_sub(self.base.0), self.tick_hz))?;
        (t_us > last.t_us).then_some(t_us)
    }

    /// Time (us) of a row that follows by its number; ticks that have run long enough are followed from here on.
    #[cold]
    fn next_row(&mut self, last: &Last, count: u64, tick: u64, runs: bool) -> u64 {
        let back = tick.wrapping_sub(last.tick).cast_signed() <= 0;
        let fault = if back { ClockHealth::Back } else { ClockHealth::Forward };
        let fresh = Run { tick, t_us: last.t_us + self.rows_us(count), frames: 0 };
        let mut now = self.by_rows.unwrap_or(ByRows {
            fault,
            since_us: self.host_us,
            base_us: last.t_us,
            rows: 0,
            run: fresh,
            stopped: false,
        });
        now.rows += count;
        if !runs {
            now.run = fresh;
        }
        let t_us = (now.base_us + self.rows_us(now.rows)).max(last.t_us + 1);
        self.judge(&mut now, tick, t_us);
        t_us
    }

    /// Whether the ticks run again, or count as stopped.
    fn judge(&mut self, now: &mut ByRows, tick: u64, t_us: u64) {
        let over_us = self.host_us + SETTLE_US;
        let run_us = t_us.saturating_sub(now.run.t_us);
        let whole = now.run.frames >= RUN_FRAMES && run_us >= RUN_US;
        if whole && micros(tick.wrapping_sub(now.run.tick), self.tick_hz) >= run_us / 10 {
            self.fault =
                Some((if now.stopped { ClockHealth::Stopped } else { now.fault }, over_us));
            (self.base, self.by_rows, self.resync) = ((tick, t_us), None, true);
            return;
        }
        let late = self.host_us.saturating_sub(now.since_us) >= REFUSE_US;
        if whole || (late && now.run.frames == 0) {
            now.stopped = true;
            self.fault = Some((ClockHealth::Stopped, over_us));
        }
        self.by_rows = Some(*now);
    }

    /// Goes on after rows that followed by nothing.
    #[cold]
    fn afresh(&mut self, last: &Last, tick: u64, step_us: u64) -> u64 {
        let t_us = last.t_us + step_us.max(1);
        let stopped = self.by_rows.is_some();
        if stopped {
            self.fault = Some((ClockHealth::Stopped, self.host_us + SETTLE_US));
        }
        self.by_rows = Some(ByRows {
            fault: ClockHealth::Back,
            since_us: self.host_us,
            base_us: t_us,
            rows: 0,
            run: Run { tick, t_us, frames: 0 },
            stopped,
        });
        t_us
    }

    /// Time (us) of so many rows at the configured rate.
    fn rows_us(&self, rows: u64) -> u64 {
        (rows.saturating_mul(1_000_000) / self.rate_hz).max(1)
    }

    /// Takes how far the device's rate is certainly off the nominal one, by the clock estimate.
    pub(super) fn set_rate_error(&mut self, off: Option<f64>) {
        let Some(off) = off.filter(|_| self.follows_ticks()) else { return };
        self.rate = match off {
            off if off > RATE_OFF => ClockHealth::Fast,
            off if off < -RATE_OFF => ClockHealth::Slow,
            off if off.abs() < RATE_GOOD => ClockHealth::Good,
            _ => self.rate,
        };
    }

    /// State of the clock.
    pub(super) fn health(&self) -> ClockHealth {
        self.fault.map_or(self.rate, |(fault, _)| fault)
    }

    /// Whether ticks are followed and their relation to the host's clock holds.
    pub(super) fn follows_ticks(&self) -> bool {
        self.by_rows.is_none() && !self.resync
    }

    /// Whether the relation of the clocks has to be learned again; asked once.
    pub(super) fn take_resync(&mut self) -> bool {
        if self.resync {
            self.rate = ClockHealth::Good;
        }
        core::mem::take(&mut self.resync)
    }

    /// Tick and pipeline time of the last usable row, and when it came in (host us).
    pub(super) fn newest(&self) -> Option<(u64, Micros, u64)> {
        self.last.map(|last| (last.tick, Micros(last.t_us), last.host_us))
    }
}

/// Ticks in microseconds, rounded down; exact for any tick count that fits.
fn micros(tick: u64, tick_hz: u64) -> u64 {
    if tick_hz == 1_000_000 {
        return tick;
    }
    (tick / tick_hz)
        .saturating_mul(1_000_000)
        .saturating_add((tick % tick_hz) * 1_000_000 / tick_hz)
}

#[cfg(test)]
mod tests;
