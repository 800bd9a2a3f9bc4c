//! The names and values beside a plot.

use super::Seen;
use crate::palette::{self, Tone};
use crate::plot::{Kind, Scale};
use crate::strip::{Curve, StripId, enclosure};
use eframe::egui::{Align, Color32, Label, Layout, Response, RichText, Sense, Ui, vec2};
use grip_scope::Channel;
use grip_scope::feed::esc_flags;
use grip_scope::format::{self, Shown};

/// Room for the values right of a plot (points).
pub(super) const WIDTH: f32 = 212.0;
/// Height of a line (points).
const LINE: f32 = 15.0;
/// A value of a slow channel stays true for so long (s).
const STAYS_S: f64 = 0.5;

/// One line for each curve: its colour, its name, its value at the time that is looked at, its unit. Where lines are left over a value that has
/// bounds states them too.
pub(super) fn readout(
    ui: &mut Ui,
    strip: StripId,
    scale: &Scale,
    curves: &[Curve],
    by_hand: bool,
    seen: &Seen<'_>,
) {
    ui.spacing_mut().item_spacing = vec2(5.0, 0.0);
    ui.spacing_mut().interact_size.y = LINE;
    // The button that gives the scale back stands below.
    let below = if by_hand { LINE } else { 0.0 };
    let lines = crate::num::whole(f64::from((ui.available_height() - below) / LINE)).max(1);
    let mut left = lines.saturating_sub(curves.len());
    // The curve drawn last lies on top; it is also reported first.
    for curve in curves.iter().rev().take(lines) {
        match enclosure(curve.channel).filter(|_| left > 0) {
            Some((low, high)) => {
                let ends = [low, high].map(|channel| value(channel, seen));
                left -= usize::from(bounded(ui, curve, ends, scale, seen));
            }
            None => line(ui, curve, scale, seen),
        }
    }
    if strip == StripId::Esc {
        flags(ui, seen);
    }
}

/// A value and its bounds in two lines; in one, and `false`, where the bounds are not known.
fn bounded(
    ui: &mut Ui,
    curve: &Curve,
    ends: [Option<f64>; 2],
    scale: &Scale,
    seen: &Seen<'_>,
) -> bool {
    let unit = seen.model.info().unit(curve.channel);
    let ([Some(low), Some(high)], median) = (ends, value(curve.channel, seen)) else {
        line(ui, curve, scale, seen);
        return false;
    };
    let text = match median.filter(|_| curve.channel == Channel::Need) {
        Some(median) => {
            fan(ui, curve, seen);
            RichText::new(format!("   {low:.2} / {median:.2} / {high:.2} {unit}"))
                .font(palette::number_font())
        }
        None => {
            line(ui, curve, scale, seen);
            let [low, high] = [low, high].map(|end| format::with_unit(end, unit));
            RichText::new(format!("    {low} .. {high}")).size(10.5).weak()
        }
    };
    ui.label(text);
    true
}

/// The name of a value that is known by its quantiles.
fn fan(ui: &mut Ui, curve: &Curve, seen: &Seen<'_>) {
    ui.horizontal(|ui| {
        swatch(ui, seen.palette.tone(curve.tone), false);
        let name = seen.model.info().name(curve.channel);
        let text = RichText::new(format!("{name} (10 / 50 / 90 %)")).size(11.5);
        cell(ui, WIDTH - 30.0, Layout::left_to_right(Align::Center), text);
    });
}

/// A value in the unit of the axis, so that all of a plot can be compared.
fn line(ui: &mut Ui, curve: &Curve, scale: &Scale, seen: &Seen<'_>) {
    let info = seen.model.info();
    let (name, unit) = (info.name(curve.channel), info.unit(curve.channel));
    let (factor, prefix) = scale.prefix(unit);
    let shown = value(curve.channel, seen).map(|value| match scale.kind() {
        Kind::Log => format::value(value, unit),
        Kind::Linear => {
            Shown { number: format::number(value / factor), unit: format!("{prefix}{unit}") }
        }
    });
    ui.horizontal(|ui| {
        swatch(ui, seen.palette.tone(curve.tone), curve.style == crate::plot::DASHED);
        let text = RichText::new(name).size(11.5);
        cell(ui, 90.0, Layout::left_to_right(Align::Center), text)
            .on_hover_text(about(name, curve));
        let (number, unit) =
            shown.map_or((format::NOTHING.to_owned(), String::new()), |s| (s.number, s.unit));
        let number = RichText::new(number).font(palette::number_font());
        cell(ui, 60.0, Layout::right_to_left(Align::Center), number);
        ui.label(RichText::new(unit).size(11.0).weak());
    });
}

/// The name of a curve, and what it does not say.
fn about(name: &str, curve: &Curve) -> String {
    format!("{name}\n{}", curve.channel.about()).trim_end().to_owned()
}

/// A text in so much room, at one side of it.
fn cell(ui: &mut Ui, wide: f32, layout: Layout, text: RichText) -> Response {
    let add = |ui: &mut Ui| {
        ui.set_min_width(wide);
        ui.add(Label::new(text).truncate())
    };
    ui.allocate_ui_with_layout(vec2(wide, LINE), layout, add).inner
}

fn swatch(ui: &mut Ui, colour: Color32, dashed: bool) {
    let (rect, _) = ui.allocate_exact_size(vec2(9.0, LINE), Sense::hover());
    let stroke = eframe::egui::Stroke::new(2.5, colour);
    let (left, right, y) = (rect.left(), rect.right(), rect.center().y);
    if dashed {
        ui.painter().hline(left..=left + 3.5, y, stroke);
        ui.painter().hline(right - 3.5..=right, y, stroke);
    } else {
        ui.painter().hline(left..=right, y, stroke);
    }
}

/// The value of a channel at the time that is looked at; of slow ones the last one that still holds.
pub(super) fn value(channel: Channel, seen: &Seen<'_>) -> Option<f64> {
    value_at(channel, seen, seen.looked_at_s)
}

/// The same at another time (s).
pub(super) fn value_at(channel: Channel, seen: &Seen<'_>, t_s: f64) -> Option<f64> {
    let series = seen.model.series(channel)?;
    let last = series.latest().filter(|(last_s, _)| (*last_s..=last_s + STAYS_S).contains(&t_s));
    let value = series.at(t_s).or(last.map(|(_, value)| value))?;
    (!value.is_nan()).then_some(f64::from(value))
}

/// The flags of the value that is reported; of thinned-out stretches, which keep means only, none.
fn flags(ui: &mut Ui, seen: &Seen<'_>) {
    let flags = value(Channel::EscFlags, seen).filter(|flags| flags.fract() == 0.0);
    let flags = flags.and_then(|flags| u8::try_from(crate::num::whole(flags)).ok());
    for name in flags.map(esc_flags).unwrap_or_default() {
        let text = RichText::new(format!("! {name}")).size(11.0);
        ui.label(text.color(seen.palette.tone(Tone::Orange)));
    }
}
