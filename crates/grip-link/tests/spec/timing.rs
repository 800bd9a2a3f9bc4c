//! Times and counts of the pages against constants of the crate where there are any, and against what the machines do.

use crate::page::assert_states;
use crate::rig::{device, hello, report};
use crate::source::constant;
use crate::targets::gripper::{CONFIG, SESSION, press, sent, written};
use grip_link::decoder::DUPLICATE_WINDOW;
use grip_link::device::{DeviceLink, KEPT_BATCHES};
use grip_link::frame::{Direction, Header, MAX_WIRE};
use grip_link::host::{HostConfig, HostLink, LinkState};
use grip_link::message::{Config, ConfigAck, Grip, Kind, MAX_CHANNELS};

/// Ticks a millisecond of the device, and microseconds of the host.
const MS: u64 = 1000;

fn linked() -> DeviceLink {
    let mut device = device();
    report(&mut device, 1, Kind::HELLO, 0, &hello());
    device
}

fn configured(config: &Config) -> (DeviceLink, Config) {
    let mut device = linked();
    report(&mut device, 2, Kind::CONFIG, 1, &config.to_bytes());
    let frames = sent(&mut device, 2);
    let (_, payload) = frames.iter().find(|(kind, _)| *kind == Kind::CONFIG_ACK).unwrap();
    (device, ConfigAck::parse(payload).unwrap().config)
}

/// Milliseconds between the second and the third frame of a type that goes out by itself.
fn period_ms(kind: Kind) -> u64 {
    let mut device = linked();
    let times: Vec<u64> = (1..4000)
        .filter(|ms| sent(&mut device, ms * MS).iter().any(|(sent, _)| *sent == kind))
        .collect();
    times[2] - times[1]
}

fn announce_ms() -> u64 {
    let mut device = device();
    let stale = Header::new(Direction::ToDevice, Kind::STOP, 0, SESSION);
    let bytes = crate::targets::gripper::wire(&stale, &[]);
    let mut ask = |ms: u64| {
        assert_eq!(device.receive(ms * MS, &mut &bytes[..]), None);
        !sent(&mut device, ms * MS).is_empty()
    };
    let times: Vec<u64> = (0..500).filter(|ms| ask(*ms)).collect();
    times[1] - times[0]
}

/// Age of the first row at which a batch that is not full goes out.
fn batch_age_ms() -> u64 {
    let (mut device, _) = configured(&Config { batch: 255, ..CONFIG });
    report(&mut device, 3, Kind::START, 2, &[]);
    let start = 10 * MS;
    let _before = sent(&mut device, start);
    device.push_i16(start, &[1, 2]).unwrap();
    let gone = |ticks: &u64| {
        let frames = sent(&mut device, start + ticks);
        frames.iter().any(|(kind, _)| *kind == Kind::SAMPLES)
    };
    (0..10 * MS).find(gone).unwrap() / MS
}

/// Time for which a force step after a long pause moves the force.
fn longest_step_ms() -> u64 {
    let (mut device, given) = configured(&CONFIG);
    let grip = Grip { ttl_ms: 100, slew_mn_s: given.slew_mn_s, ..press(1, given.force_max_mn) };
    device.drive(MS);
    report(&mut device, MS, Kind::GRIP, 2, &written(|p| grip.write(p)));
    let force_mn = u64::try_from(device.drive(90 * MS).force_mn()).unwrap();
    force_mn * 1000 / u64::from(given.slew_mn_s)
}

/// Waits after one, two, .. failures to find a gripper, with the time of HELLO \[us\].
fn back_off() -> (u64, u64) {
    let mut host = HostLink::new(HostConfig::new(CONFIG)).unwrap();
    let mut waits = Vec::new();
    let mut now = 0;
    for _ in 0..10 {
        host.open(now, SESSION).unwrap();
        now += 10_000 * MS;
        let mut out = [0; MAX_WIRE];
        let _preamble = host.poll_transmit(now, &mut out);
        while host.receive(now, &mut &[][..]).is_some() {}
        assert_eq!(host.state(), LinkState::Closed);
        waits.push(host.reopen_after_us());
    }
    assert!(waits.windows(2).all(|pair| pair[1] == (2 * pair[0]).min(waits[9])), "{waits:?}");
    (waits[0] / MS, waits[9] / MS)
}

fn states(page: &str, phrases: impl IntoIterator<Item = String>) {
    for phrase in phrases {
        assert_states(page, &[phrase]);
    }
}

#[test]
fn numbers_of_the_device() {
    let (_, shortest) = configured(&Config { ttl_ms: 0, loss_after_ms: 0, ..CONFIG });
    let (_, longest) = configured(&Config { ttl_ms: 9999, loss_after_ms: u16::MAX, ..CONFIG });
    assert_eq!(period_ms(Kind::STATS), 1000);
    assert_eq!((events_kept(), answers_kept()), (8, 8));
    states(
        "SPEC.md",
        [
            format!("| every {} ms, after every GRIP", period_ms(Kind::STATUS)),
            "| every second; change of state".to_owned(),
            format!("| IDENT of session 0, at most every {} ms |", announce_ms()),
            format!("when its first row is {} ms old.", batch_age_ms()),
            format!("with the time since the last call limited to {} ms:", longest_step_ms()),
            format!("(newest - seq) mod 65536 < {DUPLICATE_WINDOW} |"),
            format!("keeps {KEPT_BATCHES} finished batches beside the one being filled"),
            "answers, oldest first (8 wait; a ninth".to_owned(),
            "The 8 newest events wait".to_owned(),
        ],
    );
    let range = |from: u16, to: u16| format!("clamped to {from}..{to} |");
    states(
        "MESSAGES.md",
        [
            format!("life of a GRIP; {}", range(shortest.ttl_ms, longest.ttl_ms)),
            format!(
                "HOLD before the loss action; {}",
                range(shortest.loss_after_ms, longest.loss_after_ms)
            ),
            format!("| n, 0..{MAX_CHANNELS}; more is malformed |"),
        ],
    );
}

#[test]
fn numbers_of_the_host() {
    let host = HostConfig::new(CONFIG);
    let conversation = |name| constant("host/conversation.rs", name);
    let (first_wait, last_wait) = back_off();
    let tries = constant("host/request.rs", "TRIES");
    let retry_ms = constant("host/request.rs", "RETRY_US") / MS;
    assert_eq!((conversation("PING_US"), host.lost_us), (1000 * MS, 1000 * MS));
    states(
        "HOST.md",
        [
            format!(
                "| HELLO | every {} ms, the first at once |",
                conversation("HELLO_EVERY_US") / MS
            ),
            format!("| HELLO | {} s over |", host.hello_for_us / MS / 1000),
            format!("| request sent {tries} times, {retry_ms} ms after the last |"),
            format!(
                "sends PING {} times {} ms apart after IDENT and again after an OUTLIER, else every second",
                conversation("QUICK_PINGS"),
                conversation("QUICK_PING_US") / MS
            ),
            format!("no SAMPLES for more than {} ms or 3 sample periods", host.stale_us / MS),
            "no good frame for more than 1 s |".to_owned(),
            format!("waits {first_wait} ms x 2^(k-1), at most {} s", last_wait / 1000),
            format!("write `00` {} times", preamble()),
            format!("The last {} kept points", constant("clock.rs", "WINDOW")),
            format!("the {}th outlier in a row", constant("clock.rs", "OUTLIERS_TO_RESTART")),
        ],
    );
    states("SPEC.md", [format!("sent up to {tries} times {retry_ms} ms apart")]);
}

/// Events that a device kept for a host which comes late.
fn events_kept() -> u64 {
    let mut device = device();
    for fault in 0x0301..0x0401 {
        device.raise_fault(5, grip_link::message::FaultCode(fault));
    }
    report(&mut device, 6, Kind::HELLO, 0, &hello());
    let frames = sent(&mut device, 7);
    frames.iter().filter(|(kind, _)| *kind == Kind::EVENT).count() as u64
}

/// Answers that a device kept for a busy port.
fn answers_kept() -> u64 {
    let mut device = linked();
    let _ident = sent(&mut device, 2);
    for seq in 1..100 {
        report(&mut device, 3, Kind::STOP, seq, &[]);
    }
    let frames = sent(&mut device, 4);
    frames.iter().filter(|(kind, _)| *kind == Kind::ACK).count() as u64
}

fn preamble() -> u64 {
    let mut host = HostLink::new(HostConfig::new(CONFIG)).unwrap();
    host.open(0, SESSION).unwrap();
    let mut out = [7; MAX_WIRE];
    let len = host.poll_transmit(0, &mut out).unwrap();
    assert!(out[..len].iter().all(|byte| *byte == 0));
    len as u64
}
