//! HEALTH: figures of the daemon, every second.

use super::{LinkState, Recording};
use crate::message::wire::{PayloadError, Reader, Writer};

/// Blocks and frames of the gripper that were no good, by cause; all saturate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BadFrames {
    /// Longer than any frame.
    pub too_long: u32,
    /// Not COBS.
    pub cobs: u32,
    /// Length field disagrees.
    pub length: u32,
    /// Wrong checksum.
    pub crc: u32,
    /// Good frames that were of no use: echo, version, stale, duplicate, unknown, malformed.
    pub useless: u32,
    /// Frames missing by their numbers.
    pub gap: u32,
}

/// What found no room inside the daemon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// Items for the service thread.
    pub service: u64,
    /// Items for the recorder.
    pub recorder: u64,
    /// Frames for clients, of all clients together; saturates.
    pub clients: u32,
}

/// From the last byte of a frame to the command on the line, since the daemon's start (us).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Latency {
    /// Half of the frames were faster.
    pub p50_us: Option<f32>,
    /// 99 of 100 were faster.
    pub p99_us: Option<f32>,
    /// The slowest.
    pub max_us: Option<f32>,
}

/// Where the clock of the gripper stands against that of the daemon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockOffset {
    /// Host time minus device time of the newest sample (us).
    pub offset_us: i64,
    /// What that may be off: half of the shortest round trip (us).
    pub half_us: f32,
}

/// What was appended to HEALTH after its first version: daemons older than that do not send it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Appended {
    /// 999 of 1000 frames were faster (us).
    pub p999_us: Option<f32>,
    /// The clocks; `None` before the first answer of the gripper.
    pub clock: Option<ClockOffset>,
    /// Frames by their latency: see [`Appended::upper_ns`].
    pub histogram: [u64; Appended::BUCKETS],
}

/// HEALTH (A3), daemon to client. Counts are since the daemon's start.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 8 | u64 | host time since the daemon's start | us |
/// | 8 | 4 | f32 | sample rate measured | Hz |
/// | 12 | 8 | u64 | samples | |
/// | 20 | 8 | u64 | rows lost | |
/// | 28 | 24 | u32\[6\] | bad frames: too long, COBS, length, CRC, useless, gap | |
/// | 52 | 8 | u64 | items dropped before the service thread | |
/// | 60 | 8 | u64 | items dropped before the recorder | |
/// | 68 | 4 | u32 | frames dropped for clients | |
/// | 72 | 2 | u16 | clients | |
/// | 74 | 1 | u8 | [`LinkState`] code | |
/// | 75 | 1 | u8 | [`Recording`] code | |
/// | 76 | 12 | f32\[3\] | latency: p50, p99, largest | us |
/// | 88 | 8 | u64 | bytes recorded | |
/// | 96 | 32 | u64\[4\] | samples through bands, gate, methods, observation | |
/// | 128 | 4 | u32 | slips | |
/// | 132 | 4 | u32 | lines opened after the first | |
/// | 136 | 8 | u64 | force commands written | |
/// | 144 | 4 | f32 | latency: p99.9; from here on appended, and absent where an older daemon speaks | us |
/// | 148 | 4 | f32 | what the clock offset may be off | us |
/// | 152 | 8 | i64 | host time minus device time | us |
/// | 160 | 192 | u64\[24\] | frames by latency | |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Health {
    /// Host time (us since the daemon's start).
    pub host_us: u64,
    /// Sample rate measured (Hz).
    pub rate_hz: Option<f32>,
    /// Samples.
    pub samples: u64,
    /// Rows lost.
    pub lost: u64,
    /// Frames that were no good.
    pub bad: BadFrames,
    /// What found no room.
    pub dropped: Dropped,
    /// Clients connected.
    pub clients: u16,
    /// State of the link.
    pub link: LinkState,
    /// State of the recording.
    pub recording: Recording,
    /// From the last byte to the command.
    pub latency: Latency,
    /// Bytes recorded.
    pub recorded_bytes: u64,
    /// Samples that went through the bands of the detector, its gate, the other methods, and the measurement of slips.
    pub stages: [u64; 4],
    /// Slips.
    pub slips: u32,
    /// Lines opened after the first.
    pub reconnects: u32,
    /// Force commands written.
    pub commands: u64,
    /// What older daemons do not send.
    pub appended: Option<Appended>,
}

impl Default for Health {
    fn default() -> Self {
        Self {
            host_us: 0,
            rate_hz: None,
            samples: 0,
            lost: 0,
            bad: BadFrames::default(),
            dropped: Dropped::default(),
            clients: 0,
            link: LinkState::Closed,
            recording: Recording::Off,
            latency: Latency::default(),
            recorded_bytes: 0,
            stages: [0; 4],
            slips: 0,
            reconnects: 0,
            commands: 0,
            appended: None,
        }
    }
}

impl BadFrames {
    fn read(r: &mut Reader<'_>) -> Result<Self, PayloadError> {
        Ok(Self {
            too_long: r.u32()?,
            cobs: r.u32()?,
            length: r.u32()?,
            crc: r.u32()?,
            useless: r.u32()?,
            gap: r.u32()?,
        })
    }

    fn write<'a>(&self, w: Writer<'a>) -> Writer<'a> {
        let w = w.u32(self.too_long).u32(self.cobs).u32(self.length);
        w.u32(self.crc).u32(self.useless).u32(self.gap)
    }
}

impl Appended {
    /// Buckets of the histogram.
    pub const BUCKETS: usize = 24;
    /// Bytes of it in the payload.
    pub const SIZE: usize = 208;

    /// The latency (ns) below which the times of a bucket lie: 256 ns, and twice as much from each bucket to the next; the last one has no
    /// such bound.
    #[must_use]
    pub const fn upper_ns(bucket: usize) -> Option<u64> {
        if bucket + 1 < Self::BUCKETS { Some(256 << bucket) } else { None }
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, PayloadError> {
        let (p999_us, half_us, offset_us) = (r.maybe()?, r.maybe()?, r.i64()?);
        let clock = half_us.map(|half_us| ClockOffset { offset_us, half_us });
        let mut histogram = [0; Self::BUCKETS];
        for count in &mut histogram {
            *count = r.u64()?;
        }
        Ok(Self { p999_us, clock, histogram })
    }

    fn write<'a>(&self, w: Writer<'a>) -> Writer<'a> {
        let half_us = self.clock.map(|clock| clock.half_us);
        let offset_us = self.clock.map_or(0, |clock| clock.offset_us);
        let w = w.maybe(self.p999_us).maybe(half_us).i64(offset_us);
        self.histogram.iter().fold(w, |w, count| w.u64(*count))
    }
}

impl Health {
    /// Bytes of the payload without what was appended.
    pub const SIZE: usize = 144;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, or an infinite number.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let (host_us, rate_hz) = (r.u64()?, r.maybe()?);
        let (samples, lost) = (r.u64()?, r.u64()?);
        let bad = BadFrames::read(&mut r)?;
        let dropped = Dropped { service: r.u64()?, recorder: r.u64()?, clients: r.u32()? };
        let clients = r.u16()?;
        let [link, recording] = r.take()?;
        let health = Self {
            host_us,
            rate_hz,
            samples,
            lost,
            bad,
            dropped,
            clients,
            link: LinkState::from_code(link),
            recording: Recording::from_code(recording),
            latency: Latency { p50_us: r.maybe()?, p99_us: r.maybe()?, max_us: r.maybe()? },
            recorded_bytes: r.u64()?,
            stages: [r.u64()?, r.u64()?, r.u64()?, r.u64()?],
            slips: r.u32()?,
            reconnects: r.u32()?,
            commands: r.u64()?,
            appended: None,
        };
        // All of it or nothing: what a reader knows of a longer payload is at its beginning.
        let whole = payload.len() >= Self::SIZE + Appended::SIZE;
        let appended = if whole { Some(Appended::read(&mut r)?) } else { None };
        Ok(Self { appended, ..health })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u64(self.host_us).maybe(self.rate_hz);
        let w = self.bad.write(w.u64(self.samples).u64(self.lost));
        let w = w.u64(self.dropped.service).u64(self.dropped.recorder).u32(self.dropped.clients);
        let w = w.u16(self.clients).u8(self.link.code()).u8(self.recording.code());
        let Latency { p50_us, p99_us, max_us } = self.latency;
        let w = w.maybe(p50_us).maybe(p99_us).maybe(max_us).u64(self.recorded_bytes);
        let [bands, gate, methods, observation] = self.stages;
        let w = w.u64(bands).u64(gate).u64(methods).u64(observation);
        let w = w.u32(self.slips).u32(self.reconnects).u64(self.commands);
        match &self.appended {
            Some(appended) => appended.write(w).finish(),
            None => w.finish(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Appended, ClockOffset, Health};
    use crate::message::PayloadError;

    #[test]
    fn a_payload_of_an_older_daemon_lacks_what_was_appended_and_a_longer_one_is_read() {
        let clock = Some(ClockOffset { offset_us: -1_234_567_890_123, half_us: 40.5 });
        let mut histogram = [0; Appended::BUCKETS];
        histogram[7] = u64::MAX;
        let appended = Some(Appended { p999_us: Some(250.0), clock, histogram });
        let health = Health { samples: 5, appended, ..Health::default() };
        let mut bytes = [0xEE; 400];
        let len = health.write(&mut bytes).unwrap();
        assert_eq!(len, Health::SIZE + Appended::SIZE);
        for more in [len, len + 1, 400] {
            assert_eq!(Health::parse(&bytes[..more]), Ok(health));
        }
        let first = Health { appended: None, ..health };
        for less in [Health::SIZE, Health::SIZE + 1, len - 1] {
            assert_eq!(Health::parse(&bytes[..less]), Ok(first));
        }
        let short = Health::parse(&bytes[..Health::SIZE - 1]);
        assert!(matches!(short, Err(PayloadError::Short { .. })), "{short:?}");
        assert_eq!(first.write(&mut bytes), Ok(Health::SIZE));
    }

    #[test]
    fn buckets_double_up_to_a_second_and_the_last_has_no_end() {
        assert_eq!((Appended::upper_ns(0), Appended::upper_ns(22)), (Some(256), Some(1 << 30)));
        assert_eq!((Appended::upper_ns(23), Appended::upper_ns(99)), (None, None));
    }
}
