//! What a frame costs without a window: the whole user interface is run and its shapes are turned into triangles.
//!
//! `cargo bench -p gripmon --bench frames` prints a table; times are those of this thread, 300 frames each.

#[path = "../tests/window/fixture.rs"]
#[expect(dead_code, reason = "the tests need more of it")]
mod fixture;

use core::time::Duration;
use eframe::egui::{Context, Pos2, RawInput, Rect, vec2};
use grip_scope::feed::Feed;
use grip_scope::{Channel, Model, Span};
use gripmon::layout::Layout;
use gripmon::scope::{self, Shared};
use gripmon::state::ViewState;
use gripmon::strip::StripId;
use gripmon::{Engine, Scope};
use std::sync::Arc;
use std::time::Instant;

const FRAMES: usize = 300;
const RATE_HZ: u64 = 20_000;
/// The plots of the first row: all of curves at the sample rate.
const SIX: [StripId; 6] = [
    StripId::Stylus,
    StripId::Force,
    StripId::Speed,
    StripId::Travel,
    StripId::Reference,
    StripId::Pressure,
];

fn main() {
    line(&format!(
        "{:<44} {:>9} {:>9} {:>9} {:>10}",
        "frame", "least", "median", "95 %", "triangles"
    ));
    let mut model = Model::new(800 << 20);
    for start in (0..1_000_000).step_by(10_000) {
        model.take(Feed::Rows(fixture::rows(&Channel::ROWS, RATE_HZ, (start, start + 10_000))));
    }
    let mut bench = Bench::new(model, &SIX);
    let whole = |bench: &mut Bench, i: usize| bench.show(0.001 * i as f64, 50.0);
    bench.run("6 plots, 9 channels of 1e6 samples, all seen", whole);
    let part = |bench: &mut Bench, i: usize| bench.show(10.0 + 0.01 * i as f64, 1.0);
    bench.run("the same, one second seen", part);
    let few = |bench: &mut Bench, i: usize| bench.show(10.0 + 0.0001 * i as f64, 0.02);
    bench.run("the same, 20 ms seen", few);
    live();
}

/// Twelve channels that grow at 20 kHz while every plot is seen: 33 ms of samples come before each frame.
fn live() {
    let mut model = fixture::grasp();
    model.take(Feed::Restart);
    let mut bench = Bench::new(model, &StripId::ALL);
    bench.scope.state.window.follow();
    let mut taken = Vec::new();
    let rows = 667;
    let grow = |bench: &mut Bench, i: usize| {
        let block =
            fixture::rows(&Channel::ROWS, RATE_HZ, (100_000 + i * rows, 100_000 + (i + 1) * rows));
        let start = now();
        bench.scope.shared.engine().model.take(Feed::Rows(block));
        taken.push(start.elapsed());
    };
    bench.run("10 plots, 12 and more channels, live at 20 kHz", grow);
    taken.sort();
    line(&format!(
        "{:<44} {:>9}",
        "  33 ms of samples into the model",
        shown(taken[taken.len() / 2])
    ));
}

struct Bench {
    ctx: Context,
    scope: Scope,
}

impl Bench {
    fn new(model: Model, plots: &[StripId]) -> Self {
        let ctx = Context::default();
        let mut layout = Layout::default();
        layout.plots.iter_mut().for_each(|plot| plot.shown = plots.contains(&plot.plot));
        scope::prepare(&ctx, layout.theme);
        let shared = Arc::new(Shared::new(Engine::new(model, None)));
        Self { ctx, scope: Scope::new(shared, ViewState::new(layout)) }
    }

    fn show(&mut self, from_s: f64, length_s: f64) {
        self.scope.state.window.show(Span { from_s, to_s: from_s + length_s });
    }

    fn run(&mut self, name: &str, mut before: impl FnMut(&mut Self, usize)) {
        let mut times = Vec::with_capacity(FRAMES);
        let mut triangles = 0;
        for i in 0..FRAMES + 20 {
            before(self, i);
            let screen = Rect::from_min_size(Pos2::ZERO, vec2(1600.0, 1000.0));
            let input = RawInput {
                screen_rect: Some(screen),
                time: Some(i as f64 / 30.0),
                ..RawInput::default()
            };
            let start = now();
            let mut output = self.ctx.run_ui(input, |ui| {
                let _effects = self.scope.ui(ui);
            });
            let drawn = self.ctx.tessellate(output.shapes, output.pixels_per_point);
            let time = start.elapsed();
            output.textures_delta.clear();
            triangles = drawn.iter().map(|part| count(&part.primitive)).sum();
            // The first frames make fonts.
            if i >= 20 {
                times.push(time);
            }
        }
        times.sort();
        let at = |share: usize| shown(times[(times.len() - 1) * share / 100]);
        line(&format!("{name:<44} {:>9} {:>9} {:>9} {triangles:>10}", at(0), at(50), at(95)));
    }
}

fn count(primitive: &eframe::egui::epaint::Primitive) -> usize {
    match primitive {
        eframe::egui::epaint::Primitive::Mesh(mesh) => mesh.indices.len() / 3,
        eframe::egui::epaint::Primitive::Callback(_) => 0,
    }
}

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn line(text: &str) {
    println!("{text}");
}

fn shown(time: Duration) -> String {
    format!("{:.2} ms", 1e3 * time.as_secs_f64())
}

#[expect(clippy::disallowed_methods, reason = "a bench measures time")]
fn now() -> Instant {
    Instant::now()
}
