//! A gripper behind a TCP forwarder of a robot arm: bytes late, in pieces and together, stalls, and requests that are lost on RS-485.

use super::{
    F85,
    device::{Device, crc},
    is_ready,
};
use crate::gripper::{Gripper, Order, State};
use std::collections::VecDeque;

const STEP_US: u64 = 250;
/// Status and refusal of a request behind the forwarder, at 115200 bits per second.
const DEVICE_US: u64 = 2500;

/// The same numbers from the same seed.
struct Chance(u64);

impl Chance {
    /// A whole number below `below`.
    fn below(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) % below
    }

    fn one_in(&mut self, count: u64) -> bool {
        self.below(count) == 0
    }
}

/// When bytes come (us), and the number of the request that they belong to.
struct Piece {
    due_us: u64,
    number: u8,
    bytes: Vec<u8>,
}

/// One direction: nothing is lost and nothing overtakes.
#[derive(Default)]
struct Way {
    due: VecDeque<Piece>,
    stalled_us: u64,
    /// What every piece is late by, besides.
    delay_us: u64,
}

impl Way {
    fn push(&mut self, now_us: u64, number: u8, bytes: &[u8], chance: &mut Chance) {
        let mut left = bytes;
        while !left.is_empty() {
            let cut = if chance.one_in(3) { 1 + chance.below(left.len() as u64) } else { 99 };
            let (piece, rest) = left.split_at(left.len().min(usize::try_from(cut).unwrap()));
            let late_us = now_us + 1000 + self.delay_us + chance.below(5000);
            let before_us = self.due.back().map_or(0, |piece| piece.due_us);
            let due_us = late_us.max(before_us).max(self.stalled_us);
            self.due.push_back(Piece { due_us, number, bytes: piece.to_vec() });
            left = rest;
        }
    }

    /// What has come by now.
    fn take(&mut self, now_us: u64) -> Vec<Piece> {
        let count = self.due.iter().take_while(|piece| piece.due_us <= now_us).count();
        self.due.drain(..count).collect()
    }
}

struct Forwarder {
    gripper: Gripper,
    device: Device,
    chance: Chance,
    now_us: u64,
    there: Way,
    back: Way,
    /// What has come to the gripper of the request that is on its way, and when its last piece did.
    request: Vec<u8>,
    piece_us: u64,
    /// Number of the newest request.
    number: u8,
}

impl Forwarder {
    fn new(seed: u64) -> Self {
        let mut gripper = Gripper::new(F85);
        gripper.opened(0);
        let device = Device { object: true, ..Device::new(true) };
        let (there, back) = (Way::default(), Way::default());
        Self {
            gripper,
            device,
            chance: Chance(seed),
            now_us: 0,
            there,
            back,
            request: Vec::new(),
            piece_us: 0,
            number: 0,
        }
    }

    fn step(&mut self) {
        self.now_us += STEP_US;
        let (now_us, mut out) = (self.now_us, Vec::new());
        if self.gripper.poll_transmit(now_us, &mut out) {
            self.number = self.number.wrapping_add(1);
            self.there.push(now_us, self.number, &out, &mut self.chance);
        }
        for Piece { number, bytes, .. } in self.there.take(now_us) {
            self.arrive(number, &bytes);
        }
        let back = self.back.take(now_us);
        let back: Vec<u8> = back.into_iter().flat_map(|piece| piece.bytes).collect();
        if !back.is_empty() {
            self.gripper.receive(now_us, &back);
        }
    }

    /// Bytes on RS-485: a gap within a request breaks it, and two that touch are none.
    fn arrive(&mut self, number: u8, bytes: &[u8]) {
        if self.now_us - core::mem::replace(&mut self.piece_us, self.now_us) > 1750 {
            self.request.clear();
        }
        self.request.extend(bytes);
        let whole = if self.request.get(1) == Some(&0x10) { 15 } else { 8 };
        if self.request.len() < whole {
            return;
        }
        let request = core::mem::take(&mut self.request);
        // The checksum of a whole with its own behind it is 0.
        if request.len() > whole || crc(&request) != 0 {
            return;
        }
        self.device.current = number;
        if let Some(answer) = self.device.answer(&request) {
            self.back.push(self.now_us + DEVICE_US, number, &answer, &mut self.chance);
        }
    }

    /// Runs, and states whether the gripper could take orders all the time.
    fn run_ms(&mut self, ms: u64) -> bool {
        let mut ready = true;
        for _ in 0..1000 * ms / STEP_US {
            self.step();
            ready &= is_ready(self.gripper.state());
        }
        ready
    }

    fn stall(&mut self, us: u64) {
        for way in [&mut self.there, &mut self.back] {
            way.stalled_us = self.now_us + us;
            for piece in &mut way.due {
                piece.due_us = piece.due_us.max(way.stalled_us);
            }
        }
    }
}

/// Whatever the line does, a state is that of the newest request.
#[test]
fn late_answers_are_never_those_of_later_requests() {
    for seed in 1..=24 {
        let mut line = Forwarder::new(seed);
        let (mut before, mut news) = (None, 0);
        for _ in 0..40_000 {
            if line.chance.one_in(400) {
                let force_n = 20.0 + f32::from(u16::try_from(line.chance.below(40)).unwrap());
                line.gripper.order(Order::Force(force_n));
            }
            if line.chance.one_in(2000) {
                let us = 20_000 + line.chance.below(300_000);
                line.stall(us);
            }
            line.step();
            let State::Ready(ready) = line.gripper.state() else { continue };
            let seen = ready.current_ma / 10;
            if before.replace(seen) != Some(seen) {
                news += 1;
                assert_eq!(seen, u16::from(line.number), "seed {seed} at {} us", line.now_us);
            }
        }
        assert!(news > 100, "seed {seed}: {news} states");
        line.run_ms(3000);
        assert!(is_ready(line.gripper.state()), "seed {seed}: found again");
        let counters = line.gripper.counters();
        assert_eq!(counters.note(), None, "an even line is not blamed: {counters:?}");
        assert!(counters.answers > 200, "{counters:?}");
    }
}

/// Answers that always come after their time-out are none, although a probe may take one for its own.
#[test]
fn a_line_that_is_late_for_good_is_silent() {
    for delay_us in [80_000, 90_000, 110_000] {
        let mut line = Forwarder::new(1);
        line.run_ms(500);
        assert!(is_ready(line.gripper.state()), "{delay_us} us: before");
        line.back.delay_us = delay_us;
        line.run_ms(1500);
        for _ in 0..40 {
            assert!(!line.run_ms(50), "{delay_us} us late at {} us", line.now_us);
        }
        line.back.delay_us = 0;
        line.run_ms(3000);
        assert!(is_ready(line.gripper.state()), "{delay_us} us: found again");
    }
}

/// Also one that takes back another whose acknowledgement was lost.
#[test]
fn the_last_order_stands_in_the_registers_whatever_became_of_those_before() {
    let force = |device: &Device| F85.model.force_n(device.registers[2].to_be_bytes()[1]);
    let mut checked = 0;
    for seed in 1..=8 {
        let mut line = Forwarder::new(seed);
        line.run_ms(500);
        for round in 0..40 {
            for force_n in [35.0, 25.0] {
                line.gripper.order(Order::Force(force_n));
                let ms = line.chance.below(25);
                line.run_ms(ms);
                let us = line.chance.below(150_000);
                line.stall(us);
            }
            line.run_ms(400);
            line.gripper.order(Order::Force(35.0));
            // What is silent for too long forgets its orders, and the loop gives them again.
            if !line.run_ms(400) {
                continue;
            }
            checked += 1;
            let holds_n = force(&line.device);
            assert!((holds_n - 35.0).abs() < 0.5, "seed {seed}, round {round}: {holds_n} N");
        }
    }
    assert!(checked > 250, "{checked} of 320");
}
