//! The pressure array: a row for each taxel over time, and the frame that is looked at as a small map.

use super::picture::Shows;
use super::{Scratch, Seen};
use crate::num;
use crate::palette::Palette;
use crate::plot::Frame;
use eframe::egui::{Color32, ColorImage, Rect, RichText, Sense, Ui, vec2};

/// Frames across the picture, at most.
const WIDE: usize = 400;

/// Taxels of the newest frame.
pub(super) fn count(seen: &Seen<'_>) -> f64 {
    num::count(seen.model.taxels(seen.span.to_s).map_or(1, |frame| frame.values.len()))
}

pub(super) fn draw(ui: &Ui, frame: &Frame, seen: &Seen<'_>, scratch: &mut Scratch) {
    let wide = frame.columns(1.0).min(WIDE);
    let newest_s = seen.model.taxels(frame.span.to_s).map_or(f64::NEG_INFINITY, |frame| frame.t_s);
    let shows = Shows { span: frame.span, newest_s, wide };
    scratch.pressure.draw(ui, frame, shows, || image(seen, frame, wide));
}

fn image(seen: &Seen<'_>, frame: &Frame, wide: usize) -> ColorImage {
    let first_s = seen.model.span().map_or(f64::INFINITY, |data| data.from_s);
    let end_s = seen.model.span().map_or(f64::NEG_INFINITY, |data| data.to_s);
    let at = |x: usize| {
        frame.span.from_s + (num::count(x) + 0.5) / num::count(wide) * frame.span.length_s()
    };
    let frames: Vec<_> = (0..wide)
        .map(|x| {
            Some(at(x)).filter(|t| (first_s..=end_s).contains(t)).and_then(|t| seen.model.taxels(t))
        })
        .collect();
    let high = frames.iter().flatten().map(|frame| frame.values.len()).max().unwrap_or(1);
    let (low, top) = range(frames.iter().flatten().flat_map(|frame| frame.values.iter()));
    let mut image = ColorImage::filled([wide, high], Color32::TRANSPARENT);
    for (x, found) in frames.iter().enumerate() {
        let Some(found) = found else { continue };
        for (taxel, value) in found.values.iter().enumerate().filter(|(_, value)| value.is_finite())
        {
            if let Some(pixel) = image.pixels.get_mut((high - 1 - taxel) * wide + x) {
                *pixel = Palette::heat((value - low) / (top - low));
            }
        }
    }
    image
}

/// Least and greatest finite reading, never the same.
fn range<'a>(values: impl Iterator<Item = &'a f32>) -> (f32, f32) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    if low < high {
        (low, high)
    } else if low.is_finite() {
        (low - 0.5, low + 0.5)
    } else {
        (0.0, 1.0)
    }
}

/// The frame at the time that is looked at, as square as its number of taxels allows.
pub(super) fn readout(ui: &mut Ui, seen: &Seen<'_>) {
    let Some(frame) = seen.model.taxels(seen.looked_at_s) else {
        ui.label(RichText::new("no frame").weak());
        return;
    };
    let (low, high) = range(frame.values.iter());
    let across = num::whole(num::count(frame.values.len()).sqrt().ceil()).max(1);
    let down = frame.values.len().div_ceil(across);
    let room = ui.available_size() - vec2(0.0, 17.0);
    let cells = vec2(num::narrow(num::count(across)), num::narrow(num::count(down.max(1))));
    let side = (room.x / cells.x).min(room.y / cells.y).clamp(3.0, 26.0);
    let (rect, _) = ui.allocate_exact_size(side * cells, Sense::hover());
    for (taxel, value) in frame.values.iter().enumerate() {
        let cell =
            vec2(num::narrow(num::count(taxel % across)), num::narrow(num::count(taxel / across)));
        let cell = Rect::from_min_size(rect.min + side * cell, vec2(side - 1.0, side - 1.0));
        let colour = if value.is_finite() {
            Palette::heat((value - low) / (high - low))
        } else {
            seen.palette.grid
        };
        ui.painter().rect_filled(cell, 1, colour);
    }
    let text = format!(
        "{} taxels, {} .. {}",
        frame.values.len(),
        grip_scope::format::number(low.into()),
        grip_scope::format::number(high.into())
    );
    ui.label(RichText::new(text).size(10.5).weak());
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn a_range_is_never_empty() {
        for values in [&[][..], &[1.0, 1.0], &[f32::NAN], &[f32::INFINITY, 2.0]] {
            let (low, high) = range(values.iter());
            assert!(low < high, "{values:?}");
        }
    }
}
