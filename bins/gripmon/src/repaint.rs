//! When a frame is worth painting.
//!
//! Where nobody looks (a view that stands still, a hidden window) data go on being taken in, and nothing is painted; while a file is loaded a
//! view that stands still is painted a few times a second, as how far it is can be seen there.

use crate::engine::Brought;
use crate::scope::Shared;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use eframe::egui::Context;
use grip_scope::{SourceHandle, SourceSpec};
use std::io;
use std::sync::Arc;

/// Time between two frames of live data (30 a second).
pub const FRAME: Duration = Duration::from_millis(33);
/// The same of a view that stands still while a file is loaded (5 a second).
pub const PROGRESS: Duration = Duration::from_millis(200);

/// What the window reports to the thread of its source.
#[derive(Debug, Default)]
pub struct Watch {
    /// The view stands still.
    pub paused: AtomicBool,
    /// Nobody can see the window.
    pub hidden: AtomicBool,
}

/// Starts a source that fills the model and asks for frames.
///
/// # Errors
/// Where the system starts no thread.
pub fn open(
    spec: SourceSpec,
    shared: &Arc<Shared>,
    ctx: &Context,
    watch: &Arc<Watch>,
) -> io::Result<SourceHandle> {
    let filled = Arc::clone(shared);
    let take = move |feed| filled.engine().model.take(feed);
    let (shown, ctx, watch) = (Arc::clone(shared), ctx.clone(), Arc::clone(watch));
    let wake = move || look(&shown, &ctx, &watch);
    let source = SourceHandle::spawn(spec, grip_sim::mcu::peer, take, wake)?;
    shared.engine().orders = Some(source.orders.clone());
    Ok(source)
}

/// Asks for a frame where what is new is worth one.
pub fn look(shared: &Shared, ctx: &Context, watch: &Watch) {
    let brought = shared.engine().look();
    let looked_at = !watch.paused.load(Ordering::Relaxed);
    let visible = !watch.hidden.load(Ordering::Relaxed);
    if let Some(wait) = wait(brought, looked_at).filter(|_| visible) {
        ctx.request_repaint_after(wait);
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
