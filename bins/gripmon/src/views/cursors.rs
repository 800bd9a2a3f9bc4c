//! Both cursors, and of every curve that is shown: its values there, what lies between.

use super::{Seen, heading, readout, row, sentence};
use crate::palette;
use crate::state::ViewState;
use crate::strip;
use eframe::egui::{Button, Grid, RichText, Ui};
use grip_scope::Channel;
use grip_scope::format;

pub(super) fn cursors(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    heading(ui, "Cursors");
    ui.horizontal(|ui| {
        for (cursor, name) in ["Set A", "Set B"].into_iter().enumerate() {
            let about = "In the middle of the view; the keys A and B set it at the pointer.";
            if ui.button(name).on_hover_text(about).clicked() {
                state.put_cursor(cursor, seen.model);
            }
        }
        let any = state.cursors.iter().any(Option::is_some);
        if ui.add_enabled(any, Button::new("Clear")).clicked() {
            state.cursors = [None; 2];
        }
        if ui.add_enabled(state.between().is_some(), Button::new("Zoom")).clicked() {
            state.zoom_to_cursors();
        }
    });
    let time = |at_s: Option<f64>| at_s.map_or(format::NOTHING.to_owned(), |s| format!("{s:.6} s"));
    row(ui, "A", time(state.cursors[0]));
    row(ui, "B", time(state.cursors[1]));
    let [Some(a_s), Some(b_s)] = state.cursors else {
        sentence(ui, "Set both cursors to measure what lies between them.");
        return;
    };
    row(ui, "B - A", format::with_unit(b_s - a_s, "s"));
    if (b_s - a_s).abs() > 0.0 {
        row(ui, "1 / (B - A)", format::with_unit(1.0 / (b_s - a_s).abs(), "Hz"));
    }
    for channel in shown(seen, state) {
        between(ui, channel, a_s, b_s, seen);
    }
}

/// The curves of the plots that are shown.
fn shown(seen: &Seen<'_>, state: &ViewState) -> Vec<Channel> {
    let plots = state.layout.plots.iter().filter(|plot| plot.shown);
    // The curve drawn last lies on top; it is also reported first, as beside the plot.
    let curves = plots.flat_map(|plot| strip::curves(plot.plot, seen.model).into_iter().rev());
    curves.map(|curve| curve.channel).collect()
}

fn between(ui: &mut Ui, channel: Channel, a_s: f64, b_s: f64, seen: &Seen<'_>) {
    let unit = seen.model.info().unit(channel);
    let stats =
        seen.model.series(channel).and_then(|series| series.stats(grip_scope::Span::new(a_s, b_s)));
    let ends = [a_s, b_s].map(|t_s| readout::value_at(channel, seen, t_s));
    if stats.is_none() && ends.iter().all(Option::is_none) {
        return;
    }
    heading(ui, seen.model.info().name(channel));
    let reported = |value: Option<f64>| {
        value.map_or(format::NOTHING.to_owned(), |v| format::with_unit(v, unit))
    };
    let difference = match ends {
        [Some(a), Some(b)] => Some(b - a),
        _ => None,
    };
    let mean = stats.map(|stats| stats.mean);
    let peaks = stats.map(|stats| f64::from(stats.peak_to_peak()));
    let rms = stats.map(|stats| stats.rms);
    let rows = [
        [("A", reported(ends[0])), ("B", reported(ends[1]))],
        [("B - A", reported(difference)), ("peak-peak", reported(peaks))],
        [("mean", reported(mean)), ("rms", reported(rms))],
    ];
    Grid::new(("between", channel)).num_columns(4).spacing([8.0, 1.0]).show(ui, |ui| {
        for cells in rows {
            for (name, value) in cells {
                ui.label(RichText::new(name).size(11.0).weak());
                ui.label(RichText::new(format!("{value:<12}")).font(palette::number_font()));
            }
            ui.end_row();
        }
    });
}
