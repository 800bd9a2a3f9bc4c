//! Picture of data on the graphics card, made anew only where a change in what it shall show can be seen.

use crate::num;
use crate::plot::Frame;
use eframe::egui::{Color32, ColorImage, Rect, TextureHandle, TextureOptions, Ui, pos2};
use grip_scope::Span;

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shows {
    /// From its left to its right edge.
    pub(super) span: Span,
    /// Time of the newest data in it (s); minus infinity where there are none.
    pub(super) newest_s: f64,
    /// Columns of pixels.
    pub(super) wide: usize,
}

impl Shows {
    /// Whether a picture of the one can stand for the other: nothing has moved by a column of pixels. An hour that is followed is made anew
    /// every some seconds, and not thirty times in each.
    fn fits(&self, other: &Self) -> bool {
        let column_s = self.span.length_s() / num::count(self.wide.max(1));
        let near = |a: f64, b: f64| a == b || (a - b).abs() < column_s;
        self.wide == other.wide
            && near(self.span.from_s, other.span.from_s)
            && near(self.span.to_s, other.span.to_s)
            && near(self.newest_s, other.newest_s)
    }
}

/// A picture on the graphics card and what it shows.
#[derive(Default)]
pub(super) struct Picture {
    texture: Option<TextureHandle>,
    shows: Option<Shows>,
}

impl Picture {
    /// Draws what is asked for into the frame.
    pub(super) fn draw(
        &mut self,
        ui: &Ui,
        frame: &Frame,
        shows: Shows,
        make: impl FnOnce() -> ColorImage,
    ) {
        let shown = match self.shows.filter(|shown| shown.fits(&shows)) {
            Some(shown) => shown,
            None => {
                self.make(ui, make());
                self.shows = Some(shows);
                shows
            }
        };
        let Some(texture) = &self.texture else { return };
        // It stands where its own times are.
        let across = frame.x(shown.span.from_s)..=frame.x(shown.span.to_s);
        let rect = Rect::from_x_y_ranges(across, frame.rect.y_range());
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(frame.rect));
        painter.image(texture.id(), rect, whole, Color32::WHITE);
    }

    fn make(&mut self, ui: &Ui, image: ColorImage) {
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::NEAREST),
            None => {
                let texture = ui.ctx().load_texture("picture", image, TextureOptions::NEAREST);
                self.texture = Some(texture);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Shows;
    use grip_scope::Span;

    #[test]
    fn a_picture_stands_until_something_moves_by_a_column() {
        let shows = |from_s, to_s, newest_s| {
            let span = Span { from_s, to_s };
            Shows { span, newest_s, wide: 1200 }
        };
        let hour = shows(0.0, 3600.0, 3600.0);
        assert!(hour.fits(&shows(0.033, 3600.033, 3600.033)));
        assert!(hour.fits(&shows(0.0, 3602.9, 3602.9)));
        assert!(!hour.fits(&shows(3.1, 3603.1, 3603.1)));
        assert!(!hour.fits(&shows(0.0, 3604.0, 3604.0)));
        // Data that arrive within a view that stands still.
        assert!(!hour.fits(&shows(0.0, 3600.0, 3596.0)));
        assert!(!hour.fits(&Shows { wide: 1201, ..hour }));
        let none = shows(0.0, 5.0, f64::NEG_INFINITY);
        assert!(none.fits(&none) && !none.fits(&shows(0.0, 5.0, 0.1)));
    }
}
