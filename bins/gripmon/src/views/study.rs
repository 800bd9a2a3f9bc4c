//! The curves of a study, two plots beside each other.

use super::Seen;
use crate::palette::{SERIES, Tone};
use crate::plot::Style;
use eframe::egui::{self, Role, Ui, WidgetInfo, vec2};
use egui_plot::{Line, Plot, PlotPoint, PlotPoints};
use grip_scope::feed::{StudyCurve, StudyCurves, StudyPlot};

/// Height of a plot (points).
const HIGH: f32 = 270.0;
/// Free at the border (points).
const MARGIN: f32 = 8.0;

/// Draws the page.
pub fn study(ui: &mut Ui, study: &StudyCurves, seen: &Seen<'_>) {
    let area = egui::ScrollArea::vertical().auto_shrink([false, false]).content_margin(MARGIN);
    area.show(ui, |ui| {
        ui.heading(&study.title);
        for note in &study.notes {
            super::sentence(ui, note.clone());
        }
        if study.plots.is_empty() {
            super::sentence(ui, "This study has no learning curves.");
        }
        let nets = nets(study);
        ui.horizontal_wrapped(|ui| {
            for (net, tone) in nets.iter().zip(SERIES.iter().cycle()) {
                ui.colored_label(seen.palette.tone(*tone), *net);
            }
            super::sentence(ui, "solid: on the rows of the training, dashed: on unseen rows");
        });
        let wide = (ui.available_width() - 24.0) / 2.0;
        for pair in study.plots.chunks(2) {
            ui.horizontal(|ui| {
                for one in pair {
                    ui.allocate_ui(vec2(wide, HIGH), |ui| draw(ui, one, &nets, seen));
                }
            });
        }
    });
}

fn draw(ui: &mut Ui, one: &StudyPlot, nets: &[&str], seen: &Seen<'_>) {
    ui.vertical(|ui| {
        ui.label(&one.title);
        let plot = Plot::new(&one.title)
            .height(HIGH - 24.0)
            .x_axis_label("epoch")
            .y_axis_label("mean squared error")
            .y_axis_formatter(|mark, _| format!("1e{:.1}", mark.value).replace(".0", ""))
            .allow_scroll(false);
        let shown = plot.show(ui, |plot| {
            for curve in &one.curves {
                let (tone, style) = look(curve, nets);
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

/// The nets of all plots, each once: a net has the same colour in each.
fn nets(study: &StudyCurves) -> Vec<&str> {
    let mut nets = Vec::new();
    for curve in study.plots.iter().flat_map(|plot| &plot.curves) {
        let (name, _) = net(&curve.name);
        if !nets.contains(&name) {
            nets.push(name);
        }
    }
    nets
}

/// How a curve is drawn: a colour for each net, dashes for the rows that were not trained on.
fn look(curve: &StudyCurve, nets: &[&str]) -> (Tone, Style) {
    let (name, is_test) = net(&curve.name);
    let place = nets.iter().position(|known| *known == name).unwrap_or(0);
    let style = if is_test { Style::Dashed } else { Style::Solid };
    (SERIES[place % SERIES.len()], style)
}

#[cfg(test)]
mod tests {
    use super::{StudyCurve, StudyCurves, StudyPlot, drawn, look, nets};
    use crate::palette::SERIES;
    use crate::plot::Style;

    #[test]
    fn a_net_has_one_colour_in_all_plots_and_its_test_rows_are_dashed() {
        let names = ["2-10-1 gd", "2-10-1 lm", "2-20-1 gd", "2-20-1 lm", "cg", "bfgs"];
        let curve = |net: &str, rows| StudyCurve { name: format!("{net}, {rows}"), points: vec![] };
        let both = |net: &&str| [curve(net, "train"), curve(net, "test")];
        // The second plot lacks some.
        let plots = [0, 3].map(|from| StudyPlot {
            title: String::new(),
            curves: names[from..].iter().flat_map(both).collect(),
        });
        let (title, notes) = (String::new(), Vec::new());
        let study = StudyCurves { title, plots: plots.into(), notes };
        let nets = nets(&study);
        assert_eq!(nets, names);
        for (plot, from) in study.plots.iter().zip([0, 3]) {
            for (pair, tone) in plot.curves.chunks(2).zip(&SERIES[from..]) {
                let looks: Vec<_> = pair.iter().map(|curve| look(curve, &nets)).collect();
                assert_eq!(looks, [(*tone, Style::Solid), (*tone, Style::Dashed)]);
            }
        }
    }

    #[test]
    fn nonsense_is_left_out() {
        let points = vec![[1.0, 0.1], [2.0, f64::NAN], [100.0, 0.0], [f64::INFINITY, 1.0]];
        let curve = StudyCurve { name: "a".into(), points };
        assert_eq!(drawn(&curve).len(), 1);
    }
}
