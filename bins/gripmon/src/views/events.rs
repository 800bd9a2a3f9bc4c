//! What happened, the newest first: click one to see it.

use super::{Seen, heading, lane, sentence};
use crate::action::Action;
use eframe::egui::{Button, Label, RichText, Ui};
use grip_scope::EventMark;

/// Up to so many events are listed.
const MOST: usize = 120;

pub(super) fn events(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    let all = seen.model.events();
    heading(ui, "Events");
    ui.horizontal(|ui| {
        for (name, action) in
            [("Previous event", Action::PreviousEvent), ("Next event", Action::NextEvent)]
        {
            if ui.add_enabled(!all.is_empty(), Button::new(name)).clicked() {
                actions.push(action);
            }
        }
        let explain = ui.add_enabled(!all.is_empty(), Button::new("Explain"));
        if explain.on_hover_text("Explain the slip that was looked at last (W)").clicked() {
            actions.push(Action::ToggleExplain);
        }
    });
    if all.is_empty() {
        sentence(
            ui,
            "Nothing has happened yet. Slips, reflexes, gaps, faults and your own markers stand here.",
        );
    } else if all.len() > MOST {
        sentence(
            ui,
            format!("The newest {MOST} of {}; Previous event goes further back.", all.len()),
        );
    }
    for mark in all.iter().rev().take(MOST) {
        actions.extend(event(ui, mark, seen));
    }
    actions
}

fn event(ui: &mut Ui, mark: &EventMark, seen: &Seen<'_>) -> Option<Action> {
    let colour = seen.palette.tone(lane::tone(mark.kind));
    let head = format!("{:>11.4} s  {}", mark.t_s, mark.kind.name());
    let clicked = ui
        .selectable_label(
            seen.state.event_s == Some(mark.t_s),
            RichText::new(head).monospace().color(colour),
        )
        .clicked();
    ui.add(Label::new(RichText::new(&mark.text).size(11.0).weak()).wrap());
    clicked.then_some(Action::JumpTo(mark.t_s))
}
