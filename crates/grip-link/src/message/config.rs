//! CONFIG and its answer: the sampling and the limits wanted, and those in force.

use super::wire::{PayloadError, Reader, Writer};
use super::{LossAction, SampleFormat};
use crate::crc::crc32c;

/// CONFIG (03), host to MCU, ACK_REQ; answered by CONFIG_ACK or NACK. It stops sampling and ends in state ARMED.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 4 | u32 | sample rate | Hz, 1..= IDENT's fastest |
/// | 4 | 1 | u8 | samples a batch n | 1..=255; a batch also ends after 1 ms |
/// | 5 | 1 | u8 | format | [`SampleFormat`] code |
/// | 6 | 2 | u16 | ttl | ms, 20..=100 |
/// | 8 | 4 | u32 | channel mask | bit 0 = first channel of IDENT |
/// | 12 | 4 | i32 | F_max | mN, 0..= IDENT's largest; negative = NACK |
/// | 16 | 4 | u32 | slew | mN/s, 1..= IDENT's fastest |
/// | 20 | 4 | i32 | hold cap | mN, 0..= F_max; negative = NACK |
/// | 24 | 2 | u16 | loss action after | ms of HOLD, 100..=60000; usually 1000 |
/// | 26 | 1 | u8 | loss action | [`LossAction`] code |
/// | 27 | 1 | | reserved | 0 |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// Sampling \[Hz\].
    pub sample_rate_hz: u32,
    /// Samples a batch.
    pub batch: u8,
    /// Format of the rows.
    pub format: SampleFormat,
    /// Life of a GRIP command \[ms\].
    pub ttl_ms: u16,
    /// Channels to send.
    pub channel_mask: u32,
    /// Largest force \[mN\].
    pub force_max_mn: i32,
    /// Fastest change of force \[mN/s\].
    pub slew_mn_s: u32,
    /// Largest force held without commands \[mN\].
    pub hold_cap_mn: i32,
    /// Time in HOLD before the loss action \[ms\].
    pub loss_after_ms: u16,
    /// The loss action.
    pub loss_action: LossAction,
}

impl Config {
    /// Bytes of the payload.
    pub const SIZE: usize = 28;
    /// Shortest life of a command \[ms\].
    pub const TTL_MIN_MS: u16 = 20;
    /// Longest life of a command \[ms\].
    pub const TTL_MAX_MS: u16 = 100;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, an unknown format or loss action, a negative force, or zero for rate, batch or slew.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let config = Self {
            sample_rate_hz: r.u32()?,
            batch: r.coded(|n| (n > 0).then_some(n))?,
            format: r.coded(SampleFormat::from_code)?,
            ttl_ms: r.u16()?,
            channel_mask: r.u32()?,
            force_max_mn: r.i32()?,
            slew_mn_s: r.u32()?,
            hold_cap_mn: r.i32()?,
            loss_after_ms: r.u16()?,
            loss_action: r.coded(LossAction::from_code)?,
        };
        let _reserved = r.u8()?;
        let refuse = |at, value| Err(PayloadError::Value { at, value });
        match config {
            Self { sample_rate_hz: 0, .. } => refuse(0, 0),
            Self { force_max_mn: ..0, .. } => refuse(12, i64::from(config.force_max_mn)),
            Self { slew_mn_s: 0, .. } => refuse(16, 0),
            Self { hold_cap_mn: ..0, .. } => refuse(20, i64::from(config.hold_cap_mn)),
            _ => Ok(config),
        }
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out)
            .u32(self.sample_rate_hz)
            .u8(self.batch)
            .u8(self.format.code())
            .u16(self.ttl_ms);
        let w = w
            .u32(self.channel_mask)
            .i32(self.force_max_mn)
            .u32(self.slew_mn_s)
            .i32(self.hold_cap_mn);
        w.u16(self.loss_after_ms).u8(self.loss_action.code()).u8(0).finish()
    }

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
/// | 6 | 1 | u8 | clamped fields | [`Clamped`] |
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
