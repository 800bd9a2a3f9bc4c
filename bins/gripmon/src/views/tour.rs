//! The tour of the first start: three hints over the lower edge of the plots, which stay in use.

use crate::state::ViewState;
use eframe::egui::{self, Align2, Key, Label, RichText, vec2};

/// Title and text of each hint.
const HINTS: [(&str, &str); 3] = [
    (
        "Time",
        "Space pauses the view and follows again. The wheel zooms at the pointer, dragging moves, Home shows everything.",
    ),
    (
        "Slips",
        "N and P go to the next and the previous event. W explains the slip: what each method saw, why the force moved.",
    ),
    (
        "Panels and files",
        "? shows every key: H health, E events, F commands, X exports, Shift S writes a report. A recording that is dropped on the window is opened.",
    ),
];

pub(super) fn tour(ctx: &egui::Context, hint: usize, state: &mut ViewState) {
    let Some((title, text)) = HINTS.get(hint) else { return };
    let last = hint + 1 == HINTS.len();
    let area = egui::Area::new(egui::Id::unique("tour"))
        .order(egui::Order::Foreground)
        .anchor(Align2::CENTER_BOTTOM, vec2(0.0, -60.0));
    area.show(ctx, |ui| {
        egui::Frame::popup(ui.style()).inner_margin(12.0).show(ui, |ui| {
            ui.set_width(440.0);
            ui.label(RichText::new(format!("{} of {}: {title}", hint + 1, HINTS.len())).strong());
            ui.add(Label::new(*text).wrap());
            ui.horizontal(|ui| {
                let next = ui.button(if last { "Done (Enter)" } else { "Next (Enter)" });
                let enter = !ctx.text_edit_focused() && ui.input(|i| i.key_pressed(Key::Enter));
                if next.clicked() || enter {
                    state.show_hint((!last).then_some(hint + 1));
                }
                if !last && ui.button("End the tour (Esc)").clicked() {
                    state.show_hint(None);
                }
            });
        });
    });
}
