//! When a frame is painted: only where something that can be seen is new. What is worth one is tested beside the engine.

use super::{fixture, window};
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use eframe::egui::{Context, RawInput, ViewportId};
use grip_scope::{Model, SourceSpec};
use gripmon::engine::Engine;
use gripmon::layout::Panel;
use gripmon::scope::Shared;
use std::sync::Arc;
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

#[test]
fn a_source_asks_for_a_frame_when_it_brings_something() {
    let (asked, ctx) = (Arc::<AtomicBool>::default(), Context::default());
    // The first frames of a window ask for more of them.
    for _ in 0..3 {
        ctx.run_ui(RawInput::default(), |_| {}).textures_delta.clear();
    }
    let heard = Arc::clone(&asked);
    ctx.set_request_repaint_callback(move |_| heard.store(true, Ordering::Relaxed));
    let shared = Arc::new(Shared::new(Engine::new(Model::new(64 << 20), None)));
    let _source = shared.open(SourceSpec::parse("demo").unwrap(), &ctx).unwrap();
    // However long a busy machine takes for it.
    let came = (0..6000).any(|_| {
        thread::park_timeout(Duration::from_millis(10));
        asked.load(Ordering::Relaxed)
    });
    assert!(came && shared.engine().model.revision() > 0);
}
