//! The name of a source in; its items out, through a bounded ring, from a thread of its own that never waits for a window.
//!
//! Where the ring is full, samples of a live source are dropped, newest first, counted and shown as a gap; a file's thread waits for room.

mod clock;
mod daemon;
mod demo;
mod outlet;
mod reception;
mod recording;
mod reported;
mod spec;
mod stream;
mod study;

pub use clock::Clock;
pub use daemon::{pause, unsent};
pub use demo::Grippers;
pub use outlet::Outlet;
pub use reception::Reception;
pub use spec::{Other, SourceSpec, SpecError};

use crate::feed::{Feed, SourceStatus};
use crate::model::Model;
use core::any::Any;
use core::panic::AssertUnwindSafe;
use core::sync::atomic::Ordering;
use outlet::{FILE_RING, LIVE_RING, Shared};
use rtrb::{Consumer, Producer, RingBuffer};
use slip_core::ClientCommand;
use std::panic;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Commands that wait for the source's thread.
const COMMANDS: usize = 64;

/// Why a command was not passed on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// Files take none.
    #[error("only a running daemon and the demo take commands")]
    NotLive,
    /// The force is none.
    #[error("{0} is no force: a number of newtons, not below 0")]
    NoForce(String),
    /// The source's thread is busy or has ended.
    #[error("the source takes no commands now")]
    Busy,
}

/// A running source. Dropping it ends its thread.
#[derive(Debug)]
pub struct SourceHandle {
    spec: SourceSpec,
    ring: Consumer<Feed>,
    commands: Producer<ClientCommand>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl SourceHandle {
    /// Starts the source. `grippers` are for the demo; `wake` is called from its thread whenever there is something to be seen; it must not wait.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn spawn(
        spec: SourceSpec,
        grippers: Grippers,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        let (to_model, ring) = RingBuffer::new(if spec.is_live() { LIVE_RING } else { FILE_RING });
        let (commands, mut orders) = RingBuffer::new(COMMANDS);
        let shared = Arc::new(Shared::default());
        let mut outlet = Outlet::new(to_model, Arc::clone(&shared), Box::new(wake));
        let what = spec.clone();
        let run = move || {
            guarded(&mut outlet, |outlet| run(&what, grippers, outlet, &mut orders));
        };
        let thread = thread::Builder::new().name("source".to_owned()).spawn(run)?;
        Ok(Self { spec, ring, commands, shared, thread: Some(thread) })
    }

    /// Moves at most `budget` items into the model: how many. Never waits.
    pub fn drain(&mut self, model: &mut Model, budget: usize) -> usize {
        model.set_dropped(self.dropped());
        let mut moved = 0;
        while moved < budget
            && let Ok(feed) = self.ring.pop()
        {
            model.take(feed);
            moved += 1;
        }
        moved
    }

    /// Items that found no room.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }

    /// Passes a command on; what becomes of it comes back as a notice.
    ///
    /// # Errors
    /// Where the source takes none.
    pub fn command(&mut self, action: ClientCommand) -> Result<(), Refused> {
        if !self.spec.is_live() {
            return Err(Refused::NotLive);
        }
        if let ClientCommand::AtLeast(force_n) = action
            && !(force_n >= 0.0 && force_n.is_finite())
        {
            return Err(Refused::NoForce(force_n.to_string()));
        }
        self.commands.push(action).map_err(|_| Refused::Busy)
    }
}

impl Drop for SourceHandle {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        // Nobody waits for a router that does not answer.
        if self.spec.may_hang() {
            return;
        }
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has nothing left to report.
            let _ended = thread.join();
        }
    }
}

/// A panic in a source is a fault of this program: reported as a state, so that nobody waits for data that never come.
fn guarded(outlet: &mut Outlet, run: impl FnOnce(&mut Outlet)) {
    // What the source has left behind is not looked at again; the outlet is whole between two items.
    let ended = panic::catch_unwind(AssertUnwindSafe(|| run(outlet)));
    if let Err(payload) = ended {
        outlet.last(SourceStatus::Failed { sentence: fault(payload.as_ref()) });
    }
}

/// What a panic left, as a sentence.
#[must_use]
pub fn fault(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.as_deref().unwrap_or("it left no message");
    format!("the source has failed by a fault of this program, please report it: {text}")
}

/// What the thread does.
fn run(
    spec: &SourceSpec,
    grippers: Grippers,
    outlet: &mut Outlet,
    orders: &mut Consumer<ClientCommand>,
) {
    match spec {
        SourceSpec::Daemon(listen) => daemon::run(listen, outlet, orders),
        SourceSpec::Demo { scene, seed } => demo::run(grippers, scene, *seed, outlet, orders),
        SourceSpec::Other(other) => other.run(outlet, orders),
        SourceSpec::Recording(file) => recording::run(file, outlet),
        SourceSpec::Study(file) => study::run(file, outlet),
    }
}

#[cfg(test)]
mod tests {
    use super::outlet::{Outlet, Shared};
    use super::{Feed, SourceStatus, guarded};
    use core::time::Duration;
    use rtrb::RingBuffer;
    use std::sync::Arc;

    #[test]
    fn a_panic_of_a_source_is_a_state_with_a_sentence_even_where_the_ring_is_full() {
        for reported_before in [0, 4] {
            let (to_model, mut ring) = RingBuffer::new(4);
            let mut outlet = Outlet::new(to_model, Arc::<Shared>::default(), Box::new(|| {}));
            let (sent, received) = std::sync::mpsc::channel();
            let reader = std::thread::spawn(move || {
                let _begun = received.recv();
                let mut last = None;
                for _ in 0..60_000 {
                    last = ring.pop().ok().or(last);
                    if matches!(last, Some(Feed::Status(_))) {
                        break;
                    }
                    std::thread::park_timeout(Duration::from_millis(1));
                }
                last
            });
            guarded(&mut outlet, |outlet| {
                (0..reported_before).for_each(|_| outlet.offer(Feed::Restart));
                sent.send(()).unwrap();
                let numbers: Vec<u32> = Vec::new();
                assert_eq!(numbers.len(), 7, "seven were expected");
            });
            let Some(Feed::Status(SourceStatus::Failed { sentence })) = reader.join().unwrap()
            else {
                panic!("no state");
            };
            assert!(sentence.contains("please report it"), "{sentence}");
            assert!(sentence.contains("seven were expected"), "{sentence}");
        }
    }
}
