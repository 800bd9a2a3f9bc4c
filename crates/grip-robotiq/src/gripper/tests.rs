mod device;
mod forwarder;

use super::{Gripper, GripperConfig, Order, State};
use crate::{Fault, Model};
use device::Device;

struct Bench {
    gripper: Gripper,
    device: Device,
    now_us: u64,
}

impl Bench {
    fn new(config: GripperConfig, device: Device) -> Self {
        let mut gripper = Gripper::new(config);
        gripper.opened(0);
        Self { gripper, device, now_us: 0 }
    }

    fn run(&mut self, ms: u64) -> State {
        let mut out = Vec::new();
        for _ in 0..ms {
            self.now_us += 1000;
            if self.gripper.poll_transmit(self.now_us, &mut out)
                && let Some(answer) = self.device.answer(&out)
            {
                let (one, other) = answer.split_at(3);
                self.gripper.receive(self.now_us + 300, one);
                self.gripper.receive(self.now_us + 700, other);
            }
        }
        self.gripper.state()
    }
}

const F85: GripperConfig = GripperConfig::new(Model::F85);

fn is_ready(state: State) -> bool {
    matches!(state, State::Ready(_))
}

/// Whether something that was written opens the fingers: a requested position of 0, or an end of the activation.
fn opens(writes: &[[u16; 3]]) -> bool {
    writes.iter().any(|[action, position, _]| *position == 0 || action & 0x0100 == 0)
}

#[test]
fn forces_become_registers_and_only_a_change_is_written() {
    let mut bench = Bench::new(F85, Device::new(true));
    assert!(is_ready(bench.run(50)));
    bench.gripper.order(Order::Force(1.2));
    bench.run(20);
    bench.gripper.order(Order::Force(35.0));
    bench.run(20);
    bench.gripper.order(Order::Force(35.1));
    bench.run(20);
    let force = |register: u8| [0x0900, 0x00FF, u16::from_be_bytes([32, register])];
    assert_eq!(bench.device.writes, [force(0), force(18)]);
    let State::Ready(ready) = bench.gripper.state() else { panic!() };
    assert!((ready.asked_n.unwrap() - 35.18).abs() < 0.01 && !ready.moving && !ready.holds);
    bench.device.object = true;
    let State::Ready(ready) = bench.run(20) else { panic!() };
    assert!(ready.holds && !ready.moving);
}

#[test]
fn a_stop_keeps_what_is_held_and_lets_fingers_stand_that_hold_nothing() {
    let mut bench = Bench::new(F85, Device::new(true));
    bench.device.object = true;
    bench.run(50);
    bench.gripper.order(Order::Force(40.0));
    bench.run(100);
    let [_, position, strength] = bench.device.registers;
    let (follows, stands) = ([0x0900, position, strength], [0x0100, position, strength]);
    bench.gripper.order(Order::Stop);
    bench.run(100);
    assert_eq!(bench.device.registers, follows, "the force stays");
    bench.device.object = false;
    bench.run(100);
    assert_eq!(bench.device.registers, stands, "what has gone is not followed");
    bench.gripper.order(Order::Keep);
    bench.run(100);
    assert_eq!(bench.device.registers, stands);
    bench.gripper.order(Order::Force(40.0));
    bench.run(100);
    assert_eq!(bench.device.registers, follows);
    assert!(!opens(&bench.device.writes), "{:?}", bench.device.writes);
}

#[test]
fn nothing_but_the_order_opens_the_fingers() {
    let mut bench = Bench::new(F85, Device::new(true));
    bench.device.object = true;
    bench.run(50);
    bench.gripper.order(Order::Force(40.0));
    bench.run(50);
    for force_n in [f32::NAN, 0.0, -1.0] {
        bench.gripper.order(Order::Force(force_n));
        bench.run(50);
    }
    bench.gripper.order(Order::Keep);
    bench.device.fault = 0x0E;
    assert_eq!(bench.run(100), State::Faulty(Fault::Gripper(0x0E)));
    bench.gripper.order(Order::Open);
    bench.device.fault = 0;
    assert!(is_ready(bench.run(100)), "what was ordered at fault is not done later");
    bench.device.answers = false;
    bench.gripper.order(Order::Force(90.0));
    assert_eq!(bench.run(1000), State::Silent);
    let before = bench.device.writes.len();
    bench.gripper.closed();
    bench.gripper.opened(bench.now_us);
    bench.device.answers = true;
    assert!(is_ready(bench.run(300)));
    assert_eq!(bench.device.writes.len(), before, "nor what was ordered before the silence");
    assert!(!opens(&bench.device.writes), "{:?}", bench.device.writes);
    bench.gripper.order(Order::Open);
    bench.run(50);
    assert!(opens(&bench.device.writes));
}

#[test]
fn an_activation_is_asked_for_and_comes_once() {
    let mut bench = Bench::new(F85, Device::new(false));
    assert_eq!(bench.run(300), State::NotActivated);
    assert!(bench.device.writes.is_empty());
    let config = GripperConfig { activate: true, ..F85 };
    let mut bench = Bench::new(config, Device::new(false));
    assert!(is_ready(bench.run(300)));
    assert_eq!(bench.device.writes, [[0; 3], [0x0100, 0, 0]]);
    // Without power for a moment: it may hold something, and stays as it is.
    bench.device.activated = false;
    assert_eq!(bench.run(300), State::NotActivated);
    assert_eq!(bench.device.writes.len(), 2);
}

#[test]
fn a_reset_gripper_has_let_go_what_it_held() {
    let mut bench = Bench::new(F85, Device::new(true));
    bench.device.object = true;
    bench.run(50);
    bench.gripper.order(Order::Force(40.0));
    bench.run(100);
    assert!(!bench.gripper.take_let_go());
    // Without power, then activated by hand, which opens the fingers.
    (bench.device.activated, bench.device.registers) = (false, [0; 3]);
    assert_eq!(bench.run(300), State::NotActivated);
    assert!(bench.gripper.take_let_go() && !bench.gripper.take_let_go());
    (bench.device.activated, bench.device.registers) = (true, [0x0100, 0, 0]);
    let before = bench.device.writes.len();
    let State::Ready(ready) = bench.run(300) else { panic!() };
    assert!(ready.asked_n.is_none() && !ready.holds);
    assert_eq!(bench.device.writes.len(), before);
    bench.gripper.order(Order::Force(40.0));
    bench.run(100);
    assert_eq!(bench.device.registers[1], 255, "a new order closes them again");
    let State::Ready(ready) = bench.gripper.state() else { panic!() };
    assert!(ready.asked_n.is_some() && !bench.gripper.take_let_go());
}

#[test]
fn what_others_did_while_the_line_was_away_is_no_grip_of_ours() {
    for (registers, object, after) in [
        // As it was left; opened; opened and closed on something by another program; made to stand.
        ([0x0900, 255, 0x2012], true, "ours"),
        ([0x0900, 0, 0x2012], true, "free"),
        ([0x0900, 200, 0x2012], true, "theirs"),
        ([0x0100, 255, 0x2012], true, "free"),
    ] {
        let mut bench = Bench::new(F85, Device::new(true));
        bench.device.object = object;
        bench.run(50);
        bench.gripper.order(Order::Force(35.0));
        bench.run(100);
        bench.gripper.closed();
        bench.device.registers = registers;
        bench.gripper.opened(bench.now_us);
        let state = match bench.run(300) {
            State::Ready(ready) if ready.asked_n.is_some() => "ours",
            State::Ready(_) => "free",
            State::Occupied => "theirs",
            state => panic!("{state:?}"),
        };
        assert_eq!((state, bench.gripper.take_let_go()), (after, after != "ours"), "{registers:?}");
    }
}

#[test]
fn a_grip_whose_acknowledgement_was_lost_is_ours() {
    let mut bench = Bench::new(F85, Device::new(true));
    bench.device.object = true;
    bench.run(50);
    bench.gripper.order(Order::Open);
    bench.run(50);
    bench.gripper.order(Order::Force(35.0));
    bench.device.answers = false;
    assert_eq!(bench.run(400), State::Silent);
    bench.device.answers = true;
    let State::Ready(ready) = bench.run(200) else { panic!() };
    assert!(ready.holds && (ready.asked_n.unwrap() - 35.0).abs() < 0.5);
    assert!(!bench.gripper.take_let_go());
}

#[test]
fn what_is_reported_in_a_fault_is_no_loss() {
    let mut bench = Bench::new(F85, Device::new(true));
    bench.device.object = true;
    bench.run(50);
    bench.gripper.order(Order::Force(40.0));
    bench.run(100);
    let registers = bench.device.registers;
    (bench.device.fault, bench.device.registers[0]) = (0x08, 0x0100);
    assert_eq!(bench.run(300), State::Faulty(Fault::Gripper(0x08)));
    (bench.device.fault, bench.device.registers) = (0, registers);
    let State::Ready(ready) = bench.run(300) else { panic!() };
    assert!(ready.asked_n.is_some() && !bench.gripper.take_let_go());
}

#[test]
fn a_grip_that_others_began_needs_its_force() {
    let held = || Device { object: true, registers: [0x0900, 255, 0], ..Device::new(true) };
    assert_eq!(Bench::new(F85, held()).run(100), State::Occupied);
    let config = GripperConfig { holds_n: Some(44.0), ..F85 };
    let mut bench = Bench::new(config, held());
    let State::Ready(ready) = bench.run(100) else { panic!() };
    assert_eq!(ready.asked_n, Some(44.0));
    assert!(bench.device.writes.is_empty(), "nothing is written before something is ordered");
}
