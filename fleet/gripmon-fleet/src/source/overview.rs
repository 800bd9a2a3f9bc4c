//! A network in, what all its grippers report out, through a bounded ring, from a thread of its own.
//!
//! Where the ring is full the thread waits: events then wait in the session, of the rest what is out of date is dropped there.

use super::{FIRST, LONGEST, LOOK, Network, may_mend};
use crate::grippers::{FleetFeed, Received, Roster};
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use grip_fleet::net::{NetError, Reported, Watch, ask_about};
use grip_fleet::{Member, Selector, Since, Site, Topic};
use grip_port::Backoff;
use grip_scope::feed::SourceStatus;
use grip_scope::source::Clock;
use rtrb::{Consumer, Producer, PushError, RingBuffer};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::{io, panic, thread};

/// Items that wait for the roster: more than a second of a thousand grippers.
const RING: usize = 8192;
/// How long the thread waits for room, or for a router, before it looks again.
const STEP: Duration = Duration::from_millis(25);
/// Models and firmware are asked for anew after so long; sooner of those that come, and of all, where so many come at once.
const ABOUT: Duration = Duration::from_secs(60);
const MANY: usize = 32;
/// How long one look for messages waits.
const TURN: Duration = Duration::from_millis(100);

/// All grippers of a network, or of one site.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FleetPlace {
    /// Where the router is.
    pub network: Network,
    /// Only grippers of this site.
    pub site: Option<Site>,
}

impl core::fmt::Display for FleetPlace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match &self.site {
            Some(site) => write!(f, "{site} at {}", self.network.name()),
            None => f.write_str(&self.network.name()),
        }
    }
}

/// A network that is being watched. Dropping it asks its thread to end; a thread that waits for a router ends after that.
#[derive(Debug)]
pub struct FleetHandle {
    ring: Consumer<FleetFeed>,
    stop: Arc<AtomicBool>,
}

impl FleetHandle {
    /// Starts to watch. `wake` is called from the thread whenever there is something new; it must not wait.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn spawn(place: FleetPlace, wake: impl Fn() + Send + 'static) -> io::Result<Self> {
        let (ring, roster) = RingBuffer::new(RING);
        let stop = Arc::<AtomicBool>::default();
        let outlet = FleetOutlet { ring, stop: Arc::clone(&stop), wake: Box::new(wake) };
        let mut watcher =
            Watcher { place, outlet, clock: Clock::start(), status: SourceStatus::Idle };
        thread::Builder::new().name("fleet".to_owned()).spawn(move || watcher.guarded())?;
        Ok(Self { ring: roster, stop })
    }

    /// Moves at most `budget` items into the roster: how many. Never waits.
    pub fn drain(&mut self, roster: &mut Roster, budget: usize) -> usize {
        let mut moved = 0;
        while moved < budget
            && let Ok(feed) = self.ring.pop()
        {
            roster.take(feed);
            moved += 1;
        }
        moved
    }
}

impl Drop for FleetHandle {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Where the thread puts what it has.
struct FleetOutlet {
    ring: Producer<FleetFeed>,
    stop: Arc<AtomicBool>,
    wake: Box<dyn Fn() + Send>,
}

impl FleetOutlet {
    fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.ring.is_abandoned()
    }

    /// Puts an item in and waits for room.
    fn put(&mut self, feed: FleetFeed, clock: Clock) {
        let mut feed = feed;
        while !self.stops() {
            match self.ring.push(feed) {
                Ok(()) => break,
                Err(PushError::Full(back)) => feed = back,
            }
            (self.wake)();
            clock.wait(STEP);
        }
        (self.wake)();
    }
}

/// The thread.
struct Watcher {
    place: FleetPlace,
    outlet: FleetOutlet,
    clock: Clock,
    status: SourceStatus,
}

impl Watcher {
    /// A panic here is a fault of this program: reported as a state, so that nobody takes a table that stands still for one that is live.
    fn guarded(&mut self) {
        let ended = panic::catch_unwind(AssertUnwindSafe(|| self.run()));
        if let Err(payload) = ended {
            let sentence = grip_scope::source::fault(payload.as_ref());
            self.report(SourceStatus::Failed { sentence });
        }
    }

    fn run(&mut self) {
        let mut backoff = Backoff::new(FIRST, LONGEST);
        let mut before = String::new();
        while !self.outlet.stops() {
            let what = format!("the router at {}", self.place);
            self.report(SourceStatus::Connecting { what, before });
            let Err(error) = self.watch(&mut backoff) else { return };
            before = error.to_string();
            if !may_mend(&error) {
                self.report(SourceStatus::Failed { sentence: before });
                return;
            }
            self.pause(&before, backoff.pause());
        }
    }

    /// Watches until the scope lets go.
    fn watch(&mut self, backoff: &mut Backoff) -> Result<(), NetError> {
        let session = self.place.network.open()?;
        let selector = Selector { site: self.place.site.clone(), uid: None };
        let mut watch =
            Watch::new(session.clone(), &selector, Since::Now, &[Topic::State, Topic::Health])?;
        backoff.reset();
        let (mut looked, mut asked) = (None, None);
        let (sender, abouts) = channel();
        let mut came = BTreeSet::new();
        while !self.outlet.stops() {
            if let Some(reported) = watch.next(TURN)? {
                if let Reported::Came(member) = &reported {
                    came.insert(member.clone());
                }
                self.pass_on(reported);
            }
            for (member, about) in abouts.try_iter() {
                self.put(member, Received::About(about));
            }
            let now = self.clock.now();
            let is_due = |last: Option<Duration>, every| {
                last.is_none_or(|last| now.saturating_sub(last) >= every)
            };
            if !is_due(looked, LOOK) {
                continue;
            }
            looked = Some(now);
            self.look(&watch);
            let mut whom: Vec<_> =
                core::mem::take(&mut came).into_iter().map(Selector::from).collect();
            if is_due(asked, ABOUT) || whom.len() > MANY {
                asked = Some(now);
                whom = vec![selector.clone()];
            }
            for selector in whom {
                let sender = sender.clone();
                // Whoever does not watch any more wants no answer.
                ask_about(&session, &selector, move |member, about| {
                    drop(sender.send((member, about)));
                })?;
            }
        }
        Ok(())
    }

    /// Whether the router is there; the session looks for it by itself. Time goes on in any case.
    fn look(&mut self, watch: &Watch) {
        self.report(if watch.is_connected() {
            SourceStatus::Live
        } else {
            let what = format!("the router at {}", self.place);
            let before = format!("no router answers any more at {}", self.place);
            SourceStatus::Connecting { what, before }
        });
        let now_s = self.clock.now().as_secs_f64();
        self.outlet.put(FleetFeed::Now(now_s), self.clock);
    }

    fn pass_on(&mut self, reported: Reported) {
        match reported {
            Reported::Came(member) => self.put(member, Received::Came),
            Reported::Gone(member) => self.put(member, Received::Gone),
            Reported::Telemetry { member, message, .. } => {
                self.put(member, Received::Message(message))
            }
            Reported::Event { member, message, missing, .. } => {
                if missing > 0 {
                    self.put(member.clone(), Received::Missing(missing));
                }
                self.put(member, Received::Message(message));
            }
            Reported::Unreadable { .. } => self.outlet.put(FleetFeed::Unreadable, self.clock),
        }
    }

    fn put(&mut self, member: Member, what: Received) {
        let at_s = self.clock.now().as_secs_f64();
        self.outlet.put(FleetFeed::Of { member, at_s, what }, self.clock);
    }

    /// Reports how the way to the router is, where that is new.
    fn report(&mut self, status: SourceStatus) {
        if self.status != status {
            self.status = status.clone();
            self.outlet.put(FleetFeed::Status(status), self.clock);
        }
    }

    /// Waits, unless the scope lets go.
    fn pause(&mut self, reason: &str, time: Duration) {
        let again_in_s = time.as_secs_f32();
        self.report(SourceStatus::Waiting { reason: reason.to_owned(), again_in_s });
        let until = self.clock.now() + time;
        while !self.outlet.stops() && self.clock.now() < until {
            self.clock.wait(STEP);
        }
    }
}
