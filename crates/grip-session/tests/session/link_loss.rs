//! Whatever happens to the line or to the stylus: commands stay within force and slew, nothing rises on samples that are too old, on a broken
//! stylus or on silence, and nothing opens the fingers.

use grip_link::{frame::MAX_WIRE, message::GripMode};
use grip_session::{HostConfig, Session, SessionOptions, model};
use grip_sim::{Scene, VirtualMcu, mcu::SensorFault};
use proptest::prelude::*;
use slip_core::{grip::GripState, health::SensorHealth, units::Micros};
use std::collections::VecDeque;

/// What happens to the bytes of both directions, or to the gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trouble {
    None,
    /// What the gripper sends is lost.
    Deaf,
    /// What the host sends is lost.
    Mute,
    /// What the gripper sends comes late by 20 to 120 ms, in one go where it ends.
    Late(u8),
    /// Every frame of the gripper comes again, up to 63 frames later.
    Replayed(u8),
    /// A bit of every eighth chunk of the gripper is turned.
    Noisy(u8),
    /// The port is gone, and comes back at the end.
    Unplugged,
    /// The stylus breaks for this long.
    Stylus(SensorFault),
}

fn any_trouble() -> impl Strategy<Value = Trouble> {
    use Trouble::{Deaf, Late, Mute, Noisy, None, Replayed, Stylus, Unplugged};
    prop_oneof![
        3 => Just(None),
        1 => Just(Deaf),
        1 => Just(Mute),
        2 => (20_u8..120).prop_map(Late),
        1 => (1_u8..64).prop_map(Replayed),
        1 => any::<u8>().prop_map(Noisy),
        1 => Just(Unplugged),
        1 => prop::sample::select(vec![SensorFault::Dead, SensorFault::Frozen, SensorFault::Saturated]).prop_map(Stylus),
    ]
}

/// Troubles one after the other, each for some milliseconds.
fn any_plan() -> impl Strategy<Value = Vec<(Trouble, u64)>> {
    prop::collection::vec((any_trouble(), 5_u64..150), 6..14)
}

/// A gripper, a session, and the line between them.
struct Bench {
    mcu: VirtualMcu,
    session: Session,
    trouble: Trouble,
    under_way: VecDeque<(Micros, Vec<u8>)>,
    sent: VecDeque<Vec<u8>>,
    chunks: u32,
    nonce: u16,
    last: Option<Last>,
    /// The force (N) of the last command that has reached the gripper.
    received_n: f64,
    raised: u32,
}

/// The command before, and what it was made from.
#[derive(Clone, Copy, Debug)]
struct Last {
    force_mn: i32,
    at: Micros,
    healthy: bool,
}

const F_MAX_N: f32 = 20.0;

impl Bench {
    fn new(seed: u64) -> Self {
        let text = "name = \"x\"\nmass_kg = 0.5\nfriction = 0.3\nlift_at_s = 0.2\n";
        let scene = Scene::from_toml(text).unwrap().reseeded(seed).unwrap();
        let mut config = HostConfig::default();
        config.link.sample_rate_hz = 2000;
        config.grip.f_max_n = F_MAX_N;
        let estimator = model::default_estimator().unwrap();
        let mut session = Session::new(config, estimator, SessionOptions::default()).unwrap();
        session.open(0, 1).unwrap();
        Self {
            mcu: VirtualMcu::new(&scene, 1).unwrap(),
            session,
            trouble: Trouble::None,
            under_way: VecDeque::new(),
            sent: VecDeque::new(),
            chunks: 0,
            nonce: 1,
            last: None,
            received_n: 0.0,
            raised: 0,
        }
    }

    fn begin(&mut self, trouble: Trouble) {
        let now = self.mcu.next_due();
        if self.trouble == Trouble::Unplugged && trouble != Trouble::Unplugged {
            self.nonce += 1;
            self.session.open(now.0, self.nonce).unwrap();
        } else if trouble == Trouble::Unplugged && self.trouble != Trouble::Unplugged {
            self.session.close();
            self.under_way.clear();
        }
        self.mcu.break_stylus(match trouble {
            Trouble::Stylus(fault) => Some(fault),
            _ => None,
        });
        self.trouble = trouble;
    }

    /// One turn of gripper, line and session.
    fn turn(&mut self) -> Result<(), TestCaseError> {
        let now = self.mcu.next_due();
        let before_n = self.mcu.commanded_n();
        self.mcu.advance(now);
        let drove_n = self.mcu.commanded_n();
        let allowed_n = self.received_n;
        prop_assert!(
            drove_n <= before_n.max(allowed_n) + 1e-6,
            "the gripper by itself: {drove_n} N"
        );
        let mut bytes = Vec::new();
        self.mcu.transmit(now, &mut bytes);
        self.carry(now, bytes);
        let mut arrived = Vec::new();
        while let Some((_, bytes)) = self.under_way.pop_front_if(|(due, _)| *due <= now) {
            arrived.extend(bytes);
        }
        let mut out = [0; MAX_WIRE];
        if let Some(len) = self.session.answer(now.0, &arrived, &mut out).unwrap() {
            prop_assert!(!arrived.is_empty(), "a command without a sample");
            self.judge(now)?;
            if self.give(now, &out[..len]) {
                self.received_n = self.last.map_or(0.0, |last| f64::from(last.force_mn) / 1000.0);
            }
        }
        while let Some(len) = self.session.poll_transmit(now.0, &mut out) {
            self.give(now, &out[..len]);
        }
        Ok(())
    }

    /// What the gripper has sent, on its way to the session.
    fn carry(&mut self, now: Micros, mut bytes: Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        self.chunks += 1;
        self.sent.push_back(bytes.clone());
        if self.sent.len() > 64 {
            self.sent.pop_front();
        }
        let mut due = now;
        match self.trouble {
            Trouble::Deaf | Trouble::Unplugged => return,
            Trouble::Late(ms) => due = now.plus(Micros::from_millis(u32::from(ms))),
            Trouble::Noisy(at) if self.chunks.is_multiple_of(8) => {
                let place = usize::from(at) % bytes.len();
                bytes[place] ^= 1 << (at % 8);
            }
            Trouble::Replayed(back) => {
                let old = self.sent.len().saturating_sub(usize::from(back));
                bytes.extend(self.sent.get(old).cloned().unwrap_or_default());
            }
            _ => {}
        }
        // A line keeps the order.
        let due = self.under_way.back().map_or(due, |(last, _)| due.max(*last));
        self.under_way.push_back((due, bytes));
    }

    /// Whether the bytes have reached the gripper.
    fn give(&mut self, now: Micros, bytes: &[u8]) -> bool {
        let received = !matches!(self.trouble, Trouble::Mute | Trouble::Unplugged);
        if received {
            self.mcu.receive(now, bytes);
        }
        received
    }

    /// The command that has just been made.
    fn judge(&mut self, now: Micros) -> Result<(), TestCaseError> {
        let command = self.session.link().last_grip().unwrap();
        let step = self.session.latest().unwrap();
        let clock = self.session.link().clock();
        let (force_mn, slew_n_s) = (command.force_mn, HostConfig::default().grip.slew_n_s);
        prop_assert!(force_mn as f32 <= 1000.0 * F_MAX_N, "{force_mn} mN");
        let mode = GripMode::from_code(command.mode);
        prop_assert_eq!(mode, Some(GripMode::Force), "{:?}", command);
        let now_is = Last { force_mn, at: now, healthy: step.sensors[0] == SensorHealth::Good };
        let Some(last) = self.last.replace(now_is) else { return Ok(()) };
        // Fingers that have lost their object start anew.
        let holds = !self.mcu.truth().dropped() && last.force_mn > 0;
        prop_assert!(force_mn > 0 || !holds, "opened at {now:?}");
        if force_mn <= last.force_mn {
            return Ok(());
        }
        self.raised += 1;
        let rise_mn = (force_mn - last.force_mn) as f32;
        let dt_s = now.since(last.at).as_seconds() as f32;
        prop_assert!(rise_mn <= 1000.0 * slew_n_s * dt_s + 1.5, "{rise_mn} mN in {dt_s} s");
        // Travel carries on without the stylus; without both nothing rises.
        let usable = self.session.grip_state() != Some(GripState::Fault);
        prop_assert!(
            now_is.healthy || last.healthy || usable,
            "raised by {rise_mn} mN on {:?}",
            step.sensors[0]
        );
        // The gripper counts from its start, which was at 0: a sample that is older than 60 ms, by more than the clocks may be off, raises
        // nothing.
        let unsure_us = clock.map_or(0.0, |clock| clock.uncertainty_us().min(1e6)) as u64;
        let age_us = now.since(step.t).0;
        prop_assert!(age_us <= 60_000 + unsure_us + 1000, "raised on a sample {age_us} us old");
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_trouble_of_line_or_stylus_raises_the_force_or_opens_the_fingers(
        plan in any_plan(), seed in 0_u64..1000, calm_ms in 300_u64..700
    ) {
        let mut bench = Bench::new(seed);
        for (trouble, ms) in [(Trouble::None, calm_ms)].into_iter().chain(plan) {
            bench.begin(trouble);
            let end = bench.mcu.next_due().plus(Micros(1000 * ms));
            while bench.mcu.next_due() < end {
                bench.turn()?;
            }
        }
        prop_assert!(bench.raised > 10, "the fingers have closed: {}", bench.raised);
    }
}

/// The same bench without trouble: it holds the object, so what the property sees is no gripper that never moves.
#[test]
fn without_trouble_the_bench_holds_its_object() {
    let mut bench = Bench::new(3);
    while bench.mcu.next_due() < Micros(1_500_000) {
        bench.turn().unwrap();
    }
    let truth = bench.mcu.truth();
    assert!(
        truth.lifted() && !truth.dropped() && truth.applied_n > truth.force_needed_n,
        "{truth:?}"
    );
}
