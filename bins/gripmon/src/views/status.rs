//! One line at the bottom: how the source is, what was done last, what is kept.

use super::Seen;
use crate::num;
use crate::palette::Tone;
use crate::state::ViewState;
use crate::time::Following;
use eframe::egui::{Align, Label, Layout, RichText, Sense, Ui, vec2};
use grip_scope::SourceStatus;
use grip_scope::format;

/// Narrower windows show the figures in a line of their own (points).
const ONE_LINE: f32 = 1000.0;

/// Draws the line, or two where the window is narrow. What finds no room is cut short; the pointer shows all of it.
pub fn status(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    let right = Layout::right_to_left(Align::Center);
    let high = ui.spacing().interact_size.y;
    let line = vec2(ui.available_width(), high);
    let narrow = ui.available_width() < ONE_LINE;
    ui.allocate_ui_with_layout(line, right, |ui| {
        if !narrow {
            figures(ui, seen, state);
        }
        if state.message.is_some() && ui.small_button("Close message").clicked() {
            state.dismiss();
        }
        let rest = vec2(ui.available_width(), high);
        let left = Layout::left_to_right(Align::Center);
        ui.allocate_ui_with_layout(rest, left, |ui| sentences(ui, seen, state));
    });
    if narrow {
        ui.allocate_ui_with_layout(line, right, |ui| figures(ui, seen, state));
    }
}

fn sentences(ui: &mut Ui, seen: &Seen<'_>, state: &ViewState) {
    ui.set_min_width(ui.available_width());
    lamp(ui, seen);
    let share = if state.message.is_some() { 0.4 } else { 1.0 };
    let status = RichText::new(seen.model.status().sentence());
    let failed = matches!(seen.model.status(), SourceStatus::Failed { .. });
    let status = if failed { status.color(seen.palette.tone(Tone::Red)) } else { status };
    cut(ui, status, ui.available_width() * share);
    if let SourceStatus::Loading { done } = seen.model.status() {
        let wide = ui.available_width().min(120.0);
        let bar = eframe::egui::ProgressBar::new(done.clamp(0.0, 1.0));
        ui.add(bar.desired_width(wide).desired_height(8.0));
    }
    if let Some(message) = &state.message {
        ui.separator();
        let text = RichText::new(&message.text);
        let red = seen.palette.tone(Tone::Red);
        cut(ui, if message.is_error { text.color(red) } else { text }, ui.available_width());
    }
}

/// A text in at most so much room.
fn cut(ui: &mut Ui, text: RichText, most: f32) {
    ui.scope(|ui| {
        ui.set_max_width(most);
        ui.add(Label::new(text).truncate());
    });
}

/// The tone of a status.
#[must_use]
pub const fn tone(status: &SourceStatus) -> Tone {
    match status {
        // What is odd about a file is reported.
        SourceStatus::Complete { note } if !note.is_empty() => Tone::Orange,
        SourceStatus::Live | SourceStatus::Complete { .. } => Tone::Green,
        SourceStatus::Idle => Tone::Quiet,
        // It was there, or should have been.
        SourceStatus::Connecting { before, .. } if !before.is_empty() => Tone::Orange,
        SourceStatus::Connecting { .. } | SourceStatus::Loading { .. } => Tone::Blue,
        SourceStatus::Waiting { .. } | SourceStatus::Stalled { .. } => Tone::Orange,
        SourceStatus::Failed { .. } => Tone::Red,
    }
}

fn lamp(ui: &mut Ui, seen: &Seen<'_>) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 14.0), Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, seen.palette.tone(tone(seen.model.status())));
}

fn figures(ui: &mut Ui, seen: &Seen<'_>, state: &ViewState) {
    let of_pipeline = seen.model.info().state;
    let view = match state.window.following() {
        Following::Newest => "following",
        Following::All => "all data",
        Following::Held if state.stands_at_hit => "triggered",
        Following::Held => "view paused",
    };
    let mut parts = vec![format!("{view}, {}", format::duration(seen.span.length_s()))];
    if state.armed {
        parts.push("trigger armed".to_owned());
    }
    if let Some(rate) = of_pipeline.map(|state| state.rate_hz).filter(|rate| *rate > 0) {
        parts.push(format::with_unit(rate.into(), "Hz"));
    }
    parts.push(format!("history {}", format::with_unit(num::count(seen.model.bytes()), "B")));
    let lost = of_pipeline.map_or(0, |state| state.lost);
    if lost > 0 {
        let text = RichText::new(format!("! {} lost", format::count(lost)))
            .color(seen.palette.tone(Tone::Orange));
        ui.label(text);
        ui.separator();
    }
    let text = RichText::new(parts.join("   ")).weak();
    ui.add(Label::new(text).truncate());
}
