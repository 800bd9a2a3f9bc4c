//! Files of what is seen.

use super::{Seen, heading, row, sentence};
use crate::action::{Action, Labelling};
use crate::labels;
use eframe::egui::{TextEdit, Ui};
use grip_scope::format;

pub(super) fn export(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    heading(ui, "Export");
    sentence(ui, "What is seen now: between the cursors where both are set, else the whole view.");
    let span = seen.state.between().unwrap_or(seen.span);
    row(ui, "from", format!("{:.4} s", span.from_s));
    row(ui, "to", format!("{:.4} s", span.to_s));
    row(ui, "lasts", format::duration(span.length_s()));
    ui.add_space(4.0);
    let label = ui.label("Names begin with (folders are allowed)");
    let mut stem = seen.state.stem.clone();
    if ui.add(TextEdit::singleline(&mut stem).desired_width(220.0)).labelled_by(label.id).changed()
    {
        actions.push(Action::ExportStem(stem));
    }
    ui.add_space(6.0);
    let any = seen.model.span().is_some();
    for (name, about, action) in [
        (
            "Samples as CSV",
            "One row for each time at which a shown curve has a sample.",
            Action::ExportCsv,
        ),
        (
            "Recording (MCAP)",
            "Of an MCAP file the same messages as in it; of any other source the samples and the pressure array, without states and events. \
             For gripctl replay, PlotJuggler, Foxglove.",
            Action::ExportMcap,
        ),
        (
            "Report (HTML)",
            "One page for a browser: numbers, curves, every slip explained, events. Key Shift S.",
            Action::ExportReport,
        ),
        ("Picture (PNG)", "This window, key S.", Action::ExportPicture),
    ] {
        let button = eframe::egui::Button::new(name).min_size(eframe::egui::vec2(160.0, 22.0));
        let enabled = any || action == Action::ExportPicture;
        if ui.add_enabled(enabled, button).on_hover_text(about).clicked() {
            actions.push(action);
        }
    }
    sentence(ui, "Files that are there are never replaced: the next free number is taken.");
    labelling(ui, seen, &mut actions);
    actions
}

/// The label of the recording that is open.
fn labelling(ui: &mut Ui, seen: &Seen<'_>, actions: &mut Vec<Action>) {
    if seen.state.recording.is_none() {
        return;
    }
    heading(ui, "Label");
    sentence(ui, "For gripctl score: the row of this recording in the labels.csv beside it.");
    let known = seen.state.label.iter().flatten().next();
    row(ui, "label", known.map_or_else(|| "none".to_owned(), |label| labels::words(label.kind)));
    if let Some(label) = known.filter(|label| !label.material.is_empty()) {
        row(ui, "material", &label.material);
    }
    let about = "A label that is there is not replaced: remove it first.";
    for (name, request) in [
        ("Slip begins at cursor A", Labelling::Onset),
        ("Slips all the time", Labelling::Steady),
        ("Never slips", Labelling::Rest),
        ("Remove the label", Labelling::Remove),
    ] {
        let enabled = known.is_some() == (request == Labelling::Remove);
        let button = eframe::egui::Button::new(name).min_size(eframe::egui::vec2(160.0, 22.0));
        if ui.add_enabled(enabled, button).on_hover_text(about).clicked() {
            actions.push(Action::Label(request));
        }
    }
}
