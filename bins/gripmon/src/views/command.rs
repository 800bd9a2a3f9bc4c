//! Commands to the gripper: locked until they are armed, and a question before it lets go.

use super::{Seen, heading, row, sentence};
use crate::apply::Effect;
use crate::num::narrow;
use crate::palette::Tone;
use crate::state::ViewState;
use eframe::egui::{self, Button, RichText, Slider, Ui, vec2};
use grip_link::message::FaultCode;
use grip_scope::SourceStatus;
use grip_scope::format;
use slip_core::ClientCommand;

/// Largest force that can be entered where the gripper reports no limit (N).
const MODEST_N: f64 = 10.0;

pub(super) fn command(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    heading(ui, "Commands to the gripper");
    match refusal(seen) {
        Some(reason) => sentence(ui, reason),
        None => allowed(ui, seen, state),
    }
}

/// Why there can be no commands, a sentence.
fn refusal(seen: &Seen<'_>) -> Option<&'static str> {
    let status = seen.model.status();
    let awaited = matches!(status, SourceStatus::Connecting { .. } | SourceStatus::Waiting { .. });
    Some(match seen.model.info().daemon.as_ref() {
        None if awaited => "No gripd has answered yet.",
        None => "Only a running gripd takes commands; this source is none.",
        Some(daemon) if daemon.dry_run => {
            "This gripd only observes (dry run): it commands nothing."
        }
        Some(daemon) if !daemon.may_command => {
            "This gripd takes no commands of clients. Its configuration allows them with allow_commands = true."
        }
        Some(_) if status.is_disconnected() => "There is no connection to gripd now.",
        Some(_) => return None,
    })
}

fn allowed(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    sentence(
        ui,
        "A software stop is not a safety function: whoever may be hurt needs an emergency stop that does not pass through this program.",
    );
    ui.add_space(4.0);
    let stop = RichText::new("Stop").strong().color(seen.palette.tone(Tone::Red));
    let stop = ui.add(Button::new(stop).min_size(vec2(160.0, 24.0)));
    let about = "Stops in software, latched by the gripper. Works without arming.";
    if stop.on_hover_text(about).clicked() {
        state.ask(Effect::Send(ClientCommand::Stop));
    }
    ui.add_space(4.0);
    ui.checkbox(&mut state.command.armed, "Arm commands")
        .on_hover_text("The buttons below work only while this is set.");
    ui.add_enabled_ui(state.command.armed, |ui| {
        force(ui, seen, state);
        others(ui, seen, state);
    });
}

fn force(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    heading(ui, "Force");
    let reported = seen.model.info().gripper.and_then(|gripper| gripper.force_max_n);
    let limit_n = reported.filter(|n| n.is_finite() && *n > 0.0).map_or(MODEST_N, f64::from);
    let force_n = &mut state.command.force_n;
    *force_n = force_n.clamp(0.0, limit_n);
    ui.add(Slider::new(force_n, 0.0..=limit_n).suffix(" N").text("At least").max_decimals(2));
    let command = ClientCommand::AtLeast(narrow(*force_n));
    row(ui, "limit", format::with_unit(limit_n, "N"));
    let hold = ui.button("Hold with this force");
    if hold.on_hover_text("The answer to a slip stays free to press harder.").clicked() {
        state.ask(Effect::Send(command));
    }
}

fn others(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    heading(ui, "Fingers");
    ui.horizontal(|ui| {
        if ui.button("Grasp").on_hover_text("Close again after a release.").clicked() {
            state.ask(Effect::Send(ClientCommand::Grasp));
        }
        if ui.button("Release ..").on_hover_text("Let go; asks first.").clicked() {
            state.command.asks_release = true;
        }
    });
    let fault = seen.model.info().state.map_or(FaultCode::NONE, |state| state.fault);
    if ui.add_enabled(fault.is_fault(), Button::new("Clear the fault")).clicked() {
        state.ask(Effect::Send(ClientCommand::ClearFault(fault)));
    }
}

/// The question before a release.
pub(super) fn question(ctx: &egui::Context, state: &mut ViewState) {
    let modal = egui::Modal::new(egui::Id::unique("release")).show(ctx, |ui| {
        ui.set_width(320.0);
        ui.heading("Let go of the object?");
        ui.label("The fingers open, and what they hold falls, until Grasp is commanded.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if ui.button("Keep holding").clicked() {
                state.command.asks_release = false;
            }
            if ui.button("Yes, release").clicked() {
                state.ask(Effect::Send(ClientCommand::Release));
            }
        });
    });
    if modal.should_close() {
        state.command.asks_release = false;
    }
}
