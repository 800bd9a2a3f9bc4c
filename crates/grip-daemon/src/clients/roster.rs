//! Publisher of messages as frames for their subscribers; what a newcomer must know is kept.

use super::batch::{Batch, Row};
use super::{Class, Client, ClientSession};
use crate::{Beginning, LinkNote};
use grip_link::frame::MAX_PAYLOAD;
use grip_link::message::daemon::{
    self, Dropped, Estimates, Gripper, Health, LinkState, Notice, NoticeKind, PipelineState,
    SlipReport, Topics, WelcomeFlags,
};
use grip_link::message::{
    DeviceState, EventKind, FaultCode, Firmware, Kind, NackReason, PayloadError, Unit, Versions,
};
use grip_session::report::{Condition, Event};
use slip_core::units::Micros;
use slip_core::{ClientCommand, Signal};

use std::collections::VecDeque;

/// Slips that QUERY reports.
const RECENT: usize = 8;

/// The clients, and the batches of samples that some of them share.
#[derive(Debug, Default)]
pub(super) struct Roster {
    pub(super) clients: Vec<Client>,
    pub(super) batches: Vec<Batch>,
}

impl Roster {
    /// One batch for every decimation that somebody wants.
    pub(super) fn regroup(&mut self) {
        let clients = &self.clients;
        let wanted = |n| clients.iter().any(|client| client.session.every_nth() == Some(n));
        self.batches.retain(|batch| wanted(batch.every_nth()));
        for n in self.clients.iter().filter_map(|client| client.session.every_nth()) {
            if !self.batches.iter().any(|batch| batch.every_nth() == n) {
                self.batches.push(Batch::new(n));
            }
        }
    }

    /// A sample, for those batches that want one of its number.
    pub(super) fn row(&mut self, row: &Row<'_>) {
        for batch in self.batches.iter_mut().filter(|batch| batch.wants(row.index)) {
            let every_nth = batch.every_nth();
            if let Some(payload) = batch.push(row) {
                hand_out(&mut self.clients, every_nth, payload);
            }
        }
    }

    /// Sends the batches whose first row has waited long enough.
    pub(super) fn flush_old(&mut self, host_us: u64) {
        for batch in &mut self.batches {
            let every_nth = batch.every_nth();
            if let Some(payload) = batch.due(host_us) {
                hand_out(&mut self.clients, every_nth, payload);
            }
        }
    }

    /// Another pipeline begins: its samples may have other channels.
    pub(super) fn begin(&mut self) {
        for batch in &mut self.batches {
            let every_nth = batch.every_nth();
            if let Some(payload) = batch.flush() {
                hand_out(&mut self.clients, every_nth, payload);
            }
            batch.begin();
        }
    }

    /// One message for all who want to receive its topic.
    fn report(
        &mut self,
        class: Class,
        topic: Topics,
        kind: Kind,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) {
        let mut payload = [0; MAX_PAYLOAD];
        let Some(payload) = write(&mut payload).ok().and_then(|len| payload.get(..len)) else {
            return;
        };
        for client in self.clients.iter_mut().filter(|client| client.session.receives(topic)) {
            client.session.send(class, kind, payload);
        }
    }
}

fn hand_out(clients: &mut [Client], every_nth: u16, payload: &[u8]) {
    let wanted = clients.iter_mut().filter(|c| c.session.every_nth() == Some(every_nth));
    for client in wanted {
        client.session.send(Class::Rows, Kind::ROWS, payload);
    }
}

/// What WELCOME reports of the daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct About {
    /// Its name and version, such as `gripd 0.1.0`; at most 255 bytes are sent.
    pub name: String,
    /// Differs at every start; tokens are made of it too.
    pub run_id: u32,
    /// Whether it only observes.
    pub dry_run: bool,
    /// Whether it was asked to record.
    pub records: bool,
    /// What of real-time operation was granted.
    pub real_time: daemon::RealTime,
}

impl About {
    pub(super) fn welcome(&self, config: &super::ClientsConfig) -> daemon::Welcome<'_> {
        let flags = WelcomeFlags::default().with(WelcomeFlags::COMMANDS, config.allow_commands);
        let flags = flags.with(WelcomeFlags::MODELS, config.allow_models);
        let flags = flags.with(WelcomeFlags::DRY_RUN, self.dry_run);
        daemon::Welcome {
            versions: Versions::OURS,
            max_rx: 480,
            flags: flags.with(WelcomeFlags::RECORDS, self.records),
            token: 0,
            run_id: self.run_id,
            host_us: 0,
            real_time: self.real_time,
            text: self.name.as_bytes(),
        }
    }

    /// No secret: it only keeps a RELEASE that was meant for another start of the daemon, or typed by mistake, from opening the fingers.
    pub(super) const fn token(&self) -> u32 {
        let mixed = self.run_id.wrapping_mul(0x9E37_79B9) ^ 0x5EED_1E55;
        if mixed == 0 { 1 } else { mixed }
    }
}

/// What SETUP states of models and settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Reloads so far.
    pub settings: u32,
    /// SHA-256 of the file of the model in force.
    pub in_force: [u8; 32],
    /// That of the model that the configuration names.
    pub configured: [u8; 32],
    /// Its name.
    pub name: String,
}

/// What was reported last: for QUERY.
#[derive(Debug)]
pub(super) struct Known {
    gripper: Gripper,
    firmware: Firmware,
    setup: Option<Setup>,
    device: DeviceState,
    fault: FaultCode,
    state: Option<PipelineState>,
    health: Option<Health>,
    slips: VecDeque<SlipReport>,
    number: u32,
    /// What is known of the object: host time (us), text, grasps.
    object: Option<(u64, String, u32)>,
    /// The last event of the gripper: it rejects every command while a fault is latched, which is news once.
    device_event: Option<(EventKind, FaultCode)>,
}

impl Default for Known {
    fn default() -> Self {
        Self {
            gripper: Gripper::NONE,
            firmware: Firmware { major: 0, minor: 0, patch: 0 },
            setup: None,
            device: DeviceState::Boot,
            fault: FaultCode::NONE,
            state: None,
            health: None,
            slips: VecDeque::with_capacity(RECENT),
            number: 0,
            object: None,
            device_event: None,
        }
    }
}

impl Known {
    /// Why the fingers would not move now.
    pub(super) fn immovable(&self) -> Option<NackReason> {
        let streams = self.gripper.link.streams();
        match self.fault {
            _ if !streams && self.fault == FaultCode::NONE => Some(NackReason::WrongState),
            FaultCode::NONE => None,
            _ => Some(NackReason::Latched),
        }
    }

    /// Largest force of the controller (N), where there is one.
    pub(super) const fn force_max_n(&self) -> Option<f32> {
        self.gripper.force_max_n
    }

    /// Everything, then the answer.
    pub(super) fn answer(&self, session: &mut ClientSession, ack: Option<u16>) {
        session.message(Class::Answers, Kind::GRIPPER, |out| self.gripper.write(out));
        if let Some(setup) = self.setup() {
            session.message(Class::Answers, Kind::SETUP, |out| setup.write(out));
        }
        if let Some(state) = &self.state {
            session.message(Class::Answers, Kind::STATE, |out| state.write(out));
        }
        if let Some(health) = &self.health {
            session.message(Class::Answers, Kind::HEALTH, |out| health.write(out));
        }
        for slip in &self.slips {
            session.message(Class::Answers, Kind::SLIP, |out| slip.write(out));
        }
        if let Some((host_us, text, grasps)) = &self.object {
            let notice = object_notice(*host_us, text, *grasps);
            session.message(Class::Answers, Kind::NOTICE, |out| notice.write(out));
        }
        session.accept(ack, Kind::QUERY);
    }

    pub(super) fn object(&mut self, host_us: u64, text: &str, grasps: u32, roster: &mut Roster) {
        self.object = Some((host_us, text.to_owned(), grasps));
        let notice = object_notice(host_us, text, grasps);
        roster.report(Class::News, Topics::NEWS, Kind::NOTICE, |out| notice.write(out));
    }

    pub(super) fn state(&mut self, state: &PipelineState, roster: &mut Roster) {
        let state = PipelineState { device: self.device, fault: self.fault, ..*state };
        self.state = Some(state);
        let mut payload = [0; PipelineState::WHOLE];
        // What is not known at its end is left out.
        let Some(payload) = state.write(&mut payload).ok().and_then(|len| payload.get(..len))
        else {
            return;
        };
        for client in roster.clients.iter_mut().filter(|c| c.session.receives(Topics::STATE)) {
            if client.session.state_is_due(state.host.0) {
                client.session.send(Class::States, Kind::STATE, payload);
            }
        }
    }

    pub(super) fn event(&mut self, host_us: u64, event: &Event, roster: &mut Roster) {
        let slip = match event {
            Event::Slip(slip) => slip,
            Event::Health { condition: Condition::Sensor(sensor, health), .. } => {
                let text = format!("{sensor} {health}");
                let notice = Notice {
                    value: health.code().into(),
                    ..notice(NoticeKind::Sensor, sensor.code(), host_us, &text)
                };
                return roster
                    .report(Class::News, Topics::NEWS, Kind::NOTICE, |out| notice.write(out));
            }
            Event::Health { condition: Condition::Clock(health), .. } => {
                let text = format!("clock of the gripper: {}", health.name());
                let notice = notice(NoticeKind::Link, self.gripper.link.code(), host_us, &text);
                return roster
                    .report(Class::News, Topics::NEWS, Kind::NOTICE, |out| notice.write(out));
            }
            Event::Health { condition: Condition::Floor(_), .. } | Event::Grip { .. } => return,
        };
        self.number = self.number.saturating_add(1);
        let slip = SlipReport { number: self.number, host: Micros(host_us), ..*slip };
        if self.slips.len() == RECENT {
            self.slips.pop_front();
        }
        self.slips.push_back(slip);
        roster.report(Class::News, Topics::SLIP, Kind::SLIP, |out| slip.write(out));
    }

    /// Of the slip that was reported last.
    pub(super) fn estimates(&self, host_us: u64, estimates: &Estimates, roster: &mut Roster) {
        let (slip, host) = (self.number, Micros(host_us));
        let estimates = Estimates { slip, host, ..*estimates };
        roster.report(Class::News, Topics::ESTIMATES, Kind::ESTIMATES, |out| estimates.write(out));
    }

    pub(super) fn began(&mut self, _host_us: u64, beginning: &Beginning, roster: &mut Roster) {
        self.gripper.force_max_n = beginning.config.grip.as_ref().map(|grip| grip.f_max_n);
        self.gripper.rate_hz = hertz(beginning.config.sample_rate.0);
        self.gripper.taxels = u8::try_from(beginning.taxels).unwrap_or(u8::MAX);
        self.gripper.stylus = match beginning.config.signal {
            Signal::Displacement => Unit::Metre,
            Signal::Vibration => Unit::None,
        };
        self.report_gripper(roster);
    }

    fn report_gripper(&self, roster: &mut Roster) {
        let gripper = self.gripper;
        roster.report(Class::News, Topics::NEWS, Kind::GRIPPER, |out| gripper.write(out));
    }

    fn setup(&self) -> Option<daemon::Setup<'_>> {
        let firmware = self.firmware;
        self.setup.as_ref().map(|Setup { settings, in_force, configured, name }| daemon::Setup {
            settings: *settings,
            firmware,
            in_force: *in_force,
            configured: *configured,
            text: name.as_bytes(),
        })
    }

    fn report_setup(&self, roster: &mut Roster) {
        if let Some(setup) = self.setup() {
            roster.report(Class::News, Topics::NEWS, Kind::SETUP, |out| setup.write(out));
        }
    }

    pub(super) fn set_setup(&mut self, setup: Setup, roster: &mut Roster) {
        self.setup = Some(setup);
        self.report_setup(roster);
    }

    pub(super) fn link(&mut self, host_us: u64, note: &LinkNote, roster: &mut Roster) {
        match note {
            LinkNote::Status(status) => {
                self.device = status.state;
                self.fault = status.fault;
            }
            LinkNote::Identified { uid, boot_id, firmware, .. } => {
                self.gripper.uid = *uid;
                self.gripper.boot_id = *boot_id;
                self.firmware = *firmware;
                self.report_gripper(roster);
                self.report_setup(roster);
            }
            LinkNote::State(state) => {
                self.gripper.link = *state;
                self.report_gripper(roster);
            }
            LinkNote::PortLost => {
                self.gripper.link = LinkState::Closed;
                self.report_gripper(roster);
            }
            LinkNote::Device(event) => {
                let event = (event.kind, event.fault);
                if self.device_event.replace(event) == Some(event) {
                    return;
                }
            }
            _ => {}
        }
        let Some(text) = note.text() else { return };
        let notice = notice(NoticeKind::Link, self.gripper.link.code(), host_us, &text);
        roster.report(Class::News, Topics::NEWS, Kind::NOTICE, |out| notice.write(out));
    }

    pub(super) fn client(host_us: u64, command: ClientCommand, roster: &mut Roster) {
        let text = command.to_string();
        let notice = notice(NoticeKind::Client, command.operation().code(), host_us, &text);
        let notice = Notice { value: command.fault().0, ..notice };
        roster.report(Class::News, Topics::NEWS, Kind::NOTICE, |out| notice.write(out));
    }

    pub(super) fn health(
        &mut self,
        health: &Health,
        clients: u16,
        dropped: u32,
        roster: &mut Roster,
    ) {
        let health = Health {
            clients,
            link: self.gripper.link,
            dropped: Dropped { clients: dropped, ..health.dropped },
            ..*health
        };
        self.health = Some(health);
        roster.report(Class::States, Topics::HEALTH, Kind::HEALTH, |out| health.write(out));
    }
}

const fn object_notice(host_us: u64, text: &str, grasps: u32) -> Notice<'_> {
    Notice { count: grasps, ..notice(NoticeKind::Object, 0, host_us, text) }
}

const fn notice(kind: NoticeKind, code: u8, host_us: u64, text: &str) -> Notice<'_> {
    Notice { kind, code, value: 0, count: 0, host_us, text: text.as_bytes() }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
const fn hertz(rate: f32) -> u32 {
    rate.round() as u32
}
