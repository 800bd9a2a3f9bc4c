//! When the view shall stop and show: level and edge of a channel, or an event.

use super::{Seen, heading, row, sentence};
use crate::state::ViewState;
use eframe::egui::{ComboBox, DragValue, Response, Ui};
use grip_scope::format::{self, Typed};
use grip_scope::trigger::{Condition, TriggerMode, TriggerSettings};
use grip_scope::{Channel, EventKind};

/// Events that are worth waiting for.
const EVENTS: [EventKind; 7] = [
    EventKind::Incipient,
    EventKind::Gross,
    EventKind::Ended,
    EventKind::Reflex,
    EventKind::Gap,
    EventKind::Fault,
    EventKind::Marker,
];

/// Height of a list of choices (points): all conditions are seen.
const CHOICES: f32 = 320.0;

const fn name(condition: Condition, event: EventKind) -> &'static str {
    match condition {
        Condition::RisingEdge => "rising edge",
        Condition::FallingEdge => "falling edge",
        Condition::Above => "above the level",
        Condition::Below => "below the level",
        Condition::Event => event.name(),
    }
}

pub(super) fn trigger(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    heading(ui, "Trigger");
    sentence(ui, "Stops the view where something happens; recording goes on.");
    ui.add_space(4.0);
    let armed = state.armed;
    if ui.button(if armed { "Disarm" } else { "Arm" }).on_hover_text("Key T").clicked() {
        state.toggle_trigger();
    }
    let form = &mut state.layout.trigger;
    kind(ui, form);
    if form.condition != Condition::Event {
        level(ui, form, seen);
    }
    mode(ui, form);
    window(ui, form);
    heading(ui, "State");
    row(ui, "trigger", if armed { "armed, waiting" } else { "not armed" });
    row(ui, "found", format::count(state.triggered));
}

fn labelled(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> Response) {
    ui.horizontal(|ui| {
        let left = eframe::egui::Layout::left_to_right(eframe::egui::Align::Center);
        let label = ui.allocate_ui_with_layout(eframe::egui::vec2(84.0, 20.0), left, |ui| {
            ui.set_min_width(84.0);
            ui.weak(name)
        });
        add(ui).labelled_by(label.inner.id);
    });
}

fn choices(ui: &mut Ui, id: &str, chosen: &str, choose: impl FnOnce(&mut Ui)) -> Response {
    let list = ComboBox::from_id_salt(id).selected_text(chosen).width(150.0).height(CHOICES);
    list.show_ui(ui, choose).response
}

fn kind(ui: &mut Ui, form: &mut TriggerSettings) {
    heading(ui, "Waits for");
    let mut chosen = (form.condition, form.event);
    let of_a_channel = Condition::OF_A_CHANNEL.map(|condition| (condition, form.event));
    let events = EVENTS.map(|event| (Condition::Event, event));
    let text = name(form.condition, form.event);
    labelled(ui, "Condition", |ui| {
        let choose = |ui: &mut Ui| {
            for (condition, event) in of_a_channel.into_iter().chain(events) {
                ui.selectable_value(&mut chosen, (condition, event), name(condition, event));
            }
        };
        choices(ui, "condition", text, choose)
    });
    (form.condition, form.event) = chosen;
}

fn level(ui: &mut Ui, form: &mut TriggerSettings, seen: &Seen<'_>) {
    let before = form.channel;
    labelled(ui, "Channel", |ui| {
        let channels: Vec<Channel> =
            seen.model.channels().filter(|channel| *channel != Channel::EscFlags).collect();
        let info = seen.model.info();
        let chosen = info.name(form.channel);
        let choose = |ui: &mut Ui| {
            for channel in channels {
                ui.selectable_value(&mut form.channel, channel, info.name(channel));
            }
        };
        choices(ui, "channel", chosen, choose)
    });
    if form.channel != before {
        form.level = middle(form.channel, seen);
    }
    // One unit for a channel, whatever the level: a number that is typed means the same each time.
    let unit = seen.model.info().unit(form.channel);
    let (factor, prefix) = fixed_prefix(form.channel, unit);
    let mut shown = form.level / factor;
    let was = shown;
    labelled(ui, "Level", |ui| {
        let suffix = format!(" {prefix}{unit}");
        let suffix = suffix.trim_end();
        let parse = |text: &str| {
            format::parse(text, unit).map(|typed| match typed {
                Typed::Number(number) => number,
                Typed::Quantity(value) => value / factor,
            })
        };
        let value = DragValue::new(&mut shown)
            .speed((0.01 * was.abs()).max(0.01))
            .suffix(suffix)
            .max_decimals(4)
            .custom_parser(parse);
        ui.add(value).on_hover_text("Drag, or click and type; a number may have a unit (0.2 mm).")
    });
    if shown.is_finite() && (shown - was).abs() > 0.0 {
        form.level = shown * factor;
    }
}

/// Factor and prefix in which the levels of a channel are reported.
fn fixed_prefix(channel: Channel, unit: &str) -> (f64, &'static str) {
    match channel {
        Channel::Stylus | Channel::SecondStylus if unit == "m" => (1e-6, "\u{b5}"),
        Channel::Travel | Channel::Velocity | Channel::SlipSpeed | Channel::SlipSpeedSigma => {
            (1e-3, "m")
        }
        _ => (1.0, ""),
    }
}

/// The middle of what is seen of a channel, with two digits: a level of another channel means nothing here.
fn middle(channel: Channel, seen: &Seen<'_>) -> f64 {
    let stats = seen.model.series(channel).and_then(|series| series.stats(seen.span));
    let middle = stats.map_or(0.0, |stats| f64::midpoint(stats.min.into(), stats.max.into()));
    let step = 10_f64.powf(middle.abs().log10().floor() - 1.0);
    if step.is_finite() && step > 0.0 { (middle / step).round() * step } else { 0.0 }
}

fn mode(ui: &mut Ui, form: &mut TriggerSettings) {
    heading(ui, "Mode");
    ui.horizontal(|ui| {
        for (mode, name, about) in [
            (TriggerMode::Single, "Single", "Once; then the view stands."),
            (TriggerMode::Normal, "Normal", "Every time."),
            (TriggerMode::Auto, "Auto", "Every time; the newest data where nothing comes."),
        ] {
            ui.radio_value(&mut form.mode, mode, name).on_hover_text(about);
        }
    });
}

fn window(ui: &mut Ui, form: &mut TriggerSettings) {
    heading(ui, "Shows");
    let seconds =
        |value| DragValue::new(value).speed(0.01).range(0.001..=600.0).suffix(" s").max_decimals(3);
    labelled(ui, "Before it", |ui| ui.add(seconds(&mut form.before_s)));
    labelled(ui, "In all", |ui| ui.add(seconds(&mut form.window_s)));
    form.window_s = form.window_s.max(form.before_s);
}
