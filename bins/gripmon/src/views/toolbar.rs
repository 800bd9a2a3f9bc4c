//! The line at the top: source, time, measuring, plots, panels.

use super::Seen;
use crate::layout::{Look, Panel};
use crate::state::ViewState;
use eframe::egui::{Align, Button, DragValue, Layout, RichText, Role, Ui, WidgetInfo, vec2};

/// From this width on everything stands in one line, the panels at the right (points).
const ONE_LINE: f32 = 1240.0;

/// Draws the line, or several where the window is narrow.
pub fn toolbar(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    if ui.available_width() < ONE_LINE {
        ui.horizontal_wrapped(|ui| {
            controls(ui, seen, state);
            panels(ui, state, false);
        });
    } else {
        ui.horizontal(|ui| {
            controls(ui, seen, state);
            let right = Layout::right_to_left(Align::Center);
            ui.with_layout(right, |ui| panels(ui, state, true));
        });
    }
}

fn controls(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    time(ui, seen, state);
    events(ui, seen, state);
    measure(ui, seen, state);
    ui.menu_button("Plots", |ui| plots(ui, state));
}

fn time(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    let held = state.is_paused();
    let name = RichText::new(if held { "Follow" } else { "Pause" }).strong();
    let button = ui.add(Button::new(name).min_size(vec2(58.0, 21.0)).selected(held));
    if button.on_hover_text("Space. Recording goes on while the view is paused.").clicked() {
        state.toggle_pause(seen.model);
    }
    let mut seconds = seen.span.length_s();
    let decimals = crate::num::whole((2.0 - seconds.max(1e-6).log10().floor()).clamp(0.0, 6.0));
    let speed = seconds * 0.01;
    let label = ui.weak("View");
    let value = DragValue::new(&mut seconds)
        .speed(speed)
        .range(2e-4..=1e6)
        .suffix(" s")
        .fixed_decimals(decimals);
    let value = ui.add(value).labelled_by(label.id);
    if value.on_hover_text("Seconds that are seen: drag, or click and type.").changed() {
        state.view().resize(seconds, seen.model.span());
    }
    if ui.button("-").on_hover_text("Zoom out (Down)").clicked() {
        state.zoom(2.0, seen.model);
    }
    if ui.button("+").on_hover_text("Zoom in (Up)").clicked() {
        state.zoom(0.5, seen.model);
    }
    if ui.button("All").on_hover_text("Show everything (Home)").clicked() {
        state.view().all();
    }
}

fn events(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    let any = !seen.model.events().marks.is_empty();
    for (name, about, later) in
        [("< Event", "Previous event (P)", false), ("Event >", "Next event (N)", true)]
    {
        if ui.add_enabled(any, Button::new(name)).on_hover_text(about).clicked() {
            state.step(later, seen.model);
        }
    }
    let about = "Marker at the newest sample; the key M sets it at the pointer.";
    if ui.button("Mark").on_hover_text(about).clicked() {
        state.mark(seen.model);
    }
}

fn measure(ui: &mut Ui, seen: &Seen<'_>, state: &mut ViewState) {
    for (cursor, name) in ["A", "B"].into_iter().enumerate() {
        let about = format!(
            "Cursor {name} in the middle of the view; the key {name} sets it at the pointer."
        );
        let set = state.cursors[cursor].is_some();
        if ui.selectable_label(set, name).on_hover_text(about).clicked() {
            state.put_cursor(cursor, seen.model);
        }
    }
    let any = state.cursors.iter().any(Option::is_some);
    if any && ui.button("Clear cursors").on_hover_text("C").clicked() {
        state.cursors = [None; 2];
    }
}

fn plots(ui: &mut Ui, state: &mut ViewState) {
    let mut moved = None;
    for (place, plot) in state.layout.plots.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.checkbox(&mut plot.shown, plot.plot.title());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let up = Button::new(RichText::new("up").small());
                let up = ui.add_enabled(place > 0, up);
                let about = format!("Move {} up", plot.plot.title());
                up.widget_info(|| WidgetInfo::labeled(Role::Button, place > 0, &about));
                if up.on_hover_text(about).clicked() {
                    moved = Some(place);
                }
            });
        });
    }
    if let Some(place) = moved {
        state.layout.plots.swap(place, place.saturating_sub(1));
    }
    ui.separator();
    if ui.button("Scale values to what is seen").clicked() {
        state.values.clear();
    }
}

fn panels(ui: &mut Ui, state: &mut ViewState, from_right: bool) {
    let count = Panel::ALL.len() + 2;
    for place in 0..count {
        let place = if from_right { count - 1 - place } else { place };
        if let Some(panel) = Panel::ALL.get(place).copied() {
            let open = state.layout.panel == Some(panel);
            if ui.add(Button::selectable(open, panel.name())).clicked() {
                state.toggle_panel(panel);
            }
        } else if place == Panel::ALL.len() {
            let other = if state.layout.theme == Look::Dark { "Light" } else { "Dark" };
            if ui.button(other).on_hover_text("Other colours (L)").clicked() {
                state.toggle_theme();
            }
        } else if ui.button("?").on_hover_text("Keys and mouse").clicked() {
            state.help = !state.help;
        }
    }
}
