//! What is seen of the model, and what a user changes of the view.

mod axis;
mod command;
mod cursors;
mod events;
mod explain;
mod export;
mod gestures;
mod health;
mod help;
mod joined;
mod lane;
mod overview;
mod picture;
mod pressure;
mod readout;
mod spectrogram;
pub(crate) mod stack;
pub(crate) mod status;
mod strips;
mod study;
mod toolbar;
mod tour;
mod trigger;

pub use stack::{empty, stack};
pub use status::{status, tone};
pub use study::study;
pub use toolbar::toolbar;

use crate::layout::Panel;
use crate::palette::Palette;
use crate::state::ViewState;
use eframe::egui::{self, Painter, Rect, Ui};
use grip_scope::{EventKind, Model, Span};

/// What a view may look at.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The data.
    pub model: &'a Model,
    /// The colours.
    pub palette: Palette,
    /// The time that is seen.
    pub span: Span,
    /// The time that numbers beside the plots belong to (s): that of the pointer, else the newest that is seen.
    pub looked_at_s: f64,
}

/// Memory that frames use again, and pictures that are on the graphics card.
#[derive(Default)]
pub struct Scratch {
    pieces: Vec<joined::Piece<EventKind>>,
    spectrogram: picture::Picture,
    pressure: picture::Picture,
}

impl core::fmt::Debug for Scratch {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Scratch").finish_non_exhaustive()
    }
}

/// The panel at the right.
pub fn panel(ui: &mut Ui, panel: Panel, seen: &Seen<'_>, state: &mut ViewState) {
    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().interact_size.y = 16.0;
        ui.spacing_mut().item_spacing.y = 3.0;
        match panel {
            Panel::Health => health::health(ui, seen),
            Panel::Events => events::events(ui, seen, state),
            Panel::Cursors => cursors::cursors(ui, seen, state),
            Panel::Trigger => trigger::trigger(ui, seen, state),
            Panel::Export => export::export(ui, seen, state),
            Panel::Command => command::command(ui, seen, state),
        }
    });
}

/// What lies over the plots.
pub fn overlay(ctx: &egui::Context, seen: &Seen<'_>, state: &mut ViewState) {
    if state.help {
        help::help(ctx, state);
    }
    if let Some(at_s) = state.explain {
        explain::explain(ctx, seen.model, at_s, state);
    }
    if let Some(hint) = state.tour {
        tour::tour(ctx, hint, state);
    }
    if state.command.asks_release {
        command::question(ctx, state);
    }
}

/// The ground of a plot.
fn ground(painter: &Painter, rect: Rect, palette: &Palette) {
    let edge = egui::Stroke::new(1.0, palette.edge);
    painter.rect(rect, 0, palette.plot, edge, egui::StrokeKind::Outside);
}

/// A button of a panel, as wide as others: whether it was clicked.
fn wide_button(ui: &mut Ui, enabled: bool, name: &str, about: &str) -> bool {
    let button = egui::Button::new(name).min_size(egui::vec2(160.0, 22.0));
    ui.add_enabled(enabled, button).on_hover_text(about).clicked()
}

/// A heading of a part of a panel.
fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    ui.label(egui::RichText::new(text).strong());
    ui.add_space(1.0);
}

/// A row of a panel: what it is, and its value with equal digits.
fn row(ui: &mut Ui, name: &str, value: impl Into<String>) {
    row_in(ui, name, egui::RichText::new(value.into()).monospace());
}

fn row_in(ui: &mut Ui, name: &str, value: egui::RichText) {
    ui.horizontal(|ui| {
        let left = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(egui::vec2(112.0, 16.0), left, |ui| {
            ui.set_min_width(112.0);
            ui.weak(name);
        });
        ui.add(egui::Label::new(value).wrap());
    });
}

/// A quiet sentence.
fn sentence(ui: &mut Ui, text: impl Into<String>) {
    ui.add(egui::Label::new(egui::RichText::new(text.into()).weak()).wrap());
}
