//! Receiver of the messages of one connection to a daemon, as items for the model.

use super::outlet::Outlet;
use super::reported;
use super::stream::Stream;
use crate::feed::{DaemonInfo, EventKind, EventMark, Feed, ObserverSettings, SourceStatus};
use core::time::Duration;
use grip_link::message::daemon::{
    Goodbye, Gripper, NoticeKind, RealTime, Rows, ToClient, Welcome, WelcomeFlags,
};
use grip_link::message::{Kind, NackReason, Unit, Versions};
use grip_session::{HostConfig, model};
use slip_core::ClientCommand;
use slip_core::{PipelineConfig, Signal, units::Hertz};

/// Without rows for so long the stream has stalled.
const STALL: Duration = Duration::from_secs(1);

/// What was received and not passed on yet.
#[expect(missing_debug_implementations, reason = "it holds what has none")]
#[derive(Default)]
pub struct Reception {
    place: String,
    every_nth: u16,
    stream: Stream,
    pub(super) greeted: bool,
    /// What commands must bear, where they are allowed.
    pub(super) token: Option<u32>,
    /// Why the daemon closed the connection, where it said so.
    pub(super) farewell: Option<String>,
    /// Why this connection is of no use, where it is not.
    pub(super) refusal: Option<String>,
    gripper: Option<Gripper>,
    rate_hz: u32,
    /// The rate that the observer was made for, or could not be.
    observed_hz: u32,
    /// The last command, and the number of its request.
    pub(super) asked: Option<(u16, ClientCommand)>,
    rows_at: Option<Duration>,
    rows_since: bool,
}

impl Reception {
    /// What is received at this place, of every n-th sample.
    #[must_use]
    pub fn new(place: String, every_nth: u16) -> Self {
        // Whatever was there before this connection, something is missing since.
        let mut stream = Stream::default();
        stream.broken(0);
        Self { place, every_nth, stream, ..Self::default() }
    }

    /// Takes a message.
    pub fn take(&mut self, message: &ToClient<'_>) {
        match message {
            ToClient::Welcome(welcome) => self.greet(welcome),
            ToClient::Slip(slip) => self.stream.mark(EventMark::slip(slip)),
            ToClient::State(state) => {
                self.set_rate(state.rate_hz);
                self.stream.update(Feed::State(*state));
            }
            ToClient::Health(health) => self.stream.update(Feed::Health(Box::new(*health))),
            ToClient::Gripper(gripper) => self.meet(*gripper),
            ToClient::Rows(rows) => self.take_rows(rows),
            ToClient::Notice(notice) => {
                if notice.kind == NoticeKind::Goodbye {
                    let version = notice.code == Goodbye::Version.code();
                    let what = notice.as_str();
                    let text = format!("{}: the daemon closed the connection: {what}", self.place);
                    self.farewell = Some(if version { self.misfit(None) } else { text });
                }
                self.stream.update(Feed::Notice(notice.as_str().to_owned()));
                self.event_of(notice.kind, notice.as_str());
            }
            ToClient::Nack(nack) if nack.kind == Kind::COMMAND => {
                let text = format!("{}: refused, {}", self.what(nack.seq), refused(nack.reason));
                let answer = reported::answer(text);
                answer.into_iter().for_each(|feed| self.stream.update(feed));
            }
            ToClient::Nack(nack) if nack.reason == NackReason::Version => {
                self.refusal = Some(self.misfit(None));
            }
            ToClient::Nack(_) | ToClient::Ack(_) | ToClient::Setup(_) | ToClient::Estimates(_) => {}
        }
    }

    /// Updates of link and clients as marks in time.
    fn event_of(&mut self, kind: NoticeKind, text: &str) {
        let kind = match kind {
            NoticeKind::Link => EventKind::Link,
            NoticeKind::Client => EventKind::Client,
            _ => return,
        };
        self.stream.mark(EventMark::plain(f64::NAN, kind, text));
    }

    fn greet(&mut self, welcome: &Welcome<'_>) {
        if Versions::OURS.common(welcome.versions).is_none() {
            self.refusal = Some(self.misfit(Some(welcome.versions)));
            return;
        }
        self.greeted = true;
        let flags = welcome.flags;
        self.token = flags.has(WelcomeFlags::COMMANDS).then_some(welcome.token);
        self.stream.update(Feed::Welcome(DaemonInfo {
            name: welcome.daemon().to_owned(),
            place: self.place.clone(),
            may_command: self.token.is_some(),
            dry_run: flags.has(WelcomeFlags::DRY_RUN),
            real_time: welcome.real_time,
            every_nth: self.every_nth,
        }));
        self.report_decimated();
    }

    fn report_decimated(&mut self) {
        if self.every_nth > 1 {
            let text = format!(
                "every {}th sample comes: band energies, peaks, spectra and bounds of E_sc are not derived from decimated rows",
                self.every_nth
            );
            self.stream.update(Feed::Notice(text));
        }
    }

    /// Nobody greets over a network of many grippers: whose messages these are, and of which samples; 0: of none.
    pub fn greet_over_network(&mut self, name: &str, every_nth: u16) {
        self.every_nth = every_nth;
        self.stream.update(Feed::Welcome(DaemonInfo {
            name: name.to_owned(),
            place: self.place.clone(),
            may_command: false,
            dry_run: false,
            real_time: RealTime::Other(u8::MAX),
            every_nth,
        }));
        self.report_decimated();
    }

    /// Something was missed: the next rows do not join.
    pub fn broken(&mut self) {
        self.stream.broken(0);
    }

    /// Something happened to the connection.
    pub fn mark(&mut self, mark: EventMark) {
        self.stream.mark(mark);
    }

    /// No version in common.
    fn misfit(&self, theirs: Option<Versions>) -> String {
        let Versions { min, max } = Versions::OURS;
        let ours = if min == max { min.to_string() } else { format!("{min} to {max}") };
        let place = &self.place;
        match theirs {
            Some(Versions { min, max }) => format!(
                "{place}: the daemon speaks versions {min} to {max} of the protocol, this program {ours}: install both from one release"
            ),
            None => format!(
                "{place}: the daemon does not speak version {ours} of the protocol: install daemon and scope from one release"
            ),
        }
    }

    fn meet(&mut self, gripper: Gripper) {
        let before = self.gripper.replace(gripper);
        self.set_rate(gripper.rate_hz);
        self.stream.update(Feed::Gripper(gripper));
        if before.map(|before| before.stylus) != Some(gripper.stylus) {
            self.observed_hz = 0;
        }
        let other = before.is_some_and(|before| {
            (before.uid, before.boot_id) != (gripper.uid, gripper.boot_id) && before.boot_id != 0
        });
        if other {
            self.observed_hz = 0;
            let text = "another gripper, or the same one after a restart";
            self.stream.mark(EventMark::plain(f64::NAN, EventKind::Reload, text));
        }
    }

    fn set_rate(&mut self, rate_hz: u32) {
        if rate_hz > 0 {
            self.rate_hz = rate_hz;
        }
    }

    fn take_rows(&mut self, rows: &Rows<'_>) {
        self.observe();
        let step = u32::from(rows.header.every_nth);
        let mut taxels = Vec::with_capacity(usize::from(rows.header.taxels));
        for row in rows.iter() {
            self.stream.number(row.index, step);
            taxels.clear();
            taxels.extend((0..usize::from(rows.header.taxels)).filter_map(|k| row.taxel(k)));
            self.stream.push(&grip_session::status::sample(&row), &taxels);
        }
        self.rows_since = true;
    }

    /// Makes an observer for the rate in force.
    fn observe(&mut self) {
        if self.every_nth != 1 || self.rate_hz == self.observed_hz {
            return;
        }
        self.observed_hz = self.rate_hz;
        let signal = match self.gripper.map_or(Unit::Metre, |gripper| gripper.stylus) {
            Unit::Metre => Signal::Displacement,
            _ => Signal::Vibration,
        };
        let none = self.stream.observe(shipped(signal, self.rate_hz), model::default_estimator());
        // The protocol does not carry the settings of the daemon.
        self.stream.update(none.unwrap_or(Feed::Observes(ObserverSettings::Shipped)));
    }

    /// Passes on what was received, and reports whether the stream flows.
    pub(super) fn deliver(&mut self, outlet: &mut Outlet) {
        let now = outlet.clock.now();
        self.pass_on(outlet);
        self.report_flow(now, outlet);
    }

    /// Passes on what was received.
    pub fn pass_on(&mut self, outlet: &mut Outlet) {
        let feeds = self.stream.take();
        if !feeds.is_empty() {
            feeds.into_iter().for_each(|feed| outlet.offer(feed));
            outlet.wake();
        }
    }

    fn report_flow(&mut self, now: Duration, outlet: &mut Outlet) {
        if core::mem::take(&mut self.rows_since) {
            self.rows_at = Some(now);
        }
        if !self.greeted {
            return;
        }
        let silent = now - *self.rows_at.get_or_insert(now);
        if silent < STALL {
            outlet.status(SourceStatus::Live);
        } else {
            // Whole seconds, so that the scope is not woken for every look.
            let for_s = Duration::from_secs(silent.as_secs()).as_secs_f32();
            outlet.status(SourceStatus::Stalled { for_s });
        }
    }

    fn what(&self, seq: u16) -> String {
        let asked = self.asked.filter(|(asked, _)| *asked == seq);
        asked.map_or_else(|| "the command".to_owned(), |(_, command)| command.to_string())
    }
}

/// The shipped settings for samples of this signal at this rate.
pub(super) fn shipped(signal: Signal, rate_hz: u32) -> PipelineConfig {
    HostConfig::default().pipeline(signal, Hertz(rate_hz as f32))
}

/// Why a command was refused.
const fn refused(reason: NackReason) -> &'static str {
    match reason {
        NackReason::UnknownType => "the daemon does not know it",
        NackReason::Malformed => "a value is outside its range",
        NackReason::WrongState => "not in this state",
        NackReason::Latched => "a fault or a stop is latched",
        NackReason::OtherFault => "another fault is latched",
        NackReason::Version => "no protocol version in common",
        NackReason::Forbidden => "the daemon allows no commands",
        NackReason::Token => "the token does not fit",
        NackReason::Busy => "too many requests wait",
        _ => "for a reason this program does not know",
    }
}

#[cfg(test)]
mod tests {
    use super::Reception;
    use crate::Channel;
    use crate::feed::{EventKind, Feed};
    use grip_link::message::daemon::{Gripper, ToClient};
    use grip_link::message::{Kind, Nack, NackReason, Unit};
    use slip_core::{ClientCommand, Sample, units::Micros};

    #[test]
    fn a_refused_command_is_reported_and_stands_among_the_events() {
        let mut reception = Reception::new("unix:socket".to_owned(), 1);
        reception.asked = Some((7, ClientCommand::Grasp));
        let nack = Nack { kind: Kind::COMMAND, reason: NackReason::Latched, seq: 7 };
        reception.take(&ToClient::Nack(nack));
        let reported = "grasp: refused, a fault or a stop is latched";
        let feeds = reception.stream.take();
        let as_event = |feed: &Feed| matches!(feed, Feed::Event(mark) if mark.kind == EventKind::Client && mark.text == reported);
        let as_line = |feed: &Feed| matches!(feed, Feed::Notice(line) if line == reported);
        assert!(feeds.iter().any(as_event) && feeds.iter().any(as_line), "{feeds:?}");
    }

    /// Noise of a hundredth in a unit of its own: as metres no stylus shows it.
    #[test]
    fn a_vibration_in_a_unit_of_its_own_has_bands() {
        let bands = |stylus| {
            let mut reception = Reception::new("unix:socket".to_owned(), 1);
            let gripper = Gripper { rate_hz: 1600, stylus, ..Gripper::NONE };
            reception.take(&ToClient::Gripper(gripper));
            reception.observe();
            for n in 0..3200_u32 {
                let noise = 1e-3 * ((n * 7919 % 101) as f32 - 50.0);
                let sample = Sample::stylus(Micros(625 * u64::from(n)), noise);
                reception.stream.number(n, 1);
                reception.stream.push(&sample, &[]);
            }
            let of_bands = |feed: &Feed| matches!(feed, Feed::Derived(block) if block.values.iter().any(|of| of.channel == Channel::Band0 && of.value > Some(0.0)));
            reception.stream.whole().iter().any(of_bands)
        };
        assert!(bands(Unit::None));
        assert!(!bands(Unit::Metre));
    }
}
