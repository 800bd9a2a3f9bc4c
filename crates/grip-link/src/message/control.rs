//! The short messages: PING, PONG, HEARTBEAT, CLEAR_FAULT, ACK, NACK.

use super::FaultCode;
use super::wire::{PayloadError, Reader, Writer};
use super::{Kind, NackReason};

/// PING (06), host to MCU.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 8 | u64 | t1: host time of sending | us; the MCU only echoes it |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ping {
    /// Host time of sending \[us\].
    pub t1_us: u64,
}

impl Ping {
    /// Bytes of the payload.
    pub const SIZE: usize = 8;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        Ok(Self { t1_us: Reader::new(payload).u64()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        Writer::new(out).u64(self.t1_us).finish()
    }
}

/// PONG (86), MCU to host.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 8 | u64 | t1 of the PING | us of the host |
/// | 8 | 8 | u64 | rx_tick: the PING was received | ticks |
/// | 16 | 8 | u64 | tx_tick: the PONG was written | ticks |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pong {
    /// t1 of the PING \[us\].
    pub t1_us: u64,
    /// Tick of receiving.
    pub rx_tick: u64,
    /// Tick of sending.
    pub tx_tick: u64,
}

impl Pong {
    /// Bytes of the payload.
    pub const SIZE: usize = 24;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self { t1_us: r.u64()?, rx_tick: r.u64()?, tx_tick: r.u64()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        Writer::new(out).u64(self.t1_us).u64(self.rx_tick).u64(self.tx_tick).finish()
    }
}

/// HEARTBEAT (11), host to MCU: for the log and the watchdog; it does not refresh a GRIP.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 4 | u32 | turns of the hot loop | wraps |
/// | 4 | 4 | u32 | longest turn since the last HEARTBEAT | us, saturates |
/// | 8 | 2 | u16 | late turns since the last HEARTBEAT | saturates |
/// | 10 | 2 | u16 | flags | b0 degraded, others 0 |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heartbeat {
    /// Turns of the hot loop.
    pub turns: u32,
    /// Longest turn \[us\].
    pub longest_us: u32,
    /// Late turns.
    pub late: u16,
    /// b0 degraded.
    pub flags: u16,
}

impl Heartbeat {
    /// Bytes of the payload.
    pub const SIZE: usize = 12;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self { turns: r.u32()?, longest_us: r.u32()?, late: r.u16()?, flags: r.u16()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        Writer::new(out)
            .u32(self.turns)
            .u32(self.longest_us)
            .u16(self.late)
            .u16(self.flags)
            .finish()
    }
}

/// CLEAR_FAULT (13), host to MCU, ACK_REQ. It clears the named fault only, so that one nobody has seen yet stays; the
/// MCU is LINKED afterwards and must be configured again.
///
/// | offset | size | type | field | range |
/// |---|---|---|---|---|
/// | 0 | 2 | u16 | fault to clear | the latched [`FaultCode`]; another = NACK `OtherFault` |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClearFault {
    /// The fault the host has seen.
    pub fault: FaultCode,
}

impl ClearFault {
    /// Bytes of the payload.
    pub const SIZE: usize = 2;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        Ok(Self { fault: FaultCode(Reader::new(payload).u16()?) })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        Writer::new(out).u16(self.fault.0).finish()
    }
}

/// ACK (8E), MCU to host: START, STOP or CLEAR_FAULT was carried out.
///
/// | offset | size | type | field |
/// |---|---|---|---|
/// | 0 | 1 | u8 | type of the request |
/// | 1 | 1 | | reserved, 0 |
/// | 2 | 2 | u16 | seq of the request |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ack {
    /// Type of the request.
    pub kind: Kind,
    /// seq of the request.
    pub seq: u16,
}

impl Ack {
    /// Bytes of the payload.
    pub const SIZE: usize = 4;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let [kind, _] = r.take()?;
        Ok(Self { kind: Kind(kind), seq: r.u16()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        Writer::new(out).u8(self.kind.0).u8(0).u16(self.seq).finish()
    }
}

/// NACK (8F), MCU to host: a frame with ACK_REQ was refused.
///
/// | offset | size | type | field |
/// |---|---|---|---|
/// | 0 | 1 | u8 | type of the request |
/// | 1 | 1 | u8 | reason: [`NackReason`] code |
/// | 2 | 2 | u16 | seq of the request |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nack {
    /// Type of the request.
    pub kind: Kind,
    /// Why.
    pub reason: NackReason,
    /// seq of the request.
    pub seq: u16,
}

impl Nack {
    /// Bytes of the payload.
    pub const SIZE: usize = 4;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self { kind: Kind(r.u8()?), reason: NackReason::from_code(r.u8()?), seq: r.u16()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        Writer::new(out).u8(self.kind.0).u8(self.reason.code()).u16(self.seq).finish()
    }
}
