//! A change of the slip state, or trouble with the sensor, as a line of text, for LOG.

use crate::sensor::Trouble;
use core::fmt::{self, Write};
use grip_link::message::LogLevel;
use slip_core::{Phase, SlipReport};

/// Most bytes of a line.
const ROOM: usize = 96;

/// A line without allocation; what does not fit is cut off.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    bytes: [u8; ROOM],
    used: usize,
    level: LogLevel,
}

impl Line {
    const EMPTY: Self = Self { bytes: [0; ROOM], used: 0, level: LogLevel::Info };

    /// How grave it is.
    #[must_use]
    pub const fn level(&self) -> LogLevel {
        self.level
    }

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

/// `sensor: identity 0x00, not 0xE5`, `sensor: 41 readings lost`.
#[must_use]
pub fn trouble(trouble: Trouble) -> Line {
    let level = if trouble.fault().is_some() { LogLevel::Error } else { LogLevel::Warn };
    let mut line = Line { level, ..Line::EMPTY };
    let _ = match trouble {
        Trouble::Lost(readings) => write!(line, "sensor: {readings} readings lost"),
        Trouble::Absent(identity) => {
            write!(line, "sensor: identity 0x{identity:02X}, not 0xE5")
        }
        Trouble::Silent => line.write_str("sensor: no readings"),
        Trouble::Back => line.write_str("sensor: found again"),
    };
    line
}
