//! CONFIG and its answer: the sampling and the limits wanted, and those in force.

use super::wire::{PayloadError, Reader, Writer};
use super::{LossAction, SampleFormat};
use crate::crc::crc32c;
use slip_msg::message;

message! {
    /// CONFIG (03), host to MCU, ACK_REQ; answered by CONFIG_ACK or NACK. It stops sampling and ends in state ARMED. A value outside its
    /// range is malformed, but for the life of commands and what lies above the limits of IDENT: these are clamped.
    #[derive(Eq)]
    Config {
        0 sample_rate_hz: u32, "Hz, 1..= IDENT's fastest", "Sampling.", in 1..;
        4 batch: u8, "1..=255; a batch also ends after 1 ms", "Samples a batch.", in 1..;
        5 format: SampleFormat, "", "Format of the rows.";
        6 ttl_ms: u16, "ms, 20..=100", "Life of a GRIP command.";
        8 channel_mask: u32, "bit 0 = first channel of IDENT", "Channels to send.";
        12 force_max_mn: i32, "mN, 0..= IDENT's largest", "Largest force.", in 0..;
        16 slew_mn_s: u32, "mN/s, 1..= IDENT's fastest", "Fastest change of force.", in 1..;
        20 hold_cap_mn: i32, "mN, 0..= F_max", "Largest force held without commands.", in 0..;
        24 loss_after_ms: u16, "ms, 100..=60000; usually 1000", "Time in HOLD before the loss action.";
        26 loss_action: LossAction, "", "The loss action.", reserved 1;
    }
}

impl Config {
    /// Shortest life of a command \[ms\].
    pub const TTL_MIN_MS: u16 = 20;
    /// Longest life of a command \[ms\].
    pub const TTL_MAX_MS: u16 = 100;

    /// The 28 payload bytes.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let mut bytes = [0; Self::SIZE];
        // The array has the size of the payload: `write` cannot run out of room.
        let _full = self.write(&mut bytes);
        bytes
    }

    /// CRC-32C of the 28 payload bytes, as in CONFIG_ACK.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        crc32c(&self.to_bytes())
    }
}

/// Which fields of CONFIG the MCU changed.
///
/// b0 rate, b1 batch, b2 mask, b3 F_max, b4 slew, b5 ttl, b6 hold cap, b7 loss delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Clamped(pub u8);

impl Clamped {
    /// Compares what was asked with what is in force.
    #[must_use]
    pub fn between(asked: &Config, given: &Config) -> Self {
        let differs = [
            asked.sample_rate_hz != given.sample_rate_hz,
            asked.batch != given.batch,
            asked.channel_mask != given.channel_mask,
            asked.force_max_mn != given.force_max_mn,
            asked.slew_mn_s != given.slew_mn_s,
            asked.ttl_ms != given.ttl_ms,
            asked.hold_cap_mn != given.hold_cap_mn,
            asked.loss_after_ms != given.loss_after_ms,
        ];
        Self(differs.iter().rev().fold(0, |bits, &differs| bits << 1 | u8::from(differs)))
    }

    /// Whether any field was changed.
    #[must_use]
    pub const fn any(self) -> bool {
        self.0 != 0
    }
}

/// CONFIG_ACK (83), MCU to host.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 4 | u32 | CRC-32C of bytes 8..36 | equals that of the CONFIG payload when nothing was clamped |
/// | 4 | 2 | u16 | seq of the CONFIG answered | |
/// | 6 | 1 | u8 | clamped fields | b0 rate, b1 batch, b2 mask, b3 F_max, b4 slew, b5 ttl, b6 hold cap, b7 loss delay |
/// | 7 | 1 | | reserved | 0 |
/// | 8 | 28 | | the CONFIG in force | [`Config`] |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConfigAck {
    /// seq of the CONFIG answered.
    pub seq: u16,
    /// Fields that were changed.
    pub clamped: Clamped,
    /// What is in force.
    pub config: Config,
}

impl ConfigAck {
    /// Bytes of the payload.
    pub const SIZE: usize = 36;

    /// Reads a payload and checks its CRC.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, a CRC that disagrees, or a CONFIG that cannot be.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let crc = r.u32()?;
        let seq = r.u16()?;
        let clamped = Clamped(r.u8()?);
        let _reserved = r.u8()?;
        let bytes = r.slice(Config::SIZE)?;
        if crc32c(bytes) != crc {
            return Err(PayloadError::Value { at: 0, value: i64::from(crc) });
        }
        Ok(Self { seq, clamped, config: Config::parse(bytes)? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u32(self.config.checksum()).u16(self.seq).u8(self.clamped.0).u8(0);
        w.put(&self.config.to_bytes()).finish()
    }
}
