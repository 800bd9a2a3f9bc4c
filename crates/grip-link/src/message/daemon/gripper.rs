//! GRIPPER: which gripper the daemon holds.

use super::LinkState;
use crate::message::wire::{PayloadError, Reader, Writer};

/// GRIPPER (A4), daemon to client.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 16 | u8\[16\] | uid; zeros where no gripper was seen yet | |
/// | 16 | 4 | u32 | number of its starts | |
/// | 20 | 4 | u32 | sample rate in force; 0 = none yet | Hz |
/// | 24 | 4 | f32 | largest force of the controller; NaN = not known | N |
/// | 28 | 1 | u8 | [`LinkState`] code | |
/// | 29 | 1 | u8 | taxels of its array | |
/// | 30 | 2 | | reserved, 0 | |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gripper {
    /// Identity; zeros where no gripper was seen yet.
    pub uid: [u8; 16],
    /// Number of its starts.
    pub boot_id: u32,
    /// Sample rate in force (Hz); 0: none yet.
    pub rate_hz: u32,
    /// Largest force of the controller (N).
    pub force_max_n: Option<f32>,
    /// State of the link.
    pub link: LinkState,
    /// Taxels of its array.
    pub taxels: u8,
}

impl Gripper {
    /// Bytes of the payload.
    pub const SIZE: usize = 32;
    /// None was seen yet.
    pub const NONE: Self = Self {
        uid: [0; 16],
        boot_id: 0,
        rate_hz: 0,
        force_max_n: None,
        link: LinkState::Closed,
        taxels: 0,
    };

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, or an infinite force.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let (uid, boot_id, rate_hz, force_max_n) = (r.take()?, r.u32()?, r.u32()?, r.maybe()?);
        let [link, taxels, _, _] = r.take()?;
        Ok(Self { uid, boot_id, rate_hz, force_max_n, link: LinkState::from_code(link), taxels })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).put(&self.uid).u32(self.boot_id).u32(self.rate_hz);
        w.maybe(self.force_max_n).u8(self.link.code()).u8(self.taxels).u16(0).finish()
    }
}
