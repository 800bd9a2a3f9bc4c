//! How strong each frequency of the stylus is over time, as a picture.

use super::{Scratch, Seen};
use crate::num;
use crate::palette::Palette;
use crate::plot::Frame;
use eframe::egui::{Color32, ColorImage, Rect, RichText, TextureHandle, TextureOptions, Ui, pos2};
use grip_scope::Span;
use grip_scope::model::{DB_STEP, Spectrogram};

/// Widest picture (pixels).
const WIDE: usize = 1200;
/// From the strongest part of the picture to what is drawn darkest (dB).
const RANGE_DB: f32 = 66.0;

/// A picture on the graphics card and what it shows.
#[derive(Default)]
pub(super) struct Picture {
    texture: Option<TextureHandle>,
    shows: Option<(Span, u64, usize)>,
}

impl Picture {
    /// The texture of what is asked for, made anew where it shows something else.
    pub(super) fn of(
        &mut self,
        ui: &Ui,
        shows: (Span, u64, usize),
        make: impl FnOnce() -> ColorImage,
    ) -> Option<&TextureHandle> {
        if self.shows != Some(shows) || self.texture.is_none() {
            let image = make();
            match &mut self.texture {
                Some(texture) => texture.set(image, TextureOptions::NEAREST),
                None => {
                    self.texture =
                        Some(ui.ctx().load_texture("picture", image, TextureOptions::NEAREST))
                }
            }
            self.shows = Some(shows);
        }
        self.texture.as_ref()
    }
}

/// The highest frequency that the newest spectrum has (Hz).
pub(super) fn top_hz(seen: &Seen<'_>) -> f32 {
    let last = seen.model.spectrogram().in_span(seen.span).next_back();
    last.map_or(1000.0, |column| column.top_hz)
}

pub(super) fn draw(ui: &Ui, frame: &Frame, (seen, scratch): (&Seen<'_>, &mut Scratch)) {
    let wide = frame.columns(ui.pixels_per_point()).min(WIDE);
    let make = || image(seen.model.spectrogram(), frame, wide);
    let shows = (frame.span, seen.model.revision(), wide);
    if let Some(texture) = scratch.spectrogram.of(ui, shows, make) {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().image(texture.id(), frame.rect, whole, Color32::WHITE);
    }
}

/// One row of pixels for each frequency, the highest on top, one column for each point across.
fn image(spectra: &Spectrogram, frame: &Frame, wide: usize) -> ColorImage {
    let columns: Vec<_> = spectra.in_span(frame.span).collect();
    let high = columns.iter().map(|column| column.bins.len()).max().unwrap_or(1);
    let strongest =
        columns.iter().flat_map(|column| column.bins.iter().skip(2)).max().copied().unwrap_or(0);
    let lut: Vec<Color32> =
        (0..=u8::MAX).map(|byte| Palette::heat(level(byte, strongest))).collect();
    let mut image = ColorImage::filled([wide, high], Color32::TRANSPARENT);
    let place = |t_s: f64| {
        let share = (t_s - frame.span.from_s) / frame.span.length_s();
        num::whole((share * num::count(wide)).max(0.0)).min(wide)
    };
    for column in columns {
        let (from, to) = (place(column.span[0]), place(column.span[1]));
        let to = to.max(from + 1).min(wide);
        let bins = column.bins.len().max(1);
        for y in 0..high {
            let bin = (high - 1 - y) * bins / high;
            let byte = column.bins.get(bin).copied().unwrap_or(0);
            let colour = lut.get(usize::from(byte)).copied().unwrap_or(Color32::BLACK);
            if let Some(pixels) = image.pixels.get_mut(y * wide + from.min(to)..y * wide + to) {
                pixels.fill(colour);
            }
        }
    }
    image
}

fn level(byte: u8, strongest: u8) -> f32 {
    1.0 - f32::from(strongest.saturating_sub(byte)) * DB_STEP / RANGE_DB
}

pub(super) fn readout(ui: &mut Ui, seen: &Seen<'_>) {
    let spectra = seen.model.spectrogram();
    let at_s = seen.looked_at_s();
    let here = spectra.in_span(Span { from_s: at_s, to_s: at_s + 0.05 }).next();
    let Some(column) = here.or_else(|| spectra.in_span(seen.span).next_back()) else {
        ui.label(RichText::new("no spectrum").weak());
        return;
    };
    let bins = column.bins.iter().enumerate().skip(2);
    if let Some((bin, byte)) = bins.max_by_key(|(_, byte)| **byte) {
        let width_hz = f64::from(column.top_hz) / num::count(column.bins.len());
        super::row(
            ui,
            "strongest",
            crate::format::with_unit((num::count(bin) + 0.5) * width_hz, "Hz"),
        );
        super::row(ui, "its power", format!("{:.0} dB", Spectrogram::db(*byte)));
    }
}

#[cfg(test)]
mod tests {
    use super::level;

    #[test]
    fn the_strongest_is_brightest_and_66_db_below_it_is_dark() {
        assert!((level(200, 200) - 1.0).abs() < 1e-6);
        assert!(level(200 - 44, 200).abs() < 0.01 && level(0, 200) < 0.0);
    }
}
