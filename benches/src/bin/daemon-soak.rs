//! Minutes of gripd on a pseudo-terminal with a virtual gripper, two clients that want every sample, and a recording; whether every
//! sample was accounted for, and what the process cost, as one JSON object. Exit code 1 where a sample is not accounted for.
//!
//! At the end the gripper samples no more and sends what it still has; then gripd is asked to end. These counts must agree: rows that the
//! gripper sampled; samples that gripd handled, those it counted as lost, and rows that a CONFIG discarded; samples recorded.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints its result")]

use anyhow::{Context as _, Result, anyhow, ensure};
use clap::Parser;
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
use serde_json::{Value, json};
use slip_benches::{daemon::gripper::Gripper, time};
use slip_core::units::Micros;
use std::{collections::BTreeMap, fs, os::fd::AsFd as _, path::PathBuf, process::ExitCode, thread};
use stories::{Program, Signal};

/// gripd is measured from here on (us): it has started, learned and gripped.
const SETTLED_US: u64 = 3_000_000;
/// Clients get what is still on its way within this time (us).
const QUIET_US: u64 = 1_000_000;
/// A gripper that restarts forgets what it has neither sent nor counted as dropped: up to so many ms of rows a time.
const FORGOTTEN_MS: u64 = 150;

/// Runs gripd against a virtual gripper, with two clients that want every sample, and a recording.
#[derive(Debug, Parser)]
struct Cli {
    /// How long, after gripd has started and gripped
    #[arg(long, default_value_t = 30.0)]
    minutes: f64,
    /// Samples a second, 1000 to 20000; one frame a millisecond
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1000..=20_000))]
    rate: u32,
    /// The program; beside this one, unless it is named
    #[arg(long, value_name = "FILE")]
    gripd: Option<PathBuf>,
}

fn main() -> Result<ExitCode> {
    let cli = Cli::parse();
    let folder = tempfile::tempdir()?;
    let socket = Listen::Unix(folder.path().join("gripd.sock"));
    let pty = Pty::open(None)?;
    let mut gripper = Gripper::new(VirtualMcu::new(&scene::load("default")?, 1)?);
    let config =
        format!("[link]\nsample_rate_hz = {}\nbatch = {}\n", cli.rate, cli.rate.div_ceil(1000));
    fs::write(folder.path().join("gripd.toml"), config)?;
    let (listen, port) = (socket.to_string(), pty.port().display().to_string());
    let args = ["--json", "--config", "gripd.toml", "--record", "run.mcap", "--log-level", "error"];
    let args = [&args[..], &["--listen", &listen, "--port", &port]].concat();
    let beside = std::env::current_exe()?.with_file_name("gripd");
    let gripd = std::path::absolute(cli.gripd.clone().unwrap_or(beside))?;
    let daemon = Program::start(&gripd, folder.path(), &args);
    let (clock, stop, over) = (time::clock(), AtomicBool::new(false), AtomicBool::new(false));
    let rows = [const { AtomicU64::new(0) }; 2];
    let cost = thread::scope(|threads| {
        let gripping = threads.spawn(|| {
            gripper.live(pty.as_fd(), &stop, &clock)?;
            // What the gripper still has, by its own clock so much later that the batch under way is over.
            gripper.send(pty.as_fd(), Micros(clock() / 1000 + 10_000))
        });
        for (nonce, rows) in (1..).zip(&rows) {
            let (socket, over) = (&socket, &over);
            threads.spawn(move || listen_to(socket, nonce, rows, over));
        }
        let cost = watch(daemon.id(), cli.minutes * 60.0, &clock);
        stop.store(true, Ordering::Relaxed);
        let gripped = gripping.join();
        time::wait_us(QUIET_US);
        over.store(true, Ordering::Relaxed);
        gripped.map_err(|_| anyhow!("the thread of the gripper failed"))?.context("the line")?;
        cost
    })?;
    daemon.signal(Signal::TERM);
    let ended = daemon.ended();
    let summary = ended.summary();
    ensure!(summary["type"] == "summary", "no summary: {ended:?}");
    let number = |name: &str| summary[name].as_u64().with_context(|| format!("{name}: {summary}"));
    let restarts = u64::from(gripper.mcu.boot_id().saturating_sub(1));
    let known = number("samples")? + number("lost")? + gripper.discarded();
    let unaccounted = i128::from(gripper.rows()) - i128::from(known);
    let forgotten = i128::from(restarts * u64::from(cli.rate) * FORGOTTEN_MS / 1000);
    let fine = (0..=forgotten).contains(&unaccounted)
        && number("unrecorded_samples")? == 0
        && number("samples")? > 0;
    let report = json!({
        "minutes": cli.minutes, "rate_hz": cli.rate, "machine": time::machine(), "fine": fine,
        "given": gripper.rows(), "samples": summary["samples"], "lost": summary["lost"],
        "discarded": gripper.discarded(), "dropped_by_gripper": gripper.mcu.link().dropped_rows(),
        "unaccounted": i64::try_from(unaccounted)?, "restarts": restarts,
        "unrecorded": summary["unrecorded_samples"], "unreported": summary["untold_notes"],
        "clients": rows.each_ref().map(|rows| rows.load(Ordering::Relaxed)),
        "latency_us": summary["latency_us"], "cost": cost,
        "recorded_bytes": fs::metadata(folder.path().join("run.mcap"))?.len(),
    });
    println!("{report:#}");
    Ok(if fine { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A client that wants every sample and every state, until it is over or gripd gone.
fn listen_to(place: &Listen, nonce: u16, rows: &AtomicU64, over: &AtomicBool) {
    let wanted =
        Subscribe { versions: Versions::OURS, topics: Topics::ALL, every_nth: 1, state_ms: 10 };
    let mut count = |message: &ToClient<'_>| {
        if let ToClient::Rows(batch) = message {
            rows.fetch_add(batch.header.rows.into(), Ordering::Relaxed);
        }
    };
    while !over.load(Ordering::Relaxed) {
        let Ok(mut client) = Client::connect(place, nonce, wanted, Duration::from_secs(1)) else {
            time::wait_us(10_000);
            continue;
        };
        while !over.load(Ordering::Relaxed) {
            if client.wait(Duration::from_millis(100), &mut count).is_err() {
                return;
            }
        }
    }
}

/// Processor time (percent of one) and memory (kB) of a process over so many seconds, a look each minute.
fn watch(id: u32, seconds: f64, clock: &dyn Fn() -> u64) -> Result<Value> {
    time::wait_us(SETTLED_US);
    let (start_ns, first) = (clock(), threads_ns(id)?);
    let passed_s = || Duration::from_nanos(clock() - start_ns).as_secs_f64();
    let mut memory = Vec::new();
    loop {
        let status = fs::read_to_string(format!("/proc/{id}/status")).context("gripd is gone")?;
        let kb = ["VmRSS:", "RssAnon:"].map(|name| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok())
        });
        eprintln!("{:6.0} s: resident, anonymous (kB) {kb:?}", passed_s());
        memory.push(json!({"t_s": passed_s(), "resident_kb": kb[0], "anonymous_kb": kb[1]}));
        let left_s = seconds - passed_s();
        if left_s <= 0.0 {
            break;
        }
        wait_s(left_s.min(60.0));
    }
    let lasted_s = passed_s();
    let used = threads_ns(id)?.into_iter().map(|(name, ns)| {
        let ns = ns - first.get(&name).copied().unwrap_or(0);
        (name, 100.0 * Duration::from_nanos(ns).as_secs_f64() / lasted_s)
    });
    let threads: BTreeMap<String, f64> = used.collect();
    Ok(
        json!({"all_percent": threads.values().sum::<f64>(), "threads_percent": threads, "memory": memory}),
    )
}

/// Waits so many seconds.
fn wait_s(seconds: f64) {
    time::wait_us(u64::try_from(Duration::from_secs_f64(seconds).as_micros()).unwrap_or(0));
}

/// Processor time of each thread of a process by its name (ns); threads of one name are added up.
fn threads_ns(id: u32) -> Result<BTreeMap<String, u64>> {
    let mut threads = BTreeMap::new();
    for task in fs::read_dir(format!("/proc/{id}/task"))? {
        let task = task?.path();
        // A thread may end while it is looked at.
        let read = |name| fs::read_to_string(task.join(name)).unwrap_or_default();
        let (name, times) = (read("comm"), read("schedstat"));
        let ns: u64 = times.split_whitespace().next().and_then(|ns| ns.parse().ok()).unwrap_or(0);
        *threads.entry(name.trim().to_owned()).or_default() += ns;
    }
    Ok(threads)
}
