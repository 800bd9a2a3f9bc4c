//! The ADXL345's driver on a bus that answers as written here, and the detector at a gap.

use core::convert::Infallible;
use embedded_hal::{
    delay::DelayNs,
    digital::{ErrorType as PinError, InputPin, OutputPin},
    spi::{ErrorType, SpiBus},
};
use slip_rp2040::{
    adxl345::Adxl345,
    detector::Detector,
    sensor::{ADXL345, Source, Trouble},
};

const FIFO_STATUS: u8 = 0x39;

/// A sensor that answers as itself, whose queue states that it holds `entries`, each 2 steps.
struct Bus {
    entries: u8,
}

impl ErrorType for Bus {
    type Error = Infallible;
}

impl SpiBus for Bus {
    fn transfer_in_place(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        let answer = match bytes[0] {
            0x80 => 0xE5,
            read if read == 0x80 | FIFO_STATUS => self.entries,
            0xF2 => 2,
            _ => 0,
        };
        bytes[1..].fill(0);
        bytes[1] = answer;
        Ok(())
    }
    fn read(&mut self, _: &mut [u8]) -> Result<(), Infallible> {
        Ok(())
    }
    fn write(&mut self, _: &[u8]) -> Result<(), Infallible> {
        Ok(())
    }
    fn transfer(&mut self, _: &mut [u8], _: &[u8]) -> Result<(), Infallible> {
        Ok(())
    }
    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

struct Wire;

impl PinError for Wire {
    type Error = Infallible;
}

impl OutputPin for Wire {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl InputPin for Wire {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(false)
    }
}

impl DelayNs for Wire {
    fn delay_ns(&mut self, _: u32) {}
}

#[test]
fn more_entries_than_fit_are_no_readings() {
    for (entries, trouble, readings) in
        [(33, None, 33), (34, Some(Trouble::Silent), 0), (0x7F, Some(Trouble::Silent), 0)]
    {
        let mut sensor = Adxl345::new(Bus { entries }, Wire, Wire, Wire);
        assert_eq!(sensor.look(0), None, "it is found");
        assert_eq!(sensor.look(11_000), trouble, "{entries} entries");
        let values: Vec<i16> =
            std::iter::from_fn(|| sensor.next()).map(|reading| reading.value).collect();
        assert_eq!(values, vec![2; readings], "{entries} entries");
        assert_eq!(sensor.is_dead(), trouble.is_some());
    }
}

#[test]
fn no_sample_spans_lost_readings() {
    let mut detector = Detector::new(&ADXL345).expect("its configuration is valid");
    assert!(detector.reading(0, 100).is_none());
    assert!(detector.reading(7, 2).is_none(), "the other half of this mean was lost");
    let sample = detector.reading(8, 4).expect("two readings in a row");
    assert_eq!(sample.t.0, ADXL345.time_us(8));
    assert_eq!(sample.stylus, 3.0);
}
