//! What happened: a band that says whether the object is held, under it stretches of slips, faults and gaps, and a tick for every event.

use super::joined::{Piece, fill, joined};
use super::{Seen, axis, gestures, strips};
use crate::palette::{Palette, Tone};
use crate::plot::Frame;
use crate::state::ViewState;
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rangef, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2,
};
use grip_scope::format;
use grip_scope::model::Doing;
use grip_scope::{EventKind, EventMark};

/// Height of the lane (points).
pub(super) const HEIGHT: f32 = 48.0;
/// Height of the band that says what happens to the object (points).
const BAND: f32 = 15.0;
/// Events closer together than this share a tick (points).
const APART: f32 = 1.5;

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

/// How loud an event is: of those that stand at one place the loudest is reported.
const fn rank(kind: EventKind) -> u8 {
    match tone(kind) {
        Tone::Red => 5,
        Tone::Orange => 4,
        Tone::Blue => 3,
        Tone::Purple => 2,
        Tone::Green => 0,
        _ => 1,
    }
}

/// The louder one.
pub(super) const fn worst(a: EventKind, b: EventKind) -> EventKind {
    if rank(b) > rank(a) { b } else { a }
}

/// A tick, for one event or for several that cannot be distinguished.
#[derive(Clone, Copy, Debug)]
struct Tick<'a> {
    x: f32,
    /// The loudest, of equal ones the first.
    mark: &'a EventMark,
    count: u64,
}

/// The ticks of events in order of time: not more than the plot has points.
fn ticks<'a>(marks: impl Iterator<Item = &'a EventMark>, frame: &Frame) -> Vec<Tick<'a>> {
    let mut ticks: Vec<Tick<'a>> = Vec::new();
    for mark in marks {
        let x = frame.x(mark.t_s);
        match ticks.last_mut().filter(|last| x < last.x + APART) {
            Some(last) => {
                last.count += 1;
                if rank(mark.kind) > rank(last.mark.kind) {
                    last.mark = mark;
                }
            }
            None => ticks.push(Tick { x, mark, count: 1 }),
        }
    }
    ticks
}

pub(super) fn lane(
    ui: &Ui,
    rect: Rect,
    pieces: &[Piece<EventKind>],
    seen: &Seen<'_>,
    state: &mut ViewState,
) {
    let frame = axis::time_frame(rect, seen);
    let response = ui.interact(rect, ui.scope_id().with("lane"), Sense::click_and_drag());
    let ticks = ticks(seen.model.events().marks.within(frame.span), &frame);
    let count: u64 = ticks.iter().map(|tick| tick.count).sum();
    let reported =
        if count == 1 { "1 event".to_owned() } else { format!("{} events", format::count(count)) };
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(reported.clone()),
        ..WidgetInfo::labeled(Role::Figure, true, "Object and events")
    });
    let painter = ui.painter();
    super::ground(painter, rect, &seen.palette);
    names(ui, rect, &seen.palette);
    let beside = pos2(rect.right() + 12.0, rect.bottom() - 12.0);
    let font = crate::palette::axis_font();
    painter.text(beside, Align2::LEFT_CENTER, reported, font, seen.palette.weak);
    doings(ui, &frame, seen);
    stretches(ui, &frame, pieces, seen);
    marks(ui, &frame, &ticks, seen);
    strips::lines(painter, &frame, seen, state);
    gestures::over_plot(ui, &response, &frame, seen, state);
    if let Some(tick) = response.hover_pos().and_then(|at| nearest(&ticks, at.x)) {
        response.on_hover_text_at_pointer(about(&tick));
    }
}

/// The tick at the pointer.
fn nearest<'a>(ticks: &[Tick<'a>], pointer: f32) -> Option<Tick<'a>> {
    let away = |tick: &Tick<'_>| (tick.x - pointer).abs();
    let near = ticks.iter().filter(|tick| away(tick) < 7.0);
    near.min_by(|a, b| away(a).total_cmp(&away(b))).copied()
}

fn about(tick: &Tick<'_>) -> String {
    let Tick { mark, count, .. } = tick;
    let more = match count - 1 {
        0 => String::new(),
        1 => "\nand another event here".to_owned(),
        more => format!("\nand {} more events here", format::count(more)),
    };
    format!("{} at {:.4} s\n{}{more}", mark.kind.name(), mark.t_s, mark.text)
}

fn names(ui: &Ui, rect: Rect, palette: &Palette) {
    let font = FontId::proportional(11.0);
    let x = rect.left() - 6.0;
    let label = |y: f32, text: &str| {
        ui.painter().text(pos2(x, y), Align2::RIGHT_CENTER, text, font.clone(), palette.weak)
    };
    label(rect.top() + BAND / 2.0, "object");
    label(rect.top() + BAND + (HEIGHT - BAND) / 2.0, "events");
}

fn colour(doing: Doing, palette: &Palette) -> Color32 {
    let tone = match doing {
        Doing::Idle => return palette.grid,
        Doing::Moving => Tone::Sky,
        Doing::Held => Tone::Green,
        Doing::Slipping => Tone::Orange,
        Doing::Crushed | Doing::Dropped => Tone::Red,
    };
    palette.tone(tone).gamma_multiply(if palette.dark { 0.55 } else { 0.38 })
}

/// The band that says what happens to the object.
fn doings(ui: &Ui, frame: &Frame, seen: &Seen<'_>) {
    let band = Rect::from_min_size(frame.rect.min, vec2(frame.rect.width(), BAND));
    let pieces = joined(seen.model.events().doings.within(frame.span), frame, Doing::max);
    let painter = ui.painter();
    let coloured = pieces.iter().map(|piece| (piece.across, colour(piece.what, &seen.palette)));
    fill(painter, band.y_range(), coloured);
    for piece in pieces.iter().filter(|piece| piece.across.span() > 50.0) {
        let at = pos2(piece.across.min + 5.0, band.center().y);
        let (name, font) = (piece.what.name(), FontId::proportional(11.0));
        painter.text(at, Align2::LEFT_CENTER, name, font, seen.palette.text);
    }
}

/// Bars under the scenes: slips, faults and gaps as long as they last.
fn stretches(ui: &Ui, frame: &Frame, pieces: &[Piece<EventKind>], seen: &Seen<'_>) {
    let top = frame.rect.top() + BAND + 2.0;
    let faults = joined(seen.model.events().faults.within(frame.span), frame, worst);
    let coloured = pieces.iter().chain(&faults);
    let coloured = coloured.map(|piece| (piece.across, seen.palette.tone(tone(piece.what))));
    fill(ui.painter(), Rangef::new(top, top + 6.0), coloured);
}

/// Ticks and, where there is room, words.
fn marks(ui: &Ui, frame: &Frame, ticks: &[Tick<'_>], seen: &Seen<'_>) {
    let painter = ui.painter().with_clip_rect(frame.rect);
    let height = Rangef::new(frame.rect.top() + BAND + 10.0, frame.rect.bottom());
    let line = |tick: &Tick<'_>| {
        let x = painter.round_to_pixel_center(tick.x);
        (Rangef::new(x - 0.75, x + 0.75), seen.palette.tone(tone(tick.mark.kind)))
    };
    fill(&painter, height, ticks.iter().map(line));
    let mut free_from = f32::NEG_INFINITY;
    for tick in ticks {
        if tick.x >= free_from {
            let at = pos2(tick.x + 3.0, frame.rect.bottom() - 11.0);
            free_from = word(&painter, at, tick.mark, &seen.palette) + 6.0;
        }
    }
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

#[cfg(test)]
mod tests {
    use super::{about, nearest, ticks};
    use crate::plot::{Frame, Kind, Scale};
    use eframe::egui::{Rect, pos2};
    use grip_scope::{EventKind, EventMark, Span};

    #[test]
    fn however_many_events_there_are_each_counts_and_the_loudest_of_a_place_is_reported() {
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(1000.0, 48.0));
        let span = Span { from_s: 0.0, to_s: 20.0 };
        let frame = Frame { rect, span, scale: Scale::new(Kind::Linear, 0.0, 1.0) };
        let mark = |k: u32| {
            let kind = if k == 19_000 { EventKind::Fault } else { EventKind::Client };
            EventMark::plain(1e-3 * f64::from(k), kind, k.to_string())
        };
        let marks: Vec<EventMark> = (0..20_000).map(mark).collect();
        let ticks = ticks(marks.iter(), &frame);
        assert!(ticks.len() <= 667 && ticks.len() > 300, "{}", ticks.len());
        assert_eq!(ticks.iter().map(|tick| tick.count).sum::<u64>(), 20_000);
        // The newest are there as well as the oldest.
        assert!(ticks[0].x < 1.0 && ticks[ticks.len() - 1].x > 998.0);
        let loud = ticks.iter().find(|tick| tick.mark.kind == EventKind::Fault).unwrap();
        assert!((948.0..=950.0).contains(&loud.x), "{loud:?}");
        let reported = about(&nearest(&ticks, loud.x).unwrap());
        assert!(reported.starts_with("fault at 19.0000 s\n19000\nand "), "{reported}");
        assert!(nearest(&ticks, 5000.0).is_none());
    }
}
