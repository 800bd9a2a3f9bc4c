//! The curves of a study, two plots beside each other.

use super::Seen;
use crate::action::Action;
use crate::num;
use crate::palette::{Palette, SERIES};
use crate::plot::{self, Frame, GUTTER, Kind, Scale, Style};
use eframe::egui::{self, Align2, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use grip_scope::Span;
use grip_scope::feed::{StudyCurve, StudyCurves, StudyPlot};

/// Height of a plot with its title and labels (points).
const HIGH: f32 = 270.0;

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
    let inside = Rect::from_min_max(rect.min + vec2(GUTTER, 24.0), rect.max - vec2(12.0, 34.0));
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
    text(pos2(inside.right(), rect.top() + 5.0), Align2::RIGHT_TOP, &one.y_label);
    let clipped = painter.with_clip_rect(inside.intersect(ui.clip_rect()));
    for (curve, tone) in one.curves.iter().zip(SERIES.into_iter().cycle()) {
        plot::polyline(&clipped, &frame, &curve.points, (palette.tone(tone), Style::Solid));
    }
    legend(ui, inside, &one.curves, palette);
}

fn legend(ui: &Ui, inside: Rect, curves: &[StudyCurve], palette: &Palette) {
    for (i, (curve, tone)) in curves.iter().zip(SERIES.into_iter().cycle()).enumerate() {
        let at =
            pos2(inside.right() - 6.0, inside.top() + 10.0 + 15.0 * num::narrow(num::count(i)));
        if at.y > inside.bottom() - 8.0 {
            return;
        }
        let drawn = ui.painter().text(
            at,
            Align2::RIGHT_CENTER,
            &curve.name,
            FontId::proportional(11.0),
            palette.text,
        );
        let mark = drawn.left() - 16.0..=drawn.left() - 4.0;
        ui.painter().hline(mark, at.y, egui::Stroke::new(2.5, palette.tone(tone)));
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
    use super::{StudyCurve, StudyPlot, draw, frame};
    use crate::palette::Palette;
    use eframe::egui::{self, Rect, Shape, pos2};

    /// The texts that a plot paints.
    fn texts(one: &StudyPlot) -> Vec<String> {
        let ctx = egui::Context::default();
        let output = ctx.run_ui(egui::RawInput::default(), |ui| {
            let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(640.0, 270.0));
            draw(ui, rect, one, &Palette::of(egui::Theme::Dark));
        });
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
