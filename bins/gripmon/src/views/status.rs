//! One line at the bottom: how the source is, what was done last, what is kept.

use super::Seen;
use crate::action::Action;
use crate::format;
use crate::num;
use crate::palette::Tone;
use crate::time::Following;
use eframe::egui::{Align, Layout, RichText, Sense, Ui, vec2};
use grip_scope::SourceStatus;

/// Draws the line.
pub fn status(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    ui.horizontal(|ui| {
        lamp(ui, seen);
        ui.label(seen.model.status().sentence());
        if let SourceStatus::Loading { done } = seen.model.status() {
            let bar = eframe::egui::ProgressBar::new(done.clamp(0.0, 1.0))
                .desired_width(120.0)
                .desired_height(8.0);
            ui.add(bar);
        }
        if let Some(message) = &seen.state.message {
            ui.separator();
            let text = RichText::new(&message.text);
            ui.label(if message.is_error {
                text.color(seen.palette.tone(Tone::Red))
            } else {
                text
            });
            if ui.small_button("Close message").clicked() {
                actions.push(Action::Dismiss);
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| figures(ui, seen));
    });
    actions
}

/// The tone of a status.
#[must_use]
pub(super) const fn tone(status: &SourceStatus) -> Tone {
    match status {
        SourceStatus::Live | SourceStatus::Complete { .. } => Tone::Green,
        SourceStatus::Idle => Tone::Quiet,
        SourceStatus::Connecting { .. } | SourceStatus::Loading { .. } => Tone::Blue,
        SourceStatus::Waiting { .. } | SourceStatus::Stalled { .. } => Tone::Orange,
        SourceStatus::Failed { .. } => Tone::Red,
    }
}

fn lamp(ui: &mut Ui, seen: &Seen<'_>) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 14.0), Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, seen.palette.tone(tone(seen.model.status())));
}

fn figures(ui: &mut Ui, seen: &Seen<'_>) {
    let state = seen.model.info().state;
    let view = match seen.state.window.following() {
        Following::Newest => "following",
        Following::All => "all data",
        Following::Held if seen.state.stands_at_hit => "triggered",
        Following::Held => "view paused",
    };
    let mut parts = vec![format!("{view}, {}", format::duration(seen.span.length_s()))];
    if seen.state.trigger.armed {
        parts.push("trigger armed".to_owned());
    }
    if let Some(rate) = state.map(|state| state.rate_hz).filter(|rate| *rate > 0) {
        parts.push(format::with_unit(rate.into(), "Hz"));
    }
    parts.push(format!("history {}", format::with_unit(num::count(seen.model.bytes()), "B")));
    let lost = seen.dropped + state.map_or(0, |state| state.lost);
    if lost > 0 {
        let text = RichText::new(format!("! {} lost", format::count(lost)))
            .color(seen.palette.tone(Tone::Orange));
        ui.label(text);
        ui.separator();
    }
    ui.weak(parts.join("   "));
}
