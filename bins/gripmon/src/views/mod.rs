//! What is seen in; pictures on the screen and requests of the user out. Views change nothing themselves.

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
pub use tour::HINTS;

use crate::action::Action;
use crate::layout::Panel;
use crate::palette::Palette;
use crate::state::ViewState;
use eframe::egui::{self, Ui};
use grip_scope::{Bucket, Model, Span};

/// What a view may look at.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The data.
    pub model: &'a Model,
    /// What the user has changed.
    pub state: &'a ViewState,
    /// The colours.
    pub palette: Palette,
    /// The time that is seen.
    pub span: Span,
    /// Items that were lost between the source and this program.
    pub dropped: u64,
}

impl Seen<'_> {
    /// The time that numbers beside the plots belong to (s): that of the pointer, else the newest that is seen.
    #[must_use]
    pub fn looked_at_s(&self) -> f64 {
        let newest_s =
            self.model.span().map_or(self.span.to_s, |data| data.to_s.min(self.span.to_s));
        self.state.hover_s.unwrap_or(newest_s)
    }
}

/// Memory that frames use again, and pictures that are on the graphics card.
#[derive(Default)]
pub struct Scratch {
    buckets: Vec<Bucket>,
    points: Vec<[f64; 2]>,
    washes: Vec<strips::Wash>,
    spectrogram: picture::Picture,
    pressure: picture::Picture,
}

impl core::fmt::Debug for Scratch {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Scratch").finish_non_exhaustive()
    }
}

/// The panel at the right.
pub fn panel(ui: &mut Ui, panel: Panel, seen: &Seen<'_>) -> Vec<Action> {
    let contents = |ui: &mut Ui| {
        ui.spacing_mut().interact_size.y = 16.0;
        ui.spacing_mut().item_spacing.y = 3.0;
        contents(ui, panel, seen)
    };
    let area = egui::ScrollArea::vertical().auto_shrink([false, false]);
    area.show(ui, contents).inner
}

fn contents(ui: &mut Ui, panel: Panel, seen: &Seen<'_>) -> Vec<Action> {
    match panel {
        Panel::Health => health::health(ui, seen),
        Panel::Events => events::events(ui, seen),
        Panel::Cursors => cursors::cursors(ui, seen),
        Panel::Trigger => trigger::trigger(ui, seen),
        Panel::Export => export::export(ui, seen),
        Panel::Command => command::command(ui, seen),
    }
}

/// What lies over the plots.
#[must_use]
pub fn overlay(ctx: &egui::Context, seen: &Seen<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    if seen.state.help {
        actions.extend(help::help(ctx));
    }
    if let Some(at_s) = seen.state.explain {
        actions.extend(explain::explain(ctx, seen.model, at_s));
    }
    if let Some(hint) = seen.state.tour {
        actions.extend(tour::tour(ctx, hint));
    }
    if seen.state.command.asks_release {
        actions.extend(command::question(ctx));
    }
    actions
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
