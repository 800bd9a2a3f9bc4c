//! A virtual gripper that lives in real time on an open line.

use core::sync::atomic::{AtomicBool, Ordering};
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::MAX_WIRE,
    message::{Kind, SamplesHeader},
};
use grip_sim::VirtualMcu;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::{Errno, read, write},
};
use slip_core::units::Micros;
use std::{io, os::fd::BorrowedFd};

/// Longest wait without a look at the stop flag (ns).
const PATIENCE_NS: u64 = 20_000_000;

/// A gripper and what it has seen of its host.
#[derive(Debug)]
pub struct Gripper {
    /// The device.
    pub mcu: VirtualMcu,
    tap: Decoder,
    /// Rows before the CONFIG in force, and those of them that were thrown away by it.
    before: u64,
    discarded: u64,
    /// Number of the row after those that were sent, since CONFIG.
    sent: u32,
}

impl Gripper {
    /// A gripper that is not connected yet.
    #[must_use]
    pub fn new(mcu: VirtualMcu) -> Self {
        Self { mcu, tap: Decoder::new(Role::Tap), before: 0, discarded: 0, sent: 0 }
    }

    /// Rows sampled so far, over every CONFIG.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.before + u64::from(self.mcu.rows())
    }

    /// Rows that had not been sent when a CONFIG came, which begins anew: a host that stalled for longer than the gripper waits sends
    /// one, and cannot know of them.
    #[must_use]
    pub fn discarded(&self) -> u64 {
        self.discarded
    }

    /// Lives on `line` until `stop` is set or the other end is gone. `clock` gives nanoseconds since the device was powered on.
    ///
    /// # Errors
    /// What the system states of the line, but for its end.
    pub fn live(
        &mut self,
        line: BorrowedFd<'_>,
        stop: &AtomicBool,
        clock: &dyn Fn() -> u64,
    ) -> io::Result<()> {
        let mut input = [0; 4096];
        while !stop.load(Ordering::Relaxed) {
            self.catch_up(line, clock)?;
            let due_ns = self.mcu.next_due().0.saturating_mul(1000);
            if !wait(line, PollFlags::IN, due_ns.saturating_sub(clock()).min(PATIENCE_NS))? {
                continue;
            }
            let count = match read(line, &mut input) {
                Ok(0) => return Ok(()),
                Ok(count) => count,
                Err(Errno::AGAIN | Errno::INTR) => continue,
                Err(error) => return gone(error),
            };
            self.catch_up(line, clock)?;
            self.receive(Micros(clock() / 1000), input.get(..count).unwrap_or(&input));
        }
        Ok(())
    }

    fn receive(&mut self, now: Micros, bytes: &[u8]) {
        self.mcu.advance(now);
        let rows = self.mcu.rows();
        self.mcu.receive(now, bytes);
        if self.mcu.rows() < rows {
            self.before += u64::from(rows);
            self.discarded += u64::from(rows.saturating_sub(self.sent));
            self.sent = 0;
        }
    }

    /// Goes on batch by batch: a late turn is no reason for the device to drop samples.
    fn catch_up(&mut self, line: BorrowedFd<'_>, clock: &dyn Fn() -> u64) -> io::Result<()> {
        let now = Micros(clock() / 1000);
        while self.mcu.next_due() <= now {
            let due = self.mcu.next_due();
            self.mcu.advance(due);
            self.send(line, due)?;
        }
        self.send(line, now)
    }

    /// Sends what is due at `now`: later than it is, the rest of a batch, as if the gripper sampled no more.
    ///
    /// # Errors
    /// As [`Gripper::live`].
    pub fn send(&mut self, line: BorrowedFd<'_>, now: Micros) -> io::Result<()> {
        let mut out = [0; MAX_WIRE];
        while let Some(len) = self.mcu.poll_transmit(now, &mut out) {
            let frame = out.get(..len).unwrap_or(&out);
            self.count(frame);
            write_all(line, frame)?;
        }
        Ok(())
    }

    fn count(&mut self, mut frame: &[u8]) {
        while let Some(verdict) = self.tap.next(&mut frame) {
            if let Verdict::Frame(frame) = verdict
                && frame.header.kind == Kind::SAMPLES
                && let Ok(header) = SamplesHeader::parse(frame.payload)
            {
                self.sent = header.first_index.wrapping_add(header.rows.into());
            }
        }
    }
}

/// Writes all of it, waiting where the line is full; an end of the line is for the next read to find.
fn write_all(line: BorrowedFd<'_>, mut bytes: &[u8]) -> io::Result<()> {
    while !bytes.is_empty() {
        match write(line, bytes) {
            Ok(count) => bytes = bytes.get(count..).unwrap_or(&[]),
            Err(Errno::AGAIN) => {
                if !wait(line, PollFlags::OUT, PATIENCE_NS)? {
                    return Ok(());
                }
            }
            Err(Errno::INTR) => {}
            Err(error) => return gone(error),
        }
    }
    Ok(())
}

/// An end of the line is none of the gripper's errors.
fn gone(error: Errno) -> io::Result<()> {
    match error {
        Errno::PIPE | Errno::CONNRESET | Errno::IO => Ok(()),
        error => Err(error.into()),
    }
}

/// Whether the line is ready within `timeout_ns`.
fn wait(line: BorrowedFd<'_>, events: PollFlags, timeout_ns: u64) -> io::Result<bool> {
    let timeout = Timespec {
        tv_sec: 0,
        tv_nsec: i64::try_from(timeout_ns.min(PATIENCE_NS)).unwrap_or_default(),
    };
    match poll(&mut [PollFd::from_borrowed_fd(line, events)], Some(&timeout)) {
        Ok(ready) => Ok(ready > 0),
        Err(Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}
