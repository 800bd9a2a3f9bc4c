//! Health message of a live view, with the numbers of a daemon: what recordings do not hold.

use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::schema;

/// Figures of gripd, counted since its start; see the Health message for units. NaN where a value is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "as in the Health message")]
pub struct HealthRecord<'a> {
    pub rate_hz: f32,
    pub samples: u64,
    pub lost: u64,
    /// Too long, COBS, length, CRC, useless, gap.
    pub bad: [u32; 6],
    pub dropped_service: u64,
    pub dropped_recorder: u64,
    pub dropped_clients: u32,
    pub clients: u16,
    pub link: &'a str,
    pub recording: &'a str,
    pub recorded_bytes: u64,
    /// p50, p99, p99.9, largest.
    pub latency_us: [f32; 4],
    pub clock_offset_us: f64,
    pub clock_half_us: f32,
    /// Bands, gate, methods, observation.
    pub stages: [u64; 4],
    pub slips: u32,
    pub reconnects: u32,
    pub commands: u64,
}

impl<'a> HealthRecord<'a> {
    /// Name of its topic.
    pub const TOPIC: &'static str = "/gripper/health";
    /// Name of its schema.
    pub const SCHEMA: &'static str = "grip_msgs/msg/Health";

    /// The definition of its message, that of the time included.
    #[must_use]
    pub fn definition() -> String {
        schema::whole(include_str!("msg/Health.msg"))
    }

    /// Appends its message, stamped `stamp_ns` (since 1970), to `out`.
    pub fn encode(&self, stamp_ns: u64, out: &mut Vec<u8>) {
        let mut w = CdrWriter::new(out);
        w.time(stamp_ns).f32(self.rate_hz).u64(self.samples).u64(self.lost);
        for count in self.bad {
            w.u32(count);
        }
        w.u64(self.dropped_service).u64(self.dropped_recorder).u32(self.dropped_clients);
        w.u16(self.clients).text(self.link).text(self.recording).u64(self.recorded_bytes);
        for latency_us in self.latency_us {
            w.f32(latency_us);
        }
        w.f64(self.clock_offset_us).f32(self.clock_half_us);
        for count in self.stages {
            w.u64(count);
        }
        w.u32(self.slips).u32(self.reconnects).u64(self.commands);
    }

    /// Reads a message.
    ///
    /// # Errors
    /// Where the bytes are no such message.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let mut r = CdrReader::new(bytes)?;
        r.time()?;
        Ok(Self {
            rate_hz: r.f32()?,
            samples: r.u64()?,
            lost: r.u64()?,
            bad: [r.u32()?, r.u32()?, r.u32()?, r.u32()?, r.u32()?, r.u32()?],
            dropped_service: r.u64()?,
            dropped_recorder: r.u64()?,
            dropped_clients: r.u32()?,
            clients: r.u16()?,
            link: r.text()?,
            recording: r.text()?,
            recorded_bytes: r.u64()?,
            latency_us: [r.f32()?, r.f32()?, r.f32()?, r.f32()?],
            clock_offset_us: r.f64()?,
            clock_half_us: r.f32()?,
            stages: [r.u64()?, r.u64()?, r.u64()?, r.u64()?],
            slips: r.u32()?,
            reconnects: r.u32()?,
            commands: r.u64()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::HealthRecord;

    const ALL: HealthRecord<'static> = HealthRecord {
        rate_hz: 999.5,
        samples: 1,
        lost: 2,
        bad: [3, 4, 5, 6, 7, 8],
        dropped_service: 9,
        dropped_recorder: 10,
        dropped_clients: 11,
        clients: 12,
        link: "stream",
        recording: "off",
        recorded_bytes: 13,
        latency_us: [14.0, 15.0, 16.0, 17.0],
        clock_offset_us: -18.0,
        clock_half_us: 19.0,
        stages: [20, 21, 22, 23],
        slips: 24,
        reconnects: 25,
        commands: 26,
    };

    #[test]
    fn every_figure_comes_back_and_what_is_cut_off_is_reported() {
        let mut bytes = Vec::new();
        ALL.encode(1_500_000_001, &mut bytes);
        assert_eq!(HealthRecord::decode(&bytes), Ok(ALL));
        bytes.pop();
        assert!(HealthRecord::decode(&bytes).is_err());
    }

    #[test]
    fn the_message_has_a_field_for_each_figure() {
        let fields = crate::mcap::schema::fields(&HealthRecord::definition());
        assert_eq!((fields.len(), fields[1].as_str()), (30, "float32 rate_hz"), "{fields:?}");
        assert!(HealthRecord::definition().ends_with("int32 sec\nuint32 nanosec\n"));
    }
}
