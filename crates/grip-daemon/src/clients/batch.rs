//! Batches of samples as payloads of ROWS: built once for all clients that want every n-th sample.

use grip_link::frame::MAX_PAYLOAD;
use grip_link::message::MAX_ELEMENTS;
use grip_link::message::daemon::{ROWS_HEADER, RowSet, RowsHeader};
use slip_core::Sample;

/// Rows wait at most so long for the batch to fill (us).
pub(super) const AGE_US: u64 = 10_000;

/// A sample as it came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    pub(super) host_us: u64,
    pub(super) index: u32,
    pub(super) sample: &'a Sample,
    pub(super) taxels: &'a [f32],
}

/// The batch under way for one decimation.
#[derive(Debug)]
pub(super) struct Batch {
    header: RowsHeader,
    payload: [u8; MAX_PAYLOAD],
    len: usize,
    since_us: u64,
    /// A payload that is complete, while its successor grows.
    done: [u8; MAX_PAYLOAD],
    done_len: usize,
}

impl Batch {
    pub(super) const fn new(every_nth: u16) -> Self {
        let header = RowsHeader {
            first_index: 0,
            t0_us: 0,
            every_nth,
            channels: RowSet::STYLUS,
            rows: 0,
            taxels: 0,
        };
        Self {
            header,
            payload: [0; MAX_PAYLOAD],
            len: ROWS_HEADER,
            since_us: 0,
            done: [0; MAX_PAYLOAD],
            done_len: 0,
        }
    }

    pub(super) const fn every_nth(&self) -> u16 {
        self.header.every_nth
    }

    /// Whether a row of this number belongs in it.
    pub(super) const fn wants(&self, index: u32) -> bool {
        index.is_multiple_of(self.header.every_nth as u32)
    }

    /// The next pipeline may have other channels.
    pub(super) const fn begin(&mut self) {
        self.header.channels = RowSet::STYLUS;
        self.header.taxels = 0;
    }

    /// Adds a row; the payload of the batch before it where that one is complete.
    pub(super) fn push(&mut self, row: &Row<'_>) -> Option<&[u8]> {
        let full = !self.continues(row) && self.finish();
        if self.header.rows == 0 {
            self.header.channels = RowSet(self.header.channels.0 | channels(row.sample).0);
            self.header.taxels = self.header.taxels.max(taxels(row));
            self.header.first_index = row.index;
            self.header.t0_us = row.sample.t.0;
            self.since_us = row.host_us;
        }
        self.append(row);
        if full { self.done.get(..self.done_len) } else { None }
    }

    /// The payload of the rows so far, where the first of them has waited long enough.
    pub(super) fn due(&mut self, host_us: u64) -> Option<&[u8]> {
        let old = host_us.saturating_sub(self.since_us) >= AGE_US;
        if old && self.finish() { self.done.get(..self.done_len) } else { None }
    }

    /// The payload of the rows so far.
    pub(super) fn flush(&mut self) -> Option<&[u8]> {
        if self.finish() { self.done.get(..self.done_len) } else { None }
    }

    /// Whether a row may stand behind those there are.
    fn continues(&self, row: &Row<'_>) -> bool {
        let header = &self.header;
        let rows = u32::from(header.rows);
        let next = header.first_index.wrapping_add(rows * u32::from(header.every_nth));
        let after = row.sample.t.0.checked_sub(header.t0_us);
        rows > 0
            && usize::from(header.rows) < header.room().min(255)
            && row.index == next
            && after.is_some_and(|after| u32::try_from(after).is_ok())
            && channels(row.sample).0 & !header.channels.0 == 0
            && taxels(row) <= header.taxels
    }

    fn append(&mut self, row: &Row<'_>) {
        let size = self.header.row_bytes();
        let Some(room) = self.payload.get_mut(self.len..self.len + size) else { return };
        let after = row.sample.t.0.wrapping_sub(self.header.t0_us);
        let after = u32::try_from(after).unwrap_or(u32::MAX);
        let (words, _) = room.as_chunks_mut::<4>();
        let Some((time, values)) = words.split_first_mut() else { return };
        *time = after.to_le_bytes();
        let (fixed, array) = values.split_at_mut(self.header.channels.len());
        let wanted = self.header.channels.0;
        let readings = row.sample.readings();
        let chosen = readings.iter().enumerate().filter(|(bit, _)| wanted >> bit & 1 == 1);
        for (slot, (_, value)) in fixed.iter_mut().zip(chosen) {
            *slot = value.unwrap_or(f32::NAN).to_le_bytes();
        }
        let missing = core::iter::repeat(&f32::NAN);
        for (slot, value) in array.iter_mut().zip(row.taxels.iter().chain(missing)) {
            *slot = value.to_le_bytes();
        }
        self.len += size;
        self.header.rows += 1;
    }

    /// Closes the batch; `false` where it is empty.
    fn finish(&mut self) -> bool {
        let (len, rows) = (self.len, self.header.rows);
        self.len = ROWS_HEADER;
        if rows == 0 || self.header.write(&mut self.payload).is_err() {
            return false;
        }
        self.header.rows = 0;
        self.done = self.payload;
        self.done_len = len;
        true
    }
}

fn taxels(row: &Row<'_>) -> u8 {
    u8::try_from(row.taxels.len()).unwrap_or(u8::MAX).min(MAX_ELEMENTS)
}

/// The channels that a sample has; [`RowSet`] has the order of its readings.
fn channels(sample: &Sample) -> RowSet {
    let there = sample.readings().map(|value| u16::from(value.is_some()));
    RowSet(there.iter().rev().fold(0, |set, bit| set << 1 | bit))
}

#[cfg(test)]
mod tests {
    use super::{Batch, Row};
    use grip_link::message::daemon::{RowSet, Rows};
    use slip_core::{Sample, units::Micros};

    fn stylus(index: u32) -> f32 {
        f32::from(u16::try_from(index).unwrap())
    }

    fn sample(index: u32) -> Sample {
        let normal_force_n = index.is_multiple_of(2).then_some(2.5);
        let t = Micros(u64::from(index) * 101);
        Sample { normal_force_n, ..Sample::stylus(t, stylus(index)) }
    }

    /// Number, time, stylus and force of every row of some payloads.
    fn read(payloads: &[Vec<u8>]) -> Vec<(u32, u64, f32, bool)> {
        let rows = payloads.iter().flat_map(|payload| {
            let rows = Rows::parse(payload).unwrap();
            rows.iter().collect::<Vec<_>>()
        });
        let value = |row: &grip_link::message::daemon::RowOfSample<'_>, channel| row.value(channel);
        rows.map(|row| {
            let force = value(&row, RowSet::NORMAL_FORCE).is_some_and(f32::is_finite);
            (row.index, row.t_us, value(&row, RowSet::STYLUS).unwrap(), force)
        })
        .collect()
    }

    fn run(every_nth: u16, indices: impl Iterator<Item = u32>, taxels: &[f32]) -> Vec<Vec<u8>> {
        let mut batch = Batch::new(every_nth);
        let mut payloads = Vec::new();
        for index in indices.filter(|index| index % u32::from(every_nth) == 0) {
            let sample = sample(index);
            let row = Row { host_us: 0, index, sample: &sample, taxels };
            payloads.extend(batch.push(&row).map(<[u8]>::to_vec));
        }
        payloads.extend(batch.flush().map(<[u8]>::to_vec));
        assert_eq!(batch.flush(), None);
        payloads
    }

    #[test]
    fn every_row_comes_once_with_its_own_number_and_time() {
        for every_nth in [1, 3, 10] {
            let lost = |index: &u32| !(400..420).contains(index);
            let payloads = run(every_nth, (0..1000).filter(lost), &[]);
            let wanted: Vec<_> = (0..1000)
                .filter(lost)
                .filter(|index| index % u32::from(every_nth) == 0)
                .map(|i| (i, u64::from(i) * 101, stylus(i), i % 2 == 0))
                .collect();
            assert_eq!(read(&payloads), wanted);
        }
    }

    #[test]
    fn full_batches_fill_their_frames_and_arrays_fit() {
        let payloads = run(1, 0..1000, &[]);
        assert!(payloads.len() <= 1000 / 38 + 2, "{}", payloads.len());
        let payloads = run(1, 0..4, &[7.0; 64]);
        let rows = Rows::parse(&payloads[0]).unwrap();
        assert_eq!((payloads.len(), rows.header.taxels), (4, 64));
        let row = rows.iter().next().unwrap();
        assert_eq!((row.taxel(63), row.taxel(64)), (Some(7.0), None));
    }

    #[test]
    fn rows_do_not_wait_for_ever() {
        let mut batch = Batch::new(1);
        let sample = sample(0);
        batch.push(&Row { host_us: 5, index: 0, sample: &sample, taxels: &[] });
        assert_eq!(batch.due(5 + super::AGE_US - 1), None);
        assert!(batch.due(5 + super::AGE_US).is_some());
        assert_eq!(batch.due(u64::MAX), None);
    }
}
