//! What happened, the newest first: click one to see it.

use super::{Seen, heading, lane, sentence};
use crate::action::Action;
use eframe::egui::{Button, Label, RichText, Ui};
use grip_scope::format;
use grip_scope::{
    EventMark,
    feed::{causes_text, confidence_text},
};
use slip_core::alarm::Method;

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
    ui.add(Label::new(RichText::new(facts(mark)).size(11.0).weak()).wrap());
    clicked.then_some(Action::JumpTo(mark.t_s))
}

/// The sentence of an event, or what is known of a slip.
fn facts(mark: &EventMark) -> String {
    let Some(slip) = &mark.slip else { return mark.text.clone() };
    let number = |name: &str, value: Option<f64>, unit: &str| {
        value.map(|v| format!("{name} {}", format::with_unit(v, unit)))
    };
    let [ruled_out, possible] = causes_text(slip);
    let parts = [
        Some(slip.method)
            .filter(|method| *method != Method::None)
            .map(|method| format!("by {}", method.felt())),
        number("statistic", slip.statistic.map(f64::from), ""),
        slip.confidence.map(confidence_text),
        number("speed", slip.speed_m_s.map(f64::from), "m/s"),
        number("estimate", slip.estimate_n.map(f64::from), "N"),
        number("commanded", slip.command_n.map(f64::from), "N"),
        number("E_sc", slip.esc_w, "W"),
        number("lasted", slip.duration_s, "s"),
        ruled_out,
        possible,
    ];
    let known: Vec<String> = parts.into_iter().flatten().collect();
    if known.is_empty() { mark.text.clone() } else { known.join(", ") }
}
