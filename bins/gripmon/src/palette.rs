//! Everything about looks: the colours of both themes, sizes of text and spacing.
//!
//! Series take the colours of Okabe and Ito, which the colour-blind can distinguish, darkened on white and lightened on black until
//! each has a contrast of at least 3 to its background (a test measures it). A colour never stands alone: every series has its name beside
//! it, every event its word.

use eframe::egui::{
    self, Color32, CornerRadius, FontDefinitions, FontFamily, FontId, Margin, Stroke, TextStyle,
    Theme, Vec2,
};

/// What something drawn means; the theme decides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tone {
    /// First series of a plot.
    Blue,
    /// Second series, or a warning.
    Orange,
    /// Third series, or all is well.
    Green,
    /// Fourth series, a fault, or a limit.
    Red,
    /// Fifth series.
    Purple,
    /// Sixth series.
    Sky,
    /// Seventh series.
    Yellow,
    /// Something that is only background.
    Quiet,
}

/// The tones in which any number of like series follow each other.
pub const SERIES: [Tone; 7] =
    [Tone::Blue, Tone::Orange, Tone::Green, Tone::Purple, Tone::Sky, Tone::Red, Tone::Yellow];

/// The colours of one theme.
#[derive(Clone, Copy, Debug)]
pub struct Palette {
    /// Whether the background is dark.
    pub dark: bool,
    /// Bars and panels.
    pub panel: Color32,
    /// Inside of plots.
    pub plot: Color32,
    /// Grid lines.
    pub grid: Color32,
    /// Borders of plots.
    pub edge: Color32,
    /// Text.
    pub text: Color32,
    /// Labels and units.
    pub weak: Color32,
    /// Cursors A and B, and the pointer's line.
    pub cursor: Color32,
}

impl Palette {
    /// The palette of a theme.
    #[must_use]
    pub const fn of(theme: Theme) -> Self {
        match theme {
            Theme::Dark => Self {
                dark: true,
                panel: rgb(0x1b2129),
                plot: rgb(0x12171d),
                grid: rgb(0x252d37),
                edge: rgb(0x323c48),
                text: rgb(0xdbe1e8),
                weak: rgb(0x97a3b1),
                cursor: rgb(0xf2f5f8),
            },
            Theme::Light => Self {
                dark: false,
                panel: rgb(0xf3f5f7),
                plot: rgb(0xffffff),
                grid: rgb(0xe8ecf0),
                edge: rgb(0xcbd3db),
                text: rgb(0x1c242d),
                weak: rgb(0x5a6673),
                cursor: rgb(0x10161c),
            },
        }
    }

    /// The palette that a window shows now.
    #[must_use]
    pub fn now(ctx: &egui::Context) -> Self {
        Self::of(ctx.theme())
    }

    /// The colour of a tone.
    #[must_use]
    pub const fn tone(&self, tone: Tone) -> Color32 {
        let (light, dark) = match tone {
            Tone::Blue => (0x0072b2, 0x4aa8e0),
            Tone::Orange => (0xb87400, 0xe69f00),
            Tone::Green => (0x00805c, 0x2cbf94),
            Tone::Red => (0xc94f00, 0xf47b3d),
            Tone::Purple => (0xa8558a, 0xd98dbb),
            Tone::Sky => (0x2b86b5, 0x8ccbf0),
            Tone::Yellow => (0x877a00, 0xe3d840),
            Tone::Quiet => (0x7a8794, 0x7c8896),
        };
        rgb(if self.dark { dark } else { light })
    }

    /// The colour of a tone as a wash over a plot.
    #[must_use]
    pub fn wash(&self, tone: Tone) -> Color32 {
        self.tone(tone).gamma_multiply(if self.dark { 0.24 } else { 0.20 })
    }

    /// A line that is hardly there.
    #[must_use]
    pub const fn grid_stroke(&self) -> Stroke {
        Stroke { width: 1.0, color: self.grid }
    }

    /// Colours of levels 0 to 1 in a heat map: dark blue to yellow, even in lightness (after viridis: Smith and van der Walt).
    #[must_use]
    pub fn heat(level: f32) -> Color32 {
        const STEPS: [u32; 6] = [0x440154, 0x414487, 0x2a788e, 0x22a884, 0x7ad151, 0xfde725];
        let place = if level.is_nan() { 0.0 } else { level.clamp(0.0, 1.0) } * 5.0;
        let low = crate::num::whole(f64::from(place)).min(4);
        let share = place - crate::num::narrow(crate::num::count(low));
        let (from, to) = (rgb(STEPS[low]), rgb(STEPS[low + 1]));
        from.lerp_to_gamma(to, share)
    }
}

const fn rgb(hex: u32) -> Color32 {
    let [_, red, green, blue] = hex.to_be_bytes();
    Color32::from_rgb(red, green, blue)
}

/// Numbers of a plot's axis.
#[must_use]
pub const fn axis_font() -> FontId {
    FontId { size: 10.5, family: FontFamily::Monospace }
}

/// Numbers beside a plot.
#[must_use]
pub const fn number_font() -> FontId {
    FontId { size: 12.0, family: FontFamily::Monospace }
}

/// Puts both themes into a window; done once.
pub fn install(ctx: &egui::Context) {
    ctx.set_fonts(fonts());
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            shape(style);
            colour(&mut style.visuals, &Palette::of(theme));
        });
    }
}

/// The fonts of egui; signs that its font for text lacks, such as arrows, come from the one with equal widths.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let equal = fonts.families.get(&FontFamily::Monospace).cloned().unwrap_or_default();
    let text = fonts.families.entry(FontFamily::Proportional).or_default();
    let missing: Vec<String> = equal.into_iter().filter(|name| !text.contains(name)).collect();
    text.extend(missing);
    fonts
}

fn shape(style: &mut egui::Style) {
    let sizes = [
        (TextStyle::Small, FontId::proportional(10.5)),
        (TextStyle::Body, FontId::proportional(12.5)),
        (TextStyle::Button, FontId::proportional(12.5)),
        (TextStyle::Heading, FontId::proportional(14.5)),
        (TextStyle::Monospace, number_font()),
    ];
    style.text_styles = sizes.into_iter().collect();
    style.spacing.item_spacing = Vec2::new(6.0, 4.0);
    style.spacing.button_padding = Vec2::new(7.0, 2.0);
    style.spacing.interact_size.y = 21.0;
    style.spacing.window_margin = Margin::same(10);
    style.animation_time = 0.0;
    style.interaction.selectable_labels = false;
}

fn colour(visuals: &mut egui::Visuals, palette: &Palette) {
    visuals.panel_fill = palette.panel;
    visuals.window_fill = palette.panel;
    visuals.extreme_bg_color = palette.plot;
    visuals.faint_bg_color = palette.grid;
    visuals.window_stroke = Stroke::new(1.0, palette.edge);
    visuals.window_corner_radius = CornerRadius::same(5);
    visuals.override_text_color = None;
    visuals.weak_text_color = Some(palette.weak);
    visuals.warn_fg_color = palette.tone(Tone::Orange);
    visuals.error_fg_color = palette.tone(Tone::Red);
    visuals.hyperlink_color = palette.tone(Tone::Blue);
    visuals.selection.bg_fill = palette.tone(Tone::Blue).gamma_multiply(0.35);
    visuals.selection.stroke = Stroke::new(1.0, palette.text);
    let resting = palette.grid;
    let widgets = &mut visuals.widgets;
    for (state, fill, edge) in [
        (&mut widgets.noninteractive, palette.panel, palette.edge),
        (&mut widgets.inactive, resting, palette.edge),
        (&mut widgets.hovered, palette.edge, palette.weak),
        (&mut widgets.active, palette.edge, palette.text),
        (&mut widgets.open, resting, palette.weak),
    ] {
        state.bg_fill = fill;
        state.weak_bg_fill = fill;
        state.bg_stroke = Stroke::new(1.0, edge);
        state.fg_stroke = Stroke::new(1.0, palette.text);
        state.corner_radius = CornerRadius::same(3);
        state.expansion = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::{Palette, SERIES, Tone, install};
    use eframe::egui::{Color32, Context, FontId, RawInput, Rgba, Theme};

    /// Contrast of two colours as in WCAG 2.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let light = |colour| {
            let c = Rgba::from(colour);
            0.2126 * c.r() + 0.7152 * c.g() + 0.0722 * c.b() + 0.05
        };
        let (a, b) = (light(a), light(b));
        a.max(b) / a.min(b)
    }

    #[test]
    fn everything_stands_out_from_its_background() {
        for theme in [Theme::Dark, Theme::Light] {
            let palette = Palette::of(theme);
            for tone in SERIES.into_iter().chain([Tone::Quiet]) {
                let found = contrast(palette.tone(tone), palette.plot);
                assert!(found >= 3.0, "{theme:?} {tone:?} {found}");
            }
            for ground in [palette.panel, palette.plot] {
                assert!(contrast(palette.text, ground) >= 7.0);
                assert!(contrast(palette.weak, ground) >= 4.5, "{theme:?}");
            }
        }
    }

    #[test]
    fn texts_of_studies_have_every_sign() {
        let ctx = Context::default();
        install(&ctx);
        let mut output = ctx.run_ui(RawInput::default(), |_| {});
        output.textures_delta.clear();
        for font in [FontId::proportional(12.0), FontId::monospace(12.0)] {
            let lacking: Vec<char> = "ln F \u{2192} ln f, \u{b1} \u{b5} \u{d7} \u{2013} \u{b2}"
                .chars()
                .filter(|sign| !ctx.fonts_mut(|fonts| fonts.has_glyph(&font, *sign)))
                .collect();
            assert!(lacking.is_empty(), "{font:?}: {lacking:?}");
        }
    }

    #[test]
    fn heat_grows_lighter() {
        let light = |level| Rgba::from(Palette::heat(level)).intensity();
        assert!((1..=20).all(|i| light(0.05 * i as f32) > light(0.05 * (i - 1) as f32)));
        assert_eq!(Palette::heat(f32::NAN), Palette::heat(0.0));
        assert_eq!(Palette::heat(7.0), Palette::heat(1.0));
    }
}
