//! What the grasp did, and what happened: a band of scenes, under it stretches of slips, faults and gaps, and a tick for every event.

use super::{Seen, gestures, strips};
use crate::action::Action;
use crate::palette::{Palette, Tone};
use crate::plot::{Frame, Kind, Scale};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};
use grip_link::message::daemon::SceneCode;
use grip_scope::{EventKind, EventMark};

/// Height of the lane (points).
pub(super) const HEIGHT: f32 = 48.0;
/// Height of the band of scenes (points).
const SCENES: f32 = 15.0;
/// Up to so many events have a tick of their own.
const MOST: usize = 600;

/// The tone of an event.
#[must_use]
pub(super) const fn tone(kind: EventKind) -> Tone {
    match kind {
        EventKind::Incipient => Tone::Orange,
        EventKind::Gross | EventKind::Fault => Tone::Red,
        EventKind::Ended | EventKind::Recovered => Tone::Green,
        EventKind::Reflex => Tone::Blue,
        EventKind::Client | EventKind::Marker => Tone::Purple,
        _ => Tone::Quiet,
    }
}

pub(super) fn lane(ui: &Ui, rect: Rect, seen: &Seen<'_>) -> Vec<Action> {
    let frame = Frame { rect, span: seen.span, scale: Scale::new(Kind::Linear, 0.0, 1.0) };
    let response = ui.interact(rect, ui.scope_id().with("lane"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Figure, true, "Scenes and events"));
    let painter = ui.painter();
    painter.rect(
        rect,
        0,
        seen.palette.plot,
        Stroke::new(1.0, seen.palette.edge),
        eframe::egui::StrokeKind::Outside,
    );
    names(ui, rect, &seen.palette);
    scenes(ui, &frame, seen);
    stretches(ui, &frame, seen);
    let nearest = marks(ui, &frame, seen, response.hover_pos().map(|at| at.x));
    strips::lines(painter, &frame, seen);
    let actions = gestures::over_plot(ui, &response, &frame, seen);
    if let Some(mark) = nearest {
        let text = format!("{} at {:.4} s\n{}", mark.kind.name(), mark.t_s, mark.text);
        response.on_hover_text_at_pointer(text);
    }
    actions
}

fn names(ui: &Ui, rect: Rect, palette: &Palette) {
    let font = FontId::proportional(11.0);
    let x = rect.left() - 6.0;
    let label = |y: f32, text: &str| {
        ui.painter().text(pos2(x, y), Align2::RIGHT_CENTER, text, font.clone(), palette.weak)
    };
    label(rect.top() + SCENES / 2.0, "scene");
    label(rect.top() + SCENES + (HEIGHT - SCENES) / 2.0, "events");
}

const fn scene_colour(scene: SceneCode, palette: &Palette) -> (Color32, bool) {
    match scene {
        SceneCode::Idle => (palette.grid, false),
        SceneCode::Moving => (palette.tone(Tone::Sky), true),
        SceneCode::Holding => (palette.tone(Tone::Green), true),
        SceneCode::Slipping => (palette.tone(Tone::Red), true),
        _ => (palette.tone(Tone::Quiet), true),
    }
}

fn scenes(ui: &Ui, frame: &Frame, seen: &Seen<'_>) {
    let band = Rect::from_min_size(frame.rect.min, vec2(frame.rect.width(), SCENES));
    for stretch in seen.model.events().scenes(frame.span) {
        let (left, right) = (frame.x(stretch.span.from_s), frame.x(stretch.span.to_s));
        let across = left.max(band.left())..=right.min(band.right()).max(left.max(band.left()));
        let rect = Rect::from_x_y_ranges(across, band.y_range());
        let (colour, strong) = scene_colour(stretch.what, &seen.palette);
        let fill = if strong {
            colour.gamma_multiply(if seen.palette.dark { 0.55 } else { 0.38 })
        } else {
            colour
        };
        ui.painter().rect_filled(rect, 0, fill);
        if rect.width() > 50.0 {
            let font = FontId::proportional(10.5);
            ui.painter().text(
                rect.left_center() + vec2(5.0, 0.0),
                Align2::LEFT_CENTER,
                stretch.what.name(),
                font,
                seen.palette.text,
            );
        }
    }
}

/// Bars under the scenes: slips, faults and gaps as long as they last.
fn stretches(ui: &Ui, frame: &Frame, seen: &Seen<'_>) {
    let events = seen.model.events();
    let top = frame.rect.top() + SCENES + 2.0;
    let all =
        events.slips(frame.span).chain(events.faults(frame.span)).chain(events.gaps(frame.span));
    for stretch in all {
        let across = strips::stretch(frame, stretch.span).x_range();
        let rect = Rect::from_x_y_ranges(across, top..=top + 6.0);
        ui.painter().rect_filled(rect, 0, seen.palette.tone(tone(stretch.what)));
    }
}

/// Ticks and, where there is room, words; the event nearest to the pointer.
fn marks<'a>(
    ui: &Ui,
    frame: &Frame,
    seen: &Seen<'a>,
    pointer: Option<f32>,
) -> Option<&'a EventMark> {
    let mut nearest: Option<(f32, &EventMark)> = None;
    let painter = ui.painter().with_clip_rect(frame.rect);
    let all = || seen.model.events().in_span(frame.span).take(MOST);
    for mark in all() {
        let x = frame.x(mark.t_s);
        let colour = seen.palette.tone(tone(mark.kind));
        let y = frame.rect.top() + SCENES + 10.0..=frame.rect.bottom();
        painter.vline(painter.round_to_pixel_center(x), y, Stroke::new(1.5, colour));
        let away = pointer.map_or(f32::INFINITY, |pointer| (pointer - x).abs());
        if away < 7.0 && nearest.is_none_or(|(best, _)| away < best) {
            nearest = Some((away, mark));
        }
    }
    let mut free_from = f32::NEG_INFINITY;
    for mark in all() {
        let x = frame.x(mark.t_s);
        if x >= free_from {
            free_from =
                word(&painter, pos2(x + 3.0, frame.rect.bottom() - 11.0), mark, &seen.palette)
                    + 6.0;
        }
    }
    nearest.map(|(_, mark)| mark)
}

/// The word of an event over the ticks of those right behind it; where it ends.
fn word(painter: &Painter, at: Pos2, mark: &EventMark, palette: &Palette) -> f32 {
    let text = mark.kind.name().to_owned();
    let galley = painter.layout_no_wrap(text, FontId::proportional(10.5), palette.text);
    let place = Rect::from_min_size(pos2(at.x, at.y - galley.size().y / 2.0), galley.size());
    painter.rect_filled(place.expand2(vec2(1.0, 0.0)), 2, palette.plot.gamma_multiply(0.85));
    painter.galley(place.min, galley, palette.text);
    place.right()
}
