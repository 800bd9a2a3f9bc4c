//! The whole window, without a system behind it.

use crate::apply::{self, Effect};
use crate::engine::Engine;
use crate::keys;
use crate::layout::{Look, PANEL};
use crate::palette::{self, Palette};
use crate::state::ViewState;
use crate::views::{self, Scratch, Seen};
use eframe::egui::{self, CentralPanel, Frame, Margin, Panel, Theme, Ui};
use grip_scope::{SourceHandle, SourceSpec};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The engine, shared by the window and the thread of its source.
#[derive(Debug)]
pub struct Shared(Mutex<Engine>);

impl Shared {
    /// An engine to be shared.
    #[must_use]
    pub const fn new(engine: Engine) -> Self {
        Self(Mutex::new(engine))
    }

    /// The engine. What a thread that has panicked left is still data.
    pub fn engine(&self) -> MutexGuard<'_, Engine> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts a source that fills the model and asks for frames.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn open(
        self: &Arc<Self>,
        spec: SourceSpec,
        ctx: &egui::Context,
    ) -> io::Result<SourceHandle> {
        let (filled, shown, ctx) = (Arc::clone(self), Arc::clone(self), ctx.clone());
        let take = move |feed| filled.engine().model.take(feed);
        let wake = move || {
            let wait = shown.engine().look();
            wait.into_iter().for_each(|wait| ctx.request_repaint_after(wait));
        };
        let source = SourceHandle::spawn(spec, grip_sim::mcu::peer, take, wake)?;
        self.engine().orders = Some(source.orders.clone());
        Ok(source)
    }
}

/// Everything that a frame needs.
#[derive(Debug)]
pub struct Scope {
    /// The data.
    pub shared: Arc<Shared>,
    /// What the user has changed.
    pub state: ViewState,
    scratch: Scratch,
    frames: u64,
}

impl Scope {
    /// A window on an engine.
    #[must_use]
    pub fn new(shared: Arc<Shared>, state: ViewState) -> Self {
        Self { shared, state, scratch: Scratch::default(), frames: 0 }
    }

    /// Frames drawn so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Draws a frame, fulfils what the user asks for in it, and reports what is left to be done.
    pub fn ui(&mut self, ui: &mut Ui) -> Vec<Effect> {
        self.frames += 1;
        let theme = if self.state.layout.theme == Look::Dark { Theme::Dark } else { Theme::Light };
        if ui.ctx().theme() != theme {
            ui.ctx().set_theme(theme);
            ui.ctx().request_repaint();
        }
        let shared = Arc::clone(&self.shared);
        let mut engine = shared.engine();
        apply::follow_up(&mut self.state, &mut engine);
        let data = engine.model.span();
        let span = self.state.window.visible(data);
        let newest_s = data.map_or(span.to_s, |data| data.to_s.min(span.to_s));
        let seen = Seen {
            model: &engine.model,
            palette: Palette::of(theme),
            span,
            looked_at_s: self.state.hover_s.unwrap_or(newest_s),
        };
        show(ui, &seen, &mut self.state, &mut self.scratch);
        engine.paused = self.state.is_paused();
        engine.watch(self.state.armed.then_some(self.state.layout.trigger));
        let asked = core::mem::take(&mut self.state.asked);
        let fulfil = |effect| apply::fulfil(&mut self.state, &mut engine, effect);
        asked.into_iter().filter_map(fulfil).collect()
    }

    /// What will be remembered.
    #[must_use]
    pub fn layout(&self) -> crate::layout::Layout {
        let seconds = self.state.window.length_s();
        crate::layout::Layout { seconds, ..self.state.layout.clone() }
    }
}

fn show(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState, scratch: &mut Scratch) {
    keys::obey(ui.ctx(), state, seen.model);
    let bar = |x, y| Frame::new().fill(seen.palette.panel).inner_margin(Margin::symmetric(x, y));
    Panel::top("toolbar").frame(bar(8, 5)).show(ui, |ui| views::toolbar(ui, seen, state));
    Panel::bottom("status").frame(bar(8, 3)).show(ui, |ui| views::status(ui, seen, state));
    if let Some(panel) = state.layout.panel {
        // The plots keep half of a narrow window.
        let most = (ui.available_width() / 2.0).clamp(PANEL.0, PANEL.1);
        let wanted = state.layout.panel_width.min(most);
        let side =
            Panel::right("panel").default_size(wanted).size_range(PANEL.0..=most).frame(bar(10, 4));
        let shown = side.show(ui, |ui| views::panel(ui, panel, seen, state));
        let width = shown.response.rect.width();
        // A window that is narrow for a while does not change what is remembered.
        if (width - wanted).abs() > 0.5 {
            state.layout.panel_width = width;
        }
    }
    let middle = CentralPanel::default().frame(Frame::new().fill(seen.palette.panel));
    middle.show(ui, |ui| match seen.model.study() {
        Some(study) if seen.model.span().is_none() => views::study(ui, study, seen),
        _ => views::stack(ui, seen, state, scratch),
    });
    views::overlay(ui.ctx(), seen, state);
}

/// Prepares a context: fonts, colours of both themes, no zooming by key.
pub fn prepare(ctx: &egui::Context, look: Look) {
    palette::install(ctx);
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.set_theme(if look == Look::Dark { Theme::Dark } else { Theme::Light });
}
