//! All data at a glance, and the part of them that is seen: drag it, or click where to look.

use super::{Scratch, Seen, lane, strips};
use crate::action::Action;
use crate::palette::Tone;
use crate::plot::{self, Frame, Kind, Scale};
use eframe::egui::{
    Align2, FontId, PointerButton, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo, pos2,
};
use grip_scope::{Channel, Span};

/// Height of the overview (points).
pub(super) const HEIGHT: f32 = 34.0;
/// Columns of the overview: coarse, because it changes with every sample.
const COLUMNS: usize = 400;

pub(super) fn overview(ui: &Ui, rect: Rect, seen: &Seen<'_>, scratch: &mut Scratch) -> Vec<Action> {
    let response = ui.interact(rect, ui.scope_id().with("overview"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::ScrollBar, true, "Overview of all data"));
    let painter = ui.painter();
    let border = Stroke::new(1.0, seen.palette.edge);
    painter.rect(rect, 0, seen.palette.plot, border, eframe::egui::StrokeKind::Outside);
    let label = pos2(rect.left() - 6.0, rect.center().y);
    painter.text(
        label,
        Align2::RIGHT_CENTER,
        "all data",
        FontId::proportional(11.0),
        seen.palette.weak,
    );
    let Some(data) = seen.model.span().filter(|data| data.length_s() > 0.0) else {
        return Vec::new();
    };
    let frame = signal(ui, rect, data, seen, scratch);
    for mark in seen.model.events().iter().rev().take(400) {
        let tone = lane::tone(mark.kind);
        if tone != Tone::Quiet && tone != Tone::Green {
            let x = painter.round_to_pixel_center(frame.x(mark.t_s));
            painter.vline(
                x,
                rect.bottom() - 7.0..=rect.bottom(),
                Stroke::new(1.5, seen.palette.tone(tone)),
            );
        }
    }
    window(ui, &frame, seen);
    let beside = pos2(rect.right() + 12.0, rect.center().y);
    let text = grip_scope::format::duration(data.length_s());
    painter.text(beside, Align2::LEFT_CENTER, text, crate::palette::axis_font(), seen.palette.weak);
    moved(&response, &frame, seen)
}

/// The stylus, else the first curve there is.
fn signal(ui: &Ui, rect: Rect, data: Span, seen: &Seen<'_>, scratch: &mut Scratch) -> Frame {
    let first = || seen.model.channels().find_map(|channel| seen.model.series(channel));
    let series = seen.model.series(Channel::Stylus).or_else(first);
    let (low, high) =
        series.and_then(|series| strips::extremes(series, data)).unwrap_or((0.0, 1.0));
    let frame = Frame {
        rect: rect.shrink2(eframe::egui::vec2(0.0, 3.0)),
        span: data,
        scale: Scale::new(Kind::Linear, low.into(), high.into()),
    };
    if let Some(series) = series {
        series.envelope(data, COLUMNS, &mut scratch.buckets);
        let stroke = Stroke::new(1.2, seen.palette.tone(Tone::Blue).gamma_multiply(0.8));
        let painter = ui.painter().with_clip_rect(rect);
        for run in plot::runs(&scratch.buckets).split(|[_, value]| value.is_nan()) {
            painter.line(
                run.iter().map(|[t_s, v]| pos2(frame.x(*t_s), frame.y(*v))).collect(),
                stroke,
            );
        }
    }
    Frame { rect, ..frame }
}

/// The part that is seen, its surroundings dimmed.
fn window(ui: &Ui, frame: &Frame, seen: &Seen<'_>) {
    let (left, right) = (frame.x(seen.span.from_s), frame.x(seen.span.to_s));
    let left = left.clamp(frame.rect.left(), frame.rect.right());
    let right = right.clamp(left, frame.rect.right()).max(left + 2.0);
    let painter = ui.painter();
    let dim = seen.palette.panel.gamma_multiply(0.6);
    painter.rect_filled(
        Rect::from_x_y_ranges(frame.rect.left()..=left, frame.rect.y_range()),
        0,
        dim,
    );
    painter.rect_filled(
        Rect::from_x_y_ranges(right..=frame.rect.right().max(right), frame.rect.y_range()),
        0,
        dim,
    );
    let rect = Rect::from_x_y_ranges(left..=right, frame.rect.y_range());
    painter.rect_stroke(
        rect,
        1,
        Stroke::new(1.2, seen.palette.weak),
        eframe::egui::StrokeKind::Inside,
    );
}

fn moved(response: &Response, frame: &Frame, seen: &Seen<'_>) -> Vec<Action> {
    if !(response.clicked() || response.dragged_by(PointerButton::Primary)) {
        return Vec::new();
    }
    let Some(pointer) = response.interact_pointer_pos() else { return Vec::new() };
    let middle_s = frame.time(pointer.x);
    let half_s = seen.span.length_s() / 2.0;
    vec![Action::Show(Span::new(middle_s - half_s, middle_s + half_s))]
}
