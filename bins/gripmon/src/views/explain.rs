//! Why a slip was noticed and why the force moved, over everything else.

use super::{heading, row_in};
use crate::state::ViewState;
use eframe::egui::{self, Align, Layout, RichText, Ui};
use grip_scope::{Model, explain};

/// Explains the slip at or before a time (s).
pub(super) fn explain(ctx: &egui::Context, model: &Model, at_s: f64, state: &mut ViewState) {
    let found = explain::slip(model, at_s);
    let mut closed = false;
    let modal = egui::Modal::new(egui::Id::unique("explain")).show(ctx, |ui| {
        ui.set_width(640.0);
        ui.horizontal(|ui| {
            ui.heading(found.as_ref().map_or("No slip yet", |found| &found.title));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                closed = ui.button("Close").clicked();
            });
        });
        match &found {
            Some(found) => {
                part(ui, "What each method saw", &found.saw);
                part(ui, "Other causes", &found.causes);
                part(ui, "Why the force moved", &found.force);
            }
            None => super::sentence(ui, "There is no slip at or before what is looked at."),
        }
    });
    if closed || modal.should_close() {
        state.explain = None;
    }
}

fn part(ui: &mut Ui, title: &str, lines: &[String]) {
    if lines.is_empty() {
        return;
    }
    heading(ui, title);
    for line in lines {
        let (who, what) = line.split_once(": ").unwrap_or(("", line));
        row_in(ui, who, RichText::new(what));
    }
}
