//! What a frame costs without a window: the whole user interface is run and its shapes are turned into triangles.
//!
//! `cargo bench -p gripmon --bench frames` prints a table; times are those of this thread, 300 frames each.

#[path = "../tests/window/fixture.rs"]
#[expect(dead_code, reason = "the tests need more of it")]
mod fixture;

use core::time::Duration;
use eframe::egui::{Context, Pos2, RawInput, Rect, Ui, vec2};
use grip_link::message::daemon::Scene;
use grip_scope::feed::{DerivedBlock, EventMark, Feed, SpectrumColumn, TaxelBlock, Turn};
use grip_scope::{Channel, EventKind, Model, Span};
use gripmon::layout::Layout;
use gripmon::scope::{self, Shared};
use gripmon::state::ViewState;
use gripmon::strip::StripId;
use gripmon::{Engine, Scope};
use std::sync::Arc;
use std::time::Instant;

pub(crate) const FRAMES: usize = 300;
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
    heading();
    curves();
    live(0);
    live(244);
    gaps();
    spectrogram();
}

pub(crate) fn heading() {
    line(&format!(
        "{:<46} {:>9} {:>9} {:>9} {:>10}",
        "frame", "least", "median", "95 %", "triangles"
    ));
}

fn curves() {
    let mut model = Model::new(800 << 20);
    for start in (0..1_000_000).step_by(10_000) {
        model.take(Feed::Rows(fixture::rows(&Channel::ROWS, RATE_HZ, start, start + 10_000)));
    }
    let mut bench = Bench::new(model, &SIX);
    let whole = |bench: &mut Bench, i: usize| bench.show(0.001 * i as f64, 50.0);
    bench.run("6 plots, 9 channels of 1e6 samples, all seen", whole);
    // No column of the frame before can be used again.
    let zoom = |bench: &mut Bench, i: usize| bench.show(0.0, 40.0 + 0.03 * i as f64);
    bench.run("the same, another zoom in each frame", zoom);
    let part = |bench: &mut Bench, i: usize| bench.show(10.0 + 0.01 * i as f64, 1.0);
    bench.run("the same, one second seen, moved on by 10 ms", part);
    let few = |bench: &mut Bench, i: usize| bench.show(10.0 + 0.0001 * i as f64, 0.02);
    bench.run("the same, 20 ms seen", few);
}

/// Channels that grow at 20 kHz beside those of states and bands.
const TWELVE: [Channel; 12] = [
    Channel::Stylus,
    Channel::NormalForce,
    Channel::TangentialForce,
    Channel::Travel,
    Channel::Velocity,
    Channel::SecondStylus,
    Channel::Reference,
    Channel::Pressure,
    Channel::Motion,
    Channel::SlipSpeed,
    Channel::OwnEsc,
    Channel::OwnEstimate,
];

/// Twelve channels, and an array of `taxels`, that grow at 20 kHz while every plot is seen, with everything else that a daemon reports and the
/// scope derives: 33 ms of it come before each frame.
fn live(taxels: usize) {
    let mut model = fixture::grasp();
    model.take(Feed::Restart);
    let mut bench = Bench::new(model, &StripId::ALL);
    bench.scope.state.window.follow();
    let mut taken = Vec::new();
    let rows = 667;
    let grow = |bench: &mut Bench, i: usize| {
        let from = 100_000 + i * rows;
        let mut block = fixture::rows(&TWELVE, RATE_HZ, from, from + rows);
        let values = || (0..rows * taxels).map(|k| ((k + i) % 1000) as f32).collect();
        block.taxels = (taxels > 0).then(|| TaxelBlock { count: taxels, values: values() });
        let more = beside(from as f64 / RATE_HZ as f64, i);
        let start = now();
        let mut engine = bench.scope.shared.engine();
        engine.model.take(Feed::Rows(block));
        more.into_iter().for_each(|feed| engine.model.take(feed));
        taken.push(start.elapsed());
    };
    let name = match taxels {
        0 => "10 plots, 12 channels live at 20 kHz, 20 more".to_owned(),
        _ => format!("the same with an array of {taxels} taxels"),
    };
    bench.run(&name, grow);
    taken.sort();
    line(&format!(
        "{:<46} {:>9}",
        "  33 ms of all that into the model",
        shown(taken[taken.len() / 2])
    ));
}

/// What comes with the rows of 33 ms: states, bands, peaks and valleys, spectra, and now and then an event and figures.
fn beside(from_s: f64, i: usize) -> Vec<Feed> {
    let at = |k: u32, of: f64| from_s + of * f64::from(k);
    let mut feeds: Vec<Feed> = (0..3).map(|k| Feed::State(fixture::state(at(k, 0.01)))).collect();
    let turn = |k: u32| Turn { t_s: at(k, 0.0005), height: 1e-5, is_peak: k.is_multiple_of(2) };
    let mut block = DerivedBlock {
        turns: (0..66).map(turn).collect(),
        spectra: (0..3).map(|k| spectrum(at(k, 0.011), 0.011)).collect(),
        ..DerivedBlock::default()
    };
    (0..8).for_each(|k| fixture::bands(&mut block, at(k, 0.004)));
    feeds.push(Feed::Derived(Box::new(block)));
    if i.is_multiple_of(10) {
        feeds.push(Feed::Event(EventMark::plain(from_s, EventKind::Client, "a client asks")));
    }
    if i.is_multiple_of(30) {
        feeds.push(Feed::Health(Box::new(fixture::health())));
    }
    feeds
}

fn spectrum(from_s: f64, length_s: f64) -> SpectrumColumn {
    let bins = (0..=u8::MAX).collect();
    SpectrumColumn { span: [from_s, from_s + length_s], top_hz: 10_000.0, bins }
}

/// As many gaps, slips and scenes as are kept, all seen at once: nearly a thousand seconds at 1 kHz with a gap each 20 ms.
fn gaps() {
    let mut model = Model::new(800 << 20);
    for gap in 0..50_000 {
        let mut block = fixture::rows(&SIX_ROWS, 1000, 20 * gap, 20 * gap + 15);
        block.broken = true;
        model.take(Feed::Rows(block));
        let t_s = 0.02 * gap as f64;
        let mut state = fixture::state(t_s + 0.01);
        state.scene = if gap.is_multiple_of(2) { Scene::Holding } else { Scene::Slipping };
        model.take(Feed::State(state));
        let kind = if gap.is_multiple_of(2) { EventKind::Gross } else { EventKind::Ended };
        model.take(Feed::Event(EventMark::plain(t_s + 0.01, kind, "x")));
    }
    let mut bench = Bench::new(model, &SIX);
    let whole = |bench: &mut Bench, i: usize| bench.show(0.001 * i as f64, 1000.0);
    bench.run("6 plots, 50,000 gaps, 25,000 slips, all seen", whole);
    let part = |bench: &mut Bench, i: usize| bench.show(10.0 + 0.01 * i as f64, 20.0);
    bench.run("the same, a thousand gaps seen", part);
}

const SIX_ROWS: [Channel; 6] = [
    Channel::Stylus,
    Channel::NormalForce,
    Channel::Travel,
    Channel::Velocity,
    Channel::Reference,
    Channel::Pressure,
];

/// An hour of spectra, and more of them before each frame.
fn spectrogram() {
    let mut model = Model::new(800 << 20);
    let second = |model: &mut Model, from: usize, rows: usize| {
        let stylus = [Channel::Stylus];
        model.take(Feed::Rows(fixture::rows(&stylus, 1000, from, from + rows)));
        let count = (rows / 13).max(1);
        let step_s = rows as f64 / 1000.0 / count as f64;
        let at = |k: usize| from as f64 / 1000.0 + step_s * k as f64;
        let spectra = (0..count).map(|k| spectrum(at(k), step_s)).collect();
        model.take(Feed::Derived(Box::new(DerivedBlock { spectra, ..DerivedBlock::default() })));
    };
    (0..3600).for_each(|s| second(&mut model, 1000 * s, 1000));
    let spectra = model.spectrogram().len();
    let mut bench = Bench::new(model, &[StripId::Spectrogram]);
    let begin = 3_600_000;
    let grow = |bench: &mut Bench, i: usize| {
        second(&mut bench.scope.shared.engine().model, begin + 33 * i, 33);
    };
    bench.scope.state.window.all();
    bench.run(&format!("spectrogram, live, {spectra} spectra seen"), grow);
    let grow = |bench: &mut Bench, i: usize| {
        second(&mut bench.scope.shared.engine().model, begin + 33 * (400 + i), 33);
    };
    bench.scope.state.window.follow();
    bench.run("the same, 5 s seen", grow);
    let moved = |bench: &mut Bench, i: usize| bench.show(10.0 * i as f64, 600.0);
    bench.run("the same, 600 s seen, moved in each frame", moved);
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
        let mut drawn = Drawn::default();
        for i in 0..FRAMES + 20 {
            before(self, i);
            drawn.frame(&self.ctx, i, |ui| drop(self.scope.ui(ui)));
        }
        drawn.print(name);
    }
}

/// What frames cost.
#[derive(Default)]
pub(crate) struct Drawn {
    times: Vec<Duration>,
    triangles: usize,
}

impl Drawn {
    pub(crate) fn frame(&mut self, ctx: &Context, i: usize, mut ui: impl FnMut(&mut Ui)) {
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(1600.0, 1000.0));
        let input = RawInput {
            screen_rect: Some(screen),
            time: Some(i as f64 / 30.0),
            ..RawInput::default()
        };
        let start = now();
        let mut output = ctx.run_ui(input, |frame| ui(frame));
        let drawn = ctx.tessellate(output.shapes, output.pixels_per_point);
        let time = start.elapsed();
        output.textures_delta.clear();
        self.triangles = drawn.iter().map(|part| count(&part.primitive)).sum();
        // The first frames make fonts.
        if i >= 20 {
            self.times.push(time);
        }
    }

    pub(crate) fn print(mut self, name: &str) {
        self.times.sort();
        let at = |share: usize| shown(self.times[(self.times.len() - 1) * share / 100]);
        let triangles = self.triangles;
        line(&format!("{name:<46} {:>9} {:>9} {:>9} {triangles:>10}", at(0), at(50), at(95)));
    }
}

fn count(primitive: &eframe::egui::epaint::Primitive) -> usize {
    match primitive {
        eframe::egui::epaint::Primitive::Mesh(mesh) => mesh.indices.len() / 3,
        eframe::egui::epaint::Primitive::Callback(_) => 0,
    }
}

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
pub(crate) fn line(text: &str) {
    println!("{text}");
}

pub(crate) fn shown(time: Duration) -> String {
    format!("{:.2} ms", 1e3 * time.as_secs_f64())
}

#[expect(clippy::disallowed_methods, reason = "a bench measures time")]
pub(crate) fn now() -> Instant {
    Instant::now()
}
