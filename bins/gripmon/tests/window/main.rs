//! The whole window without a display: what it shows, found by its labels; what its controls do; when it paints.

mod commands;
mod controls;
mod desk;
mod details;
mod fixture;
mod guides;
mod labels;
mod nasty;
mod repaint;
mod shown;

use egui_kittest::Harness;
use grip_scope::Model;
use gripmon::Scope;
use gripmon::engine::Engine;
use gripmon::layout::{Layout, Panel};
use gripmon::scope::{self, Shared};
use gripmon::state::ViewState;
use std::sync::Arc;

/// A window on a model, with this panel open and every plot shown.
fn window(model: Model, panel: Panel) -> Harness<'static, Scope> {
    let mut layout = Layout { panel: Some(panel), ..Layout::default() };
    layout.plots.iter_mut().for_each(|plot| plot.shown = true);
    let mut state = ViewState::new(layout);
    state.window.all();
    let scope = Scope::new(Arc::new(Shared::new(Engine::new(model, None))), state);
    let mut prepared = false;
    let frame = move |ui: &mut eframe::egui::Ui, scope: &mut Scope| {
        if !core::mem::replace(&mut prepared, true) {
            scope::prepare(ui.ctx(), scope.state.layout.theme);
        }
        let _effects = scope.ui(ui);
    };
    let mut harness = Harness::builder().with_size([1400.0, 1000.0]).build_ui_state(frame, scope);
    harness.run();
    harness
}
