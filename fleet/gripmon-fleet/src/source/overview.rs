//! Source of what all grippers of a network report, on a thread of its own.
//!
//! Where the table is being drawn the thread waits: events then wait in the session, of the rest what is out of date is dropped there.

use super::{FIRST, LONGEST, LOOK, Network, may_mend};
use crate::grippers::{FleetFeed, Received};
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use grip_fleet::net::{NetError, Reported, Watch, ask_about};
use grip_fleet::{Member, Part, Selector, Since, Site};
use grip_port::Backoff;
use grip_scope::feed::SourceStatus;
use grip_scope::source::Clock;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::{io, panic, thread};

/// How long the thread waits for a router before it looks again.
const STEP: Duration = Duration::from_millis(25);
/// Time between two calls to look at what is new, where that does not end.
const NEWS: Duration = Duration::from_millis(50);
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
    stop: Arc<AtomicBool>,
}

impl FleetHandle {
    /// Starts to watch. `take` takes each item and `wake` is called where there is something new, both on the thread; `wake` must not wait.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn spawn(
        place: FleetPlace,
        take: impl FnMut(FleetFeed) + Send + 'static,
        wake: impl Fn() + Send + 'static,
    ) -> io::Result<Self> {
        let stop = Arc::<AtomicBool>::default();
        let (take, wake, stops) = (Box::new(take), Box::new(wake), Arc::clone(&stop));
        let (clock, status) = (Clock::start(), SourceStatus::Idle);
        let mut watcher = Watcher { place, take, wake, woken: None, stops, clock, status };
        thread::Builder::new().name("fleet".to_owned()).spawn(move || watcher.guarded())?;
        Ok(Self { stop })
    }
}

impl Drop for FleetHandle {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The thread.
struct Watcher {
    place: FleetPlace,
    take: Box<dyn FnMut(FleetFeed) + Send>,
    wake: Box<dyn Fn() + Send>,
    /// When somebody was woken last; at once, where nothing was new since.
    woken: Option<Duration>,
    stops: Arc<AtomicBool>,
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

    fn stops(&self) -> bool {
        self.stops.load(Ordering::Relaxed)
    }

    fn take(&mut self, feed: FleetFeed) {
        (self.take)(feed);
        let now = self.clock.now();
        if self.woken.is_none_or(|woken| now.saturating_sub(woken) >= NEWS) {
            self.woken = Some(now);
            (self.wake)();
        }
    }

    /// Nothing more comes now.
    fn rest(&mut self) {
        if self.woken.take().is_some() {
            (self.wake)();
        }
    }

    fn run(&mut self) {
        let mut backoff = Backoff::new(FIRST, LONGEST);
        let mut before = String::new();
        while !self.stops() {
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
            Watch::new(session.clone(), &selector, Since::Now, &[Part::State, Part::Health])?;
        backoff.reset();
        let (mut looked, mut asked) = (None, None);
        let (sender, abouts) = channel();
        let mut came = BTreeSet::new();
        while !self.stops() {
            match watch.next(TURN)? {
                Some(reported) => {
                    if let Reported::Came(member) = &reported {
                        came.insert(member.clone());
                    }
                    self.pass_on(reported);
                }
                None => self.rest(),
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
        self.take(FleetFeed::Now(now_s));
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
            Reported::Unreadable { .. } => self.take(FleetFeed::Unreadable),
        }
    }

    fn put(&mut self, member: Member, what: Received) {
        let at_s = self.clock.now().as_secs_f64();
        self.take(FleetFeed::Of { member, at_s, what });
    }

    /// Reports how the way to the router is, where that is new.
    fn report(&mut self, status: SourceStatus) {
        if self.status != status {
            self.status = status.clone();
            self.take(FleetFeed::Status(status));
            self.rest();
        }
    }

    /// Waits, unless the scope lets go.
    fn pause(&mut self, reason: &str, time: Duration) {
        let again_in_s = time.as_secs_f32();
        self.report(SourceStatus::Waiting { reason: reason.to_owned(), again_in_s });
        let until = self.clock.now() + time;
        while !self.stops() && self.clock.now() < until {
            self.clock.wait(STEP);
        }
    }
}
