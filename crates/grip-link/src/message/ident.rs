//! HELLO and IDENT: who is there, what it can do, and whether it is the same boot as before.

use super::FaultCode;
use super::wire::{PayloadError, Reader, Writer};
use super::{ChannelKind, SampleFormat, Unit};
use super::{DeviceState, ResetReason};
use core::fmt;

/// Most channels a gripper describes.
pub const MAX_CHANNELS: usize = 16;

/// Most elements of a channel, the taxels of an array.
pub const MAX_ELEMENTS: u8 = 64;

/// One channel of IDENT.
///
/// | offset | size | type | field | range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | kind | [`ChannelKind`] code |
/// | 1 | 1 | u8 | unit | [`Unit`] code |
/// | 2 | 1 | u8 | formats | b0 i16, b1 f32; the formats in which it can be sent |
/// | 3 | 1 | u8 | count | elements a row, 1..=64; 1 except for an array |
/// | 4 | 4 | f32 | scale | unit per i16 step, finite and > 0 |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// What it measures.
    pub kind: ChannelKind,
    /// Unit after scaling.
    pub unit: Unit,
    /// b0 i16, b1 f32.
    pub formats: u8,
    /// Elements a row.
    pub count: u8,
    /// Unit per i16 step.
    pub scale: f32,
}

impl Channel {
    /// Bytes of an entry.
    pub const SIZE: usize = 8;

    /// A channel of one element in its own unit that can be sent in both formats.
    #[must_use]
    pub const fn single(kind: ChannelKind, scale: f32) -> Self {
        Self { kind, unit: kind.unit(), formats: 3, count: 1, scale }
    }

    /// Whether it can be sent in `format`.
    #[must_use]
    pub const fn offers(&self, format: SampleFormat) -> bool {
        self.formats & (1 << format.code()) != 0
    }

    /// Whether count and scale are in their ranges: a host refuses any other.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        self.count_is_possible() && self.scale_is_possible()
    }

    pub(crate) fn count_is_possible(&self) -> bool {
        (1..=MAX_ELEMENTS).contains(&self.count)
    }

    pub(crate) fn scale_is_possible(&self) -> bool {
        self.scale.is_finite() && self.scale > 0.0
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, PayloadError> {
        Ok(Self {
            kind: ChannelKind::from_code(reader.u8()?),
            unit: Unit::from_code(reader.u8()?),
            formats: reader.u8()?,
            count: reader.u8()?,
            scale: reader.f32()?,
        })
    }

    pub(crate) fn write<'a>(&self, writer: Writer<'a>) -> Writer<'a> {
        writer
            .u8(self.kind.code())
            .u8(self.unit.code())
            .u8(self.formats)
            .u8(self.count)
            .f32(self.scale)
    }
}

/// A range of protocol versions: payload bytes 0 and 1 of HELLO and IDENT, SUBSCRIBE and WELCOME, in every version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Versions {
    /// Lowest version spoken.
    pub min: u8,
    /// Highest version spoken.
    pub max: u8,
}

impl Versions {
    /// What this crate speaks.
    pub const OURS: Self = Self { min: crate::PROTOCOL, max: crate::PROTOCOL };

    /// Highest version that both speak.
    #[must_use]
    pub fn common(self, peer: Self) -> Option<u8> {
        let best = self.max.min(peer.max);
        (best >= self.min && best >= peer.min).then_some(best)
    }

    /// Reads the first two bytes of a HELLO or IDENT of any version.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        Self::read(&mut Reader::new(payload))
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, PayloadError> {
        Ok(Self { min: reader.u8()?, max: reader.u8()? })
    }
}

/// HELLO (01), host to MCU, ACK_REQ; the header carries the new session nonce, 1..=65535. Answered by IDENT. The MCU
/// forgets the CONFIG before, holds the force it has, and is LINKED.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | lowest protocol version | 0..=15 |
/// | 1 | 1 | u8 | highest protocol version | 0..=15 |
/// | 2 | 2 | u16 | longest payload the host takes | bytes, 480 |
/// | 4 | 4 | u32 | capabilities | no bit defined: 0 |
/// | 8 | 8 | u64 | host time | us, monotonic, for the log |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hello {
    /// Protocol range.
    pub versions: Versions,
    /// Longest payload the host takes.
    pub max_rx: u16,
    /// Capability bits.
    pub caps: u32,
    /// Host time \[us\].
    pub time_us: u64,
}

impl Hello {
    /// Bytes of the payload.
    pub const SIZE: usize = 16;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let versions = Versions::parse(payload)?;
        let mut r = Reader::at_offset(payload, 2);
        Ok(Self { versions, max_rx: r.u16()?, caps: r.u32()?, time_us: r.u64()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u8(self.versions.min).u8(self.versions.max);
        w.u16(self.max_rx).u32(self.caps).u64(self.time_us).finish()
    }
}

/// What the hardware allows; CONFIG is clamped to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Fastest sampling \[Hz\], >= 1.
    pub rate_max_hz: u32,
    /// Largest force \[mN\], > 0.
    pub force_max_mn: i32,
    /// Fastest change of force \[mN/s\], > 0.
    pub slew_max_mn_s: u32,
    /// Largest force held without commands \[mN\], 0..=force_max.
    pub hold_cap_mn: i32,
    /// Travel of the fingers: lower end \[um\].
    pub travel_min_um: i32,
    /// Travel of the fingers: upper end \[um\].
    pub travel_max_um: i32,
}

/// Firmware version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Firmware {
    /// Major.
    pub major: u8,
    /// Minor.
    pub minor: u8,
    /// Patch.
    pub patch: u16,
}

impl fmt::Display for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// IDENT (81), MCU to host: the answer to HELLO. With session 0 it says that the MCU has no session: sent at most every
/// 100 ms, in answer to a frame of an unknown session.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | lowest protocol version | 0..=15 |
/// | 1 | 1 | u8 | highest protocol version | 0..=15 |
/// | 2 | 2 | u16 | longest payload the MCU takes | bytes, >= 64 |
/// | 4 | 4 | u32 | capabilities | no bit defined: 0 |
/// | 8 | 16 | u8\[16\] | uid | the same at every start |
/// | 24 | 4 | u32 | boot_id | another at every start |
/// | 28 | 4 | u32 | tick_hz | Hz, 1000..=4e9; at most 65535 * sample rate |
/// | 32 | 4 | u32 | fastest sampling | Hz, >= 1 |
/// | 36 | 4 | i32 | largest force | mN, > 0 |
/// | 40 | 4 | u32 | fastest change of force | mN/s, > 0 |
/// | 44 | 4 | i32 | largest force held without commands | mN, 0..= largest force |
/// | 48 | 4 | i32 | travel, lower end | um |
/// | 52 | 4 | i32 | travel, upper end | um |
/// | 56 | 1 | u8 | firmware major | |
/// | 57 | 1 | u8 | firmware minor | |
/// | 58 | 2 | u16 | firmware patch | |
/// | 60 | 1 | u8 | reset reason | [`ResetReason`] code |
/// | 61 | 1 | u8 | state | [`DeviceState`] code |
/// | 62 | 2 | u16 | fault | [`FaultCode`], 0 = none |
/// | 64 | 1 | u8 | channels n | 0..=16 |
/// | 65 | 1 | u8 | bytes of a channel entry | >= 8; readers skip what they do not know |
/// | 66 | 2 | u16 | offset of the channel table | 72 here; later versions may put fields before it |
/// | 68 | 4 | | reserved | 0 |
/// | 72 | 8 n | | channel table | [`Channel`] |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ident {
    /// Protocol range.
    pub versions: Versions,
    /// Longest payload the MCU takes.
    pub max_rx: u16,
    /// Capability bits.
    pub caps: u32,
    /// Identity of the gripper.
    pub uid: [u8; 16],
    /// Identity of this start.
    pub boot_id: u32,
    /// Ticks of the MCU clock a second.
    pub tick_hz: u32,
    /// What the hardware allows.
    pub limits: Limits,
    /// Firmware version.
    pub firmware: Firmware,
    /// Why it started.
    pub reset: ResetReason,
    /// State now.
    pub state: DeviceState,
    /// Latched fault.
    pub fault: FaultCode,
    /// Channel table; the first `channel_count` entries count.
    pub channels: [Channel; MAX_CHANNELS],
    /// Channels described.
    pub channel_count: u8,
}

impl Ident {
    /// Bytes before the channel table.
    pub const TABLE: usize = 72;
    /// Most bytes of the payload.
    pub const MAX_SIZE: usize = Self::TABLE + MAX_CHANNELS * Channel::SIZE;
    /// An unused entry of the channel table.
    pub const NO_CHANNEL: Channel =
        Channel { kind: ChannelKind::Other(0), unit: Unit::None, formats: 0, count: 0, scale: 1.0 };

    /// The channels described.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        self.channels.get(..usize::from(self.channel_count)).unwrap_or(&self.channels)
    }

    /// Mask of the channels that can be sent in a format.
    #[must_use]
    pub fn available(&self, format: SampleFormat) -> u32 {
        let bits = self.channels().iter().enumerate().filter(|(_, channel)| channel.offers(format));
        bits.fold(0, |mask, (bit, _)| mask | (1 << bit))
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short; more than 16 channels, entries under 8 bytes, tick_hz under 1000, or a scale or
    /// element count that cannot be.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let versions = Versions::parse(payload)?;
        let mut r = Reader::at_offset(payload, 2);
        let mut ident = Self {
            versions,
            max_rx: r.u16()?,
            caps: r.u32()?,
            uid: r.take()?,
            boot_id: r.u32()?,
            tick_hz: r.u32()?,
            limits: Limits {
                rate_max_hz: r.u32()?,
                force_max_mn: r.i32()?,
                slew_max_mn_s: r.u32()?,
                hold_cap_mn: r.i32()?,
                travel_min_um: r.i32()?,
                travel_max_um: r.i32()?,
            },
            firmware: Firmware { major: r.u8()?, minor: r.u8()?, patch: r.u16()? },
            reset: ResetReason::from_code(r.u8()?),
            state: DeviceState::from_code(r.u8()?),
            fault: FaultCode(r.u16()?),
            channels: [Self::NO_CHANNEL; MAX_CHANNELS],
            channel_count: r.coded(|n| (usize::from(n) <= MAX_CHANNELS).then_some(n))?,
        };
        if ident.tick_hz < 1000 {
            return Err(PayloadError::Value { at: 28, value: i64::from(ident.tick_hz) });
        }
        ident.read_table(payload, r)?;
        Ok(ident)
    }

    fn read_table(&mut self, payload: &[u8], mut r: Reader<'_>) -> Result<(), PayloadError> {
        let stride =
            usize::from(r.coded(|size| (usize::from(size) >= Channel::SIZE).then_some(size))?);
        let mut at = usize::from(r.u16()?);
        let _reserved: [u8; 4] = r.take()?;
        for slot in self.channels.iter_mut().take(usize::from(self.channel_count)) {
            let channel = Channel::read(&mut Reader::at_offset(payload, at))?;
            if !channel.count_is_possible() {
                return Err(PayloadError::Value { at: at + 3, value: i64::from(channel.count) });
            }
            if !channel.scale_is_possible() {
                return Err(PayloadError::Value {
                    at: at + 4,
                    value: i64::from(channel.scale.to_bits()),
                });
            }
            *slot = channel;
            at += stride;
        }
        Ok(())
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let Limits {
            rate_max_hz,
            force_max_mn,
            slew_max_mn_s,
            hold_cap_mn,
            travel_min_um,
            travel_max_um,
        } = self.limits;
        let w = Writer::new(out)
            .u8(self.versions.min)
            .u8(self.versions.max)
            .u16(self.max_rx)
            .u32(self.caps);
        let w = w.put(&self.uid).u32(self.boot_id).u32(self.tick_hz);
        let w = w.u32(rate_max_hz).i32(force_max_mn).u32(slew_max_mn_s).i32(hold_cap_mn);
        let w = w.i32(travel_min_um).i32(travel_max_um);
        let w = w.u8(self.firmware.major).u8(self.firmware.minor).u16(self.firmware.patch);
        let w = w.u8(self.reset.code()).u8(self.state.code()).u16(self.fault.0);
        let w = w.u8(self.channel_count).u8(8).u16(72).u32(0);
        self.channels().iter().fold(w, |w, channel| channel.write(w)).finish()
    }
}
