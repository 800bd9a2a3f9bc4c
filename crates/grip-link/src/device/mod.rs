//! The microcontroller's side of the link: frames to send and the force for the actuator, from bytes, samples and ticks.
//!
//! ```text
//! BOOT -> IDLE -> LINKED -> ARMED -> ACTIVE <-> HOLD -> LOSS_ACTION      any -> FAULT, ESTOP (latched)
//!      ready   HELLO    CONFIG    GRIP      ttl     loss delay
//! ```
//! A firmware calls, as often as it can: [`DeviceLink::receive`] with what the port gave, `push_*` with every
//! sample, [`DeviceLink::drive`] from the force loop, and [`DeviceLink::poll_transmit`] whenever the port is free.
//! Time is the 64-bit tick count of the firmware. A software ESTOP is not a safety function.

mod batches;
mod force;
mod link;
mod outbox;
mod peer;
mod requests;
mod transmit;

pub use batches::KEPT_BATCHES;
pub use force::Drive;
pub use link::{DeviceEvent, DeviceLink, RowError};
pub use peer::{Fate, Peer, Truth};

use crate::frame::MAX_PAYLOAD;
use crate::message::{
    Channel, DeviceState, FaultCode, Ident, Layout, Limits, Reaction, SAMPLES_HEADER, SampleFormat,
};
use thiserror::Error;

/// What a firmware reports of its gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceConfig {
    /// IDENT; state and fault are filled in when it is sent.
    pub ident: Ident,
    /// What an ESTOP does: hold or torque off.
    pub estop: Reaction,
}

/// Why a [`DeviceConfig`] cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DeviceConfigError {
    /// Fewer than 1000 ticks a second.
    #[error("tick_hz is {tick_hz}, at least 1000 are needed")]
    TickRate {
        /// Ticks a second given.
        tick_hz: u32,
    },
    /// A rate or slew of zero, a negative force, or a hold cap over the largest force.
    #[error(
        "limits: rate {rate_max_hz} Hz, force {force_max_mn} mN, slew {slew_max_mn_s} mN/s, hold cap {hold_cap_mn} mN"
    )]
    Limits {
        /// Fastest sampling.
        rate_max_hz: u32,
        /// Largest force.
        force_max_mn: i32,
        /// Fastest change of force.
        slew_max_mn_s: u32,
        /// Largest force held without commands.
        hold_cap_mn: i32,
    },
    /// No channel that shows a slip.
    #[error("none of the {channels} channels is a stylus, a travel or an array of taxels")]
    NoStylus {
        /// Channels given.
        channels: u8,
    },
    /// A channel that a host would refuse.
    #[error(
        "channel {index} has {count} elements of scale {scale}: 1 to 64 and more than 0 are possible"
    )]
    Channel {
        /// Place in the list.
        index: usize,
        /// Elements given.
        count: u8,
        /// Scale given.
        scale: f32,
    },
    /// A row that does not fit a frame.
    #[error("a row of {bytes} bytes does not fit a frame")]
    Row {
        /// Bytes of a row of all channels as f32.
        bytes: usize,
    },
}

impl DeviceConfig {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`DeviceConfigError`] with the numbers that cannot be.
    pub fn check(&self) -> Result<(), DeviceConfigError> {
        let Ident { tick_hz, limits, channel_count, .. } = self.ident;
        if tick_hz < 1000 {
            return Err(DeviceConfigError::TickRate { tick_hz });
        }
        let Limits { rate_max_hz, force_max_mn, slew_max_mn_s, hold_cap_mn, .. } = limits;
        if rate_max_hz == 0
            || force_max_mn < 0
            || slew_max_mn_s == 0
            || !(0..=force_max_mn).contains(&hold_cap_mn)
        {
            return Err(DeviceConfigError::Limits {
                rate_max_hz,
                force_max_mn,
                slew_max_mn_s,
                hold_cap_mn,
            });
        }
        let channels = self.ident.channels();
        if !self.ident.shows_slips() {
            return Err(DeviceConfigError::NoStylus { channels: channel_count });
        }
        let refused = channels.iter().enumerate().find(|(_, channel)| !channel.is_possible());
        if let Some((index, Channel { count, scale, .. })) = refused {
            return Err(DeviceConfigError::Channel { index, count: *count, scale: *scale });
        }
        let bytes = Layout::new(channels, u32::MAX).row_bytes(SampleFormat::F32);
        if bytes > MAX_PAYLOAD - SAMPLES_HEADER {
            return Err(DeviceConfigError::Row { bytes });
        }
        Ok(())
    }
}

/// Latched trouble: an ESTOP and a fault can stand side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Latch {
    estop: bool,
    fault: FaultCode,
}

impl Latch {
    const CLEAR: Self = Self { estop: false, fault: FaultCode::NONE };

    const fn state(self) -> Option<DeviceState> {
        match self {
            Self { estop: true, .. } => Some(DeviceState::Estop),
            Self { fault, .. } if fault.is_fault() => Some(DeviceState::Fault),
            Self { .. } => None,
        }
    }

    const fn code(self) -> FaultCode {
        if self.estop { FaultCode::ESTOP } else { self.fault }
    }
}
