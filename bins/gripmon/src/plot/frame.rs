//! Rectangle of the window with a time axis across and a scale of values up, and the plot in it.

use super::{Kind, Scale};
use crate::palette::{self, Palette};
use crate::{num, time};
use core::hash::Hash;
use core::ops::RangeInclusive;
use eframe::egui::{Align2, Painter, Rangef, Rect, Response, Sense, Stroke, Ui, UiBuilder, pos2};
use egui_plot::{AxisHints, GridMark, Plot, PlotUi};
use grip_scope::{Span, format};

/// Room left of a plot for the labels of its values (points).
pub const GUTTER: f32 = 66.0;
/// Points between two labels of an axis of values, at least.
const VALUE_STEP: f32 = 26.0;
/// Points between two labels of the time axis, at least.
const TIME_STEP: f32 = 96.0;
/// A label nearer to an edge than this has no room (points).
const EDGE: f32 = 6.0;
/// Labels and lines stand as far apart as the marks that are given, all of one strength.
const AS_GIVEN: Rangef = Rangef { min: 0.1, max: 0.2 };

/// Where samples stand.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The inside of the plot.
    pub rect: Rect,
    /// The time from its left to its right edge.
    pub span: Span,
    /// The values from its bottom to its top.
    pub scale: Scale,
}

impl Frame {
    /// Across the window, of a time.
    #[must_use]
    pub fn x(&self, t_s: f64) -> f32 {
        let share = (t_s - self.span.from_s) / (self.span.to_s - self.span.from_s);
        self.rect.left() + num::narrow(share.clamp(-10.0, 11.0)) * self.rect.width()
    }

    /// The time at a place across.
    #[must_use]
    pub fn time(&self, x: f32) -> f64 {
        let share = f64::from((x - self.rect.left()) / self.rect.width());
        self.span.from_s + share * (self.span.to_s - self.span.from_s)
    }

    /// Down the window, of a value.
    #[must_use]
    pub fn y(&self, value: f64) -> f32 {
        self.rect.bottom() - num::narrow(self.scale.place(value)) * self.rect.height()
    }

    /// Columns of pixels across.
    #[must_use]
    pub fn columns(&self, pixels_per_point: f32) -> usize {
        num::whole(f64::from(self.rect.width() * pixels_per_point)).clamp(1, 8192)
    }

    /// The span with its ends at whole multiples of a column, so that what is drawn of a curve that moves does not flicker, and how many
    /// columns that are.
    #[must_use]
    pub fn whole_columns(&self, pixels_per_point: f32) -> (Span, usize) {
        let columns = self.columns(pixels_per_point);
        let width_s = self.span.length_s() / num::count(columns);
        let first = (self.span.from_s / width_s).floor();
        if !(width_s > 0.0 && first.abs() < 1e12) {
            return (self.span, columns);
        }
        let from_s = first * width_s;
        (Span { from_s, to_s: from_s + width_s * num::count(columns + 1) }, columns + 1)
    }
}

/// Draws a plot without its contents and what `add` puts into it: grid, the labels of the values left of it, the unit beside them.
pub fn show<'a>(
    ui: &mut Ui,
    id: impl Hash + core::fmt::Debug,
    frame: &Frame,
    unit: &str,
    add: impl FnOnce(&mut PlotUi<'a>) + 'a,
) -> Response {
    let (Frame { rect, span, scale }, palette) = (*frame, Palette::now(ui.ctx()));
    let whole = Rect::from_min_max(pos2(rect.left() - GUTTER, rect.top()), rect.max);
    let mut child = ui.new_child(UiBuilder::new().max_rect(whole).id_salt(&id));
    let marks = scale.marks(num::whole(f64::from(rect.height() / VALUE_STEP)).clamp(2, 9));
    let (label, prefix) = scale.labels(&marks, unit);
    let axis = AxisHints::new_y()
        .min_thickness(GUTTER)
        .label_spacing(AS_GIVEN)
        .tick_label_font(palette::axis_font())
        .tick_label_color(palette.weak)
        .label(eframe::egui::RichText::new(prefix).size(11.0).color(palette.weak))
        .formatter(move |mark, range: &RangeInclusive<f64>| {
            let share = (mark.value - range.start()) / (range.end() - range.start());
            let edge = f64::from(EDGE / rect.height());
            if (edge..=1.0 - edge).contains(&share) { label(mark.value) } else { String::new() }
        });
    let plot = Plot::new("plot")
        .width(whole.width())
        .height(whole.height())
        .show_axes([false, true])
        .custom_y_axes(vec![axis])
        .x_grid_spacer(move |_| across(&frame_of(rect, span)))
        .y_grid_spacer(move |_| marks.clone())
        .grid_spacing(AS_GIVEN)
        .grid_color(palette.grid)
        .show_background(false)
        .show_crosshair(false)
        .show_x(false)
        .show_y(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .sense(Sense::click_and_drag());
    let shown = plot.show(&mut child, move |plot| {
        plot.set_plot_bounds_x(span.from_s..=span.to_s);
        plot.set_plot_bounds_y(scale.drawn(scale.low())..=scale.drawn(scale.high()));
        add(plot);
    });
    shown.response
}

fn frame_of(rect: Rect, span: Span) -> Frame {
    Frame { rect, span, scale: Scale::new(Kind::Linear, 0.0, 1.0) }
}

fn across(frame: &Frame) -> Vec<GridMark> {
    let found = ticks(frame);
    found.at.iter().map(|value| GridMark { value: *value, step_size: found.step }).collect()
}

fn ticks(frame: &Frame) -> time::Ticks {
    let most = num::whole(f64::from(frame.rect.width() / TIME_STEP)).clamp(2, 20);
    time::ticks(frame.span.from_s, frame.span.to_s, most)
}

/// Draws the labels of the times at the top of the frame's rectangle.
pub fn time_labels(painter: &Painter, frame: &Frame, palette: &Palette) {
    let (rect, ticks) = (frame.rect, ticks(frame));
    for &value in &ticks.at {
        let x = painter.round_to_pixel_center(frame.x(value));
        painter.vline(x, rect.top()..=rect.top() + 4.0, Stroke::new(1.0, palette.edge));
        let (at, text) = (pos2(x, rect.top() + 5.0), time::label(value, &ticks));
        painter.text(at, Align2::CENTER_TOP, text, palette::axis_font(), palette.weak);
    }
}

/// What stands at a place of an axis, and the unit with its prefix.
impl Scale {
    fn marks(&self, most: usize) -> Vec<GridMark> {
        let (places, step_size) = match self.kind() {
            Kind::Linear => {
                let found = time::ticks(self.low(), self.high(), most);
                (found.at, found.step)
            }
            Kind::Log => (time::decades(self.low(), self.high(), most), 1.0),
        };
        places.into_iter().map(|at| GridMark { value: self.drawn(at), step_size }).collect()
    }

    /// Factor and prefix in which all values of the axis are reported.
    pub(crate) fn prefix(&self, unit: &str) -> (f64, &'static str) {
        match self.kind() {
            Kind::Linear => format::prefix_of(self.low().abs().max(self.high().abs()), unit),
            Kind::Log => (1.0, ""),
        }
    }

    fn labels(&self, marks: &[GridMark], unit: &str) -> (impl Fn(f64) -> String + use<>, String) {
        let (kind, (factor, prefix)) = (self.kind(), self.prefix(unit));
        let step = marks.first().map_or(1.0, |mark| mark.step_size) / factor;
        let decimals = num::whole((-(step.log10() + 1e-9).floor()).max(0.0)).min(6);
        let label = move |drawn: f64| match kind {
            Kind::Log => power(drawn),
            // No minus before a zero.
            Kind::Linear if drawn.abs() < 0.1 * step * factor => format!("{:.*}", decimals, 0.0),
            Kind::Linear => format!("{:.*}", decimals, drawn / factor),
        };
        (label, format!("{prefix}{unit}"))
    }
}

/// A power of ten by its exponent.
fn power(exponent: f64) -> String {
    let value = 10f64.powf(exponent.round());
    if (0.0099..=1001.0).contains(&value) {
        format!("{}", (value * 100.0).round() / 100.0)
    } else {
        format!("1e{exponent:.0}")
    }
}
