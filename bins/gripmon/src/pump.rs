//! A source's items into the engine, on a thread of their own; requests to paint out.
//!
//! The window's thread only draws. Where nobody looks (a view that stands still, a hidden window) data go on being taken in, and nothing is
//! painted; while a file is loaded a view that stands still is painted a few times a second, as how far it is can be seen there.

use crate::engine::Brought;
use crate::scope::Shared;
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use eframe::egui::Context;
use grip_scope::{Feed, SourceStatus};
use std::sync::Arc;
use std::thread::{self, JoinHandle, Thread};
use std::{io, panic};

/// Time between two frames of live data (30 a second).
pub const FRAME: Duration = Duration::from_millis(33);
/// The same of a view that stands still while a file is loaded (5 a second).
pub const PROGRESS: Duration = Duration::from_millis(200);
/// Items taken in at once while the window may want the engine.
const BUDGET: usize = 32;
/// Least time between two looks at the source.
const REST: Duration = Duration::from_millis(8);
/// The same while nobody looks.
const UNSEEN: Duration = Duration::from_millis(60);
/// Longest time between two looks.
const PATIENCE: Duration = Duration::from_millis(500);
/// How long the window is let in.
const YIELD: Duration = Duration::from_micros(500);

/// What the window reports to the pump.
#[derive(Debug, Default)]
pub struct Watch {
    /// The view stands still.
    pub paused: AtomicBool,
    /// Nobody can see the window.
    pub hidden: AtomicBool,
    stop: AtomicBool,
}

/// The thread; dropping it ends it.
#[derive(Debug)]
pub struct Pump {
    watch: Arc<Watch>,
    thread: Option<JoinHandle<()>>,
}

impl Pump {
    /// Starts the thread.
    ///
    /// # Errors
    /// Where the system starts none.
    pub fn start(shared: Arc<Shared>, ctx: Context) -> io::Result<Self> {
        let watch = Arc::new(Watch::default());
        let seen = Arc::clone(&watch);
        let thread = thread::Builder::new()
            .name("pump".to_owned())
            .spawn(move || guarded(&shared, &ctx, || run(&shared, &ctx, &seen)))?;
        Ok(Self { watch, thread: Some(thread) })
    }

    /// What the window reports to it.
    #[must_use]
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// The thread to wake when a source has something.
    #[must_use]
    pub fn thread(&self) -> Option<&Thread> {
        self.thread.as_ref().map(JoinHandle::thread)
    }
}

impl Drop for Pump {
    fn drop(&mut self) {
        self.watch.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A thread that has panicked has nothing left to report.
            let _ended = thread.join();
        }
    }
}

/// A panic here is a fault of this program: reported as a state, so that nobody takes a view that stands still for one that is live.
fn guarded(shared: &Shared, ctx: &Context, run: impl FnOnce()) {
    // What the model holds was put there item by item; a lock that was held is taken over.
    if panic::catch_unwind(AssertUnwindSafe(run)).is_err() {
        let sentence =
            "data are no longer taken in by a fault of this program, please report it".to_owned();
        shared.engine().model.take(Feed::Status(SourceStatus::Failed { sentence }));
        ctx.request_repaint();
    }
}

fn run(shared: &Shared, ctx: &Context, watch: &Watch) {
    while !watch.stop.load(Ordering::Relaxed) {
        let brought = shared.engine().take_in(BUDGET);
        let looked_at = !watch.paused.load(Ordering::Relaxed);
        let visible = !watch.hidden.load(Ordering::Relaxed);
        if let Some(wait) = wait(brought, looked_at).filter(|_| visible) {
            ctx.request_repaint_after(wait);
        }
        if brought.more {
            if shared.is_waited_for() {
                rest(YIELD);
            }
            continue;
        }
        rest(if looked_at && visible { REST } else { UNSEEN });
        thread::park_timeout(PATIENCE);
    }
}

/// How soon what was brought is worth a frame; `None` where it is not.
const fn wait(brought: Brought, looked_at: bool) -> Option<Duration> {
    if brought.urgent || (brought.changed && looked_at) {
        Some(FRAME)
    } else if brought.loading {
        Some(PROGRESS)
    } else {
        None
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "a thread of the program waits here and nowhere else"
)]
fn rest(time: Duration) {
    thread::sleep(time);
}

#[cfg(test)]
mod tests {
    use super::guarded;
    use crate::engine::Engine;
    use crate::scope::Shared;
    use eframe::egui::Context;
    use grip_scope::{Model, SourceStatus};

    #[test]
    fn a_panic_while_data_are_taken_in_is_a_state_with_a_sentence() {
        let shared = Shared::new(Engine::new(Model::new(1 << 20), None));
        guarded(&shared, &Context::default(), || {
            let engine = shared.engine();
            assert_eq!(engine.dropped(), 1, "under the lock");
        });
        let status = shared.engine().model.status().clone();
        assert!(
            matches!(&status, SourceStatus::Failed { sentence } if sentence.contains("report"))
        );
    }
}
