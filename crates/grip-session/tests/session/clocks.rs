//! A gripper whose clock lies, and one that puts limits in force that cannot be: a virtual gripper whose frames are altered on their way.

use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::{Header, MAX_WIRE, encode},
    host::{CloseReason, HostEvent, LinkState},
    message::Kind,
};
use grip_session::{
    HostConfig, Session, SessionOptions, Update, model,
    report::{Condition, Event},
};
use grip_sim::{Scene, VirtualMcu};

/// The clock of the gripper: what its ticks are at host time `t_us`.
type Clock = fn(u64) -> u64;

/// When everything happens (us).
const FAULT_US: u64 = 1_000_000;
const END_US: u64 = 5_000_000;

struct Bench {
    mcu: VirtualMcu,
    session: Session,
    decoder: Decoder,
    /// Times of health lines of the clock (host us) and what they report.
    lines: Vec<(u64, &'static str)>,
    closed: Vec<CloseReason>,
    /// Steps between usable samples: the longest (us), and the last time.
    longest_us: u64,
    last_us: Option<u64>,
    blind: u32,
    /// Largest age of a sample in the last second (us).
    oldest_us: u64,
    /// Changes the settings in force.
    config: Option<(usize, u32)>,
}

/// Gripper and host of 4 kHz in frames of a millisecond.
fn bench() -> Bench {
    let text = "name = \"x\"\nmass_kg = 0.5\nfriction = 0.4\nlift_at_s = 0.5\n";
    let mut config = HostConfig::default();
    config.link.sample_rate_hz = 4000;
    let estimator = model::default_estimator().unwrap();
    let mut session = Session::new(config, estimator, SessionOptions::default()).unwrap();
    session.open(0, 1).unwrap();
    let mut decoder = Decoder::new(Role::Host);
    decoder.open_session(1, None);
    Bench {
        mcu: VirtualMcu::new(&Scene::from_toml(text).unwrap(), 1).unwrap(),
        session,
        decoder,
        lines: Vec::new(),
        closed: Vec::new(),
        longest_us: 0,
        last_us: None,
        blind: 0,
        oldest_us: 0,
        config: None,
    }
}

impl Bench {
    /// What the gripper sent, with other ticks, and other settings in CONFIG_ACK.
    fn altered(&mut self, bytes: &[u8], clock: Clock) -> Vec<u8> {
        let (mut input, mut all) = (bytes, Vec::new());
        while let Some(verdict) = self.decoder.next(&mut input) {
            let Verdict::Frame(frame) = verdict else { continue };
            let mut payload = frame.payload.to_vec();
            let mut tick = |at: usize| {
                let bytes: [u8; 8] = payload[at..at + 8].try_into().unwrap();
                payload[at..at + 8]
                    .copy_from_slice(&clock(u64::from_le_bytes(bytes)).to_le_bytes());
            };
            match frame.header.kind {
                Kind::SAMPLES => tick(4),
                Kind::PONG => {
                    tick(8);
                    tick(16);
                }
                Kind::CONFIG_ACK => {
                    if let Some((at, value)) = self.config {
                        payload[8 + at..12 + at].copy_from_slice(&value.to_le_bytes());
                        let crc = grip_link::crc::crc32c(&payload[8..]);
                        payload[..4].copy_from_slice(&crc.to_le_bytes());
                    }
                }
                _ => {}
            }
            let header = Header { ..frame.header };
            let mut out = [0; MAX_WIRE];
            let len = encode(&header, &payload, &mut out).unwrap();
            all.extend(&out[..len]);
        }
        all
    }

    fn run(&mut self, until_us: u64, clock: Clock) {
        let mut out = [0; MAX_WIRE];
        while self.mcu.next_due().0 < until_us {
            let now = self.mcu.next_due();
            self.mcu.advance(now);
            let mut bytes = Vec::new();
            self.mcu.transmit(now, &mut bytes);
            let bytes = self.altered(&bytes, clock);
            let Self { session, lines, closed, longest_us, last_us, oldest_us, .. } = self;
            let mut left = bytes.as_slice();
            while let Some(updates) = session.receive(now.0, &mut left).unwrap() {
                match updates {
                    Update::Event(Event::Health {
                        condition: condition @ Condition::Clock(_),
                        ..
                    }) => lines.push((now.0, condition.name())),
                    Update::Link(HostEvent::Closed(reason)) => closed.push(reason),
                    Update::Step { sample, .. } => {
                        let last = last_us.replace(sample.t.0).unwrap_or(sample.t.0);
                        assert!(sample.t.0 >= last, "back to {:?}", sample.t);
                        *longest_us = (*longest_us).max(sample.t.0 - last);
                        if now.0 + 1_000_000 > until_us {
                            *oldest_us = (*oldest_us).max(sample.arrival.unwrap().age.0);
                        }
                    }
                    _ => {}
                }
            }
            if let Some(len) = session.command(now.0, &mut out) {
                self.mcu.receive(now, &out[..len]);
            }
            self.blind += u32::from(self.session.is_blind(now.0));
            while let Some(len) = self.session.poll_transmit(now.0, &mut out) {
                self.mcu.receive(now, &out[..len]);
            }
        }
    }
}

/// Before, nothing of this was seen: rows whose time did not follow were dropped, for as long as a jump back is wide.
#[test]
fn a_clock_that_lies_is_reported_and_the_object_is_held() {
    let cases: [(&str, &[&str], u64, Clock); 8] = [
        ("good", &[], 0, |t| t),
        ("stops", &["stopped"], 50_000, |t| t.min(FAULT_US)),
        ("back 3 s", &["back", "good"], 50_000, |t| {
            if t < FAULT_US { t + (1 << 33) } else { t + (1 << 33) - 3_000_000 }
        }),
        ("back 1 h", &["back", "good"], 50_000, |t| {
            if t < FAULT_US { t + (1 << 33) } else { t + (1 << 33) - 3_600_000_000 }
        }),
        ("forward 1 h", &["forward", "good"], 50_000, |t| {
            if t < FAULT_US { t } else { t + 3_600_000_000 }
        }),
        ("5 % fast", &["fast"], 2_000_000, |t| t + t.saturating_sub(FAULT_US) / 20),
        ("5 % slow", &["slow"], 2_000_000, |t| t - t.saturating_sub(FAULT_US) / 20),
        ("wraps", &[], 0, |t| t.wrapping_add(u64::MAX - FAULT_US)),
    ];
    for (name, reported, within_us, clock) in cases {
        let mut bench = bench();
        bench.run(END_US, clock);
        let names: Vec<&str> = bench.lines.iter().map(|(_, health)| *health).collect();
        assert_eq!(names, reported, "{name}: {:?}", bench.lines);
        if let Some((at_us, _)) = bench.lines.first() {
            assert!(at_us - FAULT_US <= within_us, "{name}: {:?}", bench.lines);
        }
        let truth = bench.mcu.truth();
        assert!(truth.lifted() && !truth.dropped(), "{name}: {truth:?}");
        assert_eq!(bench.blind, 0, "{name}");
        assert!(bench.longest_us < 2_000, "{name}: a step of {} us", bench.longest_us);
        assert!(bench.oldest_us < 6_000, "{name}: samples {} us old", bench.oldest_us);
    }
}

/// Silence of samples, with frames of another kind still coming: the session is blind after 50 ms.
#[test]
fn a_session_without_rows_is_blind() {
    let mut bench = bench();
    bench.run(1_000_000, |t| t);
    let now_us = bench.mcu.next_due().0;
    assert!(!bench.session.is_blind(now_us + 45_000) && bench.session.is_blind(now_us + 55_000));
}

/// A rate and limits that no controller works with: the link closes with a reason, and a gripper that answers well is worked with again.
#[test]
fn impossible_settings_close_the_link_and_end_nothing() {
    for (at, value) in [(0, 1), (0, 100_000_000), (12, 2)] {
        for begins_us in [0, 1_500_000] {
            let mut bench = bench();
            if begins_us > 0 {
                bench.run(begins_us, |t| t);
                bench.session.close();
                bench.session.open(begins_us, 2).unwrap();
                bench.decoder.open_session(2, None);
            }
            bench.config = Some((at, value));
            bench.run(begins_us + 300_000, |t| t);
            assert!(
                matches!(bench.closed[..], [CloseReason::BadConfig { .. }]),
                "{at} {value}: {:?}",
                bench.closed
            );
            assert_eq!(bench.session.link().state(), LinkState::Closed);
            assert!(bench.session.refusal().is_some());
            bench.config = None;
            bench.session.open(begins_us + 300_000, 3).unwrap();
            bench.decoder.open_session(3, None);
            bench.run(begins_us + 900_000, |t| t);
            assert_eq!(bench.session.link().state(), LinkState::Stream);
            assert!(bench.session.counters().commands > 0);
        }
    }
}
