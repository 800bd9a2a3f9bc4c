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
        0 kind: ChannelKind, "channel kind", "What it measures.";
        1 unit: Unit, "unit after scaling", "Unit after scaling.";
        2 formats: u8, "b0 can be sent as i16, b1 as f32", "The formats in which it can be sent.";
        3 count: u8, "elements in a row, 1..64; else malformed; 1 except for an array", "Elements a row.";
        4 scale: f32, "unit per i16 step; finite and > 0, else malformed", "Unit per i16 step.";
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
        0 min: u8, "lowest protocol version spoken, 0..15", "Lowest version spoken.";
        1 max: u8, "highest protocol version spoken, 0..15", "Highest version spoken.";
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
        0 versions: Versions, "", "Protocol range.";
        2 max_rx: u16, "bytes, longest payload the host takes: 480; not used by version 1", "Longest payload the host takes.";
        4 caps: u32, "no bit defined: 0", "Capability bits.";
        8 time_us: u64, "us, monotonic host time, for the device's log", "Host time.";
    }
}

message! {
    /// What the hardware allows; CONFIG is clamped to it.
    #[derive(Eq)]
    Limits {
        0 rate_max_hz: u32, "Hz, >= 1, fastest sampling", "Fastest sampling.";
        4 force_max_mn: i32, "mN, >= 0, largest force; 0: no actuator", "Largest force.";
        8 slew_max_mn_s: u32, "mN/s, > 0, fastest change of force", "Fastest change of force.";
        12 hold_cap_mn: i32, "mN, 0 .. `force_max_mn`, largest force held without commands", "Largest force held without commands.";
        16 travel_min_um: i32, "um, lower end of the finger travel", "Travel of the fingers: lower end.";
        20 travel_max_um: i32, "um, upper end", "Travel of the fingers: upper end.";
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
        0 major as "fw_major": u8, "firmware version", "Major.";
        1 minor as "fw_minor": u8, "", "Minor.";
        2 patch as "fw_patch": u16, "", "Patch.";
    }
}

impl fmt::Display for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

message! {
    /// What stands before the channel table in IDENT.
    #[derive(Eq)]
    IdentHead {
        0 versions: Versions, "", "Protocol range.";
        2 max_rx: u16, "bytes, longest payload the device takes, >= 64; not used by version 1", "Longest payload the MCU takes.";
        4 caps: u32, "no bit defined: 0", "Capability bits.";
        8 uid: [u8; 16], "identity of the gripper, the same at every start", "Identity of the gripper.";
        24 boot_id: u32, "identity of this start: another number at every start", "Identity of this start.";
        28 tick_hz: u32, "Hz, 1000 and more; less is malformed", "Ticks of the MCU clock a second.", in 1000..;
        32 limits: Limits, "", "What the hardware allows.";
        56 firmware: Firmware, "", "Firmware version.";
        60 reset: ResetReason, "reset reason", "Why it started.";
        61 state: DeviceState, "device state when this is sent", "State now.";
        62 fault: FaultCode, "latched fault, 0 = none", "Latched fault.";
        64 channel_count: u8, "n, 0..16; more is malformed", "Channels described.", in ..=16;
        65 entry_size: u8, "bytes of a channel entry: 8; less is malformed, readers skip what they do not know", "Bytes of a channel entry.", in 8..;
        66 table_at: u16, "payload offset of the first entry: 72 in version 1; readers obey it", "Offset of the channel table.", reserved 4;
    }
}

/// IDENT (81), MCU to host: the answer to HELLO. With session 0 it reports that the MCU has no session: sent at most every
/// 100 ms, in answer to a frame of an unknown session.
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
    pub const TABLE: usize = IdentHead::SIZE;
    /// Most bytes of the payload.
    pub const MAX_SIZE: usize = Self::TABLE + MAX_CHANNELS * Channel::SIZE;
    /// An unused entry of the channel table.
    pub const NO_CHANNEL: Channel =
        Channel { kind: ChannelKind::Other(0), unit: Unit::None, formats: 0, count: 0, scale: 1.0 };

    /// That of a gripper with these limits and channels, of which it describes at most [`MAX_CHANNELS`]. It has just started and
    /// reports no fault; its clock ticks in microseconds, and its firmware is 0.1.0.
    #[must_use]
    pub fn new(uid: [u8; 16], boot_id: u32, limits: Limits, channels: &[Channel]) -> Self {
        let mut table = [Self::NO_CHANNEL; MAX_CHANNELS];
        let mut channel_count = 0;
        for (slot, channel) in table.iter_mut().zip(channels) {
            *slot = *channel;
            channel_count += 1;
        }
        Self {
            versions: Versions::OURS,
            max_rx: 480,
            caps: 0,
            uid,
            boot_id,
            tick_hz: 1_000_000,
            limits,
            firmware: Firmware { major: 0, minor: 1, patch: 0 },
            reset: ResetReason::PowerOn,
            state: DeviceState::Boot,
            fault: FaultCode::NONE,
            channels: table,
            channel_count,
        }
    }

    /// The channels described.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        self.channels.get(..usize::from(self.channel_count)).unwrap_or(&self.channels)
    }

    /// Whether a channel can show a slip: a stylus or vibration, a moved distance, an array of taxels.
    #[must_use]
    pub fn shows_slips(&self) -> bool {
        use ChannelKind::{PressureArray, Stylus, Travel};
        self.channels()
            .iter()
            .any(|channel| matches!(channel.kind, Stylus | Travel | PressureArray))
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
        let head = IdentHead::parse(payload)?;
        let mut ident = Self {
            versions: head.versions,
            max_rx: head.max_rx,
            caps: head.caps,
            uid: head.uid,
            boot_id: head.boot_id,
            tick_hz: head.tick_hz,
            limits: head.limits,
            firmware: head.firmware,
            reset: head.reset,
            state: head.state,
            fault: head.fault,
            channels: [Self::NO_CHANNEL; MAX_CHANNELS],
            channel_count: head.channel_count,
        };
        ident.read_table(payload, &head)?;
        Ok(ident)
    }

    fn read_table(&mut self, payload: &[u8], head: &IdentHead) -> Result<(), PayloadError> {
        let mut at = usize::from(head.table_at);
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
            at += usize::from(head.entry_size);
        }
        Ok(())
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let Self { versions, max_rx, caps, uid, boot_id, tick_hz, limits, firmware, .. } = *self;
        let Self { reset, state, fault, channel_count, .. } = *self;
        let (entry_size, table_at) = (8, 72);
        let head = IdentHead {
            versions,
            max_rx,
            caps,
            uid,
            boot_id,
            tick_hz,
            limits,
            firmware,
            reset,
            state,
            fault,
            channel_count,
            entry_size,
            table_at,
        };
        let w = head.append(Writer::new(out));
        self.channels().iter().fold(w, |w, channel| channel.append(w)).finish()
    }
}
