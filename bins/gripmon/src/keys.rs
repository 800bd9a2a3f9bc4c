//! Every key and what it does, in one table: the window obeys it and the overlay shows it.

use crate::apply::Effect;
use crate::layout::Panel;
use crate::state::ViewState;
use eframe::egui::{Context, Key, Modifiers};
use grip_scope::Model;

/// A key and its meaning.
#[derive(Clone, Copy, Debug)]
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
    pub act: fn(&mut ViewState, &Model),
}

/// Rows of keys: the key, whether Shift is held, how it is shown, what it does.
macro_rules! keys {
    (@held) => { Modifiers::NONE };
    (@held Shift) => { Modifiers::SHIFT };
    ($($part:literal { $($key:ident $($held:ident)? $shown:literal $does:literal => |$s:ident, $m:ident| $act:expr;)+ })+) => {
        [$($(Binding {
            key: Key::$key,
            modifiers: keys!(@held $($held)?),
            shown: $shown,
            does: $does,
            part: $part,
            act: |$s, $m| $act,
        },)+)+]
    };
}

/// The table, in the order of the overlay.
pub const BINDINGS: [Binding; 30] = keys! {
    "Time" {
        Space "Space" "pause the view, or follow the newest data" => |s, m| s.toggle_pause(m);
        ArrowLeft "Left" "a tenth of the view earlier" => |s, m| s.pan_share(-0.1, m);
        ArrowRight "Right" "a tenth of the view later" => |s, m| s.pan_share(0.1, m);
        ArrowLeft Shift "Shift Left" "a whole view earlier" => |s, m| s.pan_share(-1.0, m);
        ArrowRight Shift "Shift Right" "a whole view later" => |s, m| s.pan_share(1.0, m);
        ArrowUp "Up" "zoom in" => |s, m| s.zoom(0.5, m);
        ArrowDown "Down" "zoom out" => |s, m| s.zoom(2.0, m);
        Home "Home" "show everything" => |s, _m| s.view().all();
        End "End" "follow the newest data" => |s, _m| s.view().follow();
        N "N" "next event" => |s, m| s.step(true, m);
        P "P" "previous event" => |s, m| s.step(false, m);
    }
    "Measure" {
        A "A" "cursor A at the pointer" => |s, m| s.put_cursor(0, m);
        B "B" "cursor B at the pointer" => |s, m| s.put_cursor(1, m);
        C "C" "cursors away" => |s, _m| s.cursors = [None; 2];
        Z "Z" "zoom to between the cursors" => |s, _m| s.zoom_to_cursors();
        M "M" "marker at the pointer" => |s, m| s.mark(m);
        W "W" "why: explain the slip" => |s, m| s.toggle_explain(m);
        T "T" "arm or disarm the trigger" => |s, _m| s.toggle_trigger();
        R "R" "scale all values to what is seen" => |s, _m| s.values.clear();
    }
    "Window" {
        H "H" "health" => |s, _m| s.toggle_panel(Panel::Health);
        E "E" "events" => |s, _m| s.toggle_panel(Panel::Events);
        V "V" "cursor values" => |s, _m| s.toggle_panel(Panel::Cursors);
        G "G" "trigger settings" => |s, _m| s.toggle_panel(Panel::Trigger);
        X "X" "export" => |s, _m| s.toggle_panel(Panel::Export);
        F "F" "commands to the gripper" => |s, _m| s.toggle_panel(Panel::Command);
        L "L" "light or dark" => |s, _m| s.toggle_theme();
        S "S" "picture of the window (PNG)" => |s, _m| s.ask(Effect::Picture);
        S Shift "Shift S" "report of what is seen (HTML)" => |s, _m| s.ask(Effect::Report);
        Questionmark Shift "?" "these keys" => |s, _m| s.help = !s.help;
        Escape "Esc" "close what lies over the plots" => |s, _m| s.dismiss();
    }
};

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

/// Does what the keys of this frame ask for; nothing while text is being typed, and behind a dialog only what opens or closes one.
pub fn obey(ctx: &Context, state: &mut ViewState, model: &Model) {
    if ctx.text_edit_focused() {
        return;
    }
    let stays = |key| matches!(key, Key::Escape | Key::Questionmark | Key::W);
    let behind_dialog = state.has_dialog();
    let obeyed = BINDINGS.iter().filter(|b| !behind_dialog || stays(b.key));
    let pressed = |binding: &&Binding| {
        ctx.input_mut(|input| match binding.key {
            // Where the question mark stands on the keyboard, and with which modifiers, is the keyboard's affair.
            Key::Questionmark => input.key_pressed(Key::Questionmark),
            key => input.consume_key(binding.modifiers, key),
        })
    };
    // Those with modifiers first: a plain binding would take their key.
    let (held, plain): (Vec<_>, Vec<_>) = obeyed.partition(|b| !b.modifiers.is_none());
    let pressed: Vec<&Binding> = held.into_iter().chain(plain).filter(pressed).collect();
    pressed.iter().for_each(|binding| (binding.act)(state, model));
}

#[cfg(test)]
mod tests {
    use super::BINDINGS;

    #[test]
    fn no_key_means_two_things() {
        for (i, one) in BINDINGS.iter().enumerate() {
            let again = BINDINGS
                .iter()
                .skip(i + 1)
                .find(|b| (b.key, b.modifiers) == (one.key, one.modifiers));
            assert!(again.is_none(), "{} and {}", one.does, again.unwrap().does);
        }
    }
}
