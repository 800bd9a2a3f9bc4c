//! Report of what is known of gripd, from its messages, with the names of the JSON fields.

use grip_link::message::daemon::{NoticeKind, ToClient, Welcome, WelcomeFlags};
use grip_link::message::{Kind, Versions};
use grip_session::status::{EventReport, GripperReport, HealthReport, StateReport, unread};
use serde::Serialize;
use slip_core::units::Micros;

/// Everything that QUERY reports.
#[derive(Debug, Default, Serialize)]
pub struct Report {
    /// WELCOME has come.
    #[serde(skip)]
    pub welcomed: bool,
    /// The answer to QUERY has ended.
    #[serde(skip)]
    pub answered: bool,
    /// Why gripd has closed the connection.
    #[serde(skip)]
    pub goodbye: Option<String>,
    #[serde(skip)]
    versions: Option<Versions>,
    #[serde(flatten)]
    pub(super) daemon: Option<DaemonReport>,
    /// The gripper.
    pub gripper: Option<GripperReport>,
    /// What it does.
    pub state: Option<StateReport>,
    /// Figures.
    pub health: Option<HealthReport>,
    /// What is known of the object in hand or next; absent where gripd remembers none.
    pub(super) object: Option<String>,
    pub(super) events: Vec<EventReport>,
}

#[derive(Debug, Serialize)]
pub(super) struct DaemonReport {
    pub(super) daemon: String,
    pub(super) run_id: u32,
    pub(super) uptime_s: f64,
    pub(super) commands_allowed: bool,
    pub(super) dry_run: bool,
    pub(super) records: bool,
    pub(super) real_time: &'static str,
}

impl Report {
    /// Takes a message.
    pub fn take(&mut self, message: &ToClient<'_>) {
        self.answered |= is_answer(message);
        match message {
            ToClient::Welcome(welcome) => {
                self.welcomed = true;
                self.versions = Some(welcome.versions);
                self.daemon = Some(DaemonReport::of(welcome));
            }
            ToClient::Gripper(gripper) => self.gripper = Some(GripperReport::of(gripper)),
            ToClient::State(state) => self.state = Some(StateReport::of(state)),
            ToClient::Health(health) => self.health = Some(HealthReport::of(health)),
            ToClient::Slip(_) => self.events.extend(EventReport::of(message)),
            ToClient::Notice(notice) if notice.kind == NoticeKind::Object => {
                self.object = Some(notice.as_str().to_owned());
            }
            ToClient::Notice(notice) if notice.kind == NoticeKind::Goodbye => {
                self.goodbye = Some(notice.as_str().to_owned());
            }
            _ => {}
        }
    }

    /// Whether samples come: a source that is silent leaves the link as it is.
    pub(super) fn flows(&self) -> bool {
        let silent = self.health.as_ref().is_some_and(|health| health.rate_hz == Some(0.0));
        let gripper = self.gripper.as_ref().filter(|_| !silent);
        gripper.is_some_and(|gripper| matches!(gripper.link, "stream" | "degraded"))
    }

    /// Sensors of which no samples come are not good.
    pub fn judge_sensors(&mut self) {
        let flows = self.flows();
        let Some(state) = self.state.as_mut().filter(|_| !flows) else { return };
        for health in
            [&mut state.stylus, &mut state.travel, &mut state.pressure, &mut state.reference]
        {
            *health = unread(health);
        }
    }

    /// Why the daemon cannot be understood, where it speaks no protocol version of this program.
    #[must_use]
    pub fn misfit(&self) -> Option<String> {
        misfit(self.versions?)
    }
}

impl DaemonReport {
    fn of(welcome: &Welcome<'_>) -> Self {
        Self {
            daemon: welcome.daemon().to_owned(),
            run_id: welcome.run_id,
            uptime_s: Micros(welcome.host_us).as_seconds(),
            commands_allowed: welcome.flags.has(WelcomeFlags::COMMANDS),
            dry_run: welcome.flags.has(WelcomeFlags::DRY_RUN),
            records: welcome.flags.has(WelcomeFlags::RECORDS),
            real_time: welcome.real_time.name(),
        }
    }
}

/// Why a daemon of these versions cannot be understood, where there is none in common.
#[must_use]
pub fn misfit(theirs: Versions) -> Option<String> {
    let ours = Versions::OURS;
    ours.common(theirs).is_none().then(|| {
        format!(
            "gripd speaks versions {} to {} of the protocol, this program {} to {}: use programs of one release",
            theirs.min, theirs.max, ours.min, ours.max
        )
    })
}

/// Whether a message ends an answer to QUERY.
fn is_answer(message: &ToClient<'_>) -> bool {
    matches!(message, ToClient::Ack(ack) if ack.kind == Kind::QUERY)
        || matches!(message, ToClient::Nack(nack) if nack.kind == Kind::QUERY)
}
