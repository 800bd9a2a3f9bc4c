//! HEALTH: figures of the daemon, every second.

use crate::wire::{PayloadError, Reader, Writer};
use crate::{Field, LinkState, Recording, Wire, message};

message! {
    /// Blocks and frames of the gripper that were no good, by cause; all saturate.
    #[derive(Eq, Default)]
    BadFrames {
        0 too_long: u32, "blocks, as in STATS", "Longer than any frame.";
        4 cobs: u32, "blocks", "Not COBS.";
        8 length: u32, "blocks", "Length field disagrees.";
        12 crc: u32, "blocks", "Wrong checksum.";
        16 useless: u32, "frames: echo, version, stale, duplicate, unknown, malformed", "Good frames that were of no use: echo, version, stale, duplicate, unknown, malformed.";
        20 gap: u32, "frames missing", "Frames missing by their numbers.";
    }
}

message! {
    /// What found no room inside the daemon.
    #[derive(Eq, Default)]
    Dropped {
        0 service as "dropped_service": u64, "items that the control loop could not pass to the other threads", "Items for the service thread.";
        8 recorder as "dropped_recorder": u64, "things that the recorder did not get", "Items for the recorder.";
        16 clients as "dropped_clients": u32, "frames dropped for slow clients, of all together", "Frames for clients, of all clients together.";
    }
}

message! {
    /// From the last byte of a frame to the command on the line, since the daemon's start.
    #[derive(Default)]
    Latency {
        0 p50_us as "p50": Option<f32>, "us, from the last byte of a frame to the command on the line", "Half of the frames were faster.";
        4 p99_us as "p99": Option<f32>, "us", "99 of 100 were faster.";
        8 max_us as "longest": Option<f32>, "us", "The slowest.";
    }
}

/// Where the clock of the gripper stands against that of the daemon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockOffset {
    /// Host time minus device time of the newest sample (us).
    pub offset_us: i64,
    /// What that may be off: half of the shortest round trip (us).
    pub half_us: f32,
}

/// What the offset may be off, an f32 that is NaN before it is known, and the offset, an i64.
impl<'a> Wire<'a> for Option<ClockOffset> {
    const SIZE: usize = 12;
    const TYPE: &'static str = "f32 i64";

    fn read(r: &mut Reader<'a>) -> Result<Self, PayloadError> {
        let (half_us, offset_us) = (r.maybe()?, r.i64()?);
        Ok(half_us.map(|half_us| ClockOffset { offset_us, half_us }))
    }

    fn append(self, w: Writer<'_>) -> Writer<'_> {
        w.maybe(self.map(|clock| clock.half_us)).i64(self.map_or(0, |clock| clock.offset_us))
    }
}

message! {
    /// What was appended to HEALTH after its first version: daemons older than that do not send it.
    #[derive(Default)]
    Appended {
        0 p999_us as "p999": Option<f32>, "us, latency as `p50`", "999 of 1000 frames were faster.";
        4 clock as "clock_half clock_offset": Option<ClockOffset>, "us, what `clock_offset` may be off: half of the shortest round trip; NaN = the clocks are not known | us, host time minus device time of the newest sample; 0 where it is not known", "Half of the shortest round trip, NaN before the first answer of the gripper; host time minus device time of the newest sample.";
        16 histogram: [u64; Appended::BUCKETS], "frames by latency: number k, from 0, counts those below 256 * 2^k ns that no number before counts; the last one all longer ones", "Frames by their latency: below 256 ns, and below twice as much from each bucket to the next; the last has no bound.";
    }
}

impl Appended {
    /// Buckets of the histogram.
    pub const BUCKETS: usize = 24;

    /// The latency (ns) below which the times of a bucket lie: 256 ns, and twice as much from each bucket to the next; the last one has no
    /// such bound.
    #[must_use]
    pub const fn upper_ns(bucket: usize) -> Option<u64> {
        if bucket + 1 < Self::BUCKETS { Some(256 << bucket) } else { None }
    }
}

/// All of it or nothing: what a reader knows of a longer payload is at its beginning.
impl<'a> Wire<'a> for Option<Appended> {
    const SIZE: usize = 0;
    const TYPE: &'static str = "";
    const FIELDS: &'static [Field] = Appended::FIELDS;

    fn read(r: &mut Reader<'a>) -> Result<Self, PayloadError> {
        if r.rest() < Appended::SIZE { Ok(None) } else { Wire::read(r).map(Some) }
    }

    fn append(self, w: Writer<'_>) -> Writer<'_> {
        if let Some(appended) = self { Wire::append(appended, w) } else { w }
    }
}

message! {
    /// HEALTH (A3), daemon to client. Counts are since the daemon's start.
    #[derive(Default)]
    Health {
        0 host_us: u64, "us since the daemon's start", "Host time since the daemon's start.";
        8 rate_hz as "rate": Option<f32>, "Hz, measured", "Sample rate measured.";
        12 samples: u64, "rows", "Samples.";
        20 lost: u64, "rows", "Rows lost.";
        28 bad: BadFrames, "", "Frames that were no good.";
        52 dropped: Dropped, "", "What found no room.";
        72 clients: u16, "connected", "Clients connected.";
        74 link: LinkState, "link state", "State of the link.";
        75 recording: Recording, "recording state", "State of the recording.";
        76 latency: Latency, "", "From the last byte to the command.";
        88 recorded_bytes as "recorded": u64, "bytes", "Recorded.";
        96 stages as "bands gate methods observation": [u64; 4], "samples that went through the bands of the detector | samples that also went through the gate against own motion | readings of travel and taxels that were looked at | samples of slips that were measured", "Samples that went through the bands of the detector, its gate, the other methods, and the measurement of slips.";
        128 slips: u32, "slips", "Slips.";
        132 reconnects: u32, "lines opened after the first", "Lines opened after the first.";
        136 commands: u64, "force commands written", "Force commands written.";
        144 appended: Option<Appended>, "", "What older daemons do not send.";
    }
}

#[cfg(test)]
mod tests {
    use super::{Appended, ClockOffset, Health};
    use crate::PayloadError;

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
