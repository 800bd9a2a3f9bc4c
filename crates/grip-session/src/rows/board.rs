//! Virtual board, sans-IO: frames to the host and the force for a gripper from bytes of rows and bytes of the host.

mod gripper;
mod ident;
mod line;

pub use gripper::{Actuator, GripperForce, GripperReading};

use super::{
    clock::{Placed, RowClock},
    cut::{CutError, RowCutter},
    header::{Header, HeaderError, RowFormat},
};
use core::time::Duration;
use grip_link::{
    device::{DeviceConfigError, DeviceEvent, DeviceLink, Drive},
    message::{DeviceState, FaultCode, GripMode},
};
use gripper::{Gripper, shows_force};
use ident::{device_config, milli};
use line::{Board, Times};

/// Longest header (bytes).
const HEADER: usize = 2048;
/// Rows after which times and rate are compared, and how many periods apart all of these are where the times are in another unit.
const COMPARED: u64 = 4;
const OTHER_UNIT: f64 = 10.0;
/// A row this far (us) ahead of the clock has a wrong time; nobody waits for it.
const LEAP_US: f64 = 10e6;
/// Rows in this time (us) that are all older than one before: their source has set its clock back.
const REFUSED_US: f64 = 1e6;
/// Reports of the same kind that are written out.
const WRITTEN_OUT: u64 = 3;

/// What is known before the first byte.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoardOptions {
    /// The gripper, where commands go back to the program.
    pub actuator: Option<Actuator>,
    /// Rows come as datagrams: they cannot wait, and can be lost.
    pub datagrams: bool,
}

/// Why there are no rows (any more).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RowsError {
    /// The header.
    #[error(transparent)]
    Header(#[from] HeaderError),
    /// The first row: nothing is known of the rest.
    #[error("{0}; so the header does not fit the rows")]
    First(#[source] CutError),
    /// The input ended before its first row.
    #[error("the input ended before its first row")]
    Empty,
    /// CSV without a time in datagrams.
    #[error("datagrams of CSV need t_s: a lost one cannot be noticed otherwise")]
    DatagramTime,
    /// Times that do not fit the rate.
    #[error(
        "the first rows are {by_time_s} s apart by t_s and {by_rate_s} s by rate=: is t_s in seconds?"
    )]
    Rate {
        /// By their times.
        by_time_s: f64,
        /// By the rate.
        by_rate_s: f64,
    },
    /// The columns make no board.
    #[error("the columns do not fit a frame of the link: {0}")]
    Board(#[from] DeviceConfigError),
}

/// What became of the rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowCounters {
    /// Rows taken.
    pub rows: u64,
    /// Rows that could not be read; each counts as lost too.
    pub bad: u64,
    /// Rows that were no newer than one before, and were left out.
    pub late: u64,
    /// Rows that did not arrive, by their times or numbers.
    pub missing: u64,
}

/// The board.
#[derive(Debug, Default)]
pub struct RowBoard {
    options: BoardOptions,
    header: Vec<u8>,
    cutter: Option<RowCutter>,
    board: Option<Board>,
    /// No more bytes come; and everything that came is cut.
    ended: bool,
    cut: bool,
    times: Times,
    /// A first row that could not be read: that of a stream that was joined in its middle.
    joined: Option<CutError>,
    counters: RowCounters,
    reports: Vec<String>,
    gripper: Gripper,
    /// A row with the force of that gripper.
    row: Vec<f32>,
}

impl RowBoard {
    /// A board that waits for its header.
    #[must_use]
    pub fn new(options: BoardOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// The gripper, where there is one.
    #[must_use]
    pub fn actuator(&self) -> Option<Actuator> {
        self.options.actuator
    }

    /// Sets what the gripper may be asked for. Without effect from the first row on.
    pub fn set_actuator(&mut self, actuator: Option<Actuator>) {
        if self.board.is_none() {
            self.options.actuator = actuator;
        }
    }

    /// What a gripper on a line of its own shows, or `None` where it cannot be commanded: rows that come meanwhile are missing ones.
    pub fn set_gripper(&mut self, now_us: u64, reading: Option<GripperReading>) {
        self.gripper.absent = reading.is_none();
        let Some(reading) = reading else {
            if let Some(board) = &mut self.board {
                board.sampling = false;
            }
            return;
        };
        self.gripper.reading = Some(reading);
        if let Some(board) = &mut self.board {
            let tick = board.clock.tick(now_us);
            board.link.report_motion(tick, reading.moving);
        }
    }

    /// Others have opened the fingers: the fault OBJECT_LOST is latched, so that nothing closes them before a client clears it.
    pub fn lose_object(&mut self, now_us: u64) {
        if let Some(board) = &mut self.board {
            let tick = board.clock.tick(now_us);
            board.link.raise_fault(tick, FaultCode::OBJECT_LOST);
        }
    }

    /// Whether the last command of the host is to open the fingers. [`RowBoard::drive`] alone does not show it: the loss of a host can
    /// be a reason to open, too.
    #[must_use]
    pub fn opens(&self) -> bool {
        self.gripper.opens
    }

    /// Bytes of input that can be taken now.
    #[must_use]
    pub fn room(&self) -> usize {
        self.cutter.as_ref().map_or(HEADER, RowCutter::room)
    }

    /// Whether there was a header.
    #[must_use]
    pub fn has_header(&self) -> bool {
        self.cutter.is_some()
    }

    /// What came so far was none of a source: the board waits for its header again.
    pub fn restart(&mut self) {
        if self.cutter.is_none() {
            self.header.clear();
            self.ended = false;
        }
    }

    /// Whether the first row is there: the host may call.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.board.is_some()
    }

    /// Whether the input has ended and all of it is on its way to the host.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let empty = |board: &Board| board.waiting.is_none() && board.unsent.is_empty();
        self.cut && self.board.as_ref().is_some_and(empty)
    }

    /// What became of the rows so far.
    #[must_use]
    pub fn counters(&self) -> RowCounters {
        self.counters
    }

    /// Sentences for people since the last call.
    pub fn take_reports(&mut self) -> Vec<String> {
        core::mem::take(&mut self.reports)
    }

    /// Takes bytes of a stream, at most [`RowBoard::room`].
    ///
    /// # Errors
    /// Where they begin with no header.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), RowsError> {
        if let Some(cutter) = &mut self.cutter {
            cutter.push(bytes);
            return Ok(());
        }
        let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else {
            self.header.extend_from_slice(bytes);
            let long = self.header.len() > HEADER;
            return if long { Err(HeaderError::NoText.into()) } else { Ok(()) };
        };
        let (line, rest) = bytes.split_at(end);
        self.header.extend_from_slice(line);
        self.begin()?;
        self.push(rest.get(1..).unwrap_or(&[]))
    }

    /// Takes one datagram: the header, or whole rows. Packed rows begin with the number of the first one, a u32 in little endian.
    /// The header may come again.
    ///
    /// # Errors
    /// Where the first one is no header.
    pub fn push_datagram(&mut self, bytes: &[u8]) -> Result<(), RowsError> {
        let Some(cutter) = &mut self.cutter else {
            self.push(bytes)?;
            return if self.cutter.is_some() { Ok(()) } else { self.begin() };
        };
        if let Err(what) = cutter.push_datagram(bytes) {
            self.report_bad(what);
        }
        Ok(())
    }

    /// No more bytes come.
    ///
    /// # Errors
    /// Where there was no header.
    pub fn end(&mut self) -> Result<(), RowsError> {
        if self.cutter.is_none() && !self.header.is_empty() {
            self.begin()?;
        }
        self.ended = true;
        if let Some(cutter) = &mut self.cutter {
            cutter.end();
        }
        Ok(())
    }

    fn begin(&mut self) -> Result<(), RowsError> {
        let line = core::mem::take(&mut self.header);
        let header: Header = str::from_utf8(&line).map_err(|_| HeaderError::NoText)?.parse()?;
        if self.options.datagrams && header.format == RowFormat::Csv && header.time.is_none() {
            return Err(RowsError::DatagramTime);
        }
        self.cutter = Some(RowCutter::new(header));
        Ok(())
    }

    /// Takes the rows that are there and may be taken now, and makes frames of them.
    ///
    /// # Errors
    /// Where the first row does not fit the header, times do not fit the rate, or the input ended before.
    pub fn turn(&mut self, now_us: u64) -> Result<(), RowsError> {
        if self.gripper.absent && self.board.is_some() {
            return self.leave_out(now_us);
        }
        while self.board.as_ref().is_none_or(Board::wants_rows) {
            let waits = self.board.as_ref().is_some_and(|board| board.waiting.is_some());
            if !waits && !self.cut_row(now_us)? {
                break;
            }
            if !self.take_row(now_us) {
                break;
            }
        }
        if let Some(board) = &mut self.board {
            board.link.flush_rows();
            board.transmit(now_us);
        }
        Ok(())
    }

    /// Rows that nobody waits for.
    fn leave_out(&mut self, now_us: u64) -> Result<(), RowsError> {
        let waits = |board: &mut Board| board.waiting.take().is_some();
        let mut more = self.board.as_mut().is_some_and(waits);
        while more || self.cut_row(now_us)? {
            more = false;
            self.counters.missing += 1;
            if let Some(board) = &mut self.board {
                board.waiting = None;
                board.link.skip_rows(1);
            }
        }
        Ok(())
    }

    /// Cuts the next row that can be used; `false` where none is there.
    fn cut_row(&mut self, now_us: u64) -> Result<bool, RowsError> {
        loop {
            let Some(cutter) = &mut self.cutter else { return self.none() };
            // Joined within its first time, a stream begins with a wrong one: the row after it must agree.
            let peeks = self.board.is_none() && !self.options.datagrams;
            let Some(row) = (if peeks { cutter.first_row() } else { cutter.next_row() }) else {
                return self.none();
            };
            let timed = cutter.time_s();
            let (number, period_us) = (cutter.row() - 1, cutter.header().period_us());
            match (row, self.board.is_some()) {
                // Twice: no cut row, but another unit.
                (Err(CutError::Time { time_s, next_s, .. }), false)
                    if matches!(self.joined, Some(CutError::Time { .. })) =>
                {
                    let (by_time_s, by_rate_s) = (next_s - time_s, 1e-6 * period_us);
                    return Err(RowsError::Rate { by_time_s, by_rate_s });
                }
                (Err(error), false) => {
                    let text = cutter.header().format == RowFormat::Csv;
                    if self.options.datagrams || self.joined.is_some() || !text {
                        return Err(RowsError::First(self.joined.take().unwrap_or(error)));
                    }
                    self.joined = Some(error);
                }
                (Err(error), true) => {
                    let is_timed = cutter.is_timed();
                    self.report_bad(&error.to_string());
                    if !is_timed {
                        self.skip(1);
                    }
                }
                (Ok(()), _) => {
                    let t_us = timed.map_or(number as f64 * period_us, |s| 1e6 * s);
                    if self.follows(now_us, t_us, timed.is_some())? {
                        self.wait(now_us)?;
                        return Ok(true);
                    }
                }
            }
        }
    }

    /// No row is there; where none comes any more, that is the end.
    fn none(&mut self) -> Result<bool, RowsError> {
        self.cut = self.ended;
        if !self.ended || self.board.is_some() {
            return Ok(false);
        }
        Err(self.joined.take().map_or(RowsError::Empty, RowsError::First))
    }

    /// Whether the row that was cut is newer than the one before; what is missing between them is counted.
    fn follows(&mut self, now_us: u64, t_us: f64, timed: bool) -> Result<bool, RowsError> {
        let Some(cutter) = &self.cutter else { return Ok(false) };
        let (row, period_us) = (cutter.row(), cutter.header().period_us());
        let is_first = self.board.is_none();
        let mut gap = (t_us + self.times.shift_us - self.times.last_us) / period_us;
        if !is_first && row <= COMPARED {
            let least = self.times.least.map_or(gap, |least| least.min(gap));
            self.times.least = Some(least);
            if row == COMPARED && least > OTHER_UNIT {
                let (by_time_s, by_rate_s) = (1e-6 * least * period_us, 1e-6 * period_us);
                return Err(RowsError::Rate { by_time_s, by_rate_s });
            }
        }
        if !is_first && gap <= 0.0 {
            self.counters.late += 1;
            if self.counters.late <= WRITTEN_OUT {
                let text = format!("row {row} is no newer than the one before and was left out");
                self.reports.push(text);
            }
            self.times.refused += 1;
            if f64::from(self.times.refused) * period_us < REFUSED_US {
                return Ok(false);
            }
            self.times.shift_us += (1.0 - gap) * period_us;
            self.reports
                .push(format!("t_s went back at row {row}; times go on from where they were"));
        }
        self.times.refused = 0;
        if let Some(board) = self.board.as_mut().filter(|_| timed) {
            let ahead_us = t_us + self.times.shift_us - board.clock.tick(now_us) as f64;
            if ahead_us > LEAP_US {
                self.times.shift_us -= (gap - 1.0) * period_us;
                gap = 1.0;
                let s = 1e-6 * ahead_us;
                let text =
                    format!("t_s is {s:.1} s ahead at row {row}; times go on from where they were");
                self.reports.push(text);
            }
        }
        self.times.last_us = t_us + self.times.shift_us;
        // Datagrams are lost one by one; in a stream only what a program left out is missing, and its times may be those of a loop.
        let (least, least_us) = if self.options.datagrams { (1.5, 0.0) } else { (10.0, 20_000.0) };
        if !is_first && timed && gap >= least && gap * period_us >= least_us {
            self.count_missing(row, gap.round() - 1.0);
        }
        Ok(true)
    }

    fn count_missing(&mut self, row: u64, missing: f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded")]
        let missing = missing.clamp(0.0, 1e9) as u32;
        if self.counters.missing == 0 {
            let text = format!(
                "{missing} rows are missing before row {row}; further ones are only counted"
            );
            self.reports.push(text);
        }
        self.counters.missing += u64::from(missing);
        self.skip(missing);
    }

    fn skip(&mut self, rows: u32) {
        if let Some(board) = &mut self.board {
            board.link.skip_rows(rows);
        }
    }

    /// Keeps the row until it may be taken; with the first one the board comes to life.
    fn wait(&mut self, now_us: u64) -> Result<(), RowsError> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1e18")]
        let tick = self.times.last_us.round() as u64;
        if let Some(board) = &mut self.board {
            board.waiting = Some(tick);
        } else if let Some(cutter) = &self.cutter {
            if let Some(error) = self.joined.take() {
                self.counters.bad += 1;
                self.reports
                    .push(format!("{error}; it is left out: the stream was joined in its middle"));
            }
            if let Some(limits) = cutter.header().limits() {
                self.options.actuator = None;
                self.reports.push(limits);
            }
            let mut link = DeviceLink::new(device_config(cutter.header(), &self.options))?;
            let holds_n = self.options.actuator.map_or(0.0, |actuator| actuator.holds_n);
            if holds_n > 0.0 {
                link.resume(milli(holds_n).cast_signed());
                self.gripper.lagged_n = holds_n;
            }
            link.ready(tick);
            // With a gripper no row waits: what waited would be old when it is answered.
            let waits = !self.options.datagrams && self.options.actuator.is_none();
            let clock = RowClock::new(now_us, tick, waits);
            self.board = Some(Board::new(link, clock, tick, now_us));
        }
        Ok(())
    }

    /// Gives the row that waits to the link; `false` where it is not time yet.
    fn take_row(&mut self, now_us: u64) -> bool {
        let Self { board: Some(board), cutter: Some(cutter), .. } = self else { return false };
        let Some(tick) = board.waiting.filter(|_| board.sampling) else { return false };
        let paced = board.clock.is_paced();
        let placed = board.clock.place(now_us, tick);
        if let Placed::Early(due_us) = placed {
            board.due_us = due_us;
            if !paced {
                let text = "rows come faster than rate= says: they wait, and run in real time";
                self.reports.push(text.to_owned());
            }
            return false;
        }
        board.waiting = None;
        let taken = if shows_force(cutter.header(), &self.options) {
            #[expect(clippy::cast_possible_truncation, reason = "a short time")]
            let dt_s = (1e-6 * cutter.header().period_us()) as f32;
            let force_n = self.gripper.force_n(dt_s);
            if force_n >= 0.0 {
                board.link.report_force(milli(force_n).cast_signed());
            }
            self.row.clear();
            self.row.extend(cutter.values().iter().copied().chain([force_n]));
            board.link.push_f32(tick, &self.row)
        } else {
            board.link.push_f32(tick, cutter.values())
        };
        self.counters.rows += u64::from(taken.is_ok());
        board.transmit(now_us);
        let pace = board.clock.wrong_pace().filter(|_| !cutter.is_timed());
        if let Some(pace) = pace
            && !core::mem::replace(&mut self.times.other_rate, true)
        {
            let rate_hz = cutter.header().rate_hz;
            let text = format!(
                "{:.0} rows come in a second, rate= says {rate_hz}: correct it, or send t_s",
                pace * rate_hz
            );
            self.reports.push(text);
        }
        if let Placed::After(late_us) = placed {
            board.jumped_us += late_us;
            let late_us = late_us as f64;
            self.times.shift_us += late_us;
            self.times.last_us += late_us;
            let why = pace.map_or("their source had stopped", |_| "their rate is another");
            let s = 1e-6 * late_us;
            let text = format!("rows stayed {s:.1} s late: {why}, and times go on from the clock");
            self.reports.push(text);
        }
        true
    }

    fn report_bad(&mut self, text: &str) {
        self.counters.bad += 1;
        if self.counters.bad <= WRITTEN_OUT {
            let last = if self.counters.bad == WRITTEN_OUT {
                "; further bad rows are only counted"
            } else {
                ""
            };
            self.reports.push(format!("{text}; it is left out{last}"));
        }
    }

    /// Takes bytes of the host.
    pub fn receive(&mut self, now_us: u64, mut bytes: &[u8]) {
        let Some(board) = &mut self.board else { return };
        let tick = board.clock.tick(now_us);
        while let Some(event) = board.link.receive(tick, &mut bytes) {
            match event {
                DeviceEvent::Started => board.sampling = !self.gripper.absent,
                DeviceEvent::Command(grip) => {
                    self.gripper.opens = GripMode::from_code(grip.mode) == Some(GripMode::Open);
                }
                DeviceEvent::Stopped | DeviceEvent::Configured(_) | DeviceEvent::Linked { .. } => {
                    board.sampling = false;
                }
                _ => {}
            }
        }
        board.transmit(now_us);
    }

    /// Time of the rows (us), and what a gripper is to do at it; `None` before there is a board, or without a gripper.
    pub fn drive(&mut self, now_us: u64) -> Option<(u64, Drive)> {
        let board = self.board.as_mut()?;
        let tick = board.clock.tick(now_us);
        let drive = board.link.drive(tick);
        self.options.actuator.map(|_| (tick.saturating_sub(board.jumped_us), drive))
    }

    /// Whether the host has stopped it, and has not cleared that.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.board.as_ref().is_some_and(|board| board.link.state() == DeviceState::Estop)
    }

    /// Bytes for the host.
    #[must_use]
    pub fn unsent(&self) -> &[u8] {
        self.board.as_ref().map_or(&[], |board| &board.unsent)
    }

    /// The host's line has taken so many bytes.
    pub fn sent(&mut self, count: usize) {
        if let Some(board) = &mut self.board {
            board.unsent.drain(..count.min(board.unsent.len()));
        }
    }

    /// How long nothing is to do, unless bytes come.
    #[must_use]
    pub fn pause(&self, now_us: u64, longest: Duration) -> Duration {
        let due_us =
            |board: &Board| board.waiting.filter(|_| board.wants_rows()).map(|_| board.due_us);
        self.board.as_ref().and_then(due_us).map_or(longest, |due_us| {
            longest.min(Duration::from_micros(due_us.saturating_sub(now_us)))
        })
    }
}

#[cfg(test)]
mod tests;
