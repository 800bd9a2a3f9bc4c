//! An ADXL345 over SPI: 3200 readings a second out of its queue (FIFO).
//!
//! Registers and times are those of the data sheet (Analog Devices, ADXL345). At 3200 Hz the lowest bit of a reading is
//! always 0: a step of the converter is two steps of 3.9 mg.

use crate::sensor::{ADXL345, Reading, Source, Trouble};
use embedded_hal::{
    delay::DelayNs,
    digital::{InputPin, OutputPin},
    spi::SpiBus,
};

const DEVID: u8 = 0x00;
const BW_RATE: u8 = 0x2C;
const POWER_CTL: u8 = 0x2D;
const INT_ENABLE: u8 = 0x2E;
const INT_MAP: u8 = 0x2F;
const INT_SOURCE: u8 = 0x30;
const DATA_FORMAT: u8 = 0x31;
const DATAX0: u8 = 0x32;
const FIFO_CTL: u8 = 0x38;
const FIFO_STATUS: u8 = 0x39;

/// What DEVID reads.
const IDENTITY: u8 = 0xE5;
/// Readings in the queue that raise INT1: 2.5 ms, so that 7.5 ms are left before one is lost.
const WATERMARK: u8 = 8;
/// Most readings that wait: 32 in the queue, one at its end.
const MOST: usize = 33;
/// In this order: standby, an empty queue (what it held is old where the sensor was away), then rate (3200 Hz), range (full
/// resolution, 16 g: a step is 3.9 mg in every range, so a wide one costs nothing), queue (stream), INT1 (watermark),
/// measure.
const SETTINGS: [(u8, u8); 8] = [
    (POWER_CTL, 0x00),
    (FIFO_CTL, 0x00),
    (BW_RATE, 0x0F),
    (DATA_FORMAT, 0x0B),
    (FIFO_CTL, 0x80 | WATERMARK),
    (INT_MAP, 0x00),
    (INT_ENABLE, 0x02),
    (POWER_CTL, 0x08),
];
/// INT_SOURCE: a reading was overwritten.
const OVERRUN: u8 = 0x01;
/// The queue needs so long between two readings (us).
const BETWEEN_US: u32 = 5;
/// It is looked at so often where INT1 is not wired (us).
const LATEST_US: u64 = 5_000;
/// Without a reading for so long it is silent (us).
const SILENT_US: u64 = 20_000;
/// Time between two attempts to find it (us).
const AGAIN_US: u64 = 250_000;

/// The sensor, its wires and what was read from it. The x axis counts: it lies along the slip.
#[derive(Debug)]
pub struct Adxl345<Bus, Select, Int1, Delay> {
    bus: Bus,
    select: Select,
    int1: Int1,
    delay: Delay,
    /// Time of the first reading, once there was one.
    start_us: Option<u64>,
    /// Number of the next reading.
    index: u64,
    /// When the queue was read last, and when something was in it.
    drained_us: u64,
    alive_us: u64,
    again_us: u64,
    state: State,
    values: [i16; MOST],
    taken: usize,
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Not found yet.
    New,
    Measuring,
    /// It was reported as absent or silent.
    Dead,
}

impl<Bus: SpiBus, Select: OutputPin, Int1: InputPin, Delay: DelayNs>
    Adxl345<Bus, Select, Int1, Delay>
{
    /// A bus in mode 3 at 2 to 5 MHz, the pins CS and INT1, and a clock to wait by.
    pub const fn new(bus: Bus, select: Select, int1: Int1, delay: Delay) -> Self {
        Self {
            bus,
            select,
            int1,
            delay,
            start_us: None,
            index: 0,
            drained_us: 0,
            alive_us: 0,
            again_us: 0,
            state: State::New,
            values: [0; MOST],
            taken: 0,
            count: 0,
        }
    }

    /// One transfer. A bus of this chip cannot fail; where one does, the bytes are the command's, and DEVID shows it.
    fn transfer(&mut self, bytes: &mut [u8]) {
        let _ = self.select.set_low();
        let _ = self.bus.transfer_in_place(bytes);
        let _ = self.bus.flush();
        let _ = self.select.set_high();
    }

    fn read(&mut self, register: u8) -> u8 {
        let mut bytes = [0x80 | register, 0];
        self.transfer(&mut bytes);
        bytes[1]
    }

    /// Looks for it and sets it up.
    fn begin(&mut self, now_us: u64) -> Option<Trouble> {
        if now_us < self.again_us {
            return None;
        }
        let _ = self.select.set_high();
        let identity = self.read(DEVID);
        if identity != IDENTITY {
            return self.die(now_us, Trouble::Absent(identity));
        }
        for (register, value) in SETTINGS {
            self.transfer(&mut [register, value]);
        }
        let was_dead = self.state == State::Dead;
        self.state = State::Measuring;
        (self.drained_us, self.alive_us) = (now_us, now_us);
        // Time went on while it was away.
        if let Some(start_us) = self.start_us {
            self.index = self.index.max(readings_in(now_us.saturating_sub(start_us)));
        }
        was_dead.then_some(Trouble::Back)
    }

    fn die(&mut self, now_us: u64, trouble: Trouble) -> Option<Trouble> {
        let reported = self.state == State::Dead;
        self.state = State::Dead;
        self.again_us = now_us + AGAIN_US;
        (!reported).then_some(trouble)
    }

    /// Empties the queue. What it gave counts only where the sensor still answers as itself afterwards.
    fn drain(&mut self, now_us: u64) -> Option<Trouble> {
        let overrun = self.read(INT_SOURCE) & OVERRUN != 0;
        let reported = usize::from(self.read(FIFO_STATUS) & 0x7F);
        // More than fits is no answer of this sensor.
        let count = if reported > MOST { 0 } else { reported };
        for k in 0..count {
            let mut bytes = [0xC0 | DATAX0, 0, 0, 0, 0, 0, 0];
            self.transfer(&mut bytes);
            self.delay.delay_us(BETWEEN_US);
            if let Some(value) = self.values.get_mut(k) {
                *value = i16::from_le_bytes([bytes[1], bytes[2]]);
            }
        }
        let identity = self.read(DEVID);
        if identity != IDENTITY {
            return self.die(now_us, Trouble::Absent(identity));
        }
        if reported > MOST {
            return self.die(now_us, Trouble::Silent);
        }
        let passed_us = now_us.saturating_sub(self.drained_us);
        self.drained_us = now_us;
        if count == 0 {
            let silent = now_us.saturating_sub(self.alive_us) >= SILENT_US;
            return if silent { self.die(now_us, Trouble::Silent) } else { None };
        }
        self.alive_us = now_us;
        (self.taken, self.count) = (0, count);
        if self.start_us.is_none() {
            self.start_us = Some(now_us.saturating_sub(ADXL345.time_us(count as u64)));
        }
        if !overrun {
            return None;
        }
        // The sensor does not count them; the time that passed does, to a reading or two.
        let lost = readings_in(passed_us).saturating_sub(count as u64).max(1);
        self.index += lost;
        Some(Trouble::Lost(u32::try_from(lost).unwrap_or(u32::MAX)))
    }
}

impl<Bus: SpiBus, Select: OutputPin, Int1: InputPin, Delay: DelayNs> Source
    for Adxl345<Bus, Select, Int1, Delay>
{
    fn look(&mut self, now_us: u64) -> Option<Trouble> {
        if self.state != State::Measuring {
            return self.begin(now_us);
        }
        let due = self.int1.is_high().unwrap_or(true)
            || now_us.saturating_sub(self.drained_us) >= LATEST_US;
        // What was read is taken first.
        if due && self.taken == self.count { self.drain(now_us) } else { None }
    }

    fn next(&mut self) -> Option<Reading> {
        let value = *self.values.get(self.taken..self.count)?.first()?;
        self.taken += 1;
        let index = self.index;
        self.index += 1;
        let later = ADXL345.time_us((self.count - self.taken) as u64);
        Some(Reading { index, tick_us: self.drained_us.saturating_sub(later), value })
    }

    fn is_dead(&self) -> bool {
        self.state == State::Dead
    }
}

/// Readings in a time (us).
const fn readings_in(us: u64) -> u64 {
    us * 2 / ADXL345.period_half_us as u64
}
