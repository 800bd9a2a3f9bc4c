//! Where data come from: a thread of its own puts what a source reports into the model, item by item.

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
use core::sync::atomic::{AtomicBool, Ordering};
use slip_core::ClientCommand;
use std::panic;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
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

/// The way of commands to a source.
#[derive(Clone, Debug)]
pub struct Orders {
    is_live: bool,
    commands: SyncSender<ClientCommand>,
}

impl Orders {
    /// Passes a command on; what becomes of it comes back as a notice.
    ///
    /// # Errors
    /// Where the source takes none.
    pub fn send(&self, action: ClientCommand) -> Result<(), Refused> {
        match action {
            _ if !self.is_live => Err(Refused::NotLive),
            ClientCommand::AtLeast(force_n) if !(force_n >= 0.0 && force_n.is_finite()) => {
                Err(Refused::NoForce(force_n.to_string()))
            }
            action => self.commands.try_send(action).map_err(|_| Refused::Busy),
        }
    }
}

/// A running source. Dropping it ends its thread.
#[derive(Debug)]
pub struct SourceHandle {
    /// Commands to it.
    pub orders: Orders,
    stop: Arc<AtomicBool>,
    /// None where it may wait for something that takes long to report no: nobody waits for that.
    thread: Option<JoinHandle<()>>,
}

impl SourceHandle {
    /// Starts the source. Its thread gives items to `take`, which may wait for a short look at the model, and calls `wake` whenever there is
    /// something to be seen. `grippers` are for the demo.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn spawn(
        spec: SourceSpec,
        grippers: Grippers,
        take: impl FnMut(Feed) + Send + 'static,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        let (commands, orders) = sync_channel(COMMANDS);
        let (is_live, may_hang) = (spec.is_live(), matches!(spec, SourceSpec::Other(_)));
        let stop = Arc::new(AtomicBool::new(false));
        let mut outlet = Outlet::new(take, wake, Arc::clone(&stop));
        let run = move || {
            guarded(&mut outlet, |outlet| run(&spec, grippers, outlet, &orders));
        };
        let thread = thread::Builder::new().name("source".to_owned()).spawn(run)?;
        let thread = Some(thread).filter(|_| !may_hang);
        Ok(Self { orders: Orders { is_live, commands }, stop, thread })
    }
}

impl Drop for SourceHandle {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has nothing left to report.
            let _ended = thread.join();
        }
    }
}

/// Reads a recording to its end, in this thread: the model, whose status is how it went.
#[must_use]
pub fn load(file: &Path, model: Model) -> Model {
    let model = Arc::new(Mutex::new(model));
    let filled = Arc::clone(&model);
    let lock = |model: &Mutex<Model>, feed| {
        model.lock().unwrap_or_else(PoisonError::into_inner).take(feed);
    };
    let mut outlet = Outlet::new(move |feed| lock(&filled, feed), || {}, Arc::default());
    guarded(&mut outlet, |outlet| recording::run(file, outlet));
    let mut model = model.lock().unwrap_or_else(PoisonError::into_inner);
    core::mem::replace(&mut *model, Model::new(0))
}

/// A panic in a source, or while the model takes what it has, is a fault of this program: reported as a state, so that nobody waits for data
/// that never come.
fn guarded(outlet: &mut Outlet, run: impl FnOnce(&mut Outlet)) {
    // What the source has left behind is not looked at again; the model is whole between two items.
    let ended = panic::catch_unwind(AssertUnwindSafe(|| run(outlet)));
    if let Err(payload) = ended {
        outlet.status(SourceStatus::Failed { sentence: fault(payload.as_ref()) });
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
    orders: &Receiver<ClientCommand>,
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
    use super::{Feed, Outlet, SourceStatus, guarded};
    use std::sync::{Arc, Mutex};

    #[test]
    fn a_panic_of_a_source_is_a_state_with_a_sentence() {
        let last = Arc::new(Mutex::new(None));
        let seen = Arc::clone(&last);
        let take = move |feed| *seen.lock().unwrap() = Some(feed);
        let mut outlet = Outlet::new(take, || {}, Arc::default());
        guarded(&mut outlet, |outlet| {
            outlet.offer(Feed::Restart);
            let numbers: Vec<u32> = Vec::new();
            assert_eq!(numbers.len(), 7, "seven were expected");
        });
        let Some(Feed::Status(SourceStatus::Failed { sentence })) = last.lock().unwrap().take()
        else {
            panic!("no state");
        };
        assert!(sentence.contains("please report it"), "{sentence}");
        assert!(sentence.contains("seven were expected"), "{sentence}");
    }
}
