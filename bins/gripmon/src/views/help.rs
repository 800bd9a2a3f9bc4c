//! The keys, over everything else.

use crate::keys::{BINDINGS, MOUSE};
use crate::state::ViewState;
use eframe::egui::{self, Grid, RichText, Ui};

pub(super) fn help(ctx: &egui::Context, state: &mut ViewState) {
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
                part(left, "Time", keys("Time"));
                part(left, "Measure", keys("Measure"));
                part(right, "Window", keys("Window"));
                part(right, "Mouse", MOUSE.into_iter());
            }
        });
    });
    if tour {
        state.show_hint(Some(0));
    } else if closed || modal.should_close() {
        state.help = false;
    }
}

fn keys(part: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    BINDINGS.iter().filter(move |key| key.part == part).map(|key| (key.shown, key.does))
}

fn part(ui: &mut Ui, title: &str, rows: impl Iterator<Item = (&'static str, &'static str)>) {
    super::heading(ui, title);
    Grid::new(("keys", title)).num_columns(2).spacing([12.0, 3.0]).show(ui, |ui| {
        for (shown, does) in rows {
            ui.label(RichText::new(shown).monospace().strong());
            ui.label(does);
            ui.end_row();
        }
    });
}
