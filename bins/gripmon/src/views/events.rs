//! What happened, the newest first: click one to see it.

use super::{Seen, heading, lane, sentence};
use crate::state::ViewState;
use eframe::egui::{Button, Label, RichText, Ui};
use grip_scope::EventMark;

/// Up to so many events are listed.
const MOST: usize = 120;

pub(super) fn events(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    let all = &seen.model.events().marks;
    heading(ui, "Events");
    ui.add_enabled_ui(!all.is_empty(), |ui| {
        ui.horizontal(|ui| {
            for (name, later) in [("Previous event", false), ("Next event", true)] {
                if ui.button(name).clicked() {
                    state.step(later, seen.model);
                }
            }
            let about = "Explain the slip that was looked at last (W)";
            if ui.add(Button::new("Explain")).on_hover_text(about).clicked() {
                state.toggle_explain(seen.model);
            }
        });
    });
    if all.is_empty() {
        let text = "Nothing has happened yet. Slips, reflexes, gaps, faults and your own markers stand here.";
        sentence(ui, text);
    } else if all.len() > MOST {
        let text = format!("The newest {MOST} of {}; Previous event goes further back.", all.len());
        sentence(ui, text);
    }
    for mark in all.iter().rev().take(MOST) {
        event(ui, mark, seen, state);
    }
}

fn event(ui: &mut Ui, mark: &EventMark, seen: &Seen<'_>, state: &mut ViewState) {
    let colour = seen.palette.tone(lane::tone(mark.kind));
    let head = format!("{:>11.4} s  {}", mark.t_s, mark.kind.name());
    let head = RichText::new(head).monospace().color(colour);
    if ui.selectable_label(state.event_s == Some(mark.t_s), head).clicked() {
        state.jump(mark.t_s, seen.model);
    }
    ui.add(Label::new(RichText::new(&mark.text).size(11.0).weak()).wrap());
}
