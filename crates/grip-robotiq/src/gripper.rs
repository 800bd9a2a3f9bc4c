//! State machine of a 2F-85, 2F-140 or Hand-E on Modbus RTU: requests and the state of the gripper from orders, bytes and time.
//!
//! ```text
//! Silent --answer--> Ready            no answer for 0.2 s: Silent      fault: Faulty, until it has gone
//!          \--> NotActivated, Occupied (only before the first Ready)   activation: only where it was asked for, before the first Ready
//! ```
//!
//! **Only [`Order::Open`] opens the fingers.** What is not understood, not answered or at fault leaves the registers as they are. An
//! activation opens the fingers too, so it happens only where [`GripperConfig::activate`] allows it, and never once the gripper was
//! ready. The force is not measured: what is known is what the registers ask for. A gripper that was reset, or that others moved while
//! it was away, has let go what it held ([`Gripper::take_let_go`]); what it holds then is not ours.

use crate::{
    BusCounters, Fault, Model, Severity, Status,
    modbus::{Answer, Bus, Request},
};

/// Without an answer for this long (us) the gripper is silent.
const LOST_US: u64 = 200_000;
/// Pause between two looks at the status (us): with nothing to write, with something to write, and while it is silent.
const LOOK_US: u64 = 8_000;
const LOOK_BETWEEN_US: u64 = 25_000;
const LOOK_SILENT_US: u64 = 100_000;
/// An activation takes no longer than this (us).
const ACTIVATION_US: u64 = 20_000_000;
/// Action requests: nothing, activated (fingers that are on their way stop), and activated on the way to the requested position.
const RESET: [u16; 3] = [0, 0, 0];
const ACTIVATE: [u16; 3] = [0x0100, 0, 0];
const STAND: u16 = 0x0100;
const FOLLOW: u16 = 0x0900;

/// What is known before the first byte.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperConfig {
    /// Which one.
    pub model: Model,
    /// Its address on the line; 9 as it is delivered.
    pub unit: u8,
    /// Speed register, 0 to 255: 20 to 150 mm/s on a 2F-85. Fast fingers press harder when they touch.
    pub speed: u8,
    /// Whether a gripper that is not activated may be: its fingers open and close.
    pub activate: bool,
    /// Force (N) with which it holds something when this program starts.
    pub holds_n: Option<f32>,
}

impl GripperConfig {
    /// As it is delivered; nothing is activated.
    #[must_use]
    pub const fn new(model: Model) -> Self {
        Self { model, unit: 9, speed: 32, activate: false, holds_n: None }
    }
}

/// What the fingers are to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// What they do already.
    Keep,
    /// Close, and press with this force (N).
    Force(f32),
    /// Open.
    Open,
    /// Keep what they hold; fingers that hold nothing stand still, now or once it is gone.
    Stop,
}

/// How the gripper is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// It follows orders.
    Ready(Ready),
    /// It does not answer (any more).
    Silent,
    /// It is being activated.
    Activating,
    /// It would have to be activated, which opens the fingers.
    NotActivated,
    /// It holds something with a force that nobody knows.
    Occupied,
    /// A fault keeps it from following orders.
    Faulty(Fault),
}

/// A gripper that follows orders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ready {
    /// The fingers are on their way.
    pub moving: bool,
    /// Something stops them.
    pub holds: bool,
    /// Force (N) that the registers ask for; `None` where nothing was asked for, or the fingers are to open.
    pub asked_n: Option<f32>,
    /// Position, 0 open to 255 closed.
    pub position: u8,
    /// Motor current (mA).
    pub current_ma: u16,
}

/// How far an activation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Activation {
    /// The reset was not acknowledged yet.
    Reset,
    /// The order to activate was not.
    Begin,
    /// The fingers move.
    Moving,
}

/// The gripper.
#[derive(Debug)]
pub struct Gripper {
    config: GripperConfig,
    bus: Bus,
    state: State,
    was_ready: bool,
    activation: Option<(Activation, u64)>,
    /// What the registers are to hold; what they hold.
    wanted: Option<[u16; 3]>,
    stopped: bool,
    held: Option<[u16; 3]>,
    /// What was sent last, acknowledged or not.
    sent: Option<[u16; 3]>,
    let_go: bool,
    answered_us: u64,
    look_us: u64,
}

impl Gripper {
    /// A gripper that has not answered yet.
    #[must_use]
    pub fn new(config: GripperConfig) -> Self {
        Self {
            config,
            bus: Bus::new(config.unit),
            state: State::Silent,
            was_ready: false,
            activation: None,
            wanted: None,
            stopped: false,
            held: None,
            sent: None,
            let_go: false,
            answered_us: 0,
            look_us: 0,
        }
    }

    /// How it is.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// What became of the requests.
    #[must_use]
    pub fn counters(&self) -> BusCounters {
        self.bus.counters()
    }

    /// Whether others have opened the fingers since the last call, once the gripper was ready: by an activation, or by orders of their own.
    pub fn take_let_go(&mut self) -> bool {
        core::mem::take(&mut self.let_go)
    }

    /// The line was opened (anew).
    pub fn opened(&mut self, now_us: u64) {
        self.bus.reset(now_us);
        self.lose();
        self.look_us = 0;
    }

    /// The line is gone.
    pub fn closed(&mut self) {
        self.lose();
    }

    /// Takes an order; it is left out unless the gripper is ready.
    pub fn order(&mut self, order: Order) {
        if !matches!(self.state, State::Ready(_)) {
            return;
        }
        let Self { config: GripperConfig { model, speed, .. }, .. } = *self;
        let strength = |force: u8| u16::from_be_bytes([speed, force]);
        match order {
            Order::Force(force_n) if force_n > 0.0 => {
                self.stopped = false;
                self.wanted = Some([FOLLOW, 0x00FF, strength(model.register(force_n))]);
            }
            Order::Open => {
                self.stopped = false;
                self.wanted = Some([FOLLOW, 0, strength(0)]);
            }
            Order::Stop => self.stopped = true,
            // Not a number, or nothing to press with: no reason to let go.
            Order::Keep | Order::Force(_) => {}
        }
    }

    /// Takes bytes of the line.
    pub fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        if let Some(answer) = self.bus.receive(now_us, bytes) {
            self.answer(now_us, answer);
        }
    }

    /// The next request that is due.
    pub fn poll_transmit(&mut self, now_us: u64, out: &mut Vec<u8>) -> bool {
        if let Some(answer) = self.bus.expire(now_us) {
            self.answer(now_us, answer);
        }
        if now_us.saturating_sub(self.answered_us) > LOST_US {
            self.lose();
        }
        if !self.bus.is_free(now_us) {
            return false;
        }
        let (to_write, look_us) = (self.to_write(), self.look_us);
        let look = self.bus.look();
        match to_write {
            Some(registers) if look == Request::Read && now_us < look_us + LOOK_BETWEEN_US => {
                self.sent = Some(registers);
                self.bus.send(now_us, Request::Write(registers), out)
            }
            _ if now_us >= look_us => {
                let pause_us = if self.state == State::Silent { LOOK_SILENT_US } else { LOOK_US };
                self.look_us = now_us + pause_us;
                self.bus.send(now_us, look, out)
            }
            _ => false,
        }
    }

    /// No answer: what was not acknowledged is forgotten, or it would be done when nobody expects it any more.
    fn lose(&mut self) {
        self.state = State::Silent;
        self.wanted = None;
        // The fingers may stand anywhere by now.
        self.activation = None;
    }

    fn to_write(&self) -> Option<[u16; 3]> {
        match self.activation {
            Some((Activation::Reset, _)) => return Some(RESET),
            Some((Activation::Begin, _)) => return Some(ACTIVATE),
            Some((Activation::Moving, _)) => return None,
            None => {}
        }
        let State::Ready(ready) = self.state else { return None };
        let wanted = match self.stopped {
            // Whether a gripper that is ordered to stand still presses on is not known.
            true if ready.holds => None,
            true => {
                let [_, position, strength] = self.held.unwrap_or(ACTIVATE);
                Some([STAND, position, strength])
            }
            false => self.wanted,
        };
        // What was sent after that and never acknowledged may stand in the registers.
        let is_held =
            |wanted| self.held == Some(wanted) && self.sent.is_none_or(|sent| sent == wanted);
        wanted.filter(|wanted| !is_held(*wanted))
    }

    fn answer(&mut self, now_us: u64, answer: Answer) {
        match answer {
            Answer::Failed => return,
            Answer::Written(registers) => self.written(registers),
            Answer::Status(registers) => self.judge(now_us, &Status::read(registers)),
            // It may be that of an earlier request: it shows nothing of the gripper's state now.
            Answer::Probed => {
                self.look_us = now_us;
                return;
            }
        }
        self.answered_us = now_us;
    }

    fn written(&mut self, registers: [u16; 3]) {
        match &mut self.activation {
            Some((stage @ Activation::Reset, _)) if registers == RESET => {
                *stage = Activation::Begin
            }
            Some((stage @ Activation::Begin, _)) if registers == ACTIVATE => {
                *stage = Activation::Moving;
            }
            _ => {
                self.held = Some(registers);
                if let State::Ready(ready) = &mut self.state {
                    ready.asked_n = self.config.asked_n(registers);
                }
            }
        }
    }

    fn judge(&mut self, now_us: u64, status: &Status) {
        if let Some((stage, until_us)) = self.activation {
            let done = stage == Activation::Moving && status.activated && status.complete;
            if !done && now_us < until_us {
                self.state = State::Activating;
                return;
            }
            self.activation = None;
            if !done {
                self.state = State::Faulty(status.fault.unwrap_or(Fault::Gripper(0x0D)));
                self.config.activate = false;
                return;
            }
        }
        let active = status.activated && status.complete;
        let fault = status.fault.filter(|fault| fault.severity() != Severity::Passing);
        // What it reports in a fault may be otherwise when that is gone.
        if fault.is_none() && !matches!(self.state, State::Ready(_)) {
            self.come_back(status);
        }
        if fault.is_none() && self.was_ready && !active {
            self.forget();
        }
        self.state = if let Some(fault) = fault {
            State::Faulty(fault)
        } else if !active {
            if self.config.activate && !self.was_ready {
                self.activation = Some((Activation::Reset, now_us + ACTIVATION_US));
                State::Activating
            } else {
                State::NotActivated
            }
        } else if !self.was_ready && status.holds() && self.config.holds_n.is_none() {
            State::Occupied
        } else {
            State::Ready(self.ready(status))
        };
        match self.state {
            State::Ready(_) => self.was_ready = true,
            // What was ordered before is not done when the fault has gone.
            _ => self.wanted = None,
        }
    }

    /// Looks whether it still has our orders.
    fn come_back(&mut self, status: &Status) {
        let has = |[action, position, _]: &[u16; 3]| {
            let follows = action & FOLLOW == FOLLOW;
            follows == status.follows && u16::from(status.requested) == *position
        };
        if self.held.is_some_and(|registers| !has(&registers)) {
            // The acknowledgement alone may be lost.
            match self.sent.filter(has) {
                Some(registers) => self.held = Some(registers),
                None => self.forget(),
            }
        }
    }

    /// As at the start, but never activated: whoever reset it may have put something else between its fingers.
    fn forget(&mut self) {
        (self.was_ready, self.let_go) = (false, true);
        (self.held, self.sent, self.wanted) = (None, None, None);
        self.stopped = false;
        (self.config.holds_n, self.config.activate) = (None, false);
    }

    fn ready(&self, status: &Status) -> Ready {
        let asked_n = match self.held {
            Some(registers) => self.config.asked_n(registers),
            None => self.config.holds_n.filter(|_| status.holds()),
        };
        Ready {
            moving: status.moves(),
            holds: status.holds(),
            asked_n,
            position: status.position,
            current_ma: status.current_ma,
        }
    }
}

impl GripperConfig {
    /// Force (N) that the registers ask for, where the fingers are to close.
    fn asked_n(&self, [_, position, strength]: [u16; 3]) -> Option<f32> {
        let [_, force] = strength.to_be_bytes();
        (position > 0).then(|| self.model.force_n(force))
    }
}

#[cfg(test)]
mod tests;
