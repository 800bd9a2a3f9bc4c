//! A rectangle of the window with a time axis across and a scale of values up; where a sample stands out.

use super::{Kind, Scale};
use crate::{
    num,
    palette::{self, Palette},
    time,
};
use eframe::egui::{Align2, Painter, Pos2, Rect, Stroke, pos2};
use grip_scope::Span;
use grip_scope::format;

/// Points between two labels of an axis of values, at least.
const VALUE_STEP: f32 = 26.0;
/// Points between two labels of the time axis, at least.
const TIME_STEP: f32 = 96.0;

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

    /// Where a sample stands.
    #[must_use]
    pub fn at(&self, t_s: f64, value: f64) -> Pos2 {
        pos2(self.x(t_s), self.y(value))
    }

    /// Columns of pixels across.
    #[must_use]
    pub fn columns(&self, pixels_per_point: f32) -> usize {
        num::whole(f64::from(self.rect.width() * pixels_per_point)).clamp(1, 8192)
    }
}

/// Draws background, border, grid and the labels of the values, left of the plot.
pub fn value_axis(painter: &Painter, frame: &Frame, unit: &str, palette: &Palette) {
    let rect = frame.rect;
    painter.rect(
        rect,
        CORNERS,
        palette.plot,
        Stroke::new(1.0, palette.edge),
        eframe::egui::StrokeKind::Outside,
    );
    let most = num::whole(f64::from(rect.height() / VALUE_STEP)).clamp(2, 9);
    let (places, decimals) = value_ticks(&frame.scale, most);
    let (factor, prefix) = match frame.scale.kind() {
        Kind::Linear => {
            format::prefix_of(frame.scale.low().abs().max(frame.scale.high().abs()), unit)
        }
        Kind::Log => (1.0, ""),
    };
    let decimals = decimals.map(|(step, _)| time::ticks(0.0, step / factor * 4.0, 4).decimals);
    for value in places {
        let y = frame.y(value);
        if y > rect.top() + 0.5 && y < rect.bottom() - 0.5 {
            painter.hline(rect.x_range(), painter.round_to_pixel_center(y), palette.grid_stroke());
        }
        let text = match decimals {
            Some(decimals) => {
                format!("{:.*}", decimals.min(6), no_minus_zero(value / factor, decimals))
            }
            None => power(value),
        };
        let y = y.clamp(rect.top() + 5.0, rect.bottom() - 5.0);
        painter.text(
            pos2(rect.left() - 6.0, y),
            Align2::RIGHT_CENTER,
            text,
            palette::axis_font(),
            palette.weak,
        );
    }
    if !unit.is_empty() {
        let at = pos2(rect.left() - GUTTER + 4.0, rect.center().y);
        let text = format!("{prefix}{unit}");
        painter.text(at, Align2::LEFT_CENTER, text, palette::axis_font(), palette.weak);
    }
}

/// Room left of a plot for the labels of its values (points).
pub const GUTTER: f32 = 66.0;
const CORNERS: u8 = 0;

type Decimals = Option<(f64, usize)>;

fn value_ticks(scale: &Scale, most: usize) -> (Vec<f64>, Decimals) {
    match scale.kind() {
        Kind::Linear => {
            let found = time::ticks(scale.low(), scale.high(), most);
            (found.at, Some((found.step, found.decimals)))
        }
        Kind::Log => (time::decades(scale.low(), scale.high(), most), None),
    }
}

fn no_minus_zero(value: f64, decimals: usize) -> f64 {
    let least = 0.5 * 10f64.powi(-i32::try_from(decimals).unwrap_or(9));
    if value.abs() < least { 0.0 } else { value }
}

fn power(value: f64) -> String {
    if (0.0099..=1001.0).contains(&value) {
        format!("{value}")
    } else {
        format!("1e{:.0}", value.log10())
    }
}

/// What stands across a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Times, in seconds or as on a clock.
    Time,
    /// Plain numbers.
    Numbers,
}

/// Draws the vertical grid of a time axis, and its labels below the plot where `labelled`.
pub fn time_axis(painter: &Painter, frame: &Frame, labelled: bool, palette: &Palette) {
    if labelled {
        labels(painter, frame, Across::Time, palette);
    } else {
        grid(painter, frame, palette);
    }
}

/// Draws the vertical grid of a plot.
pub fn grid(painter: &Painter, frame: &Frame, palette: &Palette) {
    let rect = frame.rect;
    for &t_s in &across(frame).at {
        let x = painter.round_to_pixel_center(frame.x(t_s));
        if x > rect.left() + 0.5 && x < rect.right() - 0.5 {
            painter.vline(x, rect.y_range(), palette.grid_stroke());
        }
    }
}

/// Draws the labels of what stands across, at the top of the frame's rectangle.
pub fn labels(painter: &Painter, frame: &Frame, of: Across, palette: &Palette) {
    let (rect, ticks) = (frame.rect, across(frame));
    let text = match of {
        Across::Time => time::label,
        Across::Numbers => time::number,
    };
    for &value in &ticks.at {
        let x = painter.round_to_pixel_center(frame.x(value));
        painter.vline(x, rect.top()..=rect.top() + 4.0, Stroke::new(1.0, palette.edge));
        let at = pos2(x, rect.top() + 5.0);
        let text = text(value, &ticks);
        painter.text(at, Align2::CENTER_TOP, text, palette::axis_font(), palette.weak);
    }
}

fn across(frame: &Frame) -> time::Ticks {
    let most = num::whole(f64::from(frame.rect.width() / TIME_STEP)).clamp(2, 20);
    time::ticks(frame.span.from_s, frame.span.to_s, most)
}
