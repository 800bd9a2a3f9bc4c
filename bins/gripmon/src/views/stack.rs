//! The plots one over the other on one time axis, with the lane of events above and the overview of all data below.

use super::{
    Scratch, Seen, axis, gestures, lane, overview, pressure, readout, spectrogram, strips,
};
use crate::layout::{HEIGHTS, StripLayout};
use crate::palette::Palette;
use crate::plot::{self, Frame, GUTTER, Kind, Scale};
use crate::state::ViewState;
use crate::strip::{self, Curve, StripId};
use eframe::egui::{
    self, Align2, FontId, Rect, Response, Role, Sense, Stroke, Ui, UiBuilder, WidgetInfo, pos2,
    vec2,
};
use grip_scope::SourceStatus;

/// A stack narrower than this has no values beside its plots (points).
const NARROW: f32 = 560.0;
/// Room that a plot needs (points).
const LEAST: f32 = 40.0;
/// Space between two plots (points).
const BETWEEN: f32 = 5.0;
/// Height of the title of a plot (points).
const TITLE: f32 = 15.0;

/// Draws everything that shares the time axis.
pub fn stack(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState, scratch: &mut Scratch) {
    let all = ui.available_rect_before_wrap().shrink2(vec2(8.0, 4.0));
    let (shown, empty_ones) = chosen(seen, state);
    // A narrow window has no room for values beside the plots.
    let beside = if all.width() > NARROW { readout::WIDTH } else { 4.0 };
    let left = all.left() + GUTTER;
    let inside = left..=(all.right() - beside).max(left + 20.0);
    let row = |top: f32, height: f32| Rect::from_x_y_ranges(inside.clone(), top..=top + height);
    state.pointed_s = None;
    let lane = row(all.top(), lane::HEIGHT);
    scratch.pieces = strips::pieces(&axis::time_frame(lane, seen), seen);
    lane::lane(ui, lane, &scratch.pieces, seen, state);
    let top = all.top() + lane::HEIGHT + BETWEEN;
    let bottom = all.bottom() - overview::HEIGHT - BETWEEN - axis::HIGH;
    if shown.is_empty() && empty_ones.is_empty() {
        let rect = row(top, (bottom - top).max(10.0));
        empty(ui, rect, "No plot is shown: choose some under Plots.", &seen.palette);
    }
    let room = crate::num::whole(f64::from((bottom - top) / LEAST)).clamp(1, shown.len().max(1));
    let (fitting, others) = shown.split_at(room.min(shown.len()));
    for (plot, top, height) in heights(fitting, top, bottom) {
        one(ui, &plot, row(top, height), seen, state, scratch);
    }
    axis::left_out(ui, row(bottom, axis::HIGH), others.len(), &empty_ones, seen);
    axis::axis(ui, row(bottom, axis::HIGH), seen, state);
    overview::overview(ui, row(all.bottom() - overview::HEIGHT, overview::HEIGHT), seen, state);
    // What is dragged beyond the plots stays where it was last over them.
    if state.pointed_s.is_some() || !ui.ctx().input(|i| i.pointer.any_down()) {
        state.hover_s = state.pointed_s.filter(|_| !state.no_pointer);
    }
    ui.advance_cursor_after_rect(all);
}

/// The plots that the user has chosen, and those of them that have no data: where any has some, the others leave their room to it.
fn chosen(seen: &Seen<'_>, state: &ViewState) -> (Vec<StripLayout>, Vec<String>) {
    let chosen = state.layout.plots.iter().filter(|plot| plot.shown).copied();
    let (full, empty): (Vec<_>, Vec<_>) =
        chosen.partition(|plot| strip::has_data(plot.plot, seen.model));
    if full.is_empty() {
        return (empty, Vec::new());
    }
    let why = |plot: &StripLayout| format!("{}: {}", plot.plot.title(), nothing(plot.plot, seen));
    (full, empty.iter().map(why).collect())
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
    plot: &StripLayout,
    rect: Rect,
    seen: &Seen<'_>,
    state: &mut ViewState,
    scratch: &mut Scratch,
) {
    let strip = plot.plot;
    let wanted = strip::curves(strip, seen.model);
    let by_hand = state.chosen(strip);
    let scale = match strip {
        StripId::Spectrogram => Scale::new(Kind::Linear, 0.0, spectrogram::top_hz(seen).into()),
        StripId::Pressure if strip::has_array(seen.model) => {
            Scale::new(Kind::Linear, 0.0, pressure::count(seen))
        }
        _ => by_hand.unwrap_or_else(|| strips::scale(strip, &wanted, seen)),
    };
    let frame = Frame { rect, span: seen.span, scale };
    let inside = draw(ui, strip, &frame, &wanted, seen, scratch);
    strips::lines(ui.painter(), &frame, seen, state);
    title(ui, rect, strip, seen);
    interact(ui, strip, &frame, &inside, seen, state);
    let beside = Rect::from_min_max(
        pos2(rect.right() + 10.0, rect.top()),
        pos2(rect.right() + readout::WIDTH, rect.bottom()),
    );
    if beside.right() > ui.max_rect().right() {
        return;
    }
    let mut child = ui.new_child(UiBuilder::new().max_rect(beside).id_salt((strip, "values")));
    child.set_clip_rect(beside.expand(2.0).intersect(ui.clip_rect()));
    match strip {
        StripId::Spectrogram => spectrogram::readout(&mut child, seen),
        StripId::Pressure if strip::has_array(seen.model) => pressure::readout(&mut child, seen),
        _ => readout::readout(&mut child, strip, &scale, &wanted, by_hand.is_some(), seen),
    }
    if by_hand.is_some() {
        let button = child.small_button("values by hand");
        if button.on_hover_text("Click to scale to what is seen again.").clicked() {
            state.set_values(strip, None);
        }
    }
    edge(ui, plot, rect, seen, state);
}

fn interact(
    ui: &Ui,
    strip: StripId,
    frame: &Frame,
    inside: &Response,
    seen: &Seen<'_>,
    state: &mut ViewState,
) {
    inside.widget_info(|| WidgetInfo::labeled(Role::Figure, true, name(strip, seen)));
    gestures::over_plot(ui, inside, frame, seen, state);
    if !strip.has_curves(seen.model) {
        return;
    }
    let across = frame.rect.left() - GUTTER..=frame.rect.left();
    let labels = Rect::from_x_y_ranges(across, frame.rect.y_range());
    let axis = ui.interact(labels, ui.scope_id().with((strip, "axis")), Sense::click_and_drag());
    let title = format!("{} axis", strip.title());
    axis.widget_info(|| WidgetInfo::labeled(Role::Figure, true, &title));
    gestures::over_axis(ui, &axis, frame, strip, state);
}

/// A sentence for the place of a plot without data.
fn nothing(strip: StripId, seen: &Seen<'_>) -> &'static str {
    let daemon = seen.model.info().daemon.as_ref();
    if strip.needs_samples() && daemon.is_some_and(|daemon| daemon.every_nth == 0) {
        return "Nothing: this gripper sends no samples here.";
    }
    if matches!(seen.model.status(), SourceStatus::Loading { .. }) {
        return "Nothing yet: the recording is being read.";
    }
    strip.nothing()
}

/// What a plot is called where it cannot be seen.
fn name(strip: StripId, seen: &Seen<'_>) -> String {
    let about = match strip {
        _ if !strip::has_data(strip, seen.model) => nothing(strip, seen).to_owned(),
        StripId::Statistic => strips::interval_text(seen),
        _ => String::new(),
    };
    format!("{} plot {about}", strip.title()).trim_end().to_owned()
}

fn draw(
    ui: &mut Ui,
    strip: StripId,
    frame: &Frame,
    wanted: &[Curve],
    seen: &Seen<'_>,
    scratch: &mut Scratch,
) -> Response {
    let unit = match strip {
        StripId::Spectrogram => "Hz",
        _ => strips::unit(wanted, seen),
    };
    super::ground(ui.painter(), frame.rect, &seen.palette);
    let is_picture = !strip.has_curves(seen.model);
    if !is_picture {
        strips::washes(ui.painter(), frame, &scratch.pieces, &seen.palette);
    }
    let inside = plot::show(ui, (strip, "plot"), frame, unit, |plot| {
        strips::curves(plot, frame, wanted, seen);
        match strip {
            StripId::Stylus => strips::turns(plot, frame, seen),
            StripId::Statistic => strips::interval(plot, frame, seen),
            _ => {}
        }
    });
    if !strip::has_data(strip, seen.model) {
        empty(ui, frame.rect, nothing(strip, seen), &seen.palette);
    } else if is_picture && strip == StripId::Spectrogram {
        spectrogram::draw(ui, frame, seen, scratch);
    } else if is_picture {
        pressure::draw(ui, frame, seen, scratch);
    }
    strips::words(ui.painter(), strip, frame, seen);
    inside
}

fn title(ui: &Ui, rect: Rect, strip: StripId, seen: &Seen<'_>) {
    let palette = &seen.palette;
    let text = match strip {
        StripId::Stylus => seen.model.info().stylus_title(),
        _ => strip.title().to_owned(),
    };
    let galley = ui.painter().layout_no_wrap(text, FontId::proportional(11.0), palette.text);
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
fn edge(ui: &Ui, plot: &StripLayout, rect: Rect, seen: &Seen<'_>, state: &mut ViewState) {
    let zone = Rect::from_x_y_ranges(rect.x_range(), rect.bottom()..=rect.bottom() + BETWEEN);
    let response = ui.interact(zone, ui.scope_id().with((plot.plot, "edge")), Sense::drag());
    let title = format!("{} height", plot.plot.title());
    response.widget_info(|| WidgetInfo::labeled(Role::Splitter, true, &title));
    if response.hovered() || response.dragged() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeVertical);
        ui.painter().hline(zone.x_range(), zone.center().y, Stroke::new(1.0, seen.palette.weak));
    }
    let by = response.drag_delta().y / rect.height();
    if response.dragged() && by.is_finite() {
        let found = state.layout.plots.iter_mut().find(|other| other.plot == plot.plot);
        let height = (plot.height * (1.0 + by)).clamp(HEIGHTS.0, HEIGHTS.1);
        found.into_iter().for_each(|plot| plot.height = height);
    }
}

/// A sentence in an empty place.
pub fn empty(ui: &Ui, rect: Rect, text: &str, palette: &Palette) {
    let (painter, font) = (ui.painter(), FontId::proportional(12.0));
    painter.rect_filled(rect, 0, palette.plot);
    painter.text(rect.center(), Align2::CENTER_CENTER, text, font, palette.weak);
}
