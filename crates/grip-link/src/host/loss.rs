//! SAMPLES headers in, rows lost before each batch out.

use crate::message::SamplesHeader;

/// What is missing before a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Loss {
    /// Rows missing according to the row numbers.
    pub rows: u32,
    /// Of these, rows the MCU says it dropped; the others were lost on the wire.
    pub dropped_by_mcu: u32,
    /// The row numbers went back: the MCU counts afresh and nothing can be said about loss.
    pub restarted: bool,
}

impl Loss {
    /// Whether the batch continues the one before.
    #[must_use]
    pub const fn is_contiguous(&self) -> bool {
        self.rows == 0 && !self.restarted
    }
}

/// Sums since the link opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LossCount {
    /// Rows received.
    pub received: u64,
    /// Rows missing.
    pub lost: u64,
    /// Of these, dropped by the MCU.
    pub dropped_by_mcu: u64,
    /// Times the row numbers went back.
    pub restarts: u32,
}

/// Follows the row numbers of one boot.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RowCount {
    next: Option<(u32, u32)>,
    count: LossCount,
}

impl RowCount {
    /// Takes the next batch as the first of its kind.
    pub(crate) const fn restart(&mut self) {
        self.next = None;
    }

    pub(crate) const fn count(&self) -> LossCount {
        self.count
    }

    pub(crate) fn take(&mut self, header: &SamplesHeader) -> Loss {
        let SamplesHeader { first_index, rows, dropped_total, .. } = *header;
        let loss = self.next.map_or(Loss::default(), |(expected, dropped)| {
            let missing = first_index.wrapping_sub(expected);
            let restarted = missing > u32::MAX / 2;
            let rows = if restarted { 0 } else { missing };
            Loss { rows, dropped_by_mcu: dropped_total.wrapping_sub(dropped).min(rows), restarted }
        });
        self.next = Some((first_index.wrapping_add(u32::from(rows)), dropped_total));
        self.count.received += u64::from(rows);
        self.count.lost += u64::from(loss.rows);
        self.count.dropped_by_mcu += u64::from(loss.dropped_by_mcu);
        self.count.restarts = self.count.restarts.saturating_add(u32::from(loss.restarted));
        loss
    }
}
