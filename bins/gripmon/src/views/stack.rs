//! The plots one over the other on one time axis, with the lane of events above and the overview of all data below.

use super::{Scratch, Seen, gestures, lane, overview, pressure, readout, spectrogram, strips};
use crate::action::{Action, Cursor};
use crate::layout::StripLayout;
use crate::palette::{Palette, Tone};
use crate::plot::{self, Frame, GUTTER, Kind, Scale};
use crate::strip::{self, Curve, StripId};
use eframe::egui::{
    self, Align2, FontId, Rect, Role, Sense, Stroke, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};

/// Height of the time axis with the cursors' flags (points).
const AXIS: f32 = 22.0;
/// A stack narrower than this has no values beside its plots (points).
const NARROW: f32 = 480.0;
/// Space between two plots (points).
const BETWEEN: f32 = 5.0;
/// Height of the title of a plot (points).
const TITLE: f32 = 15.0;

/// Draws everything that shares the time axis.
pub fn stack(ui: &mut Ui, seen: &Seen<'_>, scratch: &mut Scratch) -> Vec<Action> {
    let all = ui.available_rect_before_wrap().shrink2(vec2(8.0, 4.0));
    let shown: Vec<StripLayout> =
        seen.state.layout.plots.iter().filter(|plot| plot.shown).copied().collect();
    // A narrow window has no room for values beside the plots.
    let beside = if all.width() > NARROW { readout::WIDTH } else { 4.0 };
    let left = all.left() + GUTTER;
    let inside = left..=(all.right() - beside).max(left + 20.0);
    let row = |top: f32, height: f32| Rect::from_x_y_ranges(inside.clone(), top..=top + height);
    let mut actions = Vec::new();
    let top = all.top() + lane::HEIGHT + BETWEEN;
    actions.extend(lane::lane(ui, row(all.top(), lane::HEIGHT), seen));
    let bottom = all.bottom() - overview::HEIGHT - BETWEEN - AXIS;
    if shown.is_empty() {
        let rect = row(top, (bottom - top).max(10.0));
        empty(ui, rect, "No plot is shown: choose some under Plots.", &seen.palette);
    }
    let mut hovered = false;
    for (plot, top, height) in heights(&shown, top, bottom) {
        let found = one(ui, (&plot, row(top, height)), (seen, scratch));
        hovered |= found.iter().any(|action| matches!(action, Action::Hover(_)));
        actions.extend(found);
    }
    if !hovered && seen.state.hover_s.is_some() && !ui.ctx().input(|i| i.pointer.any_down()) {
        actions.push(Action::Hover(None));
    }
    actions.extend(axis(ui, row(bottom, AXIS), seen));
    actions.extend(overview::overview(
        ui,
        row(all.bottom() - overview::HEIGHT, overview::HEIGHT),
        (seen, scratch),
    ));
    ui.advance_cursor_after_rect(all);
    actions
}

/// Top and height of each plot.
fn heights(shown: &[StripLayout], top: f32, bottom: f32) -> Vec<(StripLayout, f32, f32)> {
    let total: f32 = shown.iter().map(|plot| plot.height).sum();
    let mut at = top;
    let share = |plot: &StripLayout| (bottom - top) * plot.height / total.max(0.1);
    let place = |plot: &StripLayout| {
        let height = share(plot);
        let here = at;
        at += height;
        (*plot, here, (height - BETWEEN).max(24.0))
    };
    shown.iter().map(place).collect()
}

fn one(
    ui: &mut Ui,
    (plot, rect): (&StripLayout, Rect),
    (seen, scratch): (&Seen<'_>, &mut Scratch),
) -> Vec<Action> {
    let strip = plot.plot;
    let wanted = strip::curves(strip, seen.model);
    let scale = match strip {
        StripId::Spectrogram => Scale::new(Kind::Linear, 0.0, spectrogram::top_hz(seen).into()),
        StripId::Pressure => Scale::new(Kind::Linear, 0.0, pressure::count(seen)),
        _ => strips::scale(strip, &wanted, seen),
    };
    let frame = Frame { rect, span: seen.span, scale };
    let mut actions = interact(ui, strip, &frame, seen);
    draw(ui, (strip, &frame), &wanted, (seen, scratch));
    let beside = Rect::from_min_max(
        pos2(rect.right() + 10.0, rect.top()),
        pos2(rect.right() + readout::WIDTH, rect.bottom()),
    );
    if beside.right() > ui.max_rect().right() {
        return actions;
    }
    let mut child = ui.new_child(UiBuilder::new().max_rect(beside).id_salt((strip, "values")));
    child.set_clip_rect(beside.expand(2.0).intersect(ui.clip_rect()));
    actions.extend(beside_plot(&mut child, strip, &wanted, seen));
    actions.extend(edge(ui, plot, rect, seen));
    actions
}

fn interact(ui: &Ui, strip: StripId, frame: &Frame, seen: &Seen<'_>) -> Vec<Action> {
    let inside =
        ui.interact(frame.rect, ui.scope_id().with((strip, "plot")), Sense::click_and_drag());
    inside.widget_info(|| WidgetInfo::labeled(Role::Figure, true, name(strip, seen)));
    let labels = Rect::from_min_max(
        pos2(frame.rect.left() - GUTTER, frame.rect.top()),
        frame.rect.left_bottom(),
    );
    let mut actions = gestures::over_plot(ui, &inside, frame, seen);
    if strip.has_curves() {
        let axis =
            ui.interact(labels, ui.scope_id().with((strip, "axis")), Sense::click_and_drag());
        axis.widget_info(|| {
            WidgetInfo::labeled(Role::Figure, true, format!("{} axis", strip.title()))
        });
        actions.extend(gestures::over_axis(ui, &axis, frame, strip));
    }
    actions
}

/// What a plot is called where it cannot be seen.
fn name(strip: StripId, seen: &Seen<'_>) -> String {
    let empty = if strip::has_data(strip, seen.model) { "" } else { strip.nothing() };
    format!("{} plot {empty}", strip.title()).trim_end().to_owned()
}

fn draw(
    ui: &Ui,
    (strip, frame): (StripId, &Frame),
    wanted: &[Curve],
    (seen, scratch): (&Seen<'_>, &mut Scratch),
) {
    let painter = ui.painter();
    let unit = match strip {
        StripId::Spectrogram => "Hz".to_owned(),
        _ => strips::unit(wanted, seen),
    };
    plot::value_axis(painter, frame, &unit, &seen.palette);
    plot::time_axis(painter, frame, false, &seen.palette);
    if strip::has_data(strip, seen.model) {
        match strip {
            StripId::Spectrogram => spectrogram::draw(ui, frame, (seen, scratch)),
            StripId::Pressure => pressure::draw(ui, frame, (seen, scratch)),
            _ => plot_curves(ui, (strip, frame), wanted, (seen, scratch)),
        }
    } else {
        empty(ui, frame.rect, strip.nothing(), &seen.palette);
    }
    strips::lines(painter, frame, seen);
    title(ui, frame.rect, strip, &seen.palette);
}

fn plot_curves(
    ui: &Ui,
    (strip, frame): (StripId, &Frame),
    wanted: &[Curve],
    (seen, scratch): (&Seen<'_>, &mut Scratch),
) {
    let painter = ui.painter();
    strips::spans(painter, frame, seen);
    strips::curves(painter, frame, wanted, (seen, scratch));
    match strip {
        StripId::Stylus => strips::turns(painter, frame, seen),
        StripId::Statistic => strips::threshold(painter, frame, 1.0, seen),
        _ => {}
    }
}

fn beside_plot(ui: &mut Ui, strip: StripId, wanted: &[Curve], seen: &Seen<'_>) -> Vec<Action> {
    match strip {
        StripId::Spectrogram => spectrogram::readout(ui, seen),
        StripId::Pressure => pressure::readout(ui, seen),
        _ => readout::readout(ui, strip, wanted, seen),
    }
    if seen.state.chosen(strip).is_some() {
        let by_hand = ui
            .small_button("values by hand")
            .on_hover_text("Click to scale to what is seen again.");
        if by_hand.clicked() {
            return vec![Action::Values(strip, None)];
        }
    }
    Vec::new()
}

fn title(ui: &Ui, rect: Rect, strip: StripId, palette: &Palette) {
    let galley = ui.painter().layout_no_wrap(
        strip.title().to_owned(),
        FontId::proportional(11.0),
        palette.text,
    );
    let place =
        Rect::from_min_size(rect.left_top() + vec2(5.0, 3.0), vec2(galley.size().x + 8.0, TITLE));
    ui.painter().rect_filled(place, 3, palette.plot.gamma_multiply(0.6));
    ui.painter().galley(
        place.left_center() - vec2(-4.0, galley.size().y / 2.0),
        galley,
        palette.text,
    );
}

/// The lower edge of a plot, which makes it higher.
fn edge(ui: &Ui, plot: &StripLayout, rect: Rect, seen: &Seen<'_>) -> Option<Action> {
    let zone = Rect::from_min_max(
        pos2(rect.left(), rect.bottom()),
        pos2(rect.right(), rect.bottom() + BETWEEN),
    );
    let response = ui.interact(zone, ui.scope_id().with((plot.plot, "edge")), Sense::drag());
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Splitter, true, format!("{} height", plot.plot.title()))
    });
    if response.hovered() || response.dragged() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeVertical);
        ui.painter().hline(zone.x_range(), zone.center().y, Stroke::new(1.0, seen.palette.weak));
    }
    let by = response.drag_delta().y;
    (response.dragged() && by != 0.0)
        .then(|| Action::Height(plot.plot, plot.height * (1.0 + by / rect.height())))
}

/// A sentence in an empty place.
pub(super) fn empty(ui: &Ui, rect: Rect, text: &str, palette: &Palette) {
    let painter = ui.painter();
    painter.rect_filled(rect, 0, palette.plot);
    painter.text(
        rect.center(),
        Align2::CENTER_CENTER,
        text,
        FontId::proportional(12.0),
        palette.weak,
    );
}

/// Labels of the time, and the flags by which cursors are moved.
fn axis(ui: &Ui, rect: Rect, seen: &Seen<'_>) -> Vec<Action> {
    let frame = Frame { rect, span: seen.span, scale: Scale::new(Kind::Linear, 0.0, 1.0) };
    plot::time_axis(ui.painter(), &frame, true, &seen.palette);
    let unit = pos2(rect.right() + 24.0, rect.top() + 5.0);
    ui.painter().text(
        unit,
        Align2::LEFT_TOP,
        "s, device time",
        crate::palette::axis_font(),
        seen.palette.weak,
    );
    let mut actions = Vec::new();
    for (cursor, name) in [(Cursor::A, "A"), (Cursor::B, "B")] {
        let Some(at_s) = seen.state.cursor(cursor) else { continue };
        actions.extend(flag(ui, &frame, (cursor, name, at_s), &seen.palette));
    }
    pointer_time(ui, &frame, seen);
    actions
}

fn flag(
    ui: &Ui,
    frame: &Frame,
    (cursor, name, at_s): (Cursor, &str, f64),
    palette: &Palette,
) -> Option<Action> {
    let x = frame.x(at_s).clamp(frame.rect.left(), frame.rect.right());
    let rect = Rect::from_center_size(pos2(x, frame.rect.top() + 8.0), vec2(15.0, 15.0));
    let response = ui.interact(rect, ui.scope_id().with(("cursor", name)), Sense::drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, format!("Cursor {name}")));
    ui.painter().rect_filled(rect, 3, palette.cursor);
    ui.painter().text(
        rect.center(),
        Align2::CENTER_CENTER,
        name,
        FontId::proportional(11.5),
        palette.plot,
    );
    let pointer = response.interact_pointer_pos().filter(|_| response.dragged())?;
    Some(Action::PlaceCursor(cursor, frame.time(pointer.x)))
}

fn pointer_time(ui: &Ui, frame: &Frame, seen: &Seen<'_>) {
    let Some(t_s) = seen.state.hover_s else { return };
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
