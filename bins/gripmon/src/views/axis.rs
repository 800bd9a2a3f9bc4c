//! The time axis under the plots: its labels, the flags of the cursors, and what found no room above it.

use super::Seen;
use crate::palette::{Palette, Tone};
use crate::plot::{self, Frame, GUTTER, Kind, Scale};
use crate::state::ViewState;
use eframe::egui::{Align2, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Height of the time axis with the cursors' flags (points).
pub(super) const HIGH: f32 = 22.0;

/// A frame that only knows where times are.
pub(super) fn time_frame(rect: Rect, seen: &Seen<'_>) -> Frame {
    Frame { rect, span: seen.span, scale: Scale::new(Kind::Linear, 0.0, 1.0) }
}

/// How many plots found no room, and which have no data, left of the time axis.
pub(super) fn left_out(ui: &Ui, axis: Rect, no_room: usize, empty: &[String], seen: &Seen<'_>) {
    let (text, tone) = match (no_room, empty.len()) {
        (0, 0) => return,
        (0, count) => (format!("+ {count} empty"), seen.palette.weak),
        (1, _) => ("+ 1 plot".to_owned(), seen.palette.tone(Tone::Orange)),
        (count, _) => (format!("+ {count} plots"), seen.palette.tone(Tone::Orange)),
    };
    let room = "No room in so low a window: make it higher, or close others under Plots.";
    let room = (no_room > 0).then(|| room.to_owned());
    let why: Vec<String> = room.into_iter().chain(empty.iter().cloned()).collect();
    let why = why.join("\n");
    let place = Rect::from_min_max(pos2(axis.left() - GUTTER, axis.top()), axis.left_bottom());
    let response = ui.interact(place, ui.scope_id().with("left out"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{text}\n{why}")));
    let font = FontId::proportional(11.0);
    ui.painter().text(place.left_center(), Align2::LEFT_CENTER, &text, font, tone);
    response.on_hover_text(why);
}

/// Labels of the time, and the flags by which cursors are moved.
pub(super) fn axis(ui: &Ui, rect: Rect, seen: &Seen<'_>, state: &mut ViewState) {
    let frame = time_frame(rect, seen);
    plot::time_labels(ui.painter(), &frame, &seen.palette);
    let unit = pos2(rect.right() + 24.0, rect.top() + 5.0);
    // After a restart of the device the axis goes on where it was.
    let text = if seen.model.is_device_time() { "s, device time" } else { "s, over restarts" };
    let font = crate::palette::axis_font();
    ui.painter().text(unit, Align2::LEFT_TOP, text, font, seen.palette.weak);
    for (cursor, name) in state.cursors.iter_mut().zip(["A", "B"]) {
        if let Some(at_s) = cursor {
            flag(ui, &frame, name, at_s, &seen.palette);
        }
    }
    pointer_time(ui, &frame, state.hover_s, seen);
}

fn flag(ui: &Ui, frame: &Frame, name: &str, at_s: &mut f64, palette: &Palette) {
    let x = frame.x(*at_s).clamp(frame.rect.left(), frame.rect.right());
    let rect = Rect::from_center_size(pos2(x, frame.rect.top() + 8.0), vec2(15.0, 15.0));
    let response = ui.interact(rect, ui.scope_id().with(("cursor", name)), Sense::drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, format!("Cursor {name}")));
    ui.painter().rect_filled(rect, 3, palette.cursor);
    let font = FontId::proportional(11.5);
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, name, font, palette.plot);
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        *at_s = frame.time(pointer.x);
    }
}

fn pointer_time(ui: &Ui, frame: &Frame, hover_s: Option<f64>, seen: &Seen<'_>) {
    let Some(t_s) = hover_s else { return };
    let decimals = crate::time::ticks(frame.span.from_s, frame.span.to_s, 200).decimals;
    let text = format!("{t_s:.*} s", decimals.min(7));
    let galley = ui.painter().layout_no_wrap(text, crate::palette::axis_font(), seen.palette.plot);
    let half = galley.size().x / 2.0 + 4.0;
    let x = frame
        .x(t_s)
        .clamp(frame.rect.left() + half, (frame.rect.right() - half).max(frame.rect.left() + half));
    let rect = Rect::from_center_size(pos2(x, frame.rect.top() + 10.5), vec2(2.0 * half, 15.0));
    ui.painter().rect_filled(rect, 3, seen.palette.tone(Tone::Quiet));
    ui.painter().galley(rect.center() - galley.size() / 2.0, galley, seen.palette.plot);
}
