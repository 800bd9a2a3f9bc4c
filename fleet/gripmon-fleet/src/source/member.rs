//! Source of one gripper of a network: the same items for the model as from its daemon's socket, but fewer of them.

use super::life::{Life, Standing};
use super::{FIRST, GripperAt, LONGEST, LOOK, may_mend};
use core::time::Duration;
use grip_fleet::net::{NetError, Reported, Session, Watch, list};
use grip_fleet::{Message, Part, Selector, Since};
use grip_link::message::daemon::ToClient;
use grip_port::Backoff;
use grip_scope::feed::{EventKind, EventMark, Feed, SourceStatus};
use grip_scope::source::Reception;
use grip_scope::source::{Other, Outlet};
use grip_scope::source::{pause, unsent};
use slip_core::ClientCommand;
use std::sync::mpsc::Receiver;

/// How long one look for messages waits.
const TURN: Duration = Duration::from_millis(10);
/// Messages of one look.
const READS: usize = 256;
impl Other for GripperAt {
    /// Listens to the gripper until the scope lets go.
    fn run(&self, outlet: &mut Outlet, orders: &Receiver<ClientCommand>) {
        let mut backoff = Backoff::new(FIRST, LONGEST);
        let mut before = String::new();
        while !outlet.stops() {
            let what = format!("{self} over {}", self.network.name());
            outlet.status(SourceStatus::Connecting { what, before });
            let Err(error) = Talk::run(self, outlet, orders) else { return };
            before = error.to_string();
            if !may_mend(&error) {
                outlet.status(SourceStatus::Failed { sentence: before });
                return;
            }
            pause(outlet, &before, backoff.pause());
        }
    }
}

/// One session.
struct Talk<'a> {
    at: &'a GripperAt,
    session: Session,
    watch: Watch,
    reception: Reception,
    life: Life,
    looked: Duration,
    /// Whether the router was there at the last look.
    connected: bool,
    /// Every n-th sample is reported, as far as it is known; 0 for none.
    every_nth: Option<u16>,
}

impl<'a> Talk<'a> {
    fn run(
        at: &'a GripperAt,
        outlet: &mut Outlet,
        orders: &Receiver<ClientCommand>,
    ) -> Result<(), NetError> {
        let session = at.network.open()?;
        let telemetry = [Part::State, Part::Health, Part::Samples];
        let watch = Watch::new(session.clone(), &selector(at), Since::Now, &telemetry)?;
        let begun = outlet.now();
        let reception = Reception::new(at.network.name(), 0);
        let mut talk = Self {
            at,
            session,
            watch,
            reception,
            life: Life::new(begun),
            looked: begun,
            connected: true,
            every_nth: None,
        };
        outlet.offer(Feed::Restart);
        while !outlet.stops() {
            talk.turn(outlet)?;
            while orders.try_recv().is_ok() {
                unsent(outlet, "gripmon sends no command over a network of many grippers");
            }
        }
        Ok(())
    }

    fn turn(&mut self, outlet: &mut Outlet) -> Result<(), NetError> {
        let now = outlet.now();
        let mut patience = TURN;
        for _ in 0..READS {
            // Nothing may have come that is reported: the next look shows.
            let Some(reported) = self.watch.next(patience)? else { break };
            patience = Duration::ZERO;
            self.take(reported, now)?;
        }
        if now.saturating_sub(self.looked) >= LOOK {
            self.looked = now;
            self.connected = self.watch.is_connected();
        }
        self.find_rowless(now);
        self.reception.pass_on(outlet);
        outlet.status(self.status(now));
        Ok(())
    }

    fn take(&mut self, reported: Reported, now: Duration) -> Result<(), NetError> {
        match reported {
            Reported::Came(_) => return self.meet(),
            Reported::Gone(_) => {
                self.life.turn(false);
                self.reception.broken();
                self.mark("its gripd, or the way to it, is gone");
            }
            Reported::Event { message, missing, .. } => {
                if missing > 0 {
                    self.mark(&format!("{missing} events are missing: they had to make room"));
                }
                self.message(&message, now);
            }
            Reported::Telemetry { message, .. } => self.message(&message, now),
            Reported::Unreadable { .. } => self.mark("something came that no gripd sends"),
        }
        Ok(())
    }

    /// What it is, which it sends nobody who comes later unless they ask.
    fn meet(&mut self) -> Result<(), NetError> {
        self.life.turn(true);
        let listed = list(&self.session, &selector(self.at))?;
        let known = listed.get(&self.at.member);
        if let Some(gripper) = known.and_then(|known| known.gripper) {
            self.reception.take(&ToClient::Gripper(gripper));
        }
        if let Some(health) = known.and_then(|known| known.health) {
            self.reception.take(&ToClient::Health(health));
        }
        Ok(())
    }

    fn message(&mut self, message: &Message, now: Duration) {
        let Ok(read) = message.read() else {
            self.mark("a message of a kind that this gripmon does not know");
            return;
        };
        match &read {
            ToClient::State(_) => self.life.speak(now),
            ToClient::Rows(rows) => {
                self.life.speak(now);
                self.reports(rows.header.every_nth);
            }
            _ => {}
        }
        self.reception.take(&read);
    }

    /// Where states come and no rows, none will.
    fn find_rowless(&mut self, now: Duration) {
        if self.every_nth.is_none() && self.life.has_spoken_long(now) {
            self.reports(0);
        }
    }

    fn reports(&mut self, every_nth: u16) {
        if self.every_nth.replace(every_nth) != Some(every_nth) {
            self.reception.greet_over_network("gripd, over a network", every_nth);
        }
    }

    fn mark(&mut self, text: &str) {
        self.reception.mark(EventMark::plain(f64::NAN, EventKind::Link, text));
    }

    fn status(&self, now: Duration) -> SourceStatus {
        let what = format!("{} over {}", self.at, self.at.network.name());
        let connecting = |before: String| SourceStatus::Connecting { what: what.clone(), before };
        if !self.connected {
            let place = self.at.network.name();
            return connecting(format!("no router answers any more at {place}"));
        }
        match self.life.standing(now) {
            Standing::Live => SourceStatus::Live,
            // Whole seconds, so that the scope is not woken for every look.
            Standing::Silent(time) => {
                SourceStatus::Stalled { for_s: Duration::from_secs(time.as_secs()).as_secs_f32() }
            }
            Standing::Awaited => connecting(String::new()),
            Standing::Gone => {
                connecting(format!("{}: its gripd, or the way to it, is gone", self.at))
            }
        }
    }
}

/// This gripper alone.
fn selector(at: &GripperAt) -> Selector {
    Selector { site: Some(at.member.site.clone()), uid: Some(at.member.uid) }
}
