//! What the network reports into the roster, on a thread of its own; requests to paint out, where something is new and seen.

use super::hall::{Brought, Hall};
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use eframe::egui::Context;
use std::sync::Arc;
use std::thread::{self, JoinHandle, Thread};
use std::{io, panic};

/// Time between two frames of the table: grippers report what they do five times a second.
pub const FRAME: Duration = Duration::from_millis(200);
/// Items taken in at once while the window may want the roster.
const BUDGET: usize = 256;
/// Least time between two looks at the network.
const REST: Duration = Duration::from_millis(50);
/// Longest time between two looks.
const PATIENCE: Duration = Duration::from_millis(500);

/// The thread; dropping it ends it.
#[derive(Debug)]
pub struct FleetPump {
    watch: Arc<Watch>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Watch {
    hidden: AtomicBool,
    stop: AtomicBool,
}

impl FleetPump {
    /// Starts the thread.
    ///
    /// # Errors
    /// Where the system starts none.
    pub fn start(hall: Arc<Hall>, ctx: Context) -> io::Result<Self> {
        let watch = Arc::<Watch>::default();
        let seen = Arc::clone(&watch);
        let thread = thread::Builder::new().name("fleet pump".to_owned()).spawn(move || {
            let ended = panic::catch_unwind(AssertUnwindSafe(|| run(&hall, &ctx, &seen)));
            if ended.is_err() {
                hall.fail(
                    "nothing is taken in any more by a fault of this program, please report it"
                        .to_owned(),
                );
                ctx.request_repaint();
            }
        })?;
        Ok(Self { watch, thread: Some(thread) })
    }

    /// Nobody can see the table, or somebody can.
    pub fn set_hidden(&self, hidden: bool) {
        self.watch.hidden.store(hidden, Ordering::Relaxed);
    }

    /// The thread to wake when the network has something.
    #[must_use]
    pub fn thread(&self) -> Option<&Thread> {
        self.thread.as_ref().map(JoinHandle::thread)
    }
}

impl Drop for FleetPump {
    fn drop(&mut self) {
        self.watch.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A thread that has panicked has nothing left to report.
            let _ended = thread.join();
        }
    }
}

fn run(hall: &Hall, ctx: &Context, watch: &Watch) {
    while !watch.stop.load(Ordering::Relaxed) {
        let Brought { changed, more } = hall.take_in(BUDGET);
        if changed && !watch.hidden.load(Ordering::Relaxed) {
            ctx.request_repaint_after(FRAME);
        }
        if !more {
            rest(REST);
            thread::park_timeout(PATIENCE);
        }
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "a thread of the program waits here and nowhere else"
)]
fn rest(time: Duration) {
    thread::sleep(time);
}
