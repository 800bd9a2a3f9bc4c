//! Many simulated grippers at one real router, all on this machine: whether a receiver gets every event once, how late, and what a gripper
//! costs.
//!
//! `cargo run --release -p grip-fleet --features zenoh --example scale -- --grippers 200 --seconds 60 --outage 20`
//!
//! Each gripper is a pipeline at 1 kHz that replays a simulated grasp in real time, with a log and a session of its own; some share a
//! process. The router is a process of its own, which an outage kills. Everything talks over the loopback interface and ends by itself.
#![expect(clippy::print_stdout, reason = "an example that prints what it finds")]

mod gripper;
mod network;
mod process;
mod receiver;
mod relay;
mod tape;

use anyhow::{Context as _, bail};
use clap::Parser;
use core::time::Duration;
use grip_fleet::net;
use std::io::Read as _;
use std::net::{TcpListener, UdpSocket};
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

#[derive(Clone, Debug, Parser)]
struct Args {
    /// Grippers in all
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u16).range(1..=2000))]
    grippers: u16,
    /// Processes that share them
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..=200))]
    processes: u16,
    /// How long they work (s)
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(5..=100_000))]
    seconds: u32,
    /// Kill the router after a third of the time, and start another one so much later (s); 0: never
    #[arg(long, default_value_t = 0)]
    outage: u32,
    /// Cut the line between grippers and router after a third of the time, for so long (s); 0: never. All of it then goes through a relay in
    /// the receiver's process, which its processor time includes.
    #[arg(long, default_value_t = 0, conflicts_with = "outage")]
    cut: u32,
    /// Routers in a chain: the grippers connect to the last, the receiver to the first
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=5), conflicts_with = "outage")]
    routers: u16,
    /// Folder of keys and certificates, of docs/certificates.sh FOLDER localhost 127.0.0.1 scale: all connections are QUIC
    /// (TLS 1.3), both sides with a certificate
    #[arg(long, value_name = "FOLDER", conflicts_with = "cut")]
    quic: Option<PathBuf>,
    /// What a process of this program is, for its own use: `router ADDRESS [ADDRESS]` or `grippers ADDRESS FIRST COUNT`
    #[arg(hide = true)]
    part: Vec<String>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let part: Vec<&str> = args.part.iter().map(String::as_str).collect();
    match part.as_slice() {
        [] => receiver::run(&args),
        ["router", address] => router(&args, address, None),
        ["router", address, before] => router(&args, address, Some(before)),
        ["grippers", address, first, count] => {
            gripper::run(address, first.parse()?, count.parse()?, &args)
        }
        other => bail!("{other:?} is no part of this program"),
    }
}

/// A router until standard input ends.
fn router(args: &Args, address: &str, before: Option<&str>) -> anyhow::Result<()> {
    let way = network::router(args, address, before)?;
    let _router = net::router(&way.network)?;
    println!("ready");
    std::io::stdin().read_to_end(&mut Vec::new())?;
    Ok(())
}

/// A place on this machine where a router can listen.
fn address(args: &Args) -> anyhow::Result<String> {
    let any = "127.0.0.1:0";
    Ok(if args.quic.is_some() {
        format!("quic/{}", UdpSocket::bind(any).context("no free port")?.local_addr()?)
    } else {
        format!("tcp/{}", TcpListener::bind(any).context("no free port")?.local_addr()?)
    })
}

/// Microseconds of the machine's clock, which all processes share.
#[expect(clippy::disallowed_methods, reason = "a measurement over several processes")]
fn now_us() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}

#[expect(clippy::disallowed_methods, reason = "grippers work in real time")]
fn pause(time: Duration) {
    std::thread::sleep(time);
}
