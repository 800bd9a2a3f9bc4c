//! The line at the top: source, time, measuring, plots, panels.

use super::Seen;
use crate::action::{Action, Cursor};
use crate::layout::{Look, Panel};
use eframe::egui::{Align, Button, DragValue, Layout, RichText, Role, Ui, WidgetInfo};

/// From this width on everything stands in one line, the panels at the right (points).
const ONE_LINE: f32 = 1240.0;

/// Draws the line, or several where the window is narrow.
pub fn toolbar(ui: &mut Ui, seen: &Seen<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    let out = &mut actions;
    if ui.available_width() < ONE_LINE {
        ui.horizontal_wrapped(|ui| {
            controls(ui, seen, out);
            panels(ui, seen, false, out);
        });
    } else {
        ui.horizontal(|ui| {
            controls(ui, seen, out);
            let right = Layout::right_to_left(Align::Center);
            ui.with_layout(right, |ui| panels(ui, seen, true, out));
        });
    }
    actions
}

fn controls(ui: &mut Ui, seen: &Seen<'_>, out: &mut Vec<Action>) {
    time(ui, seen, out);
    events(ui, seen, out);
    measure(ui, seen, out);
    plots(ui, seen, out);
}

fn time(ui: &mut Ui, seen: &Seen<'_>, out: &mut Vec<Action>) {
    let held = seen.state.is_paused();
    let name = if held { "Follow" } else { "Pause" };
    let button = Button::new(RichText::new(name).strong()).min_size(eframe::egui::vec2(58.0, 21.0));
    if ui
        .add(button.selected(held))
        .on_hover_text("Space. Recording goes on while the view is paused.")
        .clicked()
    {
        out.push(Action::TogglePause);
    }
    let mut seconds = seen.span.length_s();
    let speed = seconds * 0.01;
    let decimals = crate::num::whole((2.0 - seconds.max(1e-6).log10().floor()).clamp(0.0, 6.0));
    let label = ui.weak("View");
    let value = DragValue::new(&mut seconds)
        .speed(speed)
        .range(2e-4..=1e6)
        .suffix(" s")
        .fixed_decimals(decimals);
    if ui
        .add(value)
        .labelled_by(label.id)
        .on_hover_text("Seconds that are seen: drag, or click and type.")
        .changed()
    {
        out.push(Action::Length(seconds));
    }
    for (name, about, action) in [
        ("-", "Zoom out (Down)", Action::ZoomKey(2.0)),
        ("+", "Zoom in (Up)", Action::ZoomKey(0.5)),
        ("All", "Show everything (Home)", Action::ShowAll),
    ] {
        if ui.button(name).on_hover_text(about).clicked() {
            out.push(action);
        }
    }
}

fn events(ui: &mut Ui, seen: &Seen<'_>, out: &mut Vec<Action>) {
    let any = !seen.model.events().is_empty();
    for (name, about, action) in [
        ("< Event", "Previous event (P)", Action::PreviousEvent),
        ("Event >", "Next event (N)", Action::NextEvent),
    ] {
        if ui.add_enabled(any, Button::new(name)).on_hover_text(about).clicked() {
            out.push(action);
        }
    }
    if ui
        .button("Mark")
        .on_hover_text("Marker at the newest sample; the key M sets it at the pointer.")
        .clicked()
    {
        out.push(Action::MarkHere);
    }
}

fn measure(ui: &mut Ui, seen: &Seen<'_>, out: &mut Vec<Action>) {
    for (name, cursor) in [("A", Cursor::A), ("B", Cursor::B)] {
        let set = seen.state.cursor(cursor).is_some();
        let about = format!(
            "Cursor {name} in the middle of the view; the key {name} sets it at the pointer."
        );
        if ui.selectable_label(set, name).on_hover_text(about).clicked() {
            out.push(Action::CursorHere(cursor));
        }
    }
    let any = seen.state.cursors.iter().any(Option::is_some);
    if any && ui.button("Clear cursors").on_hover_text("C").clicked() {
        out.push(Action::ClearCursors);
    }
}

fn plots(ui: &mut Ui, seen: &Seen<'_>, out: &mut Vec<Action>) {
    ui.menu_button("Plots", |ui| {
        for (place, plot) in seen.state.layout.plots.iter().enumerate() {
            ui.horizontal(|ui| {
                let mut shown = plot.shown;
                if ui.checkbox(&mut shown, plot.plot.title()).changed() {
                    out.push(Action::ToggleStrip(plot.plot));
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let up = Button::new(RichText::new("up").small());
                    let up = ui.add_enabled(place > 0, up);
                    let about = format!("Move {} up", plot.plot.title());
                    up.widget_info(|| WidgetInfo::labeled(Role::Button, place > 0, &about));
                    if up.on_hover_text(about).clicked() {
                        out.push(Action::MoveStrip(plot.plot, 1));
                    }
                });
            });
        }
        ui.separator();
        if ui.button("Scale values to what is seen").clicked() {
            out.push(Action::AutoValues);
        }
    });
}

fn panels(ui: &mut Ui, seen: &Seen<'_>, from_right: bool, out: &mut Vec<Action>) {
    let mut buttons: Vec<(&str, bool, &str, Action)> = Panel::ALL
        .into_iter()
        .map(|panel| {
            let open = seen.state.layout.panel == Some(panel);
            (panel.name(), open, "", Action::TogglePanel(panel))
        })
        .collect();
    let theme = if seen.state.layout.theme == Look::Dark { "Light" } else { "Dark" };
    buttons.push((theme, false, "Other colours (L)", Action::ToggleTheme));
    buttons.push(("?", false, "Keys and mouse", Action::ToggleHelp));
    if from_right {
        buttons.reverse();
    }
    for (name, open, about, action) in buttons {
        let is_panel = about.is_empty();
        let button = if is_panel { Button::selectable(open, name) } else { Button::new(name) };
        let response = ui.add(button);
        let response = if is_panel { response } else { response.on_hover_text(about) };
        if response.clicked() {
            out.push(action);
        }
    }
}
