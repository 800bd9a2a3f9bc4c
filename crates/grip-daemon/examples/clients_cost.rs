//! Samples in, processor time of the service thread for each of them out, with 0, 1 and 2 clients that want every sample: what clients
//! cost. The clients are threads of this program on loopback TCP; the time is that of the serving thread alone, so a busy machine
//! changes it little.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use core::time::Duration;
use grip_daemon::Item;
use grip_daemon::client::Client;
use grip_daemon::clients::{About, Clients, ClientsConfig, Listen};
use grip_link::message::Versions;
use grip_link::message::daemon::{RealTime, Subscribe, Topics};
use rustix::time::{ClockId, clock_gettime};
use slip_core::{Sample, units::Micros};
use std::thread;

/// Samples a turn of the service thread, every 5 ms at 10 kHz.
const BURST: u32 = 50;
/// Turns: 20 s of samples.
const TURNS: u32 = 4_000;
const REPEATS: u32 = 5;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    println!("clients  ns a sample  of a core at 10 kHz   dropped frames");
    for count in 0..=2_u16 {
        let mut best = f64::INFINITY;
        let mut dropped = 0;
        for _ in 0..REPEATS {
            let (seconds, lost) = serve(count)?;
            best = best.min(seconds);
            dropped += lost;
        }
        let ns = 1e9 * best / f64::from(BURST * TURNS);
        println!("{count:7} {ns:12.1} {:17.3} % {dropped:16}", ns * 1e4 / 1e9 * 100.0);
    }
    Ok(())
}

/// Processor time (s) of this thread for all turns, and the frames that were dropped.
fn serve(count: u16) -> Result<(f64, u64), Box<dyn core::error::Error>> {
    let config = ClientsConfig { listen: "tcp:127.0.0.1:0".parse()?, ..ClientsConfig::default() };
    let about = About {
        name: "cost".into(),
        run_id: 1,
        dry_run: true,
        records: false,
        real_time: RealTime::NotAsked,
    };
    let mut clients = Clients::listen(config, about)?;
    let place = clients.place()?;
    let readers: Vec<_> = (1..=count).map(|nonce| reader(place.clone(), nonce)).collect();
    let mut now_us = 0;
    while clients.subscribed() < usize::from(count) {
        now_us += 1;
        clients.poll(now_us, Duration::from_millis(1))?;
    }
    let start = thread_seconds();
    for turn in 0..TURNS {
        for k in 0..BURST {
            let index = turn * BURST + k;
            let t = Micros(u64::from(index) * 100);
            let sample = Sample {
                normal_force_n: Some(2.0),
                tangential_n: Some(0.5),
                motion: Some(0.0),
                ..Sample::stylus(t, 1e-6)
            };
            clients.take(&Item::Sample { host_us: t.0, index, sample: &sample, taxels: &[] });
        }
        now_us = u64::from(turn + 1) * 5_000;
        clients.poll(now_us, Duration::ZERO)?;
        // The readers get the processor; waiting costs this thread nothing.
        thread::yield_now();
    }
    let seconds = thread_seconds() - start;
    clients.close(now_us);
    for reader in readers {
        let _ended = reader.join();
    }
    Ok((seconds, clients.counters().dropped))
}

fn reader(place: Listen, nonce: u16) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        let wanted = Subscribe {
            versions: Versions::OURS,
            topics: Topics::default(),
            every_nth: 1,
            state_ms: 0,
        };
        let patience = Duration::from_secs(10);
        let Ok(mut client) = Client::connect(&place, nonce, wanted, patience) else { return };
        while client.wait(patience, &mut |_| {}).is_ok() {}
    })
}

fn thread_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
        .as_secs_f64()
}
