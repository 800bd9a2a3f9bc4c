//! The curves of a study, two plots beside each other.

use super::Seen;
use crate::palette::{SERIES, Tone};
use crate::plot::Style;
use eframe::egui::{self, Role, Ui, WidgetInfo, vec2};
use egui_plot::{Corner, Legend, Line, Plot, PlotPoint, PlotPoints};
use grip_scope::feed::{StudyCurve, StudyCurves, StudyPlot};

/// Height of a plot (points).
const HIGH: f32 = 270.0;

/// Draws the page.
pub fn study(ui: &mut Ui, study: &StudyCurves, seen: &Seen<'_>) {
    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.heading(&study.title);
        for note in &study.notes {
            super::sentence(ui, note.clone());
        }
        if study.plots.is_empty() {
            super::sentence(ui, "This study has no learning curves.");
        }
        let wide = (ui.available_width() - 24.0) / 2.0;
        for pair in study.plots.chunks(2) {
            ui.horizontal(|ui| {
                for one in pair {
                    ui.allocate_ui(vec2(wide, HIGH), |ui| draw(ui, one, seen));
                }
            });
        }
    });
}

fn draw(ui: &mut Ui, one: &StudyPlot, seen: &Seen<'_>) {
    ui.vertical(|ui| {
        ui.label(&one.title);
        let plot = Plot::new(&one.title)
            .height(HIGH - 24.0)
            .legend(Legend::default().position(Corner::RightTop))
            .x_axis_label("epoch")
            .y_axis_label("mean squared error")
            .y_axis_formatter(|mark, _| format!("1e{:.1}", mark.value).replace(".0", ""))
            .allow_scroll(false);
        let shown = plot.show(ui, |plot| {
            for (curve, (tone, style)) in one.curves.iter().zip(looks(&one.curves)) {
                let points = PlotPoints::Owned(drawn(curve));
                let line = Line::new(&curve.name, points).color(seen.palette.tone(tone));
                plot.line(line.style(style.line()));
            }
        });
        let name = format!("{} plot", one.title);
        shown.response.widget_info(|| WidgetInfo::labeled(Role::Figure, true, &name));
    });
}

/// The points that can be shown, errors by their logarithms.
fn drawn(curve: &StudyCurve) -> Vec<PlotPoint> {
    let shown = curve.points.iter().filter(|[x, y]| x.is_finite() && y.is_finite() && *y > 0.0);
    shown.map(|[x, y]| PlotPoint::new(*x, y.log10())).collect()
}

/// The net of a curve, and whether its errors are those of rows that were not trained on.
fn net(name: &str) -> (&str, bool) {
    match name.rsplit_once(", ") {
        Some((net, "train")) => (net, false),
        Some((net, "test")) => (net, true),
        _ => (name, false),
    }
}

/// How each curve is drawn: a colour for each net, dashes for the rows that were not trained on.
fn looks(curves: &[StudyCurve]) -> Vec<(Tone, Style)> {
    let mut nets: Vec<&str> = Vec::new();
    let look = |curve| {
        let (name, is_test) = net(curve);
        let place = nets.iter().position(|known| *known == name).unwrap_or_else(|| {
            nets.push(name);
            nets.len() - 1
        });
        let style = if is_test { Style::Dashed } else { Style::Solid };
        (SERIES[place % SERIES.len()], style)
    };
    curves.iter().map(|curve| curve.name.as_str()).map(look).collect()
}

#[cfg(test)]
mod tests {
    use super::{StudyCurve, drawn, looks};
    use crate::palette::SERIES;
    use crate::plot::Style;

    #[test]
    fn a_net_has_one_colour_and_its_test_rows_are_dashed() {
        let nets = ["2-10-1 gd", "2-10-1 lm", "2-20-1 gd", "2-20-1 lm", "cg", "bfgs"];
        let curve = |net: &str, rows| StudyCurve { name: format!("{net}, {rows}"), points: vec![] };
        let curves: Vec<StudyCurve> =
            nets.iter().flat_map(|net| [curve(net, "train"), curve(net, "test")]).collect();
        for (pair, tone) in looks(&curves).chunks(2).zip(SERIES) {
            assert_eq!(pair, [(tone, Style::Solid), (tone, Style::Dashed)]);
        }
    }

    #[test]
    fn nonsense_is_left_out() {
        let points = vec![[1.0, 0.1], [2.0, f64::NAN], [100.0, 0.0], [f64::INFINITY, 1.0]];
        let curve = StudyCurve { name: "a".into(), points };
        assert_eq!(drawn(&curve).len(), 1);
    }
}
