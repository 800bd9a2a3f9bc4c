//! What the mouse does over a plot in; requests out.

use super::Seen;
use crate::action::Action;
use crate::plot::{Frame, Scale};
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
) -> Vec<Action> {
    let mut actions = Vec::new();
    let Some(pointer) = response.hover_pos().or_else(|| response.interact_pointer_pos()) else {
        return actions;
    };
    let at_s = frame.time(pointer.x.clamp(frame.rect.left(), frame.rect.right()));
    actions.push(Action::Hover(Some(at_s)));
    let per_point = frame.span.length_s() / f64::from(frame.rect.width());
    let wheel =
        if response.hovered() { ui.input(|i| i.smooth_scroll_delta()) } else { Default::default() };
    if wheel.y.abs() > 0.1 {
        actions.push(Action::Zoom { at_s, factor: f64::from((-wheel.y * WHEEL).exp()) });
    }
    if wheel.x.abs() > 0.1 {
        actions.push(Action::Pan(-f64::from(wheel.x) * per_point));
    }
    let dragged = response.drag_delta().x;
    if response.dragged_by(PointerButton::Primary) && dragged != 0.0 {
        actions.push(Action::Pan(-f64::from(dragged) * per_point));
    }
    if response.drag_started_by(PointerButton::Secondary) {
        actions.push(Action::Select(Some(at_s)));
    }
    if response.drag_stopped_by(PointerButton::Secondary) {
        actions.extend(selected(seen, frame, at_s));
    }
    if response.double_clicked() {
        actions.push(Action::ShowAll);
    }
    actions
}

fn selected(seen: &Seen<'_>, frame: &Frame, to_s: f64) -> Vec<Action> {
    let Some(from_s) = seen.state.select_s else { return Vec::new() };
    let wide = (frame.x(to_s) - frame.x(from_s)).abs() >= LEAST_DRAG;
    let show = wide.then(|| Action::Show(Span::new(from_s, to_s)));
    show.into_iter().chain([Action::Select(None)]).collect()
}

/// Pointer over the labels of a plot's values: values move.
pub(super) fn over_axis(
    ui: &Ui,
    response: &Response,
    frame: &Frame,
    strip: StripId,
) -> Vec<Action> {
    let mut actions = Vec::new();
    if response.double_clicked() {
        return vec![Action::Values(strip, None)];
    }
    let place = |y: f32| f64::from((frame.rect.bottom() - y) / frame.rect.height());
    let wheel = if response.hovered() { ui.input(|i| i.smooth_scroll_delta().y) } else { 0.0 };
    let changed =
        |place: f64, factor: f64, by: f64| -> Scale { frame.scale.changed(place, factor, by) };
    if let Some(pointer) = response.hover_pos().filter(|_| wheel.abs() > 0.1) {
        let factor = f64::from((-wheel * WHEEL).exp());
        actions.push(Action::Values(strip, Some(changed(place(pointer.y), factor, 0.0))));
    }
    if response.dragged() && response.drag_delta().y != 0.0 {
        let by = -f64::from(response.drag_delta().y / frame.rect.height());
        actions.push(Action::Values(strip, Some(changed(0.0, 1.0, by))));
    }
    actions
}
