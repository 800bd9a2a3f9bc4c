//! The program gripd, a rate and a time in; whether every sample was accounted for, and what the process cost, out.
//!
//! A virtual gripper lives on one end of a pseudo-terminal, gripd on the other, with two clients that want every sample, and a recording.
//! At the end the gripper samples no more and sends what it still has; then gripd is asked to end. These counts must agree: rows that the
//! gripper sampled; samples that gripd handled and those it counted as lost; samples recorded; rows that each client got.

use super::{gripper::Gripper, process::Daemon, usage::Usage};
use crate::time;
use anyhow::{Context as _, Result, anyhow, bail};
use core::{
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Duration,
};
use grip_daemon::{client::Client, clients::Listen};
use grip_link::message::{
    Versions,
    daemon::{Subscribe, ToClient, Topics},
};
use grip_sim::{Pty, VirtualMcu, scene};
use serde::Serialize;
use serde_json::Value;
use slip_core::units::Micros;
use std::{
    fs,
    os::fd::AsFd as _,
    path::{Path, PathBuf},
    thread,
};

/// Two, as in the figure that is promised.
const CLIENTS: u16 = 2;
/// gripd is measured from here on (us): it has started, learned and gripped.
const SETTLED_US: u64 = 3_000_000;
/// Clients that get nothing new for so long (us) have got everything.
const QUIET_US: u64 = 500_000;
/// So often they are looked at, at most.
const QUIET_LOOKS: u32 = 20;

/// What is run.
#[derive(Clone, Debug)]
pub struct Soak {
    /// The program.
    pub gripd: PathBuf,
    /// A folder for the socket, the configuration and the recording.
    pub folder: PathBuf,
    /// Samples a second, 1000 to 20000; one frame a millisecond.
    pub rate_hz: u32,
    /// For so long (s), from the moment gripd has settled.
    pub seconds: f64,
    /// One look at processor and memory in so many seconds.
    pub look_s: f64,
}

/// One look at the process.
#[derive(Clone, Debug, Serialize)]
pub struct Look {
    /// Since gripd has settled (s).
    pub t_s: f64,
    /// Memory in use (kB).
    pub resident_kb: u64,
    /// Of that, not mapped from files (kB).
    pub anonymous_kb: u64,
    /// Processor time since the look before, in percent of one processor.
    pub cpu_percent: f64,
}

/// What came out.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Rows that the gripper sampled.
    pub given: u64,
    /// Samples that gripd handled.
    pub samples: u64,
    /// Rows that gripd counted as lost.
    pub lost: u64,
    /// Rows that the gripper threw away at a CONFIG, which begins anew: after a stall of the machine for longer than it waits for commands.
    pub discarded: u64,
    /// Rows that the gripper itself dropped, because the line was full.
    pub dropped_by_gripper: u64,
    /// Samples that were handled and not recorded.
    pub unrecorded: u64,
    /// Events and notes that did not reach the service thread.
    pub unreported: u64,
    /// Rows that each client got.
    pub clients: Vec<u64>,
    /// Rows of the gripper in a second.
    pub rate_hz: u32,
    /// Times that the gripper restarted: its watchdog, where its own thread stood still for 100 ms.
    pub restarts: u64,
    /// Processor time of each thread, in percent of one processor.
    pub threads_percent: Vec<(String, f64)>,
    /// Of all of them.
    pub cpu_percent: f64,
    /// Wake-ups a second.
    pub wakes_per_s: f64,
    /// Looks at the process, the first when it has settled.
    pub looks: Vec<Look>,
    /// From the last byte of a frame to the command written (us), as gripd prints it.
    pub latency_us: Value,
    /// Bytes of the recording.
    pub recorded_bytes: u64,
}

impl Report {
    /// Rows of which nobody knows: those of the gripper that gripd neither handled nor counted as lost, and that no CONFIG discarded.
    #[must_use]
    pub fn unaccounted(&self) -> i128 {
        let known = u128::from(self.samples) + u128::from(self.lost) + u128::from(self.discarded);
        i128::from(self.given) - i128::try_from(known).unwrap_or(i128::MAX)
    }

    /// Whether every sample is accounted for. A gripper that restarts forgets what it has neither sent nor counted as dropped: up to 150 ms of rows a time.
    #[must_use]
    pub fn accounted(&self) -> bool {
        let forgotten = i128::from(self.restarts) * i128::from(self.rate_hz) * 150 / 1000;
        (0..=forgotten).contains(&self.unaccounted())
    }

    /// The same, by gripd and in the recording. What a stalled machine made the gripper lose is accounted for, if it was counted.
    #[must_use]
    pub fn fine(&self) -> bool {
        self.accounted() && self.unrecorded == 0 && self.samples > 0
    }

    /// Largest memory in use after `skip_s` over the least (kB).
    #[must_use]
    pub fn growth_kb(&self, skip_s: f64) -> u64 {
        let later =
            self.looks.iter().filter(|look| look.t_s >= skip_s).map(|look| look.resident_kb);
        later.clone().max().unwrap_or(0) - later.min().unwrap_or(0)
    }
}

/// What the threads share.
#[derive(Debug, Default)]
struct Shared {
    /// The gripper is to sample no more.
    stop: AtomicBool,
    /// The clients are to end.
    over: AtomicBool,
    rows: [AtomicU64; CLIENTS as usize],
}

impl Shared {
    /// Waits until nothing more arrives.
    fn settle(&self) {
        let arrived = || self.rows.iter().map(|rows| rows.load(Ordering::Relaxed)).sum::<u64>();
        for _ in 0..QUIET_LOOKS {
            let before = arrived();
            time::wait_us(QUIET_US);
            if arrived() == before {
                return;
            }
        }
    }
}

/// Runs it. `clock` gives nanoseconds since its first call or before; `reported` gets each look as it is taken.
///
/// # Errors
/// Where something else failed than the counts.
pub fn run(
    soak: &Soak,
    clock: &(dyn Fn() -> u64 + Sync),
    reported: &mut dyn FnMut(&Look),
) -> Result<Report> {
    let pty = Pty::open(None)?;
    let scene = scene::load("default")?;
    let mut device = Gripper::new(VirtualMcu::new(&scene, 1)?);
    let mut daemon = start(soak, pty.port())?;
    let shared = Shared::default();
    let (device, looks) = thread::scope(|threads| {
        let gripping = threads.spawn(|| {
            device.live(pty.as_fd(), &shared.stop, clock, &mut |_| {})?;
            // What the gripper still has, by its own clock so much later that the batch under way is over.
            device.empty(pty.as_fd(), Micros(clock() / 1000 + 10_000)).map(|()| device)
        });
        for nonce in 0..CLIENTS {
            let shared = &shared;
            threads.spawn(move || listen(&soak.socket(), nonce, shared));
        }
        let looks = watch(soak, daemon.id(), clock, reported);
        shared.stop.store(true, Ordering::Relaxed);
        let device = gripping.join();
        shared.settle();
        shared.over.store(true, Ordering::Relaxed);
        let device = device.map_err(|_| anyhow!("the thread of the gripper failed"))?;
        anyhow::Ok((device.context("the line")?, looks))
    })?;
    // Also where the process is gone already: its output states why.
    let summary = end(&mut daemon)?;
    report(soak, &device, looks?, &summary, &shared)
}

impl Soak {
    fn socket(&self) -> Listen {
        Listen::Unix(self.folder.join("gripd.sock"))
    }
}

fn start(soak: &Soak, port: &Path) -> Result<Daemon> {
    let config = soak.folder.join("gripd.toml");
    let batch = soak.rate_hz.div_ceil(1000);
    let text = format!("[link]\nsample_rate_hz = {}\nbatch = {batch}\n", soak.rate_hz);
    fs::write(&config, text).context("the configuration")?;
    let (socket, port) = (soak.socket().to_string(), port.display().to_string());
    let recorded = ["--json", "--config", "gripd.toml", "--record", "run.mcap"];
    let places = ["--log-level", "error", "--listen", &socket, "--port", &port];
    Daemon::start(&soak.gripd, &soak.folder, &[&recorded[..], &places].concat())
}

/// A client that wants every sample and every state, until the soak is over or gripd gone.
fn listen(place: &Listen, nonce: u16, shared: &Shared) {
    let wanted =
        Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 1, state_ms: 10 };
    let patience = Duration::from_secs(1);
    let mut client = None;
    let rows = shared.rows.get(usize::from(nonce));
    let mut count = |message: &ToClient<'_>| {
        if let (ToClient::Rows(batch), Some(rows)) = (message, rows) {
            rows.fetch_add(batch.header.rows.into(), Ordering::Relaxed);
        }
    };
    while !shared.over.load(Ordering::Relaxed) {
        match &mut client {
            None => {
                client = Client::connect(place, nonce + 1, wanted, patience).ok();
                if client.is_none() {
                    time::wait_us(10_000);
                }
            }
            Some(connected) => {
                if connected.wait(Duration::from_millis(100), &mut count).is_err() {
                    return;
                }
            }
        }
    }
}

/// Looks at the process until the time is over: the usage at the first and the last look, and all of them.
fn watch(
    soak: &Soak,
    id: u32,
    clock: &dyn Fn() -> u64,
    reported: &mut dyn FnMut(&Look),
) -> Result<Looks> {
    let gone = "gripd is gone";
    time::wait_us(SETTLED_US);
    let (start_ns, first) = (clock(), Usage::of(id).context(gone)?);
    let (mut looks, mut last, mut last_ns) = (Vec::new(), first.clone(), start_ns);
    loop {
        let t_s = seconds(last_ns - start_ns);
        let left_s = soak.seconds - t_s;
        if left_s <= 0.0 {
            let usage = last;
            return Ok(Looks { first, usage, seconds: t_s, looks });
        }
        time::wait_us(micros(left_s.min(soak.look_s)));
        let (now_ns, usage) = (clock(), Usage::of(id).context(gone)?);
        let cpu_ns = usage.since(&last).values().sum::<u64>();
        let look = Look {
            t_s: seconds(now_ns - start_ns),
            resident_kb: usage.resident_kb,
            anonymous_kb: usage.anonymous_kb,
            cpu_percent: 100.0 * seconds(cpu_ns) / seconds(now_ns - last_ns),
        };
        reported(&look);
        looks.push(look);
        (last, last_ns) = (usage, now_ns);
    }
}

#[derive(Debug)]
struct Looks {
    first: Usage,
    usage: Usage,
    seconds: f64,
    looks: Vec<Look>,
}

/// Asks gripd to end: its last line.
fn end(daemon: &mut Daemon) -> Result<Value> {
    let status = daemon.end()?;
    let printed = daemon.printed();
    let last = printed.lines().next_back().unwrap_or_default();
    match serde_json::from_str::<Value>(last) {
        Ok(summary) if summary["type"] == "summary" => Ok(summary),
        _ => bail!("gripd: {status}, no summary; it said: {}", daemon.log().trim()),
    }
}

fn report(
    soak: &Soak,
    device: &Gripper,
    watched: Looks,
    summary: &Value,
    shared: &Shared,
) -> Result<Report> {
    let number =
        |name: &str| summary[name].as_u64().with_context(|| format!("no {name} in {summary}"));
    let percent = |ns: u64| 100.0 * seconds(ns) / watched.seconds;
    let threads = watched.usage.since(&watched.first);
    let cpu_percent = percent(threads.values().sum());
    #[expect(clippy::cast_precision_loss, reason = "a count of wake-ups")]
    let wakes = watched.usage.waits.saturating_sub(watched.first.waits) as f64;
    let recording = fs::metadata(soak.folder.join("run.mcap")).context("the recording")?;
    Ok(Report {
        given: device.rows(),
        discarded: device.discarded(),
        samples: number("samples")?,
        lost: number("lost")?,
        dropped_by_gripper: device.mcu.link().dropped_rows().into(),
        unrecorded: number("unrecorded_samples")?,
        unreported: number("untold_notes")?,
        clients: shared.rows.iter().map(|rows| rows.load(Ordering::Relaxed)).collect(),
        rate_hz: soak.rate_hz,
        restarts: u64::from(device.mcu.boot_id().saturating_sub(1)),
        threads_percent: threads.into_iter().map(|(name, ns)| (name, percent(ns))).collect(),
        cpu_percent,
        wakes_per_s: wakes / watched.seconds,
        looks: watched.looks,
        latency_us: summary["latency_us"].clone(),
        recorded_bytes: recording.len(),
    })
}

fn seconds(ns: u64) -> f64 {
    Duration::from_nanos(ns).as_secs_f64()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and a negative time is none"
)]
fn micros(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}
