//! Seconds in; histograms of the time from the last byte of a frame to the command out: the hot loop of gripd over a socket pair and over a
//! pseudo-terminal.
//!
//! The loop runs with all its rings, which a third thread empties as the service thread and the recorder of gripd do. The gripper is
//! simulated in real time: 1000 frames of 10 samples a second. Limits that are not kept are printed as `over` and never fail: the machine
//! may be busy with something else.
#![expect(clippy::print_stdout, reason = "the result of the program")]

use clap::{Parser, ValueEnum};
use core::{
    error::Error,
    sync::atomic::{AtomicBool, Ordering},
};
use grip_daemon::{
    Latency,
    realtime::{RealtimeConfig, RealtimeMode, enter},
};
use grip_port::{DEFAULT_BAUD, Line, UsbFilter};
use grip_session::HostConfig;
use grip_sim::{Pty, VirtualMcu, scene};
use hdrhistogram::Histogram;
use slip_benches::{
    daemon::{
        gripper::Gripper,
        rig::{Far, rig},
    },
    time,
};
use std::{
    io,
    os::{
        fd::{AsFd as _, BorrowedFd, OwnedFd},
        unix::net::UnixStream,
    },
    thread,
};

/// The rings are emptied this often (us), as gripd does with clients.
const DRAIN_US: u64 = 5_000;
/// The longest bar (characters).
const BAR: u64 = 50;

/// Times the hot loop of gripd between a virtual gripper's frames and its commands.
#[derive(Debug, Parser)]
struct Cli {
    /// How long each line is measured
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Which line; both unless it is named
    #[arg(long, value_enum)]
    line: Option<Kind>,
    /// Ask for SCHED_FIFO and locked memory, for the loop and for the gripper, as far as they are granted
    #[arg(long)]
    realtime: bool,
    /// How long before and after a frame is due the loop does not sleep (us)
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=500))]
    spin: u16,
}

/// What stands between loop and gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A socket pair
    Socket,
    /// A pseudo-terminal
    Pty,
}

/// What was measured.
#[derive(Debug)]
struct Times {
    /// From the frame written to the command read, at the gripper (ns).
    there_and_back: Histogram<u64>,
    /// From the frame read to the command written, by the loop itself.
    inside: Latency,
    samples: u64,
    dropped: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let cli = Cli::parse();
    println!("machine {}, {} s each", time::machine(), cli.seconds);
    for kind in [Kind::Socket, Kind::Pty] {
        if cli.line.is_none_or(|wanted| wanted == kind) {
            let times = measure(kind, &cli)?;
            print(kind, &times);
        }
    }
    Ok(())
}

fn measure(kind: Kind, cli: &Cli) -> Result<Times, Box<dyn Error>> {
    match kind {
        Kind::Socket => {
            let (near, far) = UnixStream::pair()?;
            far.set_nonblocking(true)?;
            run(Line::from_fd(OwnedFd::from(near))?, far.as_fd(), cli)
        }
        Kind::Pty => {
            let pty = Pty::open(None)?;
            let name = pty.port().display().to_string();
            let usb = UsbFilter::default();
            let line = grip_port::Source::open(&name, DEFAULT_BAUD, usb)?.line()?;
            run(line, pty.as_fd(), cli)
        }
    }
}

fn run(line: Line, device: BorrowedFd<'_>, cli: &Cli) -> Result<Times, Box<dyn Error>> {
    let clock = time::clock();
    let realtime = RealtimeConfig {
        mode: RealtimeMode::Strict,
        spin_us: cli.spin,
        ..RealtimeConfig::default()
    };
    let (mut hot, mut far) = rig(HostConfig { realtime, ..HostConfig::default() }, &clock)?;
    let mut gripper = Gripper::new(VirtualMcu::new(&scene::load("default")?, 1)?);
    far.shared.wants_samples.store(true, Ordering::Relaxed);
    let shared = far.shared.clone();
    far.lines.push(line).map_err(|_| "no room for a line")?;
    let mut there_and_back = Histogram::new_with_max(1_000_000_000, 3)?;
    let ends = || clock() >= nanos(cli.seconds);
    let over = AtomicBool::new(false);
    let ran = thread::scope(|threads| {
        threads.spawn(|| drain(&mut far, &over));
        let looping = threads.spawn(|| {
            privileges(cli.realtime, 50);
            hot.run()
        });
        let living = threads.spawn(|| {
            privileges(cli.realtime, 49);
            let mut note = |ns| there_and_back.saturating_record(ns);
            gripper.live(device, &shared.stop, &clock, &mut note)
        });
        while !ends() && !looping.is_finished() {
            time::wait_us(DRAIN_US);
        }
        shared.stop.store(true, Ordering::Relaxed);
        let (looped, lived) = (looping.join(), living.join());
        over.store(true, Ordering::Relaxed);
        looped.map_err(|_| io::Error::other("the loop failed"))?.map_err(io::Error::other)?;
        lived.map_err(|_| io::Error::other("the gripper failed"))?
    });
    ran?;
    let counters = hot.counters();
    let dropped = counters.service_dropped + counters.recorder_dropped;
    Ok(Times { there_and_back, inside: counters.latency, samples: counters.samples, dropped })
}

/// Empties the rings now and then, until it is over.
fn drain(far: &mut Far, over: &AtomicBool) {
    while !over.load(Ordering::Relaxed) {
        far.service.drain(&mut |_| {});
        far.recorder.drain(&mut |_| {});
        while far.pulses.pop().is_ok() {}
        time::wait_us(DRAIN_US);
    }
}

/// Asks for them, and reports what was refused.
fn privileges(wanted: bool, priority: u8) {
    let mode = if wanted { RealtimeMode::Warn } else { RealtimeMode::Off };
    let granted = enter(&RealtimeConfig { mode, priority, ..RealtimeConfig::default() });
    for refused in granted.refused() {
        println!("{refused}");
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and a negative time is none"
)]
fn nanos(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}

#[expect(clippy::cast_precision_loss, reason = "below 2^53 ns")]
fn us(ns: u64) -> f64 {
    ns as f64 / 1000.0
}

/// Percentiles beside the limits, then the histogram by doublings.
fn print(kind: Kind, times: &Times) {
    let Times { there_and_back, inside, samples, dropped } = times;
    let name = match kind {
        Kind::Socket => "socket pair",
        Kind::Pty => "pseudo-terminal",
    };
    println!("\n{name}: {samples} samples, {dropped} items dropped from the rings");
    println!("| (us) | commands | p50 | p90 | p99 | p99.9 | max | limits p50 25, p99.9 250 |");
    println!("|---|---|---|---|---|---|---|---|");
    let hdr = |q| there_and_back.value_at_quantile(q);
    let loops = |q| inside.quantile_ns(q).unwrap_or(0);
    let rows: [(&str, u64, [u64; 5]); 2] = [
        (
            "frame read -> command written, in the loop",
            inside.count(),
            [loops(0.5), loops(0.9), loops(0.99), loops(0.999), inside.max_ns()],
        ),
        (
            "frame written -> command read, at the gripper",
            there_and_back.len(),
            [hdr(0.5), hdr(0.9), hdr(0.99), hdr(0.999), there_and_back.max()],
        ),
    ];
    for (what, count, [p50, p90, p99, p99_9, max]) in rows {
        let verdict = |ns, limit_us| if us(ns) <= limit_us { "PASS" } else { "over" };
        println!(
            "| {what} | {count} | {:.1} | {:.1} | {:.1} | {:.1} | {:.0} | {} {} |",
            us(p50),
            us(p90),
            us(p99),
            us(p99_9),
            us(max),
            verdict(p50, 25.0),
            verdict(p99_9, 250.0)
        );
    }
    bars(there_and_back);
}

/// How many times fell into each doubling, those at the gripper.
fn bars(times: &Histogram<u64>) {
    let bounds = (0..21).map(|doubling| 1000_u64 << doubling);
    let mut below = 0;
    for bound in bounds {
        let count = times.count_between(below, bound - 1);
        if count > 0 {
            let bar = (count * BAR).div_ceil(times.len());
            let bar = "#".repeat(usize::try_from(bar).unwrap_or(0));
            println!("{:>8.0} us {count:>8} {bar}", us(bound));
        }
        below = bound;
    }
}
