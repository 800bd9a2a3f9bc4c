//! Commands to the gripper: locked until they are armed, and a question before it lets go.

use super::{Seen, heading, row, sentence};
use crate::action::{Action, Order};
use crate::palette::Tone;
use eframe::egui::{self, Button, RichText, Slider, Ui, vec2};
use grip_scope::SourceStatus;
use grip_scope::format;

/// Largest force that can be entered where the gripper reports no limit (N).
const MODEST_N: f64 = 10.0;

pub(super) fn command(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    heading(ui, "Commands to the gripper");
    let Some(reason) = refusal(seen) else { return allowed(ui, seen) };
    sentence(ui, reason);
    Vec::new()
}

/// Why there can be no commands, a sentence.
fn refusal(seen: &Seen<'_>) -> Option<&'static str> {
    let daemon = seen.model.info().daemon.as_ref();
    let status = seen.model.status();
    match daemon {
        None if matches!(
            status,
            SourceStatus::Connecting { .. } | SourceStatus::Waiting { .. }
        ) =>
        {
            Some("No gripd has answered yet.")
        }
        None => Some("Only a running gripd takes commands; this source is none."),
        Some(daemon) if daemon.dry_run => {
            Some("This gripd only observes (dry run): it commands nothing.")
        }
        Some(daemon) if !daemon.may_command => Some(
            "This gripd takes no commands of clients. Its configuration allows them with allow_commands = true.",
        ),
        Some(_) if status.is_disconnected() => Some("There is no connection to gripd now."),
        Some(_) => None,
    }
}

fn allowed(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    let form = seen.state.command;
    let mut actions = Vec::new();
    sentence(
        ui,
        "A software stop is not a safety function: whoever may be hurt needs an emergency stop that does not pass through this program.",
    );
    ui.add_space(4.0);
    let stop = RichText::new("Stop").strong().color(seen.palette.tone(Tone::Red));
    if ui
        .add(Button::new(stop).min_size(vec2(160.0, 24.0)))
        .on_hover_text("Stops in software, latched by the gripper. Works without arming.")
        .clicked()
    {
        actions.push(Action::Send(Order::Stop));
    }
    ui.add_space(4.0);
    let mut armed = form.armed;
    if ui
        .checkbox(&mut armed, "Arm commands")
        .on_hover_text("The buttons below work only while this is set.")
        .changed()
    {
        actions.push(Action::Arm(armed));
    }
    ui.add_enabled_ui(form.armed, |ui| {
        force(ui, seen, &mut actions);
        others(ui, seen, &mut actions);
    });
    actions
}

/// The largest force that may be entered (N).
#[must_use]
pub(super) fn limit_n(seen: &Seen<'_>) -> f64 {
    let reported = seen.model.info().gripper.and_then(|gripper| gripper.force_max_n);
    reported.filter(|n| n.is_finite() && *n > 0.0).map_or(MODEST_N, f64::from)
}

fn force(ui: &mut Ui, seen: &Seen<'_>, actions: &mut Vec<Action>) {
    heading(ui, "Force");
    let limit_n = limit_n(seen);
    let mut force_n = seen.state.command.force_n.min(limit_n);
    let slider =
        Slider::new(&mut force_n, 0.0..=limit_n).suffix(" N").text("At least").max_decimals(2);
    if ui.add(slider).changed() {
        actions.push(Action::ForceEntry(force_n));
    }
    row(ui, "limit", format::with_unit(limit_n, "N"));
    if ui
        .button("Hold with this force")
        .on_hover_text("The answer to a slip stays free to press harder.")
        .clicked()
    {
        actions.push(Action::Send(Order::AtLeast(force_n)));
    }
}

fn others(ui: &mut Ui, seen: &Seen<'_>, actions: &mut Vec<Action>) {
    heading(ui, "Fingers");
    ui.horizontal(|ui| {
        if ui.button("Grasp").on_hover_text("Close again after a release.").clicked() {
            actions.push(Action::Send(Order::Grasp));
        }
        if ui.button("Release ..").on_hover_text("Let go; asks first.").clicked() {
            actions.push(Action::AskRelease(true));
        }
    });
    let fault = seen.model.info().state.map_or(0, |state| state.fault.0);
    let clear = ui.add_enabled(fault != 0, Button::new("Clear the fault"));
    if clear.clicked() {
        actions.push(Action::Send(Order::ClearFault));
    }
}

/// The question before a release.
pub(super) fn question(ctx: &egui::Context) -> Vec<Action> {
    let mut actions = Vec::new();
    let modal = egui::Modal::new(egui::Id::unique("release")).show(ctx, |ui| {
        ui.set_width(320.0);
        ui.heading("Let go of the object?");
        ui.label("The fingers open, and what they hold falls, until Grasp is commanded.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if ui.button("Keep holding").clicked() {
                actions.push(Action::AskRelease(false));
            }
            if ui.button("Yes, release").clicked() {
                actions.push(Action::Send(Order::Release));
            }
        });
    });
    if modal.should_close() {
        actions.push(Action::AskRelease(false));
    }
    actions
}
