//! Every key and what it does, in one table: the window obeys it and the overlay shows it.

use crate::action::{Action, Cursor};
use crate::layout::Panel;
use eframe::egui::{Context, Key, Modifiers};

/// A key and its meaning.
#[derive(Clone, Debug)]
pub struct Binding {
    /// The key.
    pub key: Key,
    /// Held with it.
    pub modifiers: Modifiers,
    /// How the overlay writes it.
    pub shown: &'static str,
    /// What it does, as the overlay states it.
    pub does: &'static str,
    /// Title of its part of the overlay.
    pub part: &'static str,
    /// What happens.
    pub action: Action,
}

const TIME: &str = "Time";
const MEASURE: &str = "Measure";
const WINDOW: &str = "Window";

fn plain(
    key: Key,
    shown: &'static str,
    does: &'static str,
    part: &'static str,
    action: Action,
) -> Binding {
    Binding { key, modifiers: Modifiers::NONE, shown, does, part, action }
}

fn shift(
    key: Key,
    shown: &'static str,
    does: &'static str,
    part: &'static str,
    action: Action,
) -> Binding {
    Binding { modifiers: Modifiers::SHIFT, ..plain(key, shown, does, part, action) }
}

/// The table, in the order of the overlay.
#[must_use]
pub fn bindings() -> Vec<Binding> {
    let mut all = time();
    all.extend(measure());
    all.extend(window());
    all
}

fn time() -> Vec<Binding> {
    vec![
        plain(
            Key::Space,
            "Space",
            "pause the view, or follow the newest data",
            TIME,
            Action::TogglePause,
        ),
        plain(Key::ArrowLeft, "Left", "a tenth of the view earlier", TIME, Action::PanShare(-0.1)),
        plain(Key::ArrowRight, "Right", "a tenth of the view later", TIME, Action::PanShare(0.1)),
        shift(Key::ArrowLeft, "Shift Left", "a whole view earlier", TIME, Action::PanShare(-1.0)),
        shift(Key::ArrowRight, "Shift Right", "a whole view later", TIME, Action::PanShare(1.0)),
        plain(Key::ArrowUp, "Up", "zoom in", TIME, Action::ZoomKey(0.5)),
        plain(Key::ArrowDown, "Down", "zoom out", TIME, Action::ZoomKey(2.0)),
        plain(Key::Home, "Home", "show everything", TIME, Action::ShowAll),
        plain(Key::End, "End", "follow the newest data", TIME, Action::Follow),
        plain(Key::N, "N", "next event", TIME, Action::NextEvent),
        plain(Key::P, "P", "previous event", TIME, Action::PreviousEvent),
    ]
}

fn measure() -> Vec<Binding> {
    vec![
        plain(Key::A, "A", "cursor A at the pointer", MEASURE, Action::CursorHere(Cursor::A)),
        plain(Key::B, "B", "cursor B at the pointer", MEASURE, Action::CursorHere(Cursor::B)),
        plain(Key::C, "C", "cursors away", MEASURE, Action::ClearCursors),
        plain(Key::Z, "Z", "zoom to between the cursors", MEASURE, Action::ZoomToCursors),
        plain(Key::M, "M", "marker at the pointer", MEASURE, Action::MarkHere),
        plain(Key::W, "W", "why: explain the slip", MEASURE, Action::ToggleExplain),
        plain(Key::T, "T", "arm or disarm the trigger", MEASURE, Action::ToggleTrigger),
        plain(Key::R, "R", "scale all values to what is seen", MEASURE, Action::AutoValues),
    ]
}

fn window() -> Vec<Binding> {
    let panel = Action::TogglePanel;
    vec![
        plain(Key::H, "H", "health", WINDOW, panel(Panel::Health)),
        plain(Key::E, "E", "events", WINDOW, panel(Panel::Events)),
        plain(Key::V, "V", "cursor values", WINDOW, panel(Panel::Cursors)),
        plain(Key::G, "G", "trigger settings", WINDOW, panel(Panel::Trigger)),
        plain(Key::X, "X", "export", WINDOW, panel(Panel::Export)),
        plain(Key::F, "F", "commands to the gripper", WINDOW, panel(Panel::Command)),
        plain(Key::L, "L", "light or dark", WINDOW, Action::ToggleTheme),
        plain(Key::S, "S", "picture of the window (PNG)", WINDOW, Action::ExportPicture),
        shift(Key::S, "Shift S", "report of what is seen (HTML)", WINDOW, Action::ExportReport),
        shift(Key::Questionmark, "?", "these keys", WINDOW, Action::ToggleHelp),
        plain(Key::Escape, "Esc", "close what lies over the plots", WINDOW, Action::Dismiss),
    ]
}

/// What the mouse does, for the overlay.
pub const MOUSE: [(&str, &str); 7] = [
    ("Wheel", "zoom in time at the pointer"),
    ("Shift wheel", "earlier, later"),
    ("Drag", "earlier, later"),
    ("Right drag", "zoom to the stretch that is dragged over"),
    ("Wheel on an axis", "zoom its values; drag moves them"),
    ("Double click", "everything; on an axis: its values again by themselves"),
    ("Drag A or B", "move a cursor by its flag"),
];

/// What the keys of this frame ask for; nothing while text is being typed, and behind a dialog only what opens or closes one.
#[must_use]
pub fn pressed(ctx: &Context, behind_dialog: bool) -> Vec<Action> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    let wanted = |binding: Binding| {
        let matched = ctx.input_mut(|input| match binding.key {
            // Where the question mark stands on the keyboard, and with which modifiers, is the keyboard's affair.
            Key::Questionmark => input.key_pressed(Key::Questionmark),
            key => input.consume_key(binding.modifiers, key),
        });
        matched.then_some(binding.action)
    };
    // Those with modifiers first: a plain binding would take their key.
    let stays = |action: &Action| {
        matches!(action, Action::Dismiss | Action::ToggleHelp | Action::ToggleExplain)
    };
    let obeyed = bindings().into_iter().filter(|b| !behind_dialog || stays(&b.action));
    let (held, plain): (Vec<_>, Vec<_>) = obeyed.partition(|b| !b.modifiers.is_none());
    held.into_iter().chain(plain).filter_map(wanted).collect()
}

#[cfg(test)]
mod tests {
    use super::bindings;

    #[test]
    fn no_key_means_two_things() {
        let all = bindings();
        for (i, one) in all.iter().enumerate() {
            let again =
                all.iter().skip(i + 1).find(|b| (b.key, b.modifiers) == (one.key, one.modifiers));
            assert!(again.is_none(), "{} and {}", one.does, again.unwrap().does);
        }
    }
}
