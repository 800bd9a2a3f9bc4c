//! A whole gripper at the other end of the line, real or not, in a time that whoever runs it gives.

use super::DeviceLink;
use crate::frame::MAX_WIRE;
use core::fmt::Debug;

/// A gripper that lives as its caller lets time go on (us, never back).
pub trait Peer: Debug {
    /// The time it has come to (us).
    fn now_us(&self) -> u64;

    /// When it has something to send next, if nothing is received before (us).
    fn next_due_us(&self) -> u64;

    /// Goes on to `now_us` and takes bytes of the host that arrived then; there may be none.
    fn receive(&mut self, now_us: u64, bytes: &[u8]);

    /// The next frame that is due: its length in `out`.
    fn poll_transmit(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize>;

    /// Its end of the link: state and fault.
    fn link(&self) -> &DeviceLink;

    /// What a simulator knows of the object; `None` from a gripper that can only measure.
    fn truth(&self) -> Option<Truth> {
        None
    }
}

/// What is so with an object in the fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Normal force of each finger that it needs now (N).
    pub needed_n: f32,
    /// What happens to it; `None` before it is lifted.
    pub fate: Option<Fate>,
}

/// What happens to an object in the fingers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It stands.
    Held,
    /// It slides.
    Slipping,
    /// It has left the fingers.
    Dropped,
    /// It was pressed harder than it bears.
    Crushed,
}
