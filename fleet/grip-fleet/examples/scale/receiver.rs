//! The parts of this program in; what arrived of what was sent, and when, out.

use super::process::{Process, loopback_bytes, processor_s};
use super::relay::Relay;
use super::{Args, address, network, now_us};
use core::time::Duration;
use grip_fleet::net::{Reported, Watch};
use grip_fleet::{EventId, Selector, Since, Uid};
use grip_link::message::daemon::ToClient;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, channel};
use std::thread;

/// Longest wait for what comes next.
const LOOK: Duration = Duration::from_millis(20);

/// What a process of grippers reports at its end.
type Sent = BTreeMap<String, EventId>;

#[derive(Default)]
struct Got {
    /// Numbers in the order in which they came.
    ids: BTreeMap<Uid, Vec<EventId>>,
    missing: u64,
    /// Delays (us) by the time at which the events were reported, as [`WHEN`] names it.
    delays_us: [Vec<u64>; 3],
}

/// When an event was reported.
const WHEN: [&str; 3] =
    ["", " in the first five seconds", " while the router could not be reached"];

/// What happens when (us).
#[derive(Clone, Copy)]
struct Times {
    begun_us: u64,
    /// There is no router, or no way to it.
    away_us: (u64, u64),
}

impl Times {
    fn new(args: &Args, begun_us: u64) -> Self {
        let from_us = begun_us + 1_000_000 * u64::from(args.seconds) / 3;
        Self {
            begun_us,
            away_us: (from_us, from_us + 1_000_000 * u64::from(args.outage.max(args.cut))),
        }
    }

    fn is_away(&self, now_us: u64) -> bool {
        (self.away_us.0..self.away_us.1).contains(&now_us)
    }

    /// Which of [`WHEN`].
    fn when(&self, reported_us: u64) -> usize {
        let (from_us, to_us) = self.away_us;
        // What was under way is lost with the router; and sessions look for a new one only now and then.
        let around = from_us.saturating_sub(1_000_000)..to_us + 10_000_000;
        if from_us < to_us && around.contains(&reported_us) {
            2
        } else {
            // Hundreds of grippers come at once, and the receiver asks each for what it has shown before.
            usize::from(reported_us < self.begun_us + 5_000_000)
        }
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let address = address(args)?;
    let mut router = Some(Process::start(&["router", &address], args)?);
    let (mut last, mut more) = (address.clone(), Vec::new());
    for _ in 1..args.routers {
        let next = self::address(args)?;
        more.push(Process::start(&["router", &next, &last], args)?);
        last = next;
    }
    let way = network::client(args, &address)?;
    let mut watch = Watch::new(way.network.open()?, &Selector::default(), Since::Start, &[])?;
    let relay = (args.cut > 0).then(|| Relay::start(&last)).transpose()?;
    let place = relay.as_ref().map_or(&last, |relay| &relay.address).clone();
    let (mut got, theirs) = (Got::default(), args.clone());
    // The first of them report their events while the others come.
    let starting = thread::spawn(move || start(&theirs, &place));
    while !starting.is_finished() {
        if let Some(reported) = watch.next(LOOK)? {
            got.take(reported, &Times::new(args, now_us()));
        }
    }
    let parts = starting.join().map_err(|_| anyhow::anyhow!("a thread has panicked"))??;
    let how = if args.quic.is_some() { "QUIC" } else { "TCP" };
    let (grippers, routers, seconds) = (args.grippers, args.routers, args.seconds);
    let processes = parts.len();
    println!(
        "{grippers} grippers in {processes} processes for {seconds} s, {routers} routers in a chain, {how}"
    );
    let (begun_us, bytes, own_s) = (now_us(), loopback_bytes()?, processor_s("self")?);
    let before_s = parts.iter().map(Process::processor_s).sum::<anyhow::Result<f64>>()?;
    let times = Times::new(args, begun_us);
    let ended = listen(parts);
    let (mut router_s, mut finished) = (0.0, None);
    let (sent, late_us, after_s) = loop {
        if let Some(reported) = watch.next(LOOK)? {
            got.take(reported, &times);
        }
        let now = now_us();
        if let Some(relay) = &relay {
            relay.cut(times.is_away(now));
        } else if times.is_away(now) {
            router_s += router.take().map_or(Ok(0.0), |router| router.processor_s())?;
        } else if router.is_none() {
            router = Some(Process::start(&["router", &address], args)?);
        }
        if let Ok(found) = ended.try_recv() {
            finished = Some(found?);
        }
        if let Some((sent, ..)) = &finished
            && (got.has(sent) || now > begun_us + 1_000_000 * u64::from(args.seconds + 20))
            && let Some(finished) = finished.take()
        {
            break finished;
        }
    };
    let seconds = (now_us() - begun_us) as f64 / 1e6;
    router_s += router.as_ref().map_or(Ok(0.0), Process::processor_s)?;
    router_s += more.iter().map(Process::processor_s).sum::<anyhow::Result<f64>>()?;
    got.report(&sent);
    let each = |total: f64| total / f64::from(args.grippers) / seconds;
    println!("processor of a gripper {:.3} %", 100.0 * each(after_s - before_s));
    println!("processor of the routers {:.3} % for each gripper", 100.0 * each(router_s));
    println!(
        "processor of the receiver {:.3} % for each gripper",
        100.0 * each(processor_s("self")? - own_s)
    );
    let bytes = (loopback_bytes()? - bytes) as f64;
    println!("loopback, all hops, headers included: {:.0} bytes/s for each gripper", each(bytes));
    println!(
        "the last gripper's frame of ten samples was at most {:.1} ms late",
        late_us as f64 / 1e3
    );
    anyhow::ensure!(got.is_exactly(&sent), "events were lost, doubled or out of order");
    Ok(())
}

fn start(args: &Args, address: &str) -> anyhow::Result<Vec<Process>> {
    let (processes, mut first) = (args.processes.min(args.grippers), 0);
    let mut parts = Vec::new();
    for left in (1..=processes).rev() {
        let count = (args.grippers - first) / left;
        let part = ["grippers", address, &first.to_string(), &count.to_string()];
        parts.push(Process::start(&part, args)?);
        first += count;
    }
    Ok(parts)
}

/// Reads what the grippers have sent until all have shown it, on a thread: they stay there to answer until they are let go of.
fn listen(parts: Vec<Process>) -> Receiver<anyhow::Result<(Sent, u64, f64)>> {
    let (sender, ended) = channel();
    thread::spawn(move || {
        let mut parts = parts;
        let (mut sent, mut late_us) = (Sent::new(), 0);
        let mut read = || {
            for part in &mut parts {
                loop {
                    let line = part.line()?;
                    match line.split(' ').collect::<Vec<_>>().as_slice() {
                        ["sent", uid, run, seq] => {
                            let id = EventId { run: run.parse()?, seq: seq.parse()? };
                            sent.insert((*uid).to_owned(), id);
                        }
                        ["late", late] => late_us = late_us.max(late.parse()?),
                        _ => break,
                    }
                }
            }
            parts.iter().map(Process::processor_s).sum::<anyhow::Result<f64>>()
        };
        let found = read().map(|processor_s| (sent, late_us, processor_s));
        // Nobody listens any more where the program has failed.
        let _ended = sender.send(found);
        thread::park();
    });
    ended
}

impl Got {
    fn take(&mut self, reported: Reported, times: &Times) {
        let Reported::Event { member, id, message, missing, .. } = reported else { return };
        self.missing += missing;
        self.ids.entry(member.uid).or_default().push(id);
        let Ok(ToClient::Slip(slip)) = message.read() else { return };
        let delay_us = now_us().saturating_sub(slip.host.0);
        if let Some(delays_us) = self.delays_us.get_mut(times.when(slip.host.0)) {
            delays_us.push(delay_us);
        }
    }

    fn has(&self, sent: &Sent) -> bool {
        sent.iter().all(|(uid, last)| {
            let found = self.ids.iter().find(|(member, _)| member.to_string() == *uid);
            last.seq == 0 || found.is_some_and(|(_, ids)| ids.last() == Some(last))
        })
    }

    /// Every event once and in order.
    fn is_exactly(&self, sent: &Sent) -> bool {
        let in_order = |ids: &Vec<EventId>| ids.iter().zip(1..).all(|(id, seq)| id.seq == seq);
        self.missing == 0 && self.has(sent) && self.ids.values().all(in_order)
    }

    fn report(&mut self, sent: &Sent) {
        let wanted: u64 = sent.values().map(|id| id.seq).sum();
        let events: usize = self.ids.values().map(Vec::len).sum();
        println!("events sent {wanted}, received {events}, reported as missing {}", self.missing);
        for (delays_us, when) in self.delays_us.iter_mut().zip(WHEN) {
            delays_us.sort_unstable();
            let Some(most) = delays_us.len().checked_sub(1) else { continue };
            let at = |share: usize| {
                delays_us.get(most * share / 1000).map_or(f64::NAN, |us| *us as f64 / 1e3)
            };
            let (p50, p99, p999, last) = (at(500), at(990), at(999), at(1000));
            println!(
                "delay{when}: p50 {p50:.2} ms, p99 {p99:.2} ms, p99.9 {p999:.2} ms, longest {last:.2} ms"
            );
        }
    }
}
