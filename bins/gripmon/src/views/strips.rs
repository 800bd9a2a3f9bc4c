//! Curves of a plot: what of them is drawn, their scale, peaks and valleys, cursors.

use super::joined::{Piece, fill, joined};
use super::{Seen, lane, readout};
use crate::palette::{Palette, Tone};
use crate::plot::{self, DASHED, Frame, Kind, Scale};
use crate::state::ViewState;
use crate::strip::{Curve, StripId, enclosure};
use eframe::egui::{Align2, FontId, Painter, Rect, Stroke};
use egui_plot::{HLine, MarkerShape, PlotPoint, PlotPoints, PlotUi, Points};
use grip_scope::feed::ObserverSettings;
use grip_scope::{Channel, EventKind, Series, Span};

/// Up to so many samples of a curve are drawn one by one.
const FEW: usize = 700;
/// Up to so many peaks and valleys are drawn.
const TURNS: usize = 400;
/// Least band energy over its floor that an axis goes down to.
const LEAST_LOG: f64 = 1e-3;
/// Extremes up to so many times the rms need no second look: a lone reading among thousands stands further out.
const USUAL: f64 = 30.0;
/// Nor do values below this (units of the channel), which some sensor may send.
const LARGE: f64 = 1e9;
/// The upper edge of the needed force is seen up to so many times the highest curve.
const MOST_FAN: f64 = 1.5;

/// The scale of a plot: what is seen of its curves.
pub(super) fn scale(strip: StripId, curves: &[Curve], seen: &Seen<'_>) -> Scale {
    let mut range: Option<(f64, f64)> = None;
    let mut join = |low: f64, high: f64| {
        range = Some(range.map_or((low, high), |(l, h): (f64, f64)| (l.min(low), h.max(high))));
    };
    for curve in curves.iter().filter(|curve| curve.channel != Channel::ForceLimit) {
        let found = seen.model.series(curve.channel).and_then(|series| extremes(series, seen.span));
        if let Some((low, high)) = found {
            join(f64::from(low), f64::from(high));
        }
    }
    match strip {
        StripId::Statistic => {
            let [low, high] = seen.model.info().evidence_axis();
            Scale::around(Kind::Log, low, high)
        }
        StripId::Bands => {
            join(1.0, 2.0);
            let (low, high) = range.unwrap_or((0.1, 10.0));
            Scale::around(Kind::Log, low.max(high * 1e-7).max(LEAST_LOG), high)
        }
        StripId::Force => {
            join(0.0, 1.0);
            let (low, mut high) = range.unwrap_or((0.0, 10.0));
            // Of an object that nothing is known of the fan is wide: it does not press the forces down.
            let fan = seen.model.series(Channel::NeedHigh);
            if let Some((_, fan_n)) = fan.and_then(|series| extremes(series, seen.span)) {
                high = high.max(f64::from(fan_n).min(MOST_FAN * high));
            }
            Scale::around(Kind::Linear, low, high)
        }
        _ => {
            let (low, high) = range.unwrap_or((0.0, 1.0));
            Scale::around(strip.kind(), low, high)
        }
    }
}

/// Least and greatest value that an axis should show. Where no extreme stands far out of the rms it is taken as it is, which costs a tenth of
/// looking for single readings that no sensor sends.
pub(super) fn extremes(series: &Series, span: Span) -> Option<(f32, f32)> {
    // Of a recording that is still being loaded only the look ahead knows the rest.
    let loaded_s = series.latest().map_or(f64::NEG_INFINITY, |(t_s, _)| t_s);
    if series.span().is_some_and(|all| all.to_s > loaded_s) {
        return series.robust_range(span);
    }
    let stats = series.stats(span)?;
    let greatest = f64::from(stats.max.abs().max(stats.min.abs()));
    if greatest <= USUAL * stats.rms && stats.rms < LARGE {
        return Some((stats.min, stats.max));
    }
    series.robust_range(span)
}

/// Puts the curves of a plot into it, at most two points of each for a column of pixels; behind each the wash between its bounds.
pub(super) fn curves(plot: &mut PlotUi<'_>, frame: &Frame, wanted: &[Curve], seen: &Seen<'_>) {
    let (span, columns) = frame.whole_columns(plot.ctx().pixels_per_point());
    let buckets = |series: &Series| {
        let mut found = Vec::new();
        series.envelope(span, columns, &mut found);
        found
    };
    let known = |channel| seen.model.series(channel);
    for curve in wanted {
        let bounds = enclosure(curve.channel);
        if let Some((low, high)) = bounds.and_then(|(low, high)| known(low).zip(known(high))) {
            let ends = [&*buckets(low), &*buckets(high)];
            plot::area(plot, frame, ends, seen.palette.wash(curve.tone));
        }
    }
    for curve in wanted {
        let Some(series) = known(curve.channel) else { continue };
        let mut points = Vec::new();
        if !series.points(frame.span, FEW, &mut points) {
            points = plot::runs(&buckets(series));
        }
        plot::line(plot, frame, &points, (seen.palette.tone(curve.tone), curve.style));
    }
}

/// Peaks and valleys of the stylus as the observer has them, where they are few enough to be distinguished.
pub(super) fn turns(plot: &mut PlotUi<'_>, frame: &Frame, seen: &Seen<'_>) {
    let found = seen.model.turns(frame.span, TURNS);
    for (is_peak, shape, tone) in
        [(true, MarkerShape::Down, Tone::Red), (false, MarkerShape::Up, Tone::Green)]
    {
        let some = found.iter().filter(|turn| turn.is_peak == is_peak);
        let some = some.map(|turn| PlotPoint::new(turn.t_s, f64::from(turn.height)));
        let points = Points::new("", PlotPoints::Owned(some.collect()));
        let points = points.shape(shape).radius(3.5).color(seen.palette.tone(tone));
        plot.points(points.allow_hover(false));
    }
}

/// A line across the plot where evidence is a slip.
pub(super) fn interval(plot: &mut PlotUi<'_>, frame: &Frame, seen: &Seen<'_>) {
    let at = frame.scale.drawn(seen.model.info().interval_s().into());
    let stroke = Stroke::new(1.2, seen.palette.tone(Tone::Red));
    plot.hline(HLine::new("", at).stroke(stroke).style(DASHED).allow_hover(false));
}

/// What is written at the right edge of a plot: the interval at its line, the limit of the force where that is above the plot, whose forces
/// decide its scale.
pub(super) fn words(painter: &Painter, strip: StripId, frame: &Frame, seen: &Seen<'_>) {
    let limit_n = || readout::value(Channel::ForceLimit, seen);
    let (y, text) = match strip {
        StripId::Statistic => {
            (frame.y(seen.model.info().interval_s().into()) + 1.0, interval_text(seen))
        }
        StripId::Force => {
            let Some(limit_n) = limit_n().filter(|n| *n > frame.scale.high()) else { return };
            let limit = grip_scope::format::with_unit(limit_n, "N");
            (frame.rect.top() + 2.0, format!("limit {limit} is above"))
        }
        _ => return,
    };
    if frame.rect.y_range().contains(y) {
        let at = eframe::egui::pos2(frame.rect.right() - 4.0, y);
        let colour = seen.palette.tone(Tone::Red);
        painter.text(at, Align2::RIGHT_TOP, text, FontId::proportional(10.0), colour);
    }
}

/// Cursors, the pointer's line, the stretch that is being dragged over, gaps and slips, through the whole height of a plot.
pub(super) fn lines(painter: &Painter, frame: &Frame, seen: &Seen<'_>, state: &ViewState) {
    let inside = painter.with_clip_rect(painter.clip_rect().intersect(frame.rect));
    let line = |t_s: f64, stroke: Stroke| {
        inside.vline(inside.round_to_pixel_center(frame.x(t_s)), frame.rect.y_range(), stroke)
    };
    if let (Some(from_s), Some(to_s)) = (state.select_s, state.hover_s) {
        let selected = stretch(frame, Span::new(from_s, to_s));
        inside.rect_filled(selected, 0, seen.palette.wash(Tone::Blue));
    }
    if let Some(between) = state.between() {
        inside.rect_filled(stretch(frame, between), 0, seen.palette.cursor.gamma_multiply(0.045));
    }
    if let Some(t_s) = state.hover_s {
        line(t_s, Stroke::new(1.0, seen.palette.weak.gamma_multiply(0.6)));
    }
    for t_s in state.cursors.into_iter().flatten() {
        line(t_s, Stroke::new(1.2, seen.palette.cursor));
    }
}

/// Slips and gaps, the same in the lane and behind the curves of every plot: they are looked for once.
pub(super) fn pieces(frame: &Frame, seen: &Seen<'_>) -> Vec<Piece<EventKind>> {
    let events = seen.model.events();
    let slips = joined(events.slips.within(frame.span), frame, lane::worst);
    let gaps = joined(events.gaps.within(frame.span), frame, lane::worst);
    slips.into_iter().chain(gaps).collect()
}

/// Draws them behind curves.
pub(super) fn washes(
    painter: &Painter,
    frame: &Frame,
    pieces: &[Piece<EventKind>],
    palette: &Palette,
) {
    let colour = |kind| match kind {
        EventKind::Gross => palette.tone(Tone::Red).gamma_multiply(0.10),
        EventKind::Gap => palette.tone(Tone::Quiet).gamma_multiply(0.22),
        _ => palette.tone(Tone::Orange).gamma_multiply(0.10),
    };
    let coloured = pieces.iter().map(|piece| (piece.across, colour(piece.what)));
    fill(painter, frame.rect.y_range(), coloured);
}

/// What that line is called: also whether the source does not show its settings.
pub(super) fn interval_text(seen: &Seen<'_>) -> String {
    let info = seen.model.info();
    let whose = match info.observer {
        Some(ObserverSettings::Source { .. }) => "",
        Some(ObserverSettings::Shipped) | None => " of the shipped settings",
    };
    format!("interval {} s{whose}", info.interval_s())
}

/// A stretch of time over the height of a plot, at least one point wide.
pub(super) fn stretch(frame: &Frame, span: Span) -> Rect {
    let (left, right) = (frame.x(span.from_s), frame.x(span.to_s));
    let right = right.max(left + 1.0);
    let across = left.max(frame.rect.left())..=right.min(frame.rect.right());
    Rect::from_x_y_ranges(across, frame.rect.y_range())
}

/// The unit of a plot's axis.
pub(super) fn unit(curves: &[Curve], seen: &Seen<'_>) -> &'static str {
    curves.first().map(|curve| seen.model.info().unit(curve.channel)).unwrap_or_default()
}
