//! When the view shall stop and show: level and edge of a channel, or an event.

use super::{Seen, heading, row, sentence};
use crate::action::Action;
use crate::format;
use crate::state::{TriggerForm, TriggerKind};
use eframe::egui::{ComboBox, DragValue, Ui};
use grip_scope::trigger::TriggerMode;
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

pub(super) fn trigger(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    let before = seen.state.trigger;
    let mut form = before;
    heading(ui, "Trigger");
    sentence(ui, "Stops the view where something happens; recording goes on.");
    ui.add_space(4.0);
    let name = if form.armed { "Disarm" } else { "Arm" };
    let mut actions = Vec::new();
    if ui.button(name).on_hover_text("Key T").clicked() {
        actions.push(Action::ToggleTrigger);
    }
    kind(ui, &mut form);
    if !matches!(form.kind, TriggerKind::Event(_)) {
        level(ui, &mut form, seen);
    }
    mode(ui, &mut form);
    window(ui, &mut form);
    heading(ui, "State");
    row(ui, "trigger", state(&before));
    row(ui, "found", format::count(seen.state.triggered));
    if form != before {
        actions.push(Action::SetTrigger(form));
    }
    actions
}

const fn state(form: &TriggerForm) -> &'static str {
    if form.armed { "armed, waiting" } else { "not armed" }
}

fn labelled(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> eframe::egui::Response) {
    ui.horizontal(|ui| {
        let left = eframe::egui::Layout::left_to_right(eframe::egui::Align::Center);
        let label = ui.allocate_ui_with_layout(eframe::egui::vec2(84.0, 20.0), left, |ui| {
            ui.set_min_width(84.0);
            ui.weak(name)
        });
        add(ui).labelled_by(label.inner.id);
    });
}

fn kind(ui: &mut Ui, form: &mut TriggerForm) {
    heading(ui, "Waits for");
    let text = match form.kind {
        TriggerKind::Rising => "rising edge".to_owned(),
        TriggerKind::Falling => "falling edge".to_owned(),
        TriggerKind::Event(kind) => kind.name().to_owned(),
    };
    labelled(ui, "Condition", |ui| {
        let choose = |ui: &mut Ui| {
            ui.selectable_value(&mut form.kind, TriggerKind::Rising, "rising edge");
            ui.selectable_value(&mut form.kind, TriggerKind::Falling, "falling edge");
            for kind in EVENTS {
                ui.selectable_value(&mut form.kind, TriggerKind::Event(kind), kind.name());
            }
        };
        ComboBox::from_id_salt("condition")
            .selected_text(text)
            .width(150.0)
            .show_ui(ui, choose)
            .response
    });
}

fn level(ui: &mut Ui, form: &mut TriggerForm, seen: &Seen<'_>) {
    labelled(ui, "Channel", |ui| {
        let channels: Vec<Channel> = seen
            .model
            .channels()
            .filter(|c| !matches!(c, Channel::BandThreshold(_) | Channel::EscFlags))
            .collect();
        let chosen = form.channel.name();
        let choose = |ui: &mut Ui| {
            for channel in channels {
                ui.selectable_value(&mut form.channel, channel, channel.name());
            }
        };
        ComboBox::from_id_salt("channel")
            .selected_text(chosen)
            .width(150.0)
            .show_ui(ui, choose)
            .response
    });
    let size = form.level.abs();
    let (factor, prefix) =
        if size > 0.0 { format::prefix_of(size, form.channel.unit()) } else { (1.0, "") };
    let mut shown = form.level / factor;
    labelled(ui, "Level", |ui| {
        let suffix = format!(" {prefix}{}", form.channel.unit());
        ui.add(DragValue::new(&mut shown).speed(0.01).suffix(suffix).max_decimals(4))
    });
    if shown.is_finite() && (shown * factor - form.level).abs() > 1e-12 * size {
        form.level = shown * factor;
    }
}

fn mode(ui: &mut Ui, form: &mut TriggerForm) {
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

fn window(ui: &mut Ui, form: &mut TriggerForm) {
    heading(ui, "Shows");
    let seconds =
        |value| DragValue::new(value).speed(0.01).range(0.001..=600.0).suffix(" s").max_decimals(3);
    labelled(ui, "Before it", |ui| ui.add(seconds(&mut form.pre_s)));
    labelled(ui, "In all", |ui| ui.add(seconds(&mut form.window_s)));
    form.window_s = form.window_s.max(form.pre_s);
}
