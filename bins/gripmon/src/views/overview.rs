//! All data at a glance, and the part of them that is seen: drag it, or click where to look.

use super::{Seen, lane, strips};
use crate::palette::Tone;
use crate::plot::{self, Frame, Kind, Scale};
use crate::state::ViewState;
use eframe::egui::{
    Align2, FontId, PointerButton, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2,
};
use grip_scope::{Channel, Span};

/// Height of the overview (points).
pub(super) const HEIGHT: f32 = 34.0;
/// Columns of the overview: coarse, because it changes with every sample.
const COLUMNS: usize = 400;

pub(super) fn overview(ui: &Ui, rect: Rect, seen: &Seen<'_>, state: &mut ViewState) {
    let response = ui.interact(rect, ui.scope_id().with("overview"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::ScrollBar, true, "Overview of all data"));
    let painter = ui.painter();
    super::ground(painter, rect, &seen.palette);
    let (label, font) = (pos2(rect.left() - 6.0, rect.center().y), FontId::proportional(11.0));
    painter.text(label, Align2::RIGHT_CENTER, "all data", font, seen.palette.weak);
    let Some(data) = seen.model.span().filter(|data| data.length_s() > 0.0) else { return };
    let frame = signal(ui, rect, data, seen);
    for mark in seen.model.events().marks.iter().rev().take(400) {
        let tone = lane::tone(mark.kind);
        if tone != Tone::Quiet && tone != Tone::Green {
            let x = painter.round_to_pixel_center(frame.x(mark.t_s));
            let stroke = Stroke::new(1.5, seen.palette.tone(tone));
            painter.vline(x, rect.bottom() - 7.0..=rect.bottom(), stroke);
        }
    }
    window(ui, &frame, seen);
    let beside = pos2(rect.right() + 12.0, rect.center().y);
    let text = grip_scope::format::duration(data.length_s());
    painter.text(beside, Align2::LEFT_CENTER, text, crate::palette::axis_font(), seen.palette.weak);
    let moved = response.clicked() || response.dragged_by(PointerButton::Primary);
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| moved) {
        let (middle_s, half_s) = (frame.time(pointer.x), seen.span.length_s() / 2.0);
        state.show(Span::new(middle_s - half_s, middle_s + half_s));
    }
}

/// The stylus, else the first curve there is.
fn signal(ui: &Ui, rect: Rect, data: Span, seen: &Seen<'_>) -> Frame {
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
        let mut columns = Vec::new();
        series.envelope(data, COLUMNS, &mut columns);
        let stroke = Stroke::new(1.2, seen.palette.tone(Tone::Blue).gamma_multiply(0.8));
        let painter = ui.painter().with_clip_rect(rect);
        for run in plot::runs(&columns).split(|[_, value]| value.is_nan()) {
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
    let (painter, height) = (ui.painter(), frame.rect.y_range());
    let dim = seen.palette.panel.gamma_multiply(0.6);
    for beside in [frame.rect.left()..=left, right..=frame.rect.right().max(right)] {
        painter.rect_filled(Rect::from_x_y_ranges(beside, height), 0, dim);
    }
    let rect = Rect::from_x_y_ranges(left..=right, height);
    painter.rect_stroke(rect, 1, Stroke::new(1.2, seen.palette.weak), StrokeKind::Inside);
}
