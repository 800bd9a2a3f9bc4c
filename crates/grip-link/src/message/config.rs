//! CONFIG and its answer: the sampling and the limits wanted, and those in force.

use super::bits::bits;
use super::wire::{PayloadError, Reader, Writer};
use super::{LossAction, SampleFormat};
use crate::crc::crc32c;
use slip_msg::{Wire, message};

message! {
    /// CONFIG (03), host to MCU, ACK_REQ; answered by CONFIG_ACK or NACK. It stops sampling and ends in state ARMED. A value outside its
    /// range is malformed, but for the life of commands and what lies above the limits of IDENT: these are clamped.
    #[derive(Eq)]
    Config {
        0 sample_rate_hz: u32, "Hz; 0 is malformed; clamped to slowest .. IDENT `rate_max_hz`, slowest = ceil(`tick_hz` / 65535), at most `rate_max_hz`", "Sampling.", in 1..;
        4 batch: u8, "rows of a SAMPLES, 1..255; 0 is malformed; fewer are sent when they do not fit", "Samples a batch.", in 1..;
        5 format: SampleFormat, "sample format; an unknown one is malformed", "Format of the rows.";
        6 ttl_ms: u16, "ms, life of a GRIP; clamped to 20..100", "Life of a GRIP command.";
        8 channel_mask: u32, "b0 = first channel of IDENT; bits of channels that do not exist or cannot be sent in `format` are cleared; none left = NACK MALFORMED", "Channels to send.";
        12 force_max_mn: i32, "mN, F_max; negative is malformed; clamped to IDENT `force_max_mn`", "Largest force.", in 0..;
        16 slew_mn_s: u32, "mN/s; 0 is malformed; clamped to IDENT `slew_max_mn_s`", "Fastest change of force.", in 1..;
        20 hold_cap_mn: i32, "mN, largest force held without commands; negative is malformed; clamped to IDENT `hold_cap_mn` and to F_max", "Largest force held without commands.", in 0..;
        24 loss_after_ms: u16, "ms of HOLD before the loss action; clamped to 100..60000", "Time in HOLD before the loss action.";
        26 loss_action: LossAction, "loss action; an unknown one is malformed", "The loss action.", reserved 1;
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

bits! {
    /// Which fields of CONFIG the MCU changed.
    Clamped(u8) {
        0 RATE "`sample_rate_hz`.",
        1 BATCH "`batch`; not set by a device of version 1.",
        2 MASK "`channel_mask`.",
        3 FORCE_MAX "`force_max_mn`.",
        4 SLEW "`slew_mn_s`.",
        5 TTL "`ttl_ms`.",
        6 HOLD_CAP "`hold_cap_mn`.",
        7 LOSS_AFTER "`loss_after_ms`.",
    }
}

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

message! {
    /// What stands before the CONFIG in force in CONFIG_ACK.
    #[derive(Eq)]
    ConfigAckHead {
        0 crc: u32, "CRC-32C of the payload bytes 8..35; another is malformed", "CRC-32C of the CONFIG that follows.";
        4 seq as "config_seq": u16, "seq of the CONFIG answered", "seq of the CONFIG answered.";
        6 clamped: Clamped, "clamped fields", "Fields that were changed.", reserved 1;
    }
}

/// CONFIG_ACK (83), MCU to host: its head, then the CONFIG in force.
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
    pub const SIZE: usize = ConfigAckHead::SIZE + Config::SIZE;

    /// Reads a payload and checks its CRC.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, a CRC that disagrees, or a CONFIG that cannot be.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let ConfigAckHead { crc, seq, clamped } = Wire::read(&mut r)?;
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
        let (crc, seq, clamped) = (self.config.checksum(), self.seq, self.clamped);
        let head = ConfigAckHead { crc, seq, clamped };
        self.config.append(head.append(Writer::new(out))).finish()
    }
}
