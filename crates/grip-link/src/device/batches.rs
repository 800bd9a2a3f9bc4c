//! Batches of rows as SAMPLES payloads; when nothing can be sent the oldest whole batch is dropped and counted.

use crate::frame::MAX_PAYLOAD;
use crate::message::{Config, SAMPLES_HEADER, SampleFormat, SamplesHeader};

/// Closed batches kept for sending: at most 4 ms of samples from 1 kHz on.
pub const KEPT_BATCHES: usize = 4;
const SLOTS: usize = KEPT_BATCHES + 1;

#[derive(Debug, Clone, Copy)]
struct Batch {
    payload: [u8; MAX_PAYLOAD],
    len: usize,
    header: SamplesHeader,
}

const EMPTY: SamplesHeader = SamplesHeader {
    first_index: 0,
    t0_tick: 0,
    dt_ticks: 1,
    rows: 0,
    format: SampleFormat::I16,
    dropped_total: 0,
};

#[derive(Debug, Clone)]
pub(crate) struct Batches {
    slots: [Batch; SLOTS],
    /// Slot of the oldest closed batch; the open one follows the closed ones.
    oldest: usize,
    closed: usize,
    next_index: u32,
    dropped_rows: u32,
    dropped_batches: u32,
    rows_a_batch: u8,
    row_bytes: usize,
    dt_ticks: u16,
    format: SampleFormat,
    longest_ticks: u64,
}

impl Batches {
    pub(crate) const fn new() -> Self {
        Self {
            slots: [Batch { payload: [0; MAX_PAYLOAD], len: SAMPLES_HEADER, header: EMPTY }; SLOTS],
            oldest: 0,
            closed: 0,
            next_index: 0,
            dropped_rows: 0,
            dropped_batches: 0,
            rows_a_batch: 1,
            row_bytes: 0,
            dt_ticks: 1,
            format: SampleFormat::I16,
            longest_ticks: 1,
        }
    }

    /// Starts with empty batches; row numbers and drop counts go on.
    pub(crate) fn configure(&mut self, config: &Config, row_bytes: usize, tick_hz: u32) {
        self.oldest = 0;
        self.closed = 0;
        self.open().header.rows = 0;
        self.open().len = SAMPLES_HEADER;
        self.format = config.format;
        self.row_bytes = row_bytes;
        let fitting = (MAX_PAYLOAD - SAMPLES_HEADER).checked_div(row_bytes).unwrap_or(1);
        self.rows_a_batch = config.batch.min(u8::try_from(fitting).unwrap_or(u8::MAX)).max(1);
        self.dt_ticks = u16::try_from(tick_hz / config.sample_rate_hz.max(1)).unwrap_or(u16::MAX);
        self.longest_ticks = u64::from(tick_hz / 1000);
    }

    pub(crate) const fn row_bytes(&self) -> usize {
        self.row_bytes
    }

    pub(crate) const fn format(&self) -> SampleFormat {
        self.format
    }

    pub(crate) const fn dropped_rows(&self) -> u32 {
        self.dropped_rows
    }

    pub(crate) const fn dropped_batches(&self) -> u32 {
        self.dropped_batches
    }

    fn open(&mut self) -> &mut Batch {
        let slot = (self.oldest + self.closed) % SLOTS;
        &mut self.slots[slot]
    }

    /// Appends a row of exactly `row_bytes` bytes.
    pub(crate) fn push(&mut self, tick: u64, row: impl Iterator<Item = u8>) {
        self.close_old(tick);
        let (index, dt_ticks, format) = (self.next_index, self.dt_ticks, self.format);
        self.next_index = index.wrapping_add(1);
        let row_bytes = self.row_bytes;
        let batch = self.open();
        if batch.header.rows == 0 {
            batch.header = SamplesHeader {
                first_index: index,
                t0_tick: tick,
                dt_ticks,
                rows: 0,
                format,
                dropped_total: 0,
            };
            batch.len = SAMPLES_HEADER;
        }
        let end = batch.len + row_bytes;
        for (slot, byte) in batch.payload.iter_mut().take(end).skip(batch.len).zip(row) {
            *slot = byte;
        }
        batch.len = end.min(MAX_PAYLOAD);
        batch.header.rows = batch.header.rows.saturating_add(1);
        if batch.header.rows >= self.rows_a_batch {
            self.close();
        }
    }

    /// Ends the open batch when its first row is 1 ms old.
    pub(crate) fn close_old(&mut self, tick: u64) {
        let longest = self.longest_ticks;
        let header = self.open().header;
        if header.rows > 0 && tick.saturating_sub(header.t0_tick) >= longest {
            self.close();
        }
    }

    /// Ends the open batch, where it has rows.
    pub(crate) fn flush(&mut self) {
        if self.open().header.rows > 0 {
            self.close();
        }
    }

    /// Leaves numbers out for rows that are lost.
    pub(crate) fn skip(&mut self, rows: u32) {
        self.flush();
        self.next_index = self.next_index.wrapping_add(rows);
        self.dropped_rows = self.dropped_rows.wrapping_add(rows);
    }

    fn close(&mut self) {
        self.closed += 1;
        if self.closed > KEPT_BATCHES {
            let lost = self.slots[self.oldest % SLOTS].header.rows;
            self.dropped_rows = self.dropped_rows.wrapping_add(u32::from(lost));
            self.dropped_batches = self.dropped_batches.saturating_add(1);
            self.forget_oldest();
        }
        self.open().header.rows = 0;
    }

    const fn forget_oldest(&mut self) {
        self.oldest = (self.oldest + 1) % SLOTS;
        self.closed -= 1;
    }

    /// The payload of the oldest closed batch, with the drops so far in its header.
    pub(crate) fn oldest(&mut self) -> Option<&[u8]> {
        if self.closed == 0 {
            return None;
        }
        let dropped_total = self.dropped_rows;
        let batch = &mut self.slots[self.oldest % SLOTS];
        SamplesHeader { dropped_total, ..batch.header }.write(&mut batch.payload).ok()?;
        batch.payload.get(..batch.len)
    }

    /// Removes the batch that [`Batches::oldest`] gave.
    pub(crate) fn sent(&mut self) {
        if self.closed > 0 {
            self.forget_oldest();
        }
    }
}
