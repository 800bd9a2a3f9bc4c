//! Why a slip was noticed and why the force moved, over everything else.

use super::{Seen, heading};
use crate::action::Action;
use eframe::egui::{self, Align, Label, Layout, Ui};
use grip_scope::explain;

pub(super) fn explain(ctx: &egui::Context, seen: &Seen<'_>) -> Option<Action> {
    // The event that was jumped to, else the newest that is seen.
    let at_s = seen.state.event_s.unwrap_or(seen.span.to_s);
    let found = explain::slip(seen.model, at_s);
    let mut closed = false;
    let modal = egui::Modal::new(egui::Id::unique("explain")).show(ctx, |ui| {
        ui.set_width(560.0);
        ui.horizontal(|ui| {
            ui.heading(found.as_ref().map_or("No slip yet", |found| &found.title));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                closed = ui.button("Close").clicked();
            });
        });
        match &found {
            Some(found) => {
                part(ui, "What each method saw", &found.saw);
                part(ui, "Why the force moved", &found.force);
            }
            None => super::sentence(ui, "There is no slip at or before what is looked at."),
        }
    });
    (closed || modal.should_close()).then_some(Action::ToggleExplain)
}

fn part(ui: &mut Ui, title: &str, lines: &[String]) {
    heading(ui, title);
    for line in lines {
        ui.add(Label::new(line).wrap());
    }
}
