//! The fingertips TSF-85 as an end: their bytes as datagrams of rows.

use super::line::{Condition, End};
use grip_robotiq::tsf85::{Checksum, Tsf85, Tsf85Config};
use std::os::unix::net::UnixDatagram;

/// Without a packet for longer than this (us) the sensor is silent.
const SILENT_US: u64 = 100_000;

/// The end.
#[derive(Debug)]
pub(super) struct Tsf85End {
    sensor: Tsf85,
    rows: UnixDatagram,
    streams: bool,
}

impl Tsf85End {
    pub(super) fn new(config: Tsf85Config, rows: UnixDatagram) -> Self {
        let sensor = Tsf85::new(config);
        // The socket has room for it: it is the first.
        let _sent = rows.send(sensor.header().as_bytes());
        Self { sensor, rows, streams: false }
    }
}

impl End for Tsf85End {
    fn opened(&mut self, _now_us: u64) {
        self.sensor.opened();
    }

    fn closed(&mut self, _now_us: u64) {
        self.streams = false;
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        let Self { sensor, rows, streams, .. } = self;
        let (mut taken, mut packed) = (Vec::new(), Vec::new());
        sensor.receive(now_us, bytes, |row| taken.push(*row));
        for row in &taken {
            sensor.pack(row, &mut packed);
            // What finds no room is missing, which its number shows.
            let _lost = rows.send(&packed);
            *streams = true;
        }
    }

    fn poll_transmit(&mut self, now_us: u64, out: &mut Vec<u8>) -> bool {
        let Some(request) = self.sensor.request(now_us) else { return false };
        out.clear();
        out.extend(request);
        true
    }

    fn condition(&self, now_us: u64) -> Condition {
        let counters = self.sensor.counters();
        if self.streams && now_us.saturating_sub(self.sensor.received_us()) < SILENT_US {
            return Condition::Ready;
        }
        let broken = counters.crc + counters.malformed + counters.garbage_bytes;
        Condition::Waiting(if broken > 0 && self.sensor.checksum() == Checksum::Unknown {
            "bytes come, but no packets of a TSF-85".to_owned()
        } else {
            "no samples of the chosen finger".to_owned()
        })
    }

    fn is_lost(&self) -> bool {
        false
    }

    fn note(&self) -> Option<&'static str> {
        (self.sensor.checksum() == Checksum::None).then_some(
            "its packets bear no checksum that is known: errors of the line look like vibration, and may raise the force; readings at the ends of the range are left out",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{End as _, Tsf85Config, Tsf85End, UnixDatagram};

    #[test]
    fn packets_that_cannot_be_checked_are_named() {
        let (rows, _board) = UnixDatagram::pair().unwrap();
        let mut end = Tsf85End::new(Tsf85Config::default(), rows);
        for n in 0..200 {
            end.receive(n, &[0x9A, 0x5A, 0x58, 3, 0x20, 1, 2]);
            assert_eq!(end.note().is_some(), n >= 63, "{n}");
        }
    }
}
