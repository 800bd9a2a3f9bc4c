//! The whole window, without a system behind it: data and state in, one frame out.

use crate::action::Action;
use crate::apply::{self, Effect};
use crate::engine::Engine;
use crate::keys;
use crate::layout::{Look, PANEL};
use crate::palette::{self, Palette};
use crate::state::ViewState;
use crate::views::{self, Scratch, Seen};
use core::ops::Deref;
use core::sync::atomic::{AtomicBool, Ordering};
use eframe::egui::{self, CentralPanel, Frame, Margin, Panel, Theme, Ui};
use grip_scope::Model;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The engine, shared by the pump and the window.
#[derive(Debug)]
pub struct Shared {
    engine: Mutex<Engine>,
    /// The window waits: whoever fills the engine lets it in.
    waits: AtomicBool,
}

impl Shared {
    /// An engine to be shared.
    #[must_use]
    pub const fn new(engine: Engine) -> Self {
        Self { engine: Mutex::new(engine), waits: AtomicBool::new(false) }
    }

    /// The engine, for the pump. What a thread that has panicked left is still data.
    pub fn engine(&self) -> MutexGuard<'_, Engine> {
        self.engine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The engine, for the window, which goes first.
    pub fn engine_first(&self) -> MutexGuard<'_, Engine> {
        self.waits.store(true, Ordering::Relaxed);
        let engine = self.engine();
        self.waits.store(false, Ordering::Relaxed);
        engine
    }

    /// The model, for whoever copies a piece of it.
    pub fn model(&self) -> ModelGuard<'_> {
        ModelGuard(self.engine())
    }

    /// Whether the window waits.
    #[must_use]
    pub fn is_waited_for(&self) -> bool {
        self.waits.load(Ordering::Relaxed)
    }
}

/// The model, while nobody else has the engine.
#[derive(Debug)]
pub struct ModelGuard<'a>(MutexGuard<'a, Engine>);

impl Deref for ModelGuard<'_> {
    type Target = Model;

    fn deref(&self) -> &Model {
        &self.0.model
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
        let mut engine = shared.engine_first();
        apply::follow_up(&mut self.state, &mut engine);
        let seen = Seen {
            model: &engine.model,
            state: &self.state,
            palette: Palette::of(theme),
            span: self.state.window.visible(engine.model.span()),
            dropped: engine.dropped(),
        };
        let actions = show(ui, &seen, &mut self.scratch);
        let apply = |action| apply::apply(&mut self.state, &mut engine, action);
        actions.iter().filter_map(apply).collect()
    }

    /// What will be remembered.
    #[must_use]
    pub fn layout(&self) -> crate::layout::Layout {
        let seconds = self.state.window.length_s();
        crate::layout::Layout { seconds, ..self.state.layout.clone() }
    }
}

fn show(ui: &mut Ui, seen: &Seen<'_>, scratch: &mut Scratch) -> Vec<Action> {
    let mut actions = keys::pressed(ui.ctx(), seen.state.has_dialog());
    let bar = |x, y| Frame::new().fill(seen.palette.panel).inner_margin(Margin::symmetric(x, y));
    actions.extend(
        Panel::top("toolbar").frame(bar(8, 5)).show(ui, |ui| views::toolbar(ui, seen)).inner,
    );
    actions.extend(
        Panel::bottom("status").frame(bar(8, 3)).show(ui, |ui| views::status(ui, seen)).inner,
    );
    if let Some(panel) = seen.state.layout.panel {
        // The plots keep half of a narrow window.
        let most = (ui.available_width() / 2.0).clamp(PANEL.0, PANEL.1);
        let wanted = seen.state.layout.panel_width;
        let side = Panel::right("panel")
            .default_size(wanted.min(most))
            .size_range(PANEL.0..=most)
            .frame(bar(10, 4));
        let shown = side.show(ui, |ui| views::panel(ui, panel, seen));
        let width = shown.response.rect.width();
        // A window that is narrow for a while does not change what is remembered.
        if (width - wanted.min(most)).abs() > 0.5 {
            actions.push(Action::PanelWidth(width));
        }
        actions.extend(shown.inner);
    }
    let middle = CentralPanel::default().frame(Frame::new().fill(seen.palette.panel));
    let shown = middle.show(ui, |ui| match seen.model.study() {
        Some(study) if seen.model.span().is_none() => views::study(ui, study, seen),
        _ => views::stack(ui, seen, scratch),
    });
    actions.extend(shown.inner);
    actions.extend(views::overlay(ui.ctx(), seen));
    actions
}

/// Prepares a context: fonts, colours of both themes, no zooming by key.
pub fn prepare(ctx: &egui::Context, look: Look) {
    palette::install(ctx);
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.set_theme(if look == Look::Dark { Theme::Dark } else { Theme::Light });
}
