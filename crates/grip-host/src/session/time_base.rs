//! Ticks and numbers of rows in; a pipeline time that only goes forward, and the state of the device's clock, out.
//!
//! Device time is followed as long as it is plausible beside the row numbers and the host's clock. A row whose tick does not follow, while
//! its number does, is timed by its number at the configured rate; ticks are followed again once they have run for [`RUN_US`]. A row
//! whose number does not follow either may be an old one that came again and is refused, for at most [`REFUSE_US`] in a row.

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

/// State of the device's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClockHealth {
    /// Ticks run at the nominal rate.
    #[default]
    Good,
    /// Ticks do not advance; rows are timed by their numbers.
    Stopped,
    /// Ticks went back.
    Back,
    /// Ticks jumped ahead of row numbers and host.
    Forward,
    /// Ticks run more than 1 % fast.
    Fast,
    /// Ticks run more than 1 % slow.
    Slow,
}

impl ClockHealth {
    /// All states.
    pub const ALL: [Self; 6] =
        [Self::Good, Self::Stopped, Self::Back, Self::Forward, Self::Fast, Self::Slow];

    /// The name used in output lines.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Stopped => "stopped",
            Self::Back => "back",
            Self::Forward => "forward",
            Self::Fast => "fast",
            Self::Slow => "slow",
        }
    }
}

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
mod tests {
    use super::{ClockHealth, TimeBase};
    use proptest::prelude::*;

    /// A device of 10 kHz in frames of ten rows, one every millisecond, at a line without delay.
    struct Device {
        time: TimeBase,
        index: u32,
        host_us: u64,
        /// Tick of the row at host time 0, and ticks per us.
        clock: (u64, u64),
        last_us: Option<u64>,
        /// Longest step between usable rows (us), and longest time without one.
        longest_us: u64,
        refused: u32,
        seen: Vec<(u64, ClockHealth)>,
    }

    impl Device {
        fn new(tick: u64) -> Self {
            let time = TimeBase::new(1_000_000, 10_000);
            let (clock, seen) = ((tick, 1), vec![(0, ClockHealth::Good)]);
            Self {
                time,
                index: 7,
                host_us: 0,
                clock,
                last_us: None,
                longest_us: 0,
                refused: 0,
                seen,
            }
        }

        fn tick(&self) -> u64 {
            self.clock.0.wrapping_add(self.host_us * self.clock.1)
        }

        /// Sets the rate from now on, without a step.
        fn rate(&mut self, rate: u64) {
            let tick = self.tick();
            self.clock = (tick.wrapping_sub(self.host_us * rate), rate);
        }

        fn run(&mut self, ms: u64) {
            for _ in 0..ms {
                self.host_us += 1000;
                let tick = self.tick();
                self.frame(tick);
            }
        }

        fn frame(&mut self, tick: u64) {
            self.time.frame(self.host_us);
            for row in 0..10 {
                let stamp = self.time.row(self.index, tick.wrapping_add(100 * row));
                self.index = self.index.wrapping_add(1);
                if !stamp.usable {
                    self.refused += 1;
                    continue;
                }
                if let Some(last_us) = self.last_us.replace(stamp.t.0) {
                    assert!(stamp.t.0 > last_us, "{last_us} to {stamp:?}");
                    self.longest_us = self.longest_us.max(stamp.t.0 - last_us);
                }
            }
            let health = self.time.health();
            if self.seen.last().is_some_and(|(_, last)| *last != health) {
                self.seen.push((self.host_us, health));
            }
        }

        fn names(&self) -> Vec<&'static str> {
            self.seen.iter().map(|(_, health)| health.name()).collect()
        }
    }

    #[test]
    fn device_time_is_pipeline_time_while_nothing_is_wrong() {
        for (tick_hz, step) in [(1_000_000, 100), (168_000_000, 16_800), (48_000, 5)] {
            let mut time = TimeBase::new(tick_hz, 10_000);
            for row in 0..1000_u32 {
                time.frame(u64::from(row) * 100);
                let tick = 5_000_000 + u64::from(row) * step;
                let stamp = time.row(row, tick);
                assert_eq!((stamp.t.0, stamp.usable), (super::micros(tick, tick_hz), true));
            }
        }
    }

    #[test]
    fn a_clock_that_stops_is_replaced_by_row_numbers_and_followed_when_it_runs_again() {
        let mut device = Device::new(7_200_000_000);
        device.run(500);
        device.rate(0);
        device.run(2000);
        assert!(!device.time.follows_ticks());
        let lag_us = (device.host_us + 7_200_000_000).abs_diff(device.last_us.unwrap());
        device.rate(1);
        device.run(2000);
        assert_eq!(device.names(), ["good", "stopped", "good"]);
        assert!(device.seen[1].0 - 500_000 <= 50_000, "{:?}", device.seen);
        assert_eq!((device.refused, device.longest_us), (0, 100));
        assert!(lag_us < 1000 && device.time.take_resync() && device.time.follows_ticks());
    }

    #[test]
    fn a_clock_that_jumps_is_followed_from_where_it_was() {
        let jumps = [
            (-3_000_000, "back"),
            (-3_600_000_000, "back"),
            (-500, "back"),
            (3_600_000_000, "forward"),
            (1 << 61, "forward"),
        ];
        for (jump, name) in jumps {
            let mut device = Device::new(7_200_000_000);
            device.run(500);
            device.clock.0 = device.clock.0.wrapping_add_signed(jump);
            device.run(45);
            assert!(device.time.take_resync() && device.time.follows_ticks(), "{jump}");
            device.run(3000);
            assert_eq!(device.names(), ["good", name, "good"], "{jump}");
            assert!(device.seen[1].0 - 500_000 <= 50_000, "{:?}", device.seen);
            assert_eq!((device.refused, device.longest_us), (0, 100), "{jump}");
        }
    }

    #[test]
    fn counters_that_begin_anew_are_followed_within_50_ms() {
        let mut device = Device::new(7_200_000_000);
        device.run(500);
        (device.index, device.clock.0) = (0, 0);
        device.run(45);
        assert!(device.longest_us <= 50_000 && device.refused < 450, "{} us", device.longest_us);
        device.run(2000);
        assert_eq!(device.names(), ["good", "back", "good"]);
    }

    #[test]
    fn old_frames_that_come_again_are_refused_and_change_nothing() {
        let mut device = Device::new(1000);
        device.run(100);
        for _ in 0..50 {
            device.run(3);
            let (index, host_us) = (device.index, device.host_us);
            device.index -= 25;
            device.frame(device.tick() - 3000);
            (device.index, device.host_us) = (index, host_us);
        }
        assert_eq!((device.names(), device.refused, device.longest_us), (vec!["good"], 500, 100));
    }

    #[test]
    fn counters_wrap() {
        for tick in [u64::MAX - 200_000, (1 << 63) - 200_000, (1 << 32) - 200_000, u64::MAX - 5] {
            let mut device = Device::new(tick);
            device.index = u32::MAX - 1000;
            device.run(1000);
            assert_eq!(
                (device.names(), device.refused, device.longest_us),
                (vec!["good"], 0, 100),
                "{tick}"
            );
        }
    }

    #[test]
    fn gaps_and_stalls_are_no_faults() {
        let mut device = Device::new(1000);
        device.run(100);
        // The device pauses for a second, with and without counting rows.
        device.host_us += 1_000_000;
        device.run(100);
        device.host_us += 1_000_000;
        device.index += 10_000;
        device.run(100);
        // The line holds 300 ms of frames back and delivers them at once.
        let now_us = device.host_us + 300_000;
        for _ in 0..300 {
            let real_us = device.host_us + 1000;
            device.host_us = real_us;
            let tick = device.tick();
            device.host_us = now_us;
            device.frame(tick);
            device.host_us = real_us;
        }
        device.run(100);
        assert_eq!((device.names(), device.refused), (vec!["good"], 0));
    }

    #[test]
    fn a_wrong_rate_is_reported_and_ends() {
        let mut time = TimeBase::new(1_000_000, 1000);
        let mut health = |off| {
            time.set_rate_error(off);
            time.health()
        };
        assert_eq!(health(Some(0.05)), ClockHealth::Fast);
        assert_eq!(health(None), ClockHealth::Fast);
        assert_eq!(health(Some(0.009)), ClockHealth::Fast);
        assert_eq!(health(Some(-0.002)), ClockHealth::Good);
        assert_eq!(health(Some(-0.02)), ClockHealth::Slow);
    }

    /// What a frame does to the counters of the device and to the line.
    #[derive(Clone, Debug)]
    enum Step {
        Good,
        TickJump(i64),
        Tick(u64),
        IndexJump(i32),
        Stop,
        Pause(u64),
        Burst,
    }

    fn any_step() -> impl Strategy<Value = Step> {
        prop_oneof![
            6 => Just(Step::Good),
            1 => (-10_000_000_i64..10_000_000).prop_map(Step::TickJump),
            1 => any::<i64>().prop_map(Step::TickJump),
            1 => any::<u64>().prop_map(Step::Tick),
            1 => (-5000_i32..5000).prop_map(Step::IndexJump),
            1 => any::<i32>().prop_map(Step::IndexJump),
            1 => Just(Step::Stop),
            1 => (0_u64..2_000_000).prop_map(Step::Pause),
            1 => Just(Step::Burst),
        ]
    }

    proptest! {
        /// Whatever the counters do: time goes forward, by no more than host time, row numbers and the allowances say, and no more than
        /// 50 ms of frames in a row are refused.
        #[test]
        fn pipeline_time_only_goes_forward(
            first in any::<u64>(), dt in 0_u64..70_000, tick_hz in 1_u64..200_000_000, rate in 1_u32..50_000,
            steps in prop::collection::vec((any_step(), 1_usize..40), 1..40)
        ) {
            let mut time = TimeBase::new(tick_hz, rate);
            let (mut tick, mut index, mut host_us) = (first, 0_u32, 0_u64);
            let mut last: Option<(u64, u64)> = None;
            let mut refused_us: Option<u64> = None;
            for (step, frames) in steps {
                for k in 0..frames {
                    host_us += if matches!(step, Step::Burst) { 0 } else { 1000 };
                    match step {
                        Step::TickJump(by) if k == 0 => tick = tick.wrapping_add_signed(by),
                        Step::Tick(to) if k == 0 => tick = to,
                        Step::IndexJump(by) if k == 0 => index = index.wrapping_add_signed(by),
                        Step::Pause(us) if k == 0 => host_us += us,
                        _ => {}
                    }
                    time.frame(host_us);
                    let mut usable = false;
                    for row in 0..10 {
                        let stamp = time.row(index, tick.wrapping_add(row * dt));
                        index = index.wrapping_add(1);
                        let Some((t_us, at_us)) = last else {
                            (last, usable) = (Some((stamp.t.0, host_us)), true);
                            continue;
                        };
                        if !stamp.usable {
                            prop_assert_eq!(stamp.t.0, t_us);
                            continue;
                        }
                        usable = true;
                        prop_assert!(stamp.t.0 > t_us, "{} after {}", stamp.t.0, t_us);
                        let most_us = 3 * (host_us - at_us) + 2_000_000 + 2_100_000 + 2_000_000 / u64::from(rate);
                        prop_assert!(stamp.t.0 - t_us <= most_us, "{} us", stamp.t.0 - t_us);
                        last = Some((stamp.t.0, host_us));
                    }
                    let since = (!usable).then(|| refused_us.unwrap_or(host_us));
                    refused_us = since;
                    prop_assert!(since.is_none_or(|since| host_us - since <= 50_000 || matches!(step, Step::Pause(_))));
                    if !matches!(step, Step::Stop) {
                        tick = tick.wrapping_add(10 * dt);
                    }
                }
            }
        }
    }
}
