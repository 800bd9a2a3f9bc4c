//! The line above the view of one gripper of many: which one, what it reports of its samples, and the way back.

use eframe::egui::{Button, Frame, Key, Label, Margin, Panel, Popup, RichText, Ui};
use gripmon::palette::Palette;
use gripmon::scope::Scope;
use gripmon::state::ViewState;

/// Where the user wants to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lead {
    /// Here.
    Stay,
    /// Back at the table.
    Back,
}

/// Draws the line. Esc leads back, unless it closes something that lies over the plots.
pub fn opened(ui: &mut Ui, scope: &Scope, name: &str) -> Lead {
    let palette = Palette::now(ui.ctx());
    let escape = ui.input(|input| input.key_pressed(Key::Escape)) && !is_taken(ui, &scope.state);
    let every_nth = scope.shared.engine().model.info().daemon.as_ref().map(|of| of.every_nth);
    let bar = Frame::new().fill(palette.plot).inner_margin(Margin::symmetric(8, 4));
    let clicked = Panel::top("gripper of a fleet").frame(bar).show(ui, |ui| {
        ui.horizontal(|ui| {
            let back = Button::new(RichText::new("< All grippers").strong());
            let clicked = ui.add(back).on_hover_text("Esc").clicked();
            ui.label(RichText::new(name).monospace());
            ui.add(Label::new(RichText::new(samples(every_nth)).weak()).truncate());
            clicked
        })
    });
    if clicked.inner.inner || escape { Lead::Back } else { Lead::Stay }
}

/// Whether Esc closes something else.
fn is_taken(ui: &Ui, state: &ViewState) -> bool {
    let dialog = state.help || state.command.asks_release;
    let over = dialog || state.message.is_some() || state.select_s.is_some();
    over || ui.ctx().text_edit_focused() || Popup::is_any_open(ui.ctx())
}

/// What is reported of samples, as a sentence.
fn samples(every_nth: Option<u16>) -> String {
    match every_nth {
        None => String::new(),
        Some(0) => "sends no samples (samples_every = 0 in its [fleet]): what its pipeline thinks comes five times a second, and what needs samples stays empty".to_owned(),
        Some(1) => "sends every sample".to_owned(),
        Some(nth) => format!("sends every {nth}th sample"),
    }
}
