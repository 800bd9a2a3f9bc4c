//! The board's end of the link: what it offers, and the frames of its readings and slips.

use crate::notice::{self, Line};
use crate::sensor::{Sensor, Trouble};
use grip_link::{
    device::{DeviceConfig, DeviceConfigError, DeviceEvent, DeviceLink},
    frame::MAX_WIRE,
    message::{Channel, ChannelKind, Ident, Limits, Reaction, ResetReason, SampleFormat},
};

/// Lines of slips that wait for the port.
const WAITING: usize = 8;

/// One link with the frame that is being sent.
#[derive(Debug)]
pub struct End {
    sensor: &'static Sensor,
    link: DeviceLink,
    lines: [Option<Line>; WAITING],
    frame: [u8; MAX_WIRE],
    left: core::ops::Range<usize>,
    /// Readings that make a row: their mean is sent.
    readings_a_row: i32,
    sum: i32,
    summed: i32,
}

impl End {
    /// A link that waits for a host. `boot_id` is another one at every start.
    ///
    /// # Errors
    /// None with this IDENT; the link checks each.
    pub fn new(boot_id: u32, sensor: &'static Sensor) -> Result<Self, DeviceConfigError> {
        let mut link = DeviceLink::new(DeviceConfig {
            ident: ident(boot_id, sensor),
            estop: Reaction::Passive,
        })?;
        link.ready(0);
        Ok(Self {
            sensor,
            link,
            lines: [None; WAITING],
            frame: [0; MAX_WIRE],
            left: 0..0,
            readings_a_row: 1,
            sum: 0,
            summed: 0,
        })
    }

    /// Takes what the port gave, perhaps nothing.
    pub fn receive(&mut self, tick_us: u64, mut bytes: &[u8]) {
        while let Some(event) = self.link.receive(tick_us, &mut bytes) {
            if let DeviceEvent::Configured(config) = event {
                let readings = self.sensor.rate_hz / config.sample_rate_hz.max(1);
                self.readings_a_row = i32::try_from(readings).unwrap_or(1).max(1);
                (self.sum, self.summed) = (0, 0);
            }
        }
        // There is no actuator; the link wants to be asked all the same.
        let _ = self.link.drive(tick_us);
    }

    /// Takes a reading (steps).
    pub fn reading(&mut self, tick_us: u64, value: i16) {
        self.sum += i32::from(value);
        self.summed += 1;
        if self.summed < self.readings_a_row {
            return;
        }
        let mean = self.sum / self.summed;
        (self.sum, self.summed) = (0, 0);
        let format = self.link.in_force().map(|config| config.format);
        // A row that nobody wants now is none.
        let _ = match format {
            Some(SampleFormat::F32) => {
                self.link.push_f32(tick_us, &[mean as f32 * self.sensor.scale])
            }
            _ => self.link.push_i16(tick_us, &[mean as i16]),
        };
    }

    /// Takes a line of text; it goes out before the next samples. While nobody listens the newest ones are kept.
    pub fn line(&mut self, line: Line) {
        match self.lines.iter_mut().find(|line| line.is_none()) {
            Some(free) => *free = Some(line),
            None => {
                self.lines.rotate_left(1);
                if let Some(last) = self.lines.last_mut() {
                    *last = Some(line);
                }
            }
        }
    }

    /// Takes what went wrong at the sensor: rows that are missing are counted, a fault is latched until the host clears it.
    pub fn trouble(&mut self, tick_us: u64, trouble: Trouble) {
        if let Trouble::Lost(readings) = trouble {
            self.link.skip_rows(readings / self.readings_a_row.unsigned_abs());
        }
        // No row spans lost readings.
        (self.sum, self.summed) = (0, 0);
        if let Some(fault) = trouble.fault() {
            self.link.raise_fault(tick_us, fault);
        }
        self.line(notice::trouble(trouble));
    }

    /// Bytes that wait for the port; nothing where there is nothing to send.
    pub fn waiting(&mut self, tick_us: u64) -> &[u8] {
        if self.left.is_empty() {
            let length = self.next_frame(tick_us);
            self.left = 0..length.unwrap_or(0);
        }
        self.frame.get(self.left.clone()).unwrap_or(&[])
    }

    /// The port took so many of them.
    pub fn sent(&mut self, bytes: usize) {
        self.left.start = (self.left.start + bytes).min(self.left.end);
    }

    fn next_frame(&mut self, tick_us: u64) -> Option<usize> {
        if let Some(Some(line)) = self.lines.first() {
            let line = *line;
            let length = self.link.log(tick_us, line.level(), line.text(), &mut self.frame);
            // None without a host: the line waits for one.
            if length.is_some() {
                self.lines.rotate_left(1);
                if let Some(last) = self.lines.last_mut() {
                    *last = None;
                }
                return length;
            }
        }
        self.link.poll_transmit(tick_us, &mut self.frame)
    }
}

/// A vibration on one channel.
fn ident(boot_id: u32, sensor: &Sensor) -> Ident {
    let limits = Limits {
        rate_max_hz: sensor.rate_hz,
        // No actuator.
        force_max_mn: 0,
        slew_max_mn_s: 100_000,
        hold_cap_mn: 0,
        travel_min_um: 0,
        travel_max_um: 0,
    };
    let channel =
        Channel { unit: sensor.unit, ..Channel::single(ChannelKind::Stylus, sensor.scale) };
    Ident { reset: ResetReason::Unknown, ..Ident::new(sensor.uid, boot_id, limits, &[channel]) }
}
