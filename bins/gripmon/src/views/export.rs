//! Files of what is seen.

use super::{Seen, heading, row, sentence, wide_button};
use crate::apply::Effect;
use crate::labels::{self, Labelling};
use crate::state::ViewState;
use eframe::egui::{TextEdit, Ui};
use grip_scope::format;

/// What is exported: the button, what it is, whether it needs samples.
const EXPORTS: [(&str, &str, Effect); 4] = [
    ("Samples as CSV", "One row for each time at which a shown curve has a sample.", Effect::Csv),
    (
        "Recording (MCAP)",
        "Of an MCAP file the same messages as in it; of any other source the samples and the pressure array, without states and events. \
         For gripctl replay, PlotJuggler, Foxglove.",
        Effect::Mcap,
    ),
    (
        "Report (HTML)",
        "One page for a browser: numbers, curves, every slip explained, events. Key Shift S.",
        Effect::Report,
    ),
    ("Picture (PNG)", "This window, key S.", Effect::Picture),
];

pub(super) fn export(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    heading(ui, "Export");
    sentence(ui, "What is seen now: between the cursors where both are set, else the whole view.");
    let span = state.between().unwrap_or(seen.span);
    row(ui, "from", format!("{:.4} s", span.from_s));
    row(ui, "to", format!("{:.4} s", span.to_s));
    row(ui, "lasts", format::duration(span.length_s()));
    ui.add_space(4.0);
    let label = ui.label("Names begin with (folders are allowed)");
    let stem = TextEdit::singleline(&mut state.stem).desired_width(220.0);
    ui.add(stem).labelled_by(label.id);
    ui.add_space(6.0);
    let any = seen.model.span().is_some();
    for (name, about, effect) in EXPORTS {
        if wide_button(ui, any || effect == Effect::Picture, name, about) {
            state.ask(effect);
        }
    }
    sentence(ui, "Files that are there are never replaced: the next free number is taken.");
    labelling(ui, seen, state);
}

/// The label of the recording that is open.
fn labelling(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    let Some(labelled) = &state.recording else { return };
    heading(ui, "Label");
    sentence(ui, "For gripctl score: the row of this recording in the labels.csv beside it.");
    let known = &labelled.label;
    row(
        ui,
        "label",
        known.as_ref().map_or_else(|| "none".to_owned(), |label| labels::words(label.kind)),
    );
    if let Some(label) = known.as_ref().filter(|label| !label.material.is_empty()) {
        row(ui, "material", &label.material);
    }
    let is_known = known.is_some();
    for (name, request) in [
        ("Slip begins at cursor A", Labelling::Onset),
        ("Slips all the time", Labelling::Steady),
        ("Never slips", Labelling::Rest),
        ("Remove the label", Labelling::Remove),
    ] {
        let about = "A label that is there is not replaced: remove it first.";
        if wide_button(ui, is_known == (request == Labelling::Remove), name, about) {
            state.label_as(request, seen.model);
        }
    }
}
