//! What the mouse does over a plot.

use super::Seen;
use crate::plot::Frame;
use crate::state::ViewState;
use crate::strip::StripId;
use eframe::egui::{PointerButton, Response, Ui};
use grip_scope::Span;

/// How much a notch of the wheel zooms (per point of its movement).
const WHEEL: f32 = 0.0022;
/// Shortest stretch that is taken as one (points).
const LEAST_DRAG: f32 = 4.0;

/// Pointer over the inside of a plot: time moves.
pub(super) fn over_plot(
    ui: &Ui,
    response: &Response,
    frame: &Frame,
    seen: &Seen<'_>,
    state: &mut ViewState,
) {
    let Some(pointer) = response.hover_pos().or_else(|| response.interact_pointer_pos()) else {
        return;
    };
    let data = seen.model.span();
    let at_s = frame.time(pointer.x.clamp(frame.rect.left(), frame.rect.right()));
    state.pointed_s = Some(at_s);
    let per_point = frame.span.length_s() / f64::from(frame.rect.width());
    let wheel =
        if response.hovered() { ui.input(|i| i.smooth_scroll_delta()) } else { Default::default() };
    if wheel.y.abs() > 0.1 {
        state.view().zoom(at_s, f64::from((-wheel.y * WHEEL).exp()), data);
    }
    let primary = response.dragged_by(PointerButton::Primary);
    let dragged = if primary { response.drag_delta().x } else { 0.0 };
    let moved = dragged + if wheel.x.abs() > 0.1 { wheel.x } else { 0.0 };
    if moved != 0.0 {
        state.view().pan(-f64::from(moved) * per_point, data);
    }
    if response.drag_started_by(PointerButton::Secondary) {
        state.select_s = Some(at_s);
    }
    if response.drag_stopped_by(PointerButton::Secondary)
        && let Some(from_s) = state.select_s.take()
        && (frame.x(at_s) - frame.x(from_s)).abs() >= LEAST_DRAG
    {
        state.show(Span::new(from_s, at_s));
    }
    if response.double_clicked() {
        state.view().all();
    }
}

/// Pointer over the labels of a plot's values: values move.
pub(super) fn over_axis(
    ui: &Ui,
    response: &Response,
    frame: &Frame,
    strip: StripId,
    state: &mut ViewState,
) {
    if response.double_clicked() {
        return state.set_values(strip, None);
    }
    let height = frame.rect.height();
    let wheel = if response.hovered() { ui.input(|i| i.smooth_scroll_delta().y) } else { 0.0 };
    if let Some(pointer) = response.hover_pos().filter(|_| wheel.abs() > 0.1) {
        let place = f64::from((frame.rect.bottom() - pointer.y) / height);
        let factor = f64::from((-wheel * WHEEL).exp());
        state.set_values(strip, Some(frame.scale.changed(place, factor, 0.0)));
    }
    let dragged = response.drag_delta().y;
    if response.dragged() && dragged != 0.0 {
        let by = -f64::from(dragged / height);
        state.set_values(strip, Some(frame.scale.changed(0.0, 1.0, by)));
    }
}
