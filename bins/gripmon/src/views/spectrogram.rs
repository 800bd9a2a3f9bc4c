//! How strong each frequency of the stylus is over time, as a picture.

use super::picture::Shows;
use super::{Scratch, Seen};
use crate::num;
use crate::palette::Palette;
use crate::plot::Frame;
use eframe::egui::{Color32, ColorImage, RichText, Ui};
use grip_scope::Span;
use grip_scope::feed::{DB_STEP, SpectrumColumn};
use grip_scope::model::Timeline;

/// Widest picture (pixels).
const WIDE: usize = 1200;
/// Frequencies that become pixels together.
const TOGETHER: usize = 16;
/// From the strongest part of the picture to what is drawn darkest (dB).
const RANGE_DB: f32 = 66.0;

/// The highest frequency that the newest spectrum has (Hz).
pub(super) fn top_hz(seen: &Seen<'_>) -> f32 {
    let last = seen.model.spectrogram().within(seen.span).next_back();
    last.map_or(1000.0, |column| column.top_hz)
}

pub(super) fn draw(ui: &Ui, frame: &Frame, seen: &Seen<'_>, scratch: &mut Scratch) {
    let wide = frame.columns(ui.pixels_per_point()).min(WIDE);
    let spectra = seen.model.spectrogram();
    let newest = spectra.within(frame.span).next_back();
    let newest_s = newest.map_or(f64::NEG_INFINITY, |column| column.span[1]);
    let shows = Shows { span: frame.span, newest_s, wide };
    scratch.spectrogram.draw(ui, frame, shows, || image(spectra, frame.span, wide));
}

/// One row of pixels for each frequency, the highest on top, one column for each point across: of several spectra in it the strongest of each
/// frequency.
fn image(spectra: &Timeline<SpectrumColumn>, span: Span, wide: usize) -> ColorImage {
    let columns = || spectra.within(span);
    let high = columns().map(|column| column.bins.len()).max().unwrap_or(1);
    let place = |t_s: f64| {
        let share = (t_s - span.from_s) / span.length_s();
        num::whole((share * num::count(wide)).max(0.0)).min(wide)
    };
    // Bytes first, column by column, the lowest frequency first: 0 is nothing.
    let mut bytes = vec![0_u8; wide * high];
    for column in columns() {
        let from = place(column.span[0]).min(wide.saturating_sub(1));
        let to = place(column.span[1]).max(from + 1);
        for x in from..to {
            let there = bytes.get_mut(x * high..(x + 1) * high).unwrap_or_default();
            strongest(there, &column.bins);
        }
    }
    let top = bytes.chunks(high).flat_map(|column| column.iter().skip(2)).max();
    let top = top.copied().unwrap_or(0);
    let lut: Vec<Color32> = (0..=u8::MAX).map(|byte| colour(byte, top)).collect();
    ColorImage::new([wide, high], pixels(&bytes, wide, high, &lut))
}

/// What a byte looks like: 0 is nothing.
fn colour(byte: u8, top: u8) -> Color32 {
    if byte == 0 { Color32::TRANSPARENT } else { Palette::heat(level(byte, top)) }
}

/// Columns of bytes to rows of pixels, some frequencies of all columns at a time: what is read and written stays near.
fn pixels(bytes: &[u8], wide: usize, high: usize, lut: &[Color32]) -> Vec<Color32> {
    let mut pixels = vec![Color32::TRANSPARENT; wide * high];
    // Rows from the lowest frequency up.
    let mut rows: Vec<&mut [Color32]> = pixels.chunks_mut(wide.max(1)).rev().collect();
    for (part, rows) in rows.chunks_mut(TOGETHER).enumerate() {
        for (x, column) in bytes.chunks(high.max(1)).enumerate() {
            let some = column.get(part * TOGETHER..).unwrap_or_default();
            for (row, byte) in rows.iter_mut().zip(some) {
                if let (Some(pixel), Some(colour)) = (row.get_mut(x), lut.get(usize::from(*byte))) {
                    *pixel = *colour;
                }
            }
        }
    }
    pixels
}

/// The stronger one of each frequency; spectra of other lengths are stretched.
fn strongest(there: &mut [u8], bins: &[u8]) {
    let (high, len) = (there.len(), bins.len());
    if high == len {
        there.iter_mut().zip(bins).for_each(|(byte, bin)| *byte = (*byte).max(*bin).max(1));
        return;
    }
    for (y, byte) in there.iter_mut().enumerate() {
        let bin = bins.get(y * len / high.max(1)).copied().unwrap_or(0);
        *byte = (*byte).max(bin).max(1);
    }
}

fn level(byte: u8, strongest: u8) -> f32 {
    1.0 - f32::from(strongest.saturating_sub(byte)) * DB_STEP / RANGE_DB
}

pub(super) fn readout(ui: &mut Ui, seen: &Seen<'_>) {
    let spectra = seen.model.spectrogram();
    let at_s = seen.looked_at_s;
    let here = spectra.within(Span { from_s: at_s, to_s: at_s + 0.05 }).next();
    let Some(column) = here.or_else(|| spectra.within(seen.span).next_back()) else {
        ui.label(RichText::new("no spectrum").weak());
        return;
    };
    let bins = column.bins.iter().enumerate().skip(2);
    if let Some((bin, byte)) = bins.max_by_key(|(_, byte)| **byte) {
        let width_hz = f64::from(column.top_hz) / num::count(column.bins.len());
        super::row(
            ui,
            "strongest",
            grip_scope::format::with_unit((num::count(bin) + 0.5) * width_hz, "Hz"),
        );
        super::row(ui, "its power", format!("{:.0} dB", SpectrumColumn::db(*byte)));
    }
}

#[cfg(test)]
mod tests {
    use super::{SpectrumColumn, image, level};
    use eframe::egui::Color32;
    use grip_scope::feed::DerivedBlock;
    use grip_scope::{Feed, Model, Span};

    /// The brightness of each pixel, row by row from the top.
    fn brightness(spectra: Vec<SpectrumColumn>, span: Span, wide: usize) -> Vec<u32> {
        let mut model = Model::new(1 << 20);
        model.take(Feed::Derived(Box::new(DerivedBlock { spectra, ..DerivedBlock::default() })));
        let image = image(model.spectrogram(), span, wide);
        let bright = |pixel: &Color32| pixel.to_array()[..3].iter().map(|c| u32::from(*c)).sum();
        image.pixels.iter().map(bright).collect()
    }

    #[test]
    fn a_short_burst_among_many_spectra_of_a_column_is_seen_at_its_frequency_and_gaps_are_empty() {
        let spectrum = |k: u32| {
            let mut bins: Box<[u8]> = vec![100; 8].into();
            if k == 57 {
                bins[5] = 160;
            }
            let from_s = 0.01 * f64::from(k);
            SpectrumColumn { span: [from_s, from_s + 0.01], top_hz: 1000.0, bins }
        };
        let spectra = (0..100).filter(|k| !(20..40).contains(k)).map(spectrum).collect();
        let found = brightness(spectra, Span { from_s: 0.0, to_s: 1.0 }, 10);
        assert_eq!(found.len(), 80);
        let at = |x: usize, bin: usize| found[(7 - bin) * 10 + x];
        assert!(at(5, 5) > at(5, 4) && at(5, 5) > at(4, 5), "{found:?}");
        assert_eq!((at(2, 3), at(3, 3)), (0, 0));
        assert!(at(1, 3) > 0 && at(9, 3) > 0);
    }

    #[test]
    fn the_strongest_is_brightest_and_66_db_below_it_is_dark() {
        assert!((level(200, 200) - 1.0).abs() < 1e-6);
        assert!(level(200 - 44, 200).abs() < 0.01 && level(0, 200) < 0.0);
    }
}
