//! A gripper of Robotiq as an end: takes orders, gives readings.

use super::{
    GripperUpdate,
    line::{Condition, End},
};
use grip_robotiq::gripper::{Gripper, GripperConfig, Order, Ready, State};
use grip_session::{
    gripper::GripperSpec,
    rows::{GripperForce, GripperReading},
};
use std::sync::mpsc::{Receiver, Sender};

/// The end.
#[derive(Debug)]
pub(super) struct RobotiqEnd {
    gripper: Gripper,
    holds_n: f32,
    spec: Option<GripperSpec>,
    orders: Receiver<Order>,
    updates: Sender<GripperUpdate>,
    shown: Option<GripperUpdate>,
}

impl RobotiqEnd {
    pub(super) fn new(
        config: GripperConfig,
        spec: Option<GripperSpec>,
        orders: Receiver<Order>,
        updates: Sender<GripperUpdate>,
    ) -> Self {
        let holds_n = config.holds_n.unwrap_or(0.0);
        Self { gripper: Gripper::new(config), holds_n, spec, orders, updates, shown: None }
    }

    /// Sends how the gripper is, where that has changed.
    fn show(&mut self) {
        let reading = match self.gripper.state() {
            State::Ready(ready) => Some(self.reading(&ready)),
            _ => None,
        };
        let let_go = self.gripper.take_let_go();
        let update = GripperUpdate { reading, holds_n: self.holds_n, most: None, let_go };
        if self.shown.replace(update) != Some(update) {
            let _sent = self.updates.send(update);
        }
    }

    /// The force is what the registers ask for, while something is between the fingers: the gripper measures none.
    fn reading(&self, ready: &Ready) -> GripperReading {
        let force_n = ready.asked_n.filter(|_| ready.holds).unwrap_or(0.0);
        let lag_s = self.spec.and_then(|spec| spec.lag_s).unwrap_or(0.0);
        GripperReading { force: GripperForce::Asked { force_n, lag_s }, moving: ready.moving }
    }
}

impl End for RobotiqEnd {
    fn opened(&mut self, now_us: u64) {
        self.gripper.opened(now_us);
    }

    fn closed(&mut self, _now_us: u64) {
        self.gripper.closed();
        self.show();
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        self.gripper.receive(now_us, bytes);
        self.show();
    }

    fn poll_transmit(&mut self, now_us: u64, out: &mut Vec<u8>) -> bool {
        if let Some(order) = self.orders.try_iter().last() {
            self.gripper.order(order);
        }
        let due = self.gripper.poll_transmit(now_us, out);
        self.show();
        due
    }

    fn condition(&self, _now_us: u64) -> Condition {
        let waiting = |text: &str| Condition::Waiting(text.to_owned());
        match self.gripper.state() {
            State::Ready(_) => Condition::Ready,
            State::Activating => Condition::Busy("activated: the fingers open and close"),
            State::Silent => waiting(
                "no answer over Modbus RTU; the gripper keeps what it has. Is it powered, and are unit= and baud= right?",
            ),
            State::NotActivated => waiting(
                "not activated. An activation opens the fingers: take out what they hold, and start gripd with `,activate` behind the port",
            ),
            State::Occupied => waiting(
                "it holds something with an unknown force. Start gripd with `,holds=N` behind the port to go on with N newtons",
            ),
            State::Faulty(fault) => Condition::Waiting(format!(
                "{fault}; nothing is commanded, and the gripper keeps what it has until the fault is gone"
            )),
        }
    }

    fn note(&self) -> Option<&'static str> {
        self.gripper.counters().note()
    }

    fn is_lost(&self) -> bool {
        false
    }
}
