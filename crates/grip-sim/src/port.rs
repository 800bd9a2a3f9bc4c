//! A gripper that runs in real time: a virtual device at its pseudo-terminal, paced by a clock.

mod simulator;

pub use simulator::{Simulator, SimulatorError, is_scene_error};

use crate::mcu::VirtualMcu;
use crate::pty::{Pty, PtyError};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_link::frame::MAX_WIRE;
use slip_core::units::Micros;

/// Longest time without a look at the stop flag (us).
const PATIENCE_US: u64 = 50_000;

/// Serves `pty` until `stop` is set. `clock` gives microseconds since the start of the device and never goes back.
///
/// The loop sleeps in poll(2) until bytes come or the next batch is due. What the host does not read stays in the line;
/// the device then drops its oldest batches and counts them, as a real one does.
///
/// # Errors
/// [`PtyError`] when the line fails.
pub fn run(
    mcu: &mut VirtualMcu,
    pty: &Pty,
    stop: &AtomicBool,
    mut clock: impl FnMut() -> u64,
) -> Result<(), PtyError> {
    let mut input = [0; 4096];
    let mut unsent = Unsent { bytes: [0; MAX_WIRE], start: 0, end: 0 };
    while !stop.load(Ordering::Relaxed) {
        let now = Micros(clock());
        catch_up(mcu, pty, &mut unsent, now)?;
        let timeout_us = mcu.next_due().since(Micros(clock())).0.min(PATIENCE_US);
        if pty.wait(timeout_us, !unsent.is_empty())?.read {
            let count = pty.read(&mut input)?;
            let now = Micros(clock());
            catch_up(mcu, pty, &mut unsent, now)?;
            mcu.receive(now, input.get(..count).unwrap_or(&input));
        }
    }
    Ok(())
}

/// Goes on to `now` batch by batch: a late turn of this loop is no reason for the device to drop samples.
fn catch_up(
    mcu: &mut VirtualMcu,
    pty: &Pty,
    unsent: &mut Unsent,
    now: Micros,
) -> Result<(), PtyError> {
    while mcu.next_due() <= now {
        let due = mcu.next_due();
        mcu.advance(due);
        unsent.write_all(mcu, pty, due)?;
    }
    mcu.advance(now);
    unsent.write_all(mcu, pty, now)
}

/// The frame that the line did not take whole.
struct Unsent {
    bytes: [u8; MAX_WIRE],
    start: usize,
    end: usize,
}

impl Unsent {
    fn is_empty(&self) -> bool {
        self.start >= self.end
    }

    /// Writes frames, each with one write, until none is due or the line is full.
    fn write_all(&mut self, mcu: &mut VirtualMcu, pty: &Pty, now: Micros) -> Result<(), PtyError> {
        loop {
            if self.is_empty() {
                let Some(length) = mcu.poll_transmit(now, &mut self.bytes) else { return Ok(()) };
                (self.start, self.end) = (0, length);
            }
            self.start += pty.write(self.bytes.get(self.start..self.end).unwrap_or(&[]))?;
            if !self.is_empty() {
                return Ok(());
            }
        }
    }
}
