//! The learning curves of a study, two plots beside each other.

use super::Seen;
use crate::palette::{SERIES, Tone};
use crate::plot::DASHED;
use eframe::egui::{self, Role, Ui, WidgetInfo, vec2};
use egui_plot::{Line, LineStyle, Plot, PlotPoint, PlotPoints};
use grip_scope::feed::{Study, StudyNet, StudyResult};

/// Height of a plot (points).
const HIGH: f32 = 270.0;
/// Free at the border (points).
const MARGIN: f32 = 8.0;

/// Draws the page.
pub fn study(ui: &mut Ui, study: &Study, seen: &Seen<'_>) {
    let area = egui::ScrollArea::vertical().auto_shrink([false, false]).content_margin(MARGIN);
    area.show(ui, |ui| {
        ui.heading(&study.title);
        for line in &study.summary {
            super::sentence(ui, line);
        }
        let learned = |result: &&StudyResult| result.nets.iter().any(|net| net.curve.is_some());
        let results: Vec<&StudyResult> = study.results.iter().filter(learned).collect();
        if results.is_empty() {
            super::sentence(ui, "This study has no learning curves.");
        }
        let nets = tones(&results);
        ui.horizontal_wrapped(|ui| {
            for (name, tone) in &nets {
                ui.colored_label(seen.palette.tone(*tone), name);
            }
            super::sentence(ui, "solid: on the rows of the training, dashed: on unseen rows");
        });
        let wide = (ui.available_width() - 24.0) / 2.0;
        for pair in results.chunks(2) {
            ui.horizontal(|ui| {
                for one in pair {
                    ui.allocate_ui(vec2(wide, HIGH), |ui| draw(ui, one, &nets, seen));
                }
            });
        }
    });
}

fn draw(ui: &mut Ui, one: &StudyResult, nets: &[(String, Tone)], seen: &Seen<'_>) {
    ui.vertical(|ui| {
        ui.label(&one.title);
        let plot = Plot::new(&one.title)
            .height(HIGH - 24.0)
            .x_axis_label("epoch")
            .y_axis_label("mean squared error")
            .y_axis_formatter(|mark, _| format!("1e{:.1}", mark.value).replace(".0", ""))
            .allow_scroll(false);
        let shown = plot.show(ui, |plot| {
            for (net, curve) in one.nets.iter().filter_map(|net| Some((net, net.curve.as_ref()?))) {
                let tone = nets.iter().find(|(name, _)| *name == net.name()).map(|(_, tone)| *tone);
                let colour = seen.palette.tone(tone.unwrap_or(Tone::Quiet));
                let (solid, dashed) = (LineStyle::Solid, DASHED);
                for (rows, errors, style) in
                    [("train", &curve.train, solid), ("test", &curve.test, dashed)]
                {
                    let points = PlotPoints::Owned(drawn(&curve.epoch, errors));
                    let line = Line::new(format!("{}, {rows}", net.name()), points).color(colour);
                    plot.line(line.style(style));
                }
            }
        });
        let name = format!("{} plot", one.title);
        shown.response.widget_info(|| WidgetInfo::labeled(Role::Figure, true, &name));
    });
}

/// The points that can be shown, errors by their logarithms.
fn drawn(epochs: &[f64], errors: &[Option<f64>]) -> Vec<PlotPoint> {
    let known = epochs.iter().zip(errors).filter_map(|(epoch, error)| Some((*epoch, (*error)?)));
    let shown = known.filter(|(x, y)| x.is_finite() && y.is_finite() && *y > 0.0);
    shown.map(|(x, y)| PlotPoint::new(x, y.log10())).collect()
}

/// The nets of all results that have learned, each once: a net has the same colour in each plot.
fn tones(results: &[&StudyResult]) -> Vec<(String, Tone)> {
    let mut names: Vec<String> = Vec::new();
    let learned = results.iter().flat_map(|result| &result.nets).filter(|net| net.curve.is_some());
    for name in learned.map(StudyNet::name) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.into_iter().zip(SERIES.into_iter().cycle()).collect()
}

#[cfg(test)]
mod tests {
    use super::{SERIES, StudyNet, StudyResult, drawn, tones};
    use grip_scope::feed::LearningCurve;

    #[test]
    fn a_net_has_one_colour_in_all_plots() {
        let trainers = ["gd", "lm", "cg", "bfgs", "scg"];
        let net = |trainer: &&str| StudyNet {
            net: (*trainer).to_owned(),
            trainer: (*trainer).to_owned(),
            curve: Some(LearningCurve::default()),
        };
        // The second plot lacks some.
        let result = |from: usize| StudyResult {
            nets: trainers[from..].iter().map(net).collect(),
            ..StudyResult::default()
        };
        let wanted: Vec<_> = trainers.map(str::to_owned).into_iter().zip(SERIES).collect();
        assert_eq!(tones(&[&result(0), &result(3)]), wanted);
    }

    #[test]
    fn nonsense_is_left_out() {
        let errors = [Some(0.1), None, Some(0.0), Some(1.0)];
        assert_eq!(drawn(&[1.0, 2.0, 100.0, f64::INFINITY], &errors).len(), 1);
    }
}
