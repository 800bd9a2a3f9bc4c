//! Messages of gripd in, what is known of it with the names of the JSON fields out.

use grip_link::message::Versions;
use grip_link::message::daemon::{NoticeKind, ToClient, Welcome, WelcomeFlags};
use grip_session::status::{EventReport, GripperReport, HealthReport, StateReport, unread};
use serde::Serialize;
use slip_core::units::Micros;

/// Everything that QUERY reports.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Report {
    #[serde(skip)]
    pub(crate) welcomed: bool,
    #[serde(skip)]
    pub(crate) answered: bool,
    #[serde(skip)]
    pub(crate) goodbye: Option<String>,
    #[serde(skip)]
    versions: Option<Versions>,
    #[serde(flatten)]
    pub(crate) daemon: Option<DaemonReport>,
    pub(crate) gripper: Option<GripperReport>,
    pub(crate) state: Option<StateReport>,
    pub(crate) health: Option<HealthReport>,
    /// What is known of the object in hand or next; absent where gripd remembers none.
    pub(crate) object: Option<String>,
    pub(crate) events: Vec<EventReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct DaemonReport {
    pub(crate) daemon: String,
    pub(crate) run_id: u32,
    pub(crate) uptime_s: f64,
    pub(crate) commands_allowed: bool,
    pub(crate) dry_run: bool,
    pub(crate) records: bool,
    pub(crate) real_time: &'static str,
}

impl Report {
    pub(crate) fn take(&mut self, message: &ToClient<'_>) {
        self.answered |= super::is_answer(message);
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

    /// Whether samples come.
    pub(super) fn flows(&self) -> bool {
        self.gripper.as_ref().is_some_and(|gripper| matches!(gripper.link, "stream" | "degraded"))
    }

    /// Sensors of which no samples come are not good.
    pub(super) fn judge_sensors(&mut self) {
        let flows = self.flows();
        let Some(state) = self.state.as_mut().filter(|_| !flows) else { return };
        for health in
            [&mut state.stylus, &mut state.travel, &mut state.pressure, &mut state.reference]
        {
            *health = unread(health);
        }
    }

    /// Whether the daemon speaks a protocol version of this program.
    pub(crate) fn check_versions(&self) -> anyhow::Result<()> {
        match self.versions {
            Some(theirs) if Versions::OURS.common(theirs).is_none() => anyhow::bail!(
                "gripd speaks versions {} to {} of the protocol, this gripctl {} to {}: use programs of one release",
                theirs.min,
                theirs.max,
                Versions::OURS.min,
                Versions::OURS.max
            ),
            _ => Ok(()),
        }
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
