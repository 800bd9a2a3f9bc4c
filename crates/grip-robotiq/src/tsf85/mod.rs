//! Decoder of the bytes of a TSF-85: one numbered row of samples a millisecond.
//!
//! The hub streams what it measures of up to four fingers once a period, after one command ([`Tsf85::request`]). A row is complete with the
//! dynamic channel of the chosen finger: that, 28 taxels, and where it is wanted the length of the acceleration. Rows are numbered by
//! the time stamps of the device where it sends any, and else by their order, lost ones and pauses left out.

mod packet;

pub use packet::{Checksum, PacketCounters};

use packet::{Cut, Cutter, Kind, records};

/// Taxels of a finger.
pub const TAXELS: usize = 28;
/// Ends of the range of the dynamic channel (counts): readings from here on are saturated, or errors of a line without a checksum.
pub const RAIL: f32 = 32_767.0;
/// Rows a second, and the time from row to row (us).
pub const RATE_HZ: u32 = 1000;
const PERIOD_US: u64 = 1000;
const PERIOD_MS: u8 = 1;
/// A pause longer than this (us) is made of rows that are missing.
const PAUSE_US: u64 = 20_000;
/// A sensor that is silent for this long (us) is asked again.
const ASK_US: u64 = 500_000;
/// Time stamps that go further forward than this (ms) are none.
const FORWARD_MS: u16 = 30_000;

/// Which signals make a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tsf85Config {
    /// The finger, 0 to 3.
    pub finger: u8,
    /// Whether the length of the finger's acceleration is sent too, as motion reference. It shows slips as well, so it is not for
    /// fingers that are hard.
    pub reference: bool,
}

/// A row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its number: one more a period.
    pub number: u32,
    /// The dynamic channel, in counts.
    pub dynamic: f32,
    /// The taxels in counts; NaN where none came since the last row.
    pub taxels: [f32; TAXELS],
    /// Length of the acceleration in counts; NaN as for taxels.
    pub acceleration: f32,
}

/// The sensor.
#[derive(Debug)]
pub struct Tsf85 {
    config: Tsf85Config,
    cutter: Cutter,
    row: Row,
    /// Bytes of a packet with the dynamic channel.
    size: usize,
    /// Such packets that could not be used since the last row.
    broken: u32,
    /// Time stamp of the last row, and the newest.
    stamps: (Option<u16>, Option<u16>),
    /// When the last row came (us), once one did.
    came_us: Option<u64>,
    received_us: u64,
    asked_us: Option<u64>,
}

impl Tsf85 {
    /// A sensor that was not asked yet.
    #[must_use]
    pub fn new(config: Tsf85Config) -> Self {
        Self {
            config,
            cutter: Cutter::new(),
            row: Row {
                number: 0,
                dynamic: f32::NAN,
                taxels: [f32::NAN; TAXELS],
                acceleration: f32::NAN,
            },
            size: 0,
            broken: 0,
            stamps: (None, None),
            came_us: None,
            received_us: 0,
            asked_us: None,
        }
    }

    /// The first line of the rows, as other programs send it.
    #[must_use]
    pub fn header(&self) -> String {
        let taxels: String = (0..TAXELS).map(|taxel| format!(",pressure_{taxel}")).collect();
        let reference = if self.config.reference { ",reference" } else { "" };
        format!("vibration{taxels}{reference},rate={RATE_HZ},format=f32")
    }

    /// `row` as a packed row with its number.
    pub fn pack(&self, row: &Row, out: &mut Vec<u8>) {
        out.clear();
        out.extend(row.number.to_le_bytes());
        out.extend(row.dynamic.to_le_bytes());
        out.extend(row.taxels.iter().flat_map(|value| value.to_le_bytes()));
        if self.config.reference {
            out.extend(row.acceleration.to_le_bytes());
        }
    }

    /// The order to stream, where it is due: at the start, and again while nothing comes.
    pub fn request(&mut self, now_us: u64) -> Option<[u8; 5]> {
        let quiet_us = now_us.saturating_sub(self.received_us);
        let due = self
            .asked_us
            .is_none_or(|asked_us| quiet_us > ASK_US && now_us.saturating_sub(asked_us) > ASK_US);
        if !due {
            return None;
        }
        self.asked_us = Some(now_us);
        Some([0x9A, 0x00, 0x58, 1, PERIOD_MS])
    }

    /// The line was opened anew: the sensor is asked again, and numbers go on with the time that has passed.
    pub fn opened(&mut self) {
        self.cutter.reset();
        self.asked_us = None;
        self.stamps = (None, None);
        self.broken = 0;
    }

    /// What was read.
    #[must_use]
    pub fn counters(&self) -> PacketCounters {
        self.cutter.counters()
    }

    /// Whether packets have a checksum that is checked.
    #[must_use]
    pub fn checksum(&self) -> Checksum {
        self.cutter.checksum()
    }

    /// When (us) the last packet came.
    #[must_use]
    pub fn received_us(&self) -> u64 {
        self.received_us
    }

    /// Takes bytes, and hands complete rows to `take`.
    pub fn receive(&mut self, now_us: u64, bytes: &[u8], mut take: impl FnMut(&Row)) {
        let Self { config, cutter, row, size, broken, stamps, came_us, received_us, .. } = self;
        cutter.push(bytes);
        while let Some(cut) = cutter.next() {
            let packet = match cut {
                Cut::Packet(packet) => packet,
                Cut::Broken(bytes) => {
                    *broken += u32::from(bytes == *size);
                    continue;
                }
            };
            *received_us = now_us;
            let mut complete = false;
            for record in records(packet) {
                match record.kind {
                    Kind::Time => stamps.1 = record.unsigned().next(),
                    _ if record.finger != config.finger => {}
                    Kind::Dynamic => {
                        row.dynamic = record.signed().next().map_or(f32::NAN, f32::from);
                        complete = true;
                    }
                    Kind::Taxels => {
                        for (taxel, value) in row.taxels.iter_mut().zip(record.unsigned()) {
                            *taxel = f32::from(value);
                        }
                    }
                    Kind::Acceleration => {
                        let square: f32 = record.signed().map(|axis| f32::from(axis).powi(2)).sum();
                        row.acceleration = square.sqrt();
                    }
                    Kind::Rotation | Kind::Magnetic | Kind::Temperature => {}
                }
            }
            if complete {
                *size = packet.len() + 4;
                if let Some(before_us) = came_us.replace(now_us) {
                    let pause_us = now_us.saturating_sub(before_us);
                    row.number =
                        row.number.wrapping_add(steps(stamps.0, stamps.1, pause_us, *broken));
                }
                (*stamps, *broken) = ((stamps.1, stamps.1), 0);
                take(row);
                (row.taxels, row.acceleration) = ([f32::NAN; TAXELS], f32::NAN);
            }
        }
    }
}

/// Periods from one row to the next: by time stamps, else one and what is known to be missing.
fn steps(before: Option<u16>, now: Option<u16>, pause_us: u64, broken: u32) -> u32 {
    if let (Some(before), Some(now)) = (before, now) {
        let passed_ms = now.wrapping_sub(before);
        if (1..FORWARD_MS).contains(&passed_ms) {
            return u32::from(passed_ms) / u32::from(PERIOD_MS);
        }
    }
    let paused = if pause_us > PAUSE_US { pause_us / PERIOD_US } else { 1 };
    u32::try_from(paused).unwrap_or(u32::MAX).max(1 + broken)
}

#[cfg(test)]
mod tests {
    use super::{Row, Tsf85, Tsf85Config};
    use proptest::prelude::*;

    fn packet(records: &[u8]) -> Vec<u8> {
        let length = u8::try_from(records.len()).unwrap();
        [&[0x9A, 0, 0x58, length], records].concat()
    }

    fn record(kind: u8, finger: u8, values: &[u16]) -> Vec<u8> {
        let first = [kind << 4 | finger << 2];
        let values = values.iter().flat_map(|value| value.to_be_bytes());
        first.into_iter().chain(values).collect()
    }

    /// What the hub sends in a period, by its data rate of 160 bytes: taxels of both fingers, then dynamic channels and motion.
    fn set(dynamic: [i16; 2]) -> Vec<u8> {
        let taxels = |finger: u8| packet(&record(1, finger, &[u16::from(finger) + 100; 28]));
        let rest = [0, 1].map(|finger| {
            let dynamic = dynamic[usize::from(finger)].cast_unsigned();
            [
                record(2, finger, &[dynamic]),
                record(3, finger, &[3, 0, 4]),
                record(4, finger, &[0; 3]),
            ]
            .concat()
        });
        [taxels(0), taxels(1), packet(&rest.concat())].concat()
    }

    fn rows(sensor: &mut Tsf85, now_us: u64, bytes: &[u8]) -> Vec<Row> {
        let mut rows = Vec::new();
        sensor.receive(now_us, bytes, |row| rows.push(*row));
        rows
    }

    #[test]
    fn a_set_is_one_row_of_the_chosen_finger() {
        assert_eq!(set([0, 0]).len(), 160);
        let mut sensor = Tsf85::new(Tsf85Config { finger: 1, reference: true });
        assert_eq!(sensor.request(0), Some([0x9A, 0, 0x58, 1, 1]));
        assert_eq!(sensor.request(1000), None);
        let got = rows(&mut sensor, 2000, &[set([5, -7]), set([6, -8])].concat());
        assert_eq!(
            got.iter().map(|row| (row.number, row.dynamic)).collect::<Vec<_>>(),
            [(0, -7.0), (1, -8.0)]
        );
        assert_eq!((got[0].taxels[27], got[1].acceleration), (101.0, 5.0));
        let mut packed = Vec::new();
        sensor.pack(&got[1], &mut packed);
        assert_eq!(packed.len(), 4 + 4 * 30);
        assert_eq!(sensor.header().split(',').count(), 2 + 30);
    }

    #[test]
    fn numbers_go_on_over_broken_packets_pauses_and_time_stamps() {
        let mut sensor = Tsf85::new(Tsf85Config::default());
        rows(&mut sensor, 1000, &set([1, 1]));
        let mut wrong = set([2, 2]);
        wrong[122 + 4] = 0xF0;
        assert_eq!(rows(&mut sensor, 2000, &wrong).len(), 0);
        assert_eq!(rows(&mut sensor, 3000, &set([3, 3]))[0].number, 2);
        let got = rows(&mut sensor, 503_000, &set([4, 4]));
        assert_eq!(got[0].number, 502, "half a second without the sensor");
        let stamped = |ms: u16| [packet(&record(7, 0, &[ms])), set([0, 0])].concat();
        rows(&mut sensor, 504_000, &stamped(65_534));
        let got = rows(&mut sensor, 504_100, &stamped(2));
        assert_eq!(got[0].number, 507, "four milliseconds, over the end of 16 bits");
        let lost = &set([9, 9])[61..];
        assert!(rows(&mut sensor, 505_000, lost)[0].taxels[0].is_nan(), "no taxels came");
    }

    #[test]
    fn a_silent_sensor_is_asked_again() {
        let mut sensor = Tsf85::new(Tsf85Config::default());
        assert!(sensor.request(0).is_some());
        rows(&mut sensor, 400_000, &set([0, 0]));
        assert!(sensor.request(800_000).is_none());
        assert!(sensor.request(901_000).is_some() && sensor.request(1_000_000).is_none());
        sensor.opened();
        assert!(sensor.request(1_000_100).is_some());
    }

    proptest! {
        #[test]
        fn any_bytes_in_any_pieces_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..600), cut in 1_usize..80) {
            let mut sensor = Tsf85::new(Tsf85Config::default());
            let mut last = None;
            for piece in bytes.chunks(cut) {
                for row in rows(&mut sensor, 0, piece) {
                    prop_assert!(last.is_none_or(|last| row.number > last));
                    last = Some(row.number);
                }
            }
            let all = set([1, 2]);
            let found = (0..2).any(|_| !rows(&mut sensor, 0, &all).is_empty());
            prop_assert!(found, "packets are found again");
        }
    }
}
