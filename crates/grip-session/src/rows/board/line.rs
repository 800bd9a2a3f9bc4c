//! The link of a virtual board, its clock and the times of its rows: frames for the host, as far as they may wait.

use crate::rows::clock::RowClock;
use grip_link::{device::DeviceLink, frame::MAX_WIRE};

/// Bytes for the host that may wait before rows wait too.
const UNSENT: usize = 16 * 1024;

/// What there is from the first row on.
#[derive(Debug)]
pub(super) struct Board {
    pub(super) link: DeviceLink,
    pub(super) clock: RowClock,
    /// Whether the host wants rows.
    pub(super) sampling: bool,
    /// Time (us) of the row that was cut and not taken yet.
    pub(super) waiting: Option<u64>,
    /// Host time (us) at which it may be taken.
    pub(super) due_us: u64,
    /// How far (us) the clock is ahead of the times of rows, since their source stopped.
    pub(super) jumped_us: u64,
    pub(super) unsent: Vec<u8>,
}

/// Times of rows (us): as sent, and what is added to them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Times {
    pub(super) last_us: f64,
    /// The shortest time (periods) between two of the first rows.
    pub(super) least: Option<f64>,
    pub(super) shift_us: f64,
    pub(super) refused: u32,
    /// Another rate than that of the header was reported.
    pub(super) other_rate: bool,
}

impl Board {
    /// A board whose first row (us) waits.
    pub(super) fn new(link: DeviceLink, clock: RowClock, first_us: u64, now_us: u64) -> Self {
        Self {
            link,
            clock,
            sampling: false,
            waiting: Some(first_us),
            due_us: now_us,
            jumped_us: 0,
            unsent: Vec::new(),
        }
    }

    pub(super) fn wants_rows(&self) -> bool {
        self.sampling && self.unsent.len() <= UNSENT
    }

    /// Writes the frames that are due.
    pub(super) fn transmit(&mut self, now_us: u64) {
        let tick = self.clock.tick(now_us);
        let mut frame = [0; MAX_WIRE];
        while self.unsent.len() <= UNSENT
            && let Some(length) = self.link.poll_transmit(tick, &mut frame)
        {
            self.unsent.extend(frame.iter().take(length));
        }
    }
}
