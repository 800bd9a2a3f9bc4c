//! When a frame is painted: only where something that can be seen is new.

use super::{fixture, window};
use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use eframe::egui::{Context, ViewportId};
use grip_scope::{Feed, Model, SourceHandle, SourceSpec, SourceStatus};
use gripmon::engine::Engine;
use gripmon::layout::Panel;
use gripmon::repaint::{self, Watch};
use gripmon::scope::Shared;
use std::sync::{Arc, Mutex};
use std::thread;

#[test]
fn a_window_without_updates_asks_for_no_further_frame() {
    for panel in Panel::ALL {
        let mut harness = window(fixture::grasp(), panel);
        let frames = harness.state().frames();
        harness.step();
        let output = &harness.output().viewport_output[&ViewportId::ROOT];
        assert_eq!(output.repaint_delay, Duration::MAX, "{panel:?}");
        assert_eq!(harness.state().frames(), frames + 1);
    }
}

fn paint(ctx: &Context) {
    let mut output = ctx.run_ui(eframe::egui::RawInput::default(), |_| {});
    output.textures_delta.clear();
}

/// The simulator runs; whoever asks for a frame gets one, and they are counted.
struct Running {
    shared: Arc<Shared>,
    watch: Arc<Watch>,
    ctx: Context,
    requests: Arc<AtomicU64>,
    _source: SourceHandle,
}

#[expect(clippy::unwrap_used, clippy::panic, reason = "part of a test")]
impl Running {
    fn start() -> Self {
        let requests: Arc<AtomicU64> = Arc::default();
        let (counted, ctx) = (Arc::clone(&requests), Context::default());
        ctx.set_request_repaint_callback(move |_| {
            counted.fetch_add(1, Ordering::Relaxed);
        });
        // The first frames of a window ask for more of them.
        (0..3).for_each(|_| paint(&ctx));
        requests.store(0, Ordering::Relaxed);
        let watch = Arc::default();
        let shared = Arc::new(Shared::new(Engine::new(Model::new(64 << 20), None)));
        let demo = SourceSpec::parse("demo").unwrap();
        let source = repaint::open(demo, &shared, &ctx, &watch).unwrap();
        Self { shared, watch, ctx, requests, _source: source }
    }

    /// Whether a frame is asked for, however long a busy machine takes for it; it is painted, else no other one would be.
    fn paints(&self) -> bool {
        let asked = |_| {
            thread::park_timeout(Duration::from_millis(10));
            self.requests.swap(0, Ordering::Relaxed) > 0
        };
        let painted = (0..6000).any(asked);
        paint(&self.ctx);
        painted
    }

    /// Frames until the model has this much more news, however long a busy machine takes for it.
    fn after_updates(&self, updates: u64) -> u64 {
        let revision = || self.shared.engine().model.revision();
        let (mut frames, until) = (0, revision() + updates);
        for _ in 0..6000 {
            if self.requests.swap(0, Ordering::Relaxed) > 0 {
                paint(&self.ctx);
                frames += 1;
            }
            if revision() >= until {
                return frames;
            }
            thread::park_timeout(Duration::from_millis(10));
        }
        panic!("the demo stands still");
    }
}

#[test]
fn data_paint_a_view_that_follows_and_none_that_is_paused_or_hidden() {
    let running = Running::start();
    assert!(running.paints());
    for (unseen, name) in [(&running.watch.paused, "paused"), (&running.watch.hidden, "hidden")] {
        unseen.store(true, Ordering::Relaxed);
        // What was under way.
        let _settling = running.after_updates(5);
        assert_eq!(running.after_updates(50), 0, "{name}");
        unseen.store(false, Ordering::Relaxed);
        assert!(running.paints(), "{name} no more");
    }
}

#[test]
fn a_file_that_is_loaded_paints_a_view_that_stands_still_a_few_times_a_second() {
    let (ctx, asked) = (Context::default(), Arc::<Mutex<Option<Duration>>>::default());
    let received = Arc::clone(&asked);
    ctx.set_request_repaint_callback(move |info| *received.lock().unwrap() = Some(info.delay));
    let shared = Shared::new(Engine::new(Model::new(1 << 20), None));
    let watch = Watch::default();
    watch.paused.store(true, Ordering::Relaxed);
    // The first frames of a window ask for more of them; the first state is another one.
    shared.engine().model.take(Feed::Status(SourceStatus::Loading { done: 0.0 }));
    repaint::look(&shared, &ctx, &watch);
    for done in [0.1, 0.11] {
        (0..3).for_each(|_| paint(&ctx));
        *asked.lock().unwrap() = None;
        shared.engine().model.take(Feed::Status(SourceStatus::Loading { done }));
        repaint::look(&shared, &ctx, &watch);
        let delay = asked.lock().unwrap().take().unwrap();
        assert!((0.1..0.5).contains(&delay.as_secs_f32()), "{done}: {delay:?}");
    }
}
