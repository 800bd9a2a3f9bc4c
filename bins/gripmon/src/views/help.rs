//! The keys, over everything else.

use crate::action::Action;
use crate::keys::{MOUSE, bindings};
use eframe::egui::{self, Grid, RichText, Ui};

pub(super) fn help(ctx: &egui::Context) -> Option<Action> {
    let (mut closed, mut tour) = (false, false);
    let modal = egui::Modal::new(egui::Id::unique("keys")).show(ctx, |ui| {
        ui.set_width(720.0);
        ui.horizontal(|ui| {
            ui.heading("Keys and mouse");
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                closed = ui.button("Close").clicked();
                tour =
                    ui.button("Tour").on_hover_text("The three hints of the first start").clicked();
            });
        });
        ui.columns(2, |columns| {
            if let [left, right] = columns {
                part(left, "Time");
                part(left, "Measure");
                part(right, "Window");
                mouse(right);
            }
        });
    });
    if tour {
        return Some(Action::Tour(Some(0)));
    }
    (closed || modal.should_close()).then_some(Action::ToggleHelp)
}

fn part(ui: &mut Ui, title: &str) {
    super::heading(ui, title);
    Grid::new(("keys", title)).num_columns(2).spacing([12.0, 3.0]).show(ui, |ui| {
        for binding in bindings().iter().filter(|binding| binding.part == title) {
            line(ui, binding.shown, binding.does);
        }
    });
}

fn mouse(ui: &mut Ui) {
    super::heading(ui, "Mouse");
    Grid::new("mouse").num_columns(2).spacing([12.0, 3.0]).show(ui, |ui| {
        for (shown, does) in MOUSE {
            line(ui, shown, does);
        }
    });
}

fn line(ui: &mut Ui, shown: &str, does: &str) {
    ui.label(RichText::new(shown).monospace().strong());
    ui.label(does);
    ui.end_row();
}
