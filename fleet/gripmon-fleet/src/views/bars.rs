//! The lines above and below the table: how many are how, the filter; the router, what was done last.

use super::Seen;
use crate::{Lobby, Request};
use eframe::egui::{Align, Button, Id, Key, Label, Layout, RichText, Sense, TextEdit, Ui, vec2};
use grip_scope::SourceStatus;
use grip_scope::format;
use gripmon::palette::Tone;
use gripmon::views::tone;

/// Draws the line above: counts that filter, and the filter.
pub(super) fn top(ui: &mut Ui, lobby: &mut Lobby, seen: Seen<'_>) -> Option<Request> {
    ui.horizontal(|ui| {
        filter(ui, lobby, seen);
        counts(ui, lobby, seen);
        let line = Layout::right_to_left(Align::Center);
        ui.with_layout(line, |ui| {
            let other = if seen.palette.dark { "Light" } else { "Dark" };
            if ui.button(other).on_hover_text("Other colours (L)").clicked() {
                lobby.toggle();
            }
            let open = Button::new("Open");
            let about = "The chosen gripper (Enter, or a click on its row)";
            let open = ui.add_enabled(lobby.table.chosen.is_some(), open).on_hover_text(about);
            if open.clicked() { lobby.opened(seen.roster) } else { None }
        })
        .inner
    })
    .inner
}

fn filter(ui: &mut Ui, lobby: &mut Lobby, seen: Seen<'_>) {
    let label = ui.weak("Filter");
    let mut text = lobby.table.filter.clone();
    let edit = TextEdit::singleline(&mut text).id(Id::unique("fleet filter")).desired_width(220.0);
    let edit = ui.add(edit.hint_text("words of a row: hall-2 gone")).labelled_by(label.id);
    if edit.changed() {
        lobby.table.filter(seen.roster, text);
    }
    if edit.has_focus() {
        return;
    }
    if !lobby.table.filter.is_empty() && ui.button("x").on_hover_text("No filter (Esc)").clicked() {
        lobby.table.filter(seen.roster, String::new());
    }
    if ui.input(|input| input.key_pressed(Key::Slash)) {
        edit.request_focus();
    }
}

/// How many are how; a click shows only those.
fn counts(ui: &mut Ui, lobby: &mut Lobby, seen: Seen<'_>) {
    let summary = seen.roster.summary();
    ui.separator();
    let all = if summary.all == 1 { "gripper" } else { "grippers" };
    for (count, word, of, shade) in [
        (summary.all, "", all, None),
        (summary.faults, "fault", "with a fault", Some(Tone::Red)),
        (summary.gone, "gone", "gone", Some(Tone::Orange)),
        (summary.silent, "silent", "silent", Some(Tone::Orange)),
        (summary.links, "no link", "without a link", Some(Tone::Orange)),
        (summary.sensors, "sensor", "with a bad sensor", Some(Tone::Orange)),
        (summary.slipping, "slipping", "slipping", Some(Tone::Blue)),
    ] {
        let text = RichText::new(format!("{count} {of}"));
        let text = match shade {
            Some(_) if count == 0 => text.weak(),
            Some(shade) => text.color(seen.palette.tone(shade)).strong(),
            None => text,
        };
        let chosen = !word.is_empty() && lobby.table.filter == word;
        let about = if word.is_empty() { "Show all" } else { "Show only these" };
        if ui.selectable_label(chosen, text).on_hover_text(about).clicked() {
            let wanted = if chosen { "" } else { word };
            lobby.table.filter(seen.roster, wanted.to_owned());
        }
    }
}

/// Draws the line below.
pub(super) fn bottom(ui: &mut Ui, lobby: &Lobby, seen: Seen<'_>) {
    let line = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(line, Layout::right_to_left(Align::Center), |ui| {
        figures(ui, seen);
        let rest = vec2(ui.available_width(), line.y);
        ui.allocate_ui_with_layout(rest, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(ui.available_width());
            sentences(ui, lobby, seen);
        });
    });
}

fn sentences(ui: &mut Ui, lobby: &Lobby, seen: Seen<'_>) {
    let status = seen.roster.status();
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 14.0), Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, seen.palette.tone(tone(status)));
    let red = seen.palette.tone(Tone::Red);
    let reported = match status {
        SourceStatus::Live => RichText::new(format!("connected to {}", lobby.place)),
        SourceStatus::Failed { sentence } => RichText::new(sentence).color(red),
        other => RichText::new(other.sentence()),
    };
    ui.add(Label::new(reported).truncate());
    if let Some(message) = &lobby.message {
        ui.separator();
        let text = RichText::new(&message.text);
        ui.add(Label::new(if message.is_error { text.color(red) } else { text }).truncate());
    }
}

fn figures(ui: &mut Ui, seen: Seen<'_>) {
    ui.weak("click or Enter opens   Up, Down choose   a title sorts   / filters   S picture");
    let orange = seen.palette.tone(Tone::Orange);
    for (count, what) in [
        (seen.roster.missing(), "events missing"),
        (seen.roster.unreadable(), "unreadable messages"),
        (seen.roster.refused(), "messages of more grippers than are kept"),
    ] {
        if count > 0 {
            let text = format!("! {} {what}", format::count(count));
            ui.label(RichText::new(text).color(orange));
        }
    }
}
