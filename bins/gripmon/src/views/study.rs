//! The curves of a study, two plots beside each other.

use super::Seen;
use crate::action::Action;
use crate::num;
use crate::palette::{Palette, SERIES, Tone};
use crate::plot::{self, Frame, GUTTER, Kind, Scale, Style};
use eframe::egui::{
    self, Align2, FontId, Galley, Painter, Rect, Role, Sense, Shape, Ui, WidgetInfo, pos2, vec2,
};
use grip_scope::Span;
use grip_scope::feed::{StudyCurve, StudyCurves, StudyPlot};
use std::sync::Arc;

/// Height of a plot with its title and labels (points).
const HIGH: f32 = 270.0;
/// Room for the line before a name of the legend (points).
const MARK: f32 = 24.0;

/// Draws the page.
pub fn study(ui: &mut Ui, study: &StudyCurves, seen: &Seen<'_>) -> Vec<Action> {
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
                    let (rect, response) = ui.allocate_exact_size(vec2(wide, HIGH), Sense::hover());
                    response.widget_info(|| {
                        WidgetInfo::labeled(Role::Figure, true, format!("{} plot", one.title))
                    });
                    draw(ui, rect, one, &seen.palette);
                }
            });
        }
    });
    Vec::new()
}

fn draw(ui: &Ui, rect: Rect, one: &StudyPlot, palette: &Palette) {
    let legend = legend(ui, &one.curves, palette);
    let beside = legend.iter().map(|line| line.text.size().x).fold(0.0, f32::max) + MARK + 12.0;
    let beside = beside.min(rect.width() * 0.45);
    let inside =
        Rect::from_min_max(rect.min + vec2(GUTTER, 24.0), rect.max - vec2(beside + 6.0, 34.0));
    let Some(frame) = frame(inside, one) else {
        super::stack::empty(ui, inside, "No finite points.", palette);
        return;
    };
    let painter = ui.painter();
    plot::value_axis(painter, &frame, "", palette);
    plot::grid(painter, &frame, palette);
    let below = Frame {
        rect: Rect::from_min_size(inside.left_bottom(), vec2(inside.width(), 20.0)),
        ..frame
    };
    plot::labels(painter, &below, plot::Across::Numbers, palette);
    titles(painter, rect, inside, one, palette);
    let clipped = painter.with_clip_rect(inside.intersect(ui.clip_rect()));
    for (curve, (tone, style)) in one.curves.iter().zip(looks(&one.curves)) {
        plot::polyline(&clipped, &frame, &curve.points, palette.tone(tone), style);
    }
    let place = Rect::from_min_max(
        pos2(inside.right() + 8.0, inside.top()),
        pos2(rect.right(), rect.bottom()),
    );
    beside_plot(painter, place, &legend, palette);
}

fn titles(painter: &Painter, rect: Rect, inside: Rect, one: &StudyPlot, palette: &Palette) {
    let text = |at, align, text: &str| {
        painter.text(at, align, text, FontId::proportional(11.5), palette.weak)
    };
    painter.text(
        pos2(inside.left(), rect.top() + 4.0),
        Align2::LEFT_TOP,
        &one.title,
        FontId::proportional(12.5),
        palette.text,
    );
    text(pos2(inside.center().x, rect.bottom()), Align2::CENTER_BOTTOM, &one.x_label);
    text(pos2(rect.right(), rect.top() + 5.0), Align2::RIGHT_TOP, &one.y_label);
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

/// A line of the legend.
struct Line {
    tone: Tone,
    style: Style,
    text: Arc<Galley>,
}

/// Each net once, in its colour, then what dashes mean.
fn legend(ui: &Ui, curves: &[StudyCurve], palette: &Palette) -> Vec<Line> {
    let written = |text: &str, (tone, style)| Line {
        tone,
        style,
        text: ui.painter().layout_no_wrap(
            text.to_owned(),
            FontId::proportional(11.0),
            palette.text,
        ),
    };
    let looks = looks(curves);
    let mut known: Vec<&str> = Vec::new();
    let mut lines = Vec::new();
    for (curve, (tone, _)) in curves.iter().zip(&looks) {
        let (name, _) = net(&curve.name);
        if !known.contains(&name) {
            known.push(name);
            lines.push(written(name, (*tone, Style::Solid)));
        }
    }
    if looks.iter().any(|(_, style)| *style == Style::Dashed) {
        lines.push(written("train", (Tone::Quiet, Style::Solid)));
        lines.push(written("test", (Tone::Quiet, Style::Dashed)));
    }
    lines
}

fn beside_plot(painter: &Painter, place: Rect, lines: &[Line], palette: &Palette) {
    let painter = painter.with_clip_rect(place.intersect(painter.clip_rect()));
    for (i, line) in lines.iter().enumerate() {
        let y = place.top() + 8.0 + 15.0 * num::narrow(num::count(i));
        let mark = [pos2(place.left(), y), pos2(place.left() + MARK - 6.0, y)];
        let stroke = egui::Stroke::new(2.0, palette.tone(line.tone));
        match line.style {
            Style::Solid => painter.extend([Shape::line_segment(mark, stroke)]),
            Style::Dashed => painter.extend(Shape::dashed_line(&mark, stroke, 5.0, 4.0)),
        }
        let at = pos2(place.left() + MARK, y - line.text.size().y / 2.0);
        painter.galley(at, Arc::clone(&line.text), palette.text);
    }
}

/// The frame that holds every finite point; `None` where there is none.
fn frame(rect: Rect, one: &StudyPlot) -> Option<Frame> {
    let fits = |[x, y]: &&[f64; 2]| x.is_finite() && y.is_finite() && (!one.log_y || *y > 0.0);
    let points: Vec<&[f64; 2]> =
        one.curves.iter().flat_map(|curve| &curve.points).filter(fits).collect();
    let range = |of: fn(&[f64; 2]) -> f64| {
        let ends = points.iter().map(|point| of(point));
        ends.fold(None, |range: Option<(f64, f64)>, v| {
            Some(range.map_or((v, v), |(l, h)| (l.min(v), h.max(v))))
        })
    };
    let ((from, to), (low, high)) = (range(|p| p[0])?, range(|p| p[1])?);
    let kind = if one.log_y { Kind::Log } else { Kind::Linear };
    let to = if to > from { to } else { from + 1.0 };
    Some(Frame {
        rect,
        span: Span { from_s: from, to_s: to },
        scale: Scale::around(kind, low, high),
    })
}

#[cfg(test)]
mod tests {
    use super::{StudyCurve, StudyPlot, draw, frame, looks};
    use crate::palette::{Palette, SERIES};
    use crate::plot::Style;
    use eframe::egui::{self, Rect, Shape, pos2};

    /// The texts that a plot paints.
    fn texts(one: &StudyPlot) -> Vec<String> {
        let ctx = egui::Context::default();
        let mut output = ctx.run_ui(egui::RawInput::default(), |ui| {
            let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(640.0, 270.0));
            draw(ui, rect, one, &Palette::of(egui::Theme::Dark));
        });
        output.textures_delta.clear();
        let text = |shape: egui::epaint::ClippedShape| match shape.shape {
            Shape::Text(text) => Some(text.galley.text().to_owned()),
            _ => None,
        };
        output.shapes.into_iter().filter_map(text).collect()
    }

    #[test]
    fn epochs_are_plain_numbers() {
        let points = vec![[0.0, 1.0], [1000.0, 0.1], [2000.0, 0.01]];
        let curves = vec![StudyCurve { name: "a, train".into(), points }];
        let found = texts(&StudyPlot { log_y: true, curves, ..StudyPlot::default() });
        assert!(found.iter().any(|text| text == "1000"), "{found:?}");
        assert!(found.iter().any(|text| text == "2000"), "{found:?}");
        assert!(!found.iter().any(|text| text.contains(':')), "{found:?}");
    }

    #[test]
    fn a_net_has_one_colour_and_its_test_rows_are_dashed() {
        let nets = ["2-10-1 gd", "2-10-1 lm", "2-20-1 gd", "2-20-1 lm", "cg", "bfgs"];
        let points = vec![[1.0, 1.0], [2.0, 0.5]];
        let curve =
            |net: &str, rows| StudyCurve { name: format!("{net}, {rows}"), points: points.clone() };
        let curves: Vec<StudyCurve> =
            nets.iter().flat_map(|net| [curve(net, "train"), curve(net, "test")]).collect();
        let looks = looks(&curves);
        for (pair, tone) in looks.chunks(2).zip(SERIES) {
            assert_eq!(pair, [(tone, Style::Solid), (tone, Style::Dashed)]);
        }
        let found = texts(&StudyPlot { log_y: true, curves, ..StudyPlot::default() });
        for reported in nets.iter().chain(&["train", "test"]) {
            assert_eq!(
                found.iter().filter(|text| text == reported).count(),
                1,
                "{reported}: {found:?}"
            );
        }
    }

    #[test]
    fn a_plot_without_points_has_no_frame_and_nonsense_is_left_out() {
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(100.0, 100.0));
        let curve = |points: &[[f64; 2]]| StudyCurve { name: "a".into(), points: points.to_vec() };
        let plot = |points: &[[f64; 2]]| StudyPlot {
            log_y: true,
            curves: vec![curve(points)],
            ..StudyPlot::default()
        };
        assert!(
            frame(rect, &plot(&[])).is_none()
                && frame(rect, &plot(&[[1.0, f64::NAN], [1.0, 0.0]])).is_none()
        );
        let found = frame(rect, &plot(&[[1.0, 0.1], [100.0, 1e-4], [f64::INFINITY, 1.0]])).unwrap();
        assert!(found.span.to_s == 100.0 && found.scale.low() <= 1e-4);
    }
}
