//! A virtual device, its pseudo-terminal and a clock in; a gripper that lives in real time out.

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use grip_link::host::{GripCommand, HostConfig, HostEvent, HostLink};
    use grip_link::message::{Config, LossAction, SampleFormat};
    use std::io::{Read, Write};

    const CONFIG: Config = Config {
        sample_rate_hz: 10_000,
        batch: 10,
        format: SampleFormat::I16,
        ttl_ms: 100,
        channel_mask: 1,
        force_max_mn: 10_000,
        slew_mn_s: 1_000_000,
        hold_cap_mn: 10_000,
        loss_after_ms: 1000,
        loss_action: LossAction::Hold,
    };

    /// A host that runs on the device's own messages: each read is one turn of 250 us.
    fn host_until_force(port: &std::path::Path, wanted_mn: i32) -> (usize, u32) {
        let mut file = std::fs::OpenOptions::new().read(true).write(true).open(port).unwrap();
        let mut host =
            HostLink::new(HostConfig { lost_us: 60_000_000, ..HostConfig::new(CONFIG) }).unwrap();
        host.open(0, 77).unwrap();
        let (mut out, mut buffer, mut rows, mut now, mut applied) =
            ([0; MAX_WIRE], [0; 4096], 0, 0, 0);
        while applied < wanted_mn {
            now += 250;
            while let Some(length) = host.poll_transmit(now, &mut out) {
                file.write_all(&out[..length]).unwrap();
            }
            if let Some(length) = host.grip(now, &GripCommand::newtons(5.0).unwrap(), &mut out) {
                file.write_all(&out[..length]).unwrap();
            }
            let count = file.read(&mut buffer).unwrap();
            let mut input = &buffer[..count];
            while let Some(event) = host.receive(now, &mut input) {
                match event {
                    HostEvent::Samples { header, .. } => rows += usize::from(header.rows),
                    HostEvent::Status(status) => applied = status.applied_mn,
                    HostEvent::Closed(reason) => panic!("{reason:?}"),
                    _ => {}
                }
            }
        }
        (rows, host.counters().crc)
    }

    #[test]
    fn a_host_grips_over_a_pseudo_terminal() {
        let pty = Pty::open(None).unwrap();
        let port = pty.port().to_owned();
        let stop = AtomicBool::new(false);
        let mut mcu = VirtualMcu::new(&scene::load("default").unwrap(), 3).unwrap();
        let mut now = 0;
        let (rows, crc_errors) = std::thread::scope(|threads| {
            let device = threads.spawn(|| {
                run(&mut mcu, &pty, &stop, || {
                    now += 200;
                    now
                })
            });
            let seen = host_until_force(&port, 4_900);
            stop.store(true, Ordering::Relaxed);
            device.join().unwrap().unwrap();
            seen
        });
        assert!(rows > 100 && crc_errors == 0, "{rows} {crc_errors}");
        assert!(mcu.truth().applied_n > 4.8);
    }
}
