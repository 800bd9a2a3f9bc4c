//! A change of the slip state as a line of text, for LOG.

use core::fmt::{self, Write};
use slip_core::{Phase, SlipReport};

/// Most bytes of a line.
const ROOM: usize = 96;

/// A line without allocation; what does not fit is cut off.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    bytes: [u8; ROOM],
    used: usize,
}

impl Line {
    const EMPTY: Self = Self { bytes: [0; ROOM], used: 0 };

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        self.bytes.get(..self.used).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("")
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = self.bytes.get_mut(self.used..).ok_or(fmt::Error)?;
        for (to, from) in room.iter_mut().zip(text.bytes()) {
            *to = from;
            self.used += 1;
        }
        Ok(())
    }
}

/// `slip gross at 1234500 us, statistic 2.41`: the time is that of the reading, counted from the first one.
#[must_use]
pub fn line(slip: &SlipReport) -> Line {
    let phase = match slip.phase {
        Phase::Incipient => "incipient",
        Phase::Gross => "gross",
        Phase::Ended => "ended",
        _ => "changed",
    };
    let mut line = Line::EMPTY;
    // Hundredths as an integer: formatting floats would take 10 kB of flash.
    let hundredths = (slip.statistic.unwrap_or(0.0).clamp(0.0, 1e6) * 100.0) as u32;
    let (whole, part) = (hundredths / 100, hundredths % 100);
    let _ = write!(line, "slip {phase} at {} us, statistic {whole}.{part:02}", slip.t.0);
    line
}
