//! What a board measures with, and what its readings mean.

use grip_link::message::{FaultCode, Unit};

/// A sensor as the detector and the link see it.
#[derive(Debug)]
pub struct Sensor {
    /// Readings a second (Hz).
    pub rate_hz: u32,
    /// Time from one reading to the next, in halves of a microsecond.
    pub period_half_us: u32,
    /// Readings whose mean is a sample of the detector: a core without a unit for floats has no time for each of them.
    pub readings_a_sample: u16,
    /// Unit of the channel.
    pub unit: Unit,
    /// Unit per step.
    pub scale: f32,
    /// Identity of the board.
    pub uid: [u8; 16],
}

/// A piezo on the converter; steps about the middle of the supply.
pub const PIEZO: Sensor = Sensor {
    rate_hz: 10_000,
    period_half_us: 200,
    readings_a_sample: 8,
    unit: Unit::None,
    scale: 1.0,
    uid: *b"slip-rp2040-0001",
};

/// One axis of an ADXL345, 3.9 mg a step.
pub const ADXL345: Sensor = Sensor {
    rate_hz: 3200,
    period_half_us: 625,
    readings_a_sample: 2,
    unit: Unit::MetrePerSecond2,
    scale: 0.0039 * 9.806_65,
    uid: *b"slip-adxl345-001",
};

impl Sensor {
    /// Time of a reading since the first one (us).
    #[must_use]
    pub const fn time_us(&self, index: u64) -> u64 {
        index * self.period_half_us as u64 / 2
    }
}

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Its number since the first one, lost ones counted.
    pub index: u64,
    /// Time of the board (us).
    pub tick_us: u64,
    /// Steps.
    pub value: i16,
}

/// What went wrong at a sensor, or is right again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// Readings were overwritten before they were read.
    Lost(u32),
    /// It does not answer as itself; the byte is its identity as read.
    Absent(u8),
    /// It answers, and measures nothing.
    Silent,
    /// It answers and measures again.
    Back,
}

impl Trouble {
    /// The fault for the link, where it is one.
    #[must_use]
    pub const fn fault(self) -> Option<FaultCode> {
        match self {
            Self::Absent(_) | Self::Silent => Some(FaultCode::SENSOR_DEAD),
            Self::Lost(_) | Self::Back => None,
        }
    }
}

/// Readings of a sensor; the main loop calls both again and again.
pub trait Source {
    /// Looks at the sensor, which may take 1 ms.
    fn look(&mut self, now_us: u64) -> Option<Trouble>;
    /// The oldest reading that waits.
    fn next(&mut self) -> Option<Reading>;
    /// Whether it delivers nothing now.
    fn is_dead(&self) -> bool;
}
