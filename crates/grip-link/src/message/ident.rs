//! HELLO and IDENT: who is there, what it can do, and whether it is the same boot as before.

use super::FaultCode;
use super::wire::{PayloadError, Reader, Writer};
use super::{ChannelKind, SampleFormat, Unit};
use super::{DeviceState, ResetReason};
use core::fmt;
use slip_msg::{Wire, message};

/// Most channels a gripper describes.
pub const MAX_CHANNELS: usize = 16;

/// Most elements of a channel, the taxels of an array.
pub const MAX_ELEMENTS: u8 = 64;

message! {
    /// One channel of IDENT.
    Channel {
        0 kind: ChannelKind, "", "What it measures.";
        1 unit: Unit, "", "Unit after scaling.";
        2 formats: u8, "b0 i16, b1 f32", "The formats in which it can be sent.";
        3 count: u8, "1..=64; 1 except for an array", "Elements a row.";
        4 scale: f32, "finite and > 0", "Unit per i16 step.";
    }
}

impl Channel {
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
}

message! {
    /// A range of protocol versions: payload bytes 0 and 1 of HELLO and IDENT, SUBSCRIBE and WELCOME, in every version.
    #[derive(Eq)]
    Versions {
        0 min: u8, "0..=15", "Lowest version spoken.";
        1 max: u8, "0..=15", "Highest version spoken.";
    }
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
}

message! {
    /// HELLO (01), host to MCU, ACK_REQ; the header carries the new session nonce, 1..=65535. Answered by IDENT. The MCU
    /// forgets the CONFIG before, holds the force it has, and is LINKED.
    #[derive(Eq)]
    Hello {
        0 versions: Versions, "0..=15", "Protocol range.";
        2 max_rx: u16, "bytes, 480", "Longest payload the host takes.";
        4 caps: u32, "no bit defined: 0", "Capability bits.";
        8 time_us: u64, "us, monotonic, for the log", "Host time.";
    }
}

message! {
    /// What the hardware allows; CONFIG is clamped to it.
    #[derive(Eq)]
    Limits {
        0 rate_max_hz: u32, "Hz, >= 1", "Fastest sampling.";
        4 force_max_mn: i32, "mN, >= 0; 0 = no actuator", "Largest force.";
        8 slew_max_mn_s: u32, "mN/s, > 0", "Fastest change of force.";
        12 hold_cap_mn: i32, "mN, 0..= largest force", "Largest force held without commands.";
        16 travel_min_um: i32, "um", "Travel of the fingers: lower end.";
        20 travel_max_um: i32, "um", "Travel of the fingers: upper end.";
    }
}

impl Limits {
    /// Whether there is anything to command: a board of sensors alone has a largest force of 0.
    #[must_use]
    pub const fn has_actuator(&self) -> bool {
        self.force_max_mn > 0
    }
}

message! {
    /// Firmware version.
    #[derive(Eq)]
    Firmware {
        0 major: u8, "", "Major.";
        1 minor: u8, "", "Minor.";
        2 patch: u16, "", "Patch.";
    }
}

impl fmt::Display for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// IDENT (81), MCU to host: the answer to HELLO. With session 0 it reports that the MCU has no session: sent at most every
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
/// | 36 | 4 | i32 | largest force | mN, >= 0; 0 = no actuator |
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
        let mut r = Reader::new(payload);
        let mut ident = Self {
            versions: Wire::read(&mut r)?,
            max_rx: r.u16()?,
            caps: r.u32()?,
            uid: r.take()?,
            boot_id: r.u32()?,
            tick_hz: r.u32()?,
            limits: Wire::read(&mut r)?,
            firmware: Wire::read(&mut r)?,
            reset: Wire::read(&mut r)?,
            state: Wire::read(&mut r)?,
            fault: Wire::read(&mut r)?,
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
            let channel: Channel = Wire::read(&mut Reader::at_offset(payload, at))?;
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
        let w = self.versions.append(Writer::new(out)).u16(self.max_rx).u32(self.caps);
        let w = w.put(&self.uid).u32(self.boot_id).u32(self.tick_hz);
        let w = self.firmware.append(self.limits.append(w));
        let w = self.fault.append(self.state.append(self.reset.append(w)));
        let w = w.u8(self.channel_count).u8(8).u16(72).u32(0);
        self.channels().iter().fold(w, |w, channel| channel.append(w)).finish()
    }
}
