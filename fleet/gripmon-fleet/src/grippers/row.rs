//! Row of one gripper: what the table states of it, from its messages.

use super::spark::Spark;
use super::{Member, Received};
use grip_link::message::daemon::{
    GripState, Health, LinkState, Phase, PipelineState, Scene, SensorHealth, SlipReport, ToClient,
};
use std::collections::VecDeque;

/// STATE comes five times a second: a gripper that is there and reports none for so long is silent (s).
const SILENCE_S: f64 = 3.0;

/// Slips whose times are kept: four a second, for a minute.
const MOST_SLIPS: usize = 256;

/// Whether a gripper is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Presence {
    /// It is, and reports what it does.
    Here,
    /// It is, but has shown nothing of what it does for so long (s).
    Silent(f64),
    /// It, or the way to it, is gone for so long (s).
    Gone(f64),
}

slip_msg::named! {
    /// What somebody should look at first: the higher, the sooner.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Trouble {
        fn name: "A word for it.";
    }
    None: "Nothing.", "ok";
    Slipping: "It is stopping a slip just now.", "slipping";
    Sensor: "A sensor is not good.", "sensor";
    Link: "Its daemon has no samples of it: the line is closed, or it is silent.", "no link";
    Silent: "It is there and shows nothing.", "silent";
    Gone: "It is gone.", "gone";
    Fault: "It has stopped with a fault, or its stylus cannot be trusted.", "fault";
}

/// The figures of its daemon that the table shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figures {
    /// State of the link between daemon and gripper.
    pub link: LinkState,
    /// Slips since the daemon's start.
    pub slips: u32,
    /// Samples lost since then.
    pub lost: u64,
}

/// Letters of a name that a column has room for: names come from a network.
const LONGEST: usize = 64;

fn short(name: &Option<String>) -> Option<String> {
    name.as_ref().map(|name| name.chars().take(LONGEST).collect())
}

/// One gripper that is there, or was.
#[derive(Clone, Debug)]
pub struct Row {
    /// Which.
    pub member: Member,
    /// The last STATE.
    pub state: Option<PipelineState>,
    /// Of the last HEALTH.
    pub figures: Option<Figures>,
    /// Version of its firmware, where it has shown one.
    pub firmware: Option<String>,
    /// The model that estimates its force, where it has shown that.
    pub model: Option<String>,
    /// Events that nobody has any more.
    pub missing: u64,
    /// Measured force, or the commanded one where none is measured (N).
    pub force: Spark,
    /// Slip statistic: 1 and above is a slip.
    pub statistic: Spark,
    alive: bool,
    /// When it came or went (s).
    since_s: f64,
    /// When the last STATE came (s).
    received_s: f64,
    /// When the last slips were reported (s).
    slips: VecDeque<f64>,
    /// A slip was counted whose end was not reported yet.
    slips_on: bool,
}

impl Row {
    /// A gripper of which something was received first at this time (s).
    #[must_use]
    pub fn new(member: Member, at_s: f64) -> Self {
        Self {
            member,
            state: None,
            figures: None,
            firmware: None,
            model: None,
            missing: 0,
            force: Spark::default(),
            statistic: Spark::default(),
            alive: true,
            since_s: at_s,
            received_s: at_s,
            slips: VecDeque::new(),
            slips_on: false,
        }
    }

    /// Takes what is received of it; `false` where that can be read by nobody.
    pub fn take(&mut self, at_s: f64, what: &Received) -> bool {
        match what {
            Received::Came => self.life(at_s, true),
            Received::Gone => self.life(at_s, false),
            Received::Missing(events) => {
                self.missing = self.missing.saturating_add(*events);
                // The end of a slip may be among them.
                self.slips_on = false;
            }
            Received::About(about) => {
                (self.firmware, self.model) = (short(&about.firmware), short(&about.model));
            }
            Received::Message(message) => match message.read() {
                Ok(ToClient::State(state)) => self.take_state(at_s, &state),
                Ok(ToClient::Health(health)) => self.figures = Some(figures(&health)),
                Ok(ToClient::Slip(slip)) => self.take_slip(at_s, &slip),
                Ok(_) => {}
                Err(_) => return false,
            },
        }
        true
    }

    fn life(&mut self, at_s: f64, alive: bool) {
        if core::mem::replace(&mut self.alive, alive) != alive {
            (self.since_s, self.slips_on) = (at_s, false);
        }
        if alive {
            self.received_s = at_s;
        }
    }

    fn take_state(&mut self, at_s: f64, state: &PipelineState) {
        self.received_s = at_s;
        if let Some(force_n) = state.applied_n.or(state.command_n) {
            self.force.push(at_s, force_n);
        }
        if let Some(statistic) = state.statistic {
            self.statistic.push(at_s, statistic);
        }
        self.state = Some(*state);
    }

    /// A slip is reported when it begins, when it becomes gross and when it ends: it counts once.
    fn take_slip(&mut self, at_s: f64, slip: &SlipReport) {
        let on = slip.phase != Phase::Ended;
        if on && !self.slips_on {
            if self.slips.len() >= MOST_SLIPS {
                self.slips.pop_front();
            }
            self.slips.push_back(at_s);
        }
        self.slips_on = on;
    }

    /// Whether it is there at this time (s).
    #[must_use]
    pub fn presence(&self, now_s: f64) -> Presence {
        let silent_s = now_s - self.received_s;
        match self.alive {
            false => Presence::Gone((now_s - self.since_s).max(0.0)),
            true if silent_s > SILENCE_S => Presence::Silent(silent_s),
            true => Presence::Here,
        }
    }

    /// Whether its daemon is there.
    #[must_use]
    pub const fn is_alive(&self) -> bool {
        self.alive
    }

    /// What somebody should look at first.
    #[must_use]
    pub fn trouble(&self, now_s: f64) -> Trouble {
        let grip = self.state.map(|state| state.grip);
        match self.presence(now_s) {
            _ if self.fault().is_some() || grip == Some(GripState::Fault) => Trouble::Fault,
            Presence::Gone(_) => Trouble::Gone,
            Presence::Silent(_) => Trouble::Silent,
            Presence::Here if !self.streams() => Trouble::Link,
            Presence::Here if self.worst_sensor().is_some() => Trouble::Sensor,
            Presence::Here if self.is_slipping() => Trouble::Slipping,
            Presence::Here => Trouble::None,
        }
    }

    /// Whether samples come from the gripper to its daemon, as far as is known.
    #[must_use]
    pub fn streams(&self) -> bool {
        self.figures.is_none_or(|figures| figures.link == LinkState::Stream)
    }

    fn is_slipping(&self) -> bool {
        self.state.is_some_and(|state| {
            state.scene == Scene::Slipping || state.grip == GripState::Slipping
        })
    }

    /// The fault that the gripper has latched.
    #[must_use]
    pub fn fault(&self) -> Option<u16> {
        self.state.map(|state| state.fault.0).filter(|fault| *fault != 0)
    }

    /// The sensor that is worst off, where one is not good.
    #[must_use]
    pub fn worst_sensor(&self) -> Option<(&'static str, SensorHealth)> {
        let sensors = SENSORS.into_iter().zip(self.state?.sensors);
        let ailing = sensors.filter(|(_, health)| severity(*health) > 0);
        // Of like ones the first: the stylus decides most.
        ailing.rev().max_by_key(|(_, health)| severity(*health))
    }

    /// How badly off that sensor is; 0: all are good.
    pub(super) fn severity(&self) -> u8 {
        self.worst_sensor().map_or(0, |(_, health)| severity(health))
    }

    /// Samples lost between the gripper and its daemon, since the daemon's start.
    #[must_use]
    pub fn lost(&self) -> Option<u64> {
        self.state.map(|state| state.lost).max(self.figures.map(|figures| figures.lost))
    }

    /// Slips that were reported in the minute before this time (s), up to 256 of them.
    #[must_use]
    pub fn slips_last_minute(&self, now_s: f64) -> usize {
        self.slips.iter().rev().take_while(|at_s| now_s - **at_s < 60.0).count()
    }
}

/// The sensors in the order of a state.
const SENSORS: [&str; 4] = ["stylus", "travel", "pressure", "reference"];

/// How bad it is: what is lost cannot be used at all, what drifts is still felt with.
const fn severity(health: SensorHealth) -> u8 {
    match health {
        SensorHealth::Good | SensorHealth::Absent => 0,
        SensorHealth::Other(_) => 1,
        SensorHealth::Drifting
        | SensorHealth::Doubted
        | SensorHealth::Coarse
        | SensorHealth::Late
        | SensorHealth::Uncoupled => 2,
        SensorHealth::Jumped => 3,
        SensorHealth::Backwards => 4,
        SensorHealth::Saturated => 5,
        SensorHealth::Frozen => 6,
        SensorHealth::Failed => 7,
        SensorHealth::Lost => 8,
    }
}

const fn figures(health: &Health) -> Figures {
    Figures { link: health.link, slips: health.slips, lost: health.lost }
}
