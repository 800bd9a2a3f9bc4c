//! A board with a motor as an end, on a line of its own: takes orders, gives readings.
//!
//! Commands are repeated as long as there are any, well within their life. Without orders the board holds by itself.

use super::{
    GripperUpdate,
    line::{Condition, End},
};
use grip_link::{
    frame::MAX_WIRE,
    host::{GripCommand, HostConfig as LinkConfig, HostEvent, HostLink, LinkState},
    message::{ChannelKind, Config, GripMode, LossAction, SamplesHeader, Status, StatusFlags},
};
use grip_port::nonce;
use grip_robotiq::gripper::Order;
use grip_session::{
    HostConfig,
    rows::{GripperForce, GripperReading},
    session::{device_config, explain},
};
use std::sync::mpsc::{Receiver, Sender};

/// Its force is read so often (Hz), as far as it can.
const RATE_HZ: u32 = 1000;
/// A command is repeated after this share of its life.
const REPEATS: u64 = 4;

/// The end.
#[derive(Debug)]
pub(super) struct GripperBoard {
    link: HostLink,
    orders: Receiver<Order>,
    updates: Sender<GripperUpdate>,
    order: Order,
    /// When the order is to be sent (us).
    due_us: u64,
    every_us: u64,
    /// Force (N) at the first STATUS; the newest STATUS.
    holds_n: Option<f32>,
    status: Option<Status>,
    shown: Option<GripperUpdate>,
    reason: Option<String>,
}

impl GripperBoard {
    pub(super) fn new(
        config: &HostConfig,
        orders: Receiver<Order>,
        updates: Sender<GripperUpdate>,
    ) -> Result<Self, String> {
        let config = Config {
            sample_rate_hz: RATE_HZ,
            loss_action: LossAction::Hold,
            ..device_config(config)
        };
        let link = HostLink::new(LinkConfig::new(config)).map_err(|error| error.to_string())?;
        Ok(Self {
            link,
            orders,
            updates,
            order: Order::Keep,
            due_us: 0,
            every_us: 1000 * u64::from(config.ttl_ms) / REPEATS,
            holds_n: None,
            status: None,
            shown: None,
            reason: None,
        })
    }

    fn handle(&mut self, event: HostEvent) {
        match event {
            HostEvent::Status(status) => {
                self.status = Some(status);
                // A board that aims at nothing holds nothing: what it measures then is the noise of its sensor.
                let held_mn = if status.target_mn > 0 { status.applied_mn } else { 0 };
                self.holds_n.get_or_insert(1e-3 * millis(held_mn));
                self.show(None);
            }
            HostEvent::Samples { header, .. } => {
                let force_n = self.newest_force(header);
                self.show(force_n);
            }
            HostEvent::Closed(reason) => self.reason = Some(explain(&reason)),
            _ => {}
        }
    }

    /// The last reading of the force (N) in a batch.
    fn newest_force(&self, header: SamplesHeader) -> Option<f32> {
        let samples = self.link.samples(header)?;
        let column = self.link.layout().column(ChannelKind::NormalForce)?;
        let force = |row: grip_link::message::Row<'_>| row.value(&column, 0);
        samples.rows().filter_map(force).filter(|force_n| force_n.is_finite()).last()
    }

    /// Whether it can be commanded, and how.
    fn is_ready(&self) -> bool {
        let fault = self.status.is_some_and(|status| status.fault.is_fault());
        self.link.state().streams() && self.status.is_some() && !fault
    }

    /// Sends how it is, where that has changed, and every reading of the force.
    fn show(&mut self, force_n: Option<f32>) {
        let status = self.status.filter(|_| self.is_ready());
        let moving = status.is_some_and(|status| status.flags.has(StatusFlags::MOVING));
        let force = GripperForce::Measured(force_n.unwrap_or(f32::NAN));
        let most = self.link.in_force().map(|config| {
            [1e-3 * millis(config.force_max_mn), 1e-3 * millis(config.slew_mn_s.cast_signed())]
        });
        let update = GripperUpdate {
            reading: status.map(|_| GripperReading { force, moving }),
            holds_n: self.holds_n.unwrap_or(0.0),
            most,
            let_go: false,
        };
        // Each reading of the force is sent; without one only a change is.
        let same = |shown: GripperUpdate| {
            let motion = |update: GripperUpdate| update.reading.map(|reading| reading.moving);
            motion(shown) == motion(update) && force_n.is_none()
        };
        if !self.shown.replace(update).is_some_and(same) {
            let _sent = self.updates.send(update);
        }
    }
}

fn millis(value: i32) -> f32 {
    value as f32
}

impl End for GripperBoard {
    fn opened(&mut self, now_us: u64) {
        (self.reason, self.order, self.status) = (None, Order::Keep, None);
        // A nonce is never 0, which alone is refused.
        let _opened = self.link.open(now_us, nonce());
    }

    fn closed(&mut self, _now_us: u64) {
        self.link.close();
        self.status = None;
        self.show(None);
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        let mut left = bytes;
        while let Some(event) = self.link.receive(now_us, &mut left) {
            self.handle(event);
        }
    }

    fn poll_transmit(&mut self, now_us: u64, out: &mut Vec<u8>) -> bool {
        self.receive(now_us, &[]);
        if let Some(order) = self.orders.try_iter().last() {
            (self.order, self.due_us) = (order, now_us);
        }
        let mut frame = [0; MAX_WIRE];
        let command = match self.order {
            Order::Force(force_n) => GripCommand::newtons(force_n),
            Order::Open => {
                GripCommand::newtons(0.0).map(|open| GripCommand { mode: GripMode::Open, ..open })
            }
            // Without commands the board holds what it has, by itself.
            Order::Keep | Order::Stop => None,
        };
        let due = command.filter(|_| now_us >= self.due_us && self.is_ready());
        let sent = due.and_then(|command| {
            self.due_us = now_us + self.every_us;
            self.link.grip(now_us, &command, &mut frame)
        });
        let Some(length) = sent.or_else(|| self.link.poll_transmit(now_us, &mut frame)) else {
            return false;
        };
        out.clear();
        out.extend(frame.iter().take(length));
        true
    }

    fn condition(&self, _now_us: u64) -> Condition {
        let fault = self.status.map(|status| status.fault).filter(|fault| fault.is_fault());
        match (&self.reason, fault) {
            (Some(reason), _) => Condition::Waiting(reason.clone()),
            (None, Some(fault)) => Condition::Waiting(format!(
                "fault {:#06x}; nothing is commanded until it is cleared at the board",
                fault.0
            )),
            (None, None) if self.is_ready() => Condition::Ready,
            (None, None) => Condition::Waiting("no answer over the link".to_owned()),
        }
    }

    fn is_lost(&self) -> bool {
        self.reason.is_some() || self.link.state() == LinkState::Closed
    }
}
