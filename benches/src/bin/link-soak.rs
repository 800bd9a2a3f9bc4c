//! Minutes in; whether every sample of a 10 kHz stream over a pseudo-terminal arrived or was counted as lost, out.
//!
//! The virtual gripper lives in a thread of its own and in real time, on one end of a pseudo-terminal; the host's link reads
//! the other end in pieces of up to 4096 bytes, as gripd does, and answers every batch with a GRIP. At the end the
//! gripper stops sampling and sends what it still has. Then three counts must agree: the rows that the gripper gave to
//! its link, the rows that arrived plus those missing by their numbers, and the link's own count of loss.

use clap::Parser;
use core::error::Error;
use core::sync::atomic::{AtomicBool, Ordering};
use grip_link::frame::MAX_WIRE;
use grip_link::host::{GripCommand, HostConfig, HostEvent, HostLink, LossCount};
use grip_link::message::{Config, LossAction, SampleFormat, Samples};
use grip_sim::{Pty, VirtualMcu, scene};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use slip_benches::{daemon::gripper::Gripper, time::clock};
use slip_core::units::Micros;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::fd::AsFd as _;
use std::process::ExitCode;
use std::thread;

type Failure = Box<dyn Error + Send + Sync>;

const CONFIG: Config = Config {
    sample_rate_hz: 10_000,
    batch: 10,
    format: SampleFormat::F32,
    ttl_ms: 100,
    channel_mask: u32::MAX,
    force_max_mn: 60_000,
    slew_mn_s: 1_000_000,
    hold_cap_mn: 60_000,
    loss_after_ms: 1000,
    loss_action: LossAction::Hold,
};
/// Holds the object of the default scene for good (N).
const FORCE_N: f32 = 30.0;
const PROGRESS_US: u64 = 30_000_000;
/// Nothing for this long after the gripper has ended: the line is empty (ns).
const QUIET_NS: i64 = 500_000_000;

/// Streams 10 kHz over a pseudo-terminal and accounts for every sample.
#[derive(Debug, Parser)]
struct Cli {
    /// How long to stream
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
}

/// What the gripper's thread knows at its end.
#[derive(Debug)]
struct Given {
    rows: u32,
    dropped: u32,
    boots: u32,
    device_bad_blocks: u32,
}

/// What the host counted by itself, beside the link.
#[derive(Debug, Default)]
struct Seen {
    next: u32,
    rows: u64,
    missing: u64,
    backwards: u64,
    batches: u64,
    grips: u64,
    refused_grips: u64,
    largest_gap: u32,
    longest_silence_us: u64,
    status: u64,
    last_us: Option<u64>,
}

fn main() -> Result<ExitCode, Failure> {
    let minutes = Cli::parse().minutes;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and a negative time ends at once"
    )]
    let end_us = (minutes * 60e6) as u64;
    let clock = clock();
    let clock_us = || clock() / 1000;
    let pty = Pty::open(None)?;
    let line = OpenOptions::new().read(true).write(true).open(pty.port())?;
    let (stop, over) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut host = HostLink::new(HostConfig { lost_us: 60_000_000, ..HostConfig::new(CONFIG) })?;
    let (given, seen) = thread::scope(|threads| {
        let gripper = threads.spawn(|| {
            let given = gripper(&pty, &stop, &clock);
            over.store(true, Ordering::Release);
            given
        });
        let seen = listen(line, &mut host, &clock_us, |now_us| {
            if now_us >= end_us {
                stop.store(true, Ordering::Relaxed);
            }
            over.load(Ordering::Acquire)
        });
        stop.store(true, Ordering::Relaxed);
        let given = gripper.join().map_err(|_| "the gripper's thread failed")??;
        Ok::<_, Failure>((given, seen?))
    })?;
    let fine = report(minutes, &given, &seen, host.loss(), host.counters().bad_blocks());
    Ok(if fine { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The gripper in real time until `stop`; then it samples no more and sends the rest.
fn gripper(pty: &Pty, stop: &AtomicBool, clock: &impl Fn() -> u64) -> Result<Given, Failure> {
    let mut gripper = Gripper::new(VirtualMcu::new(&scene::load("default")?, 1)?);
    let first_boot = gripper.mcu.boot_id();
    gripper.live(pty.as_fd(), stop, clock, &mut |_| {})?;
    // Ten milliseconds later by the gripper's own clock, so that the batch under way is over too.
    gripper.empty(pty.as_fd(), Micros(clock() / 1000 + 10_000))?;
    let mcu = gripper.mcu;
    Ok(Given {
        rows: mcu.rows(),
        dropped: mcu.link().dropped_rows(),
        boots: mcu.boot_id() - first_boot,
        device_bad_blocks: mcu.link().counters().bad_blocks(),
    })
}

/// The host until the gripper has ended and the line is empty.
fn listen(
    mut line: File,
    host: &mut HostLink,
    clock: &impl Fn() -> u64,
    mut over: impl FnMut(u64) -> bool,
) -> Result<Seen, Failure> {
    let mut seen = Seen::default();
    let mut input = [0; 4096];
    let mut out = [0; MAX_WIRE];
    let mut progress_us = PROGRESS_US;
    host.open(clock(), 77)?;
    loop {
        let now_us = clock();
        while let Some(len) = host.poll_transmit(now_us, &mut out) {
            line.write_all(out.get(..len).unwrap_or(&out))?;
        }
        let ended = over(now_us);
        if !readable(&line)? {
            if ended {
                return Ok(seen);
            }
            continue;
        }
        let count = line.read(&mut input)?;
        let now_us = clock();
        let batches = seen.batches;
        take(host, now_us, input.get(..count).unwrap_or(&input), &mut seen)?;
        if seen.batches > batches && !ended {
            let command = GripCommand::newtons(FORCE_N).ok_or("no force")?;
            match host.grip(now_us, &command, &mut out) {
                Some(len) => line.write_all(out.get(..len).unwrap_or(&out))?,
                None => seen.refused_grips += 1,
            }
            seen.grips += 1;
        }
        if now_us >= progress_us {
            progress_us += PROGRESS_US;
            eprintln!("{:5} s: {} rows, {} missing", now_us / 1_000_000, seen.rows, seen.missing);
        }
    }
}

fn readable(line: &File) -> Result<bool, Failure> {
    let timeout = Timespec { tv_sec: 0, tv_nsec: QUIET_NS };
    let ready = poll(&mut [PollFd::new(line, PollFlags::IN)], Some(&timeout))?;
    Ok(ready > 0)
}

fn take(
    host: &mut HostLink,
    now_us: u64,
    mut bytes: &[u8],
    seen: &mut Seen,
) -> Result<(), Failure> {
    while let Some(event) = host.receive(now_us, &mut bytes) {
        match event {
            HostEvent::Samples { header, .. } => {
                seen.batches += 1;
                for row in host.samples(header).iter().flat_map(Samples::rows) {
                    seen.row(row.index);
                }
                let silence = now_us.saturating_sub(seen.last_us.unwrap_or(now_us));
                seen.longest_silence_us = seen.longest_silence_us.max(silence);
                seen.last_us = Some(now_us);
            }
            HostEvent::Status(_) => seen.status += 1,
            HostEvent::Closed(reason) => return Err(format!("the link closed: {reason:?}").into()),
            _ => {}
        }
    }
    Ok(())
}

impl Seen {
    /// Every row has the number after the one before, from 0 on; what is between is missing.
    fn row(&mut self, index: u32) {
        let gap = index.wrapping_sub(self.next);
        if gap > u32::MAX / 2 {
            self.backwards += 1;
        } else {
            self.missing += u64::from(gap);
            self.largest_gap = self.largest_gap.max(gap);
        }
        self.next = index.wrapping_add(1);
        self.rows += 1;
    }
}

#[expect(clippy::print_stdout, reason = "the result of the program")]
fn report(minutes: f64, given: &Given, seen: &Seen, loss: LossCount, bad_blocks: u32) -> bool {
    let unaccounted = i128::from(given.rows) - i128::from(seen.rows) - i128::from(seen.missing);
    let rows: [(&str, u64); 15] = [
        ("rows the gripper sampled", given.rows.into()),
        ("rows that arrived", seen.rows),
        ("rows missing by their numbers", seen.missing),
        ("  of these counted by the link", loss.lost),
        ("  of these dropped by the gripper (host's count)", loss.dropped_by_mcu),
        ("  dropped by the gripper (its own count)", given.dropped.into()),
        ("largest gap (rows)", seen.largest_gap.into()),
        ("rows out of order or twice", seen.backwards),
        ("batches", seen.batches),
        ("longest time between batches (us)", seen.longest_silence_us),
        ("STATUS received", seen.status),
        ("GRIP sent", seen.grips - seen.refused_grips),
        ("bad blocks, host", bad_blocks.into()),
        ("bad blocks, gripper", given.device_bad_blocks.into()),
        ("restarts of the gripper", given.boots.into()),
    ];
    println!("{minutes} minutes at 10 kHz over a pseudo-terminal");
    for (name, value) in rows {
        println!("{name:50} {value:>12}");
    }
    println!("{:50} {unaccounted:>12}", "rows not accounted for");
    let fine = unaccounted == 0
        && seen.backwards == 0
        && loss.lost == seen.missing
        && loss.received == seen.rows
        && given.boots == 0;
    println!(
        "{}",
        if fine { "every sample is accounted for" } else { "SAMPLES ARE NOT ACCOUNTED FOR" }
    );
    fine
}
