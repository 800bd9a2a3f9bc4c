//! What a user can do that is more than a change of one value: methods of the state, and what waits for the end of a frame.

use crate::engine::Engine;
use crate::labels::{self, Labelled, Labelling};
use crate::layout::{Look, Panel};
use crate::plot::Scale;
use crate::state::ViewState;
use crate::strip::StripId;
use crate::time::TimeWindow;
use grip_record::{Label, LabelKind};
use grip_scope::trigger::{Found, TriggerMode};
use grip_scope::{Model, SourceStatus, Span};
use slip_core::ClientCommand;
use std::path::Path;

/// What cannot be done within a frame: it needs the engine, the window or files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// A mark at a time (s).
    Mark(f64),
    /// A command.
    Send(ClientCommand),
    /// A picture of the window.
    Picture,
    /// The samples as CSV.
    Csv,
    /// The samples as a recording.
    Mcap,
    /// A page about the grasp.
    Report,
    /// The label of the recording; none takes it away.
    Label(Option<LabelKind>),
}

/// Does what needs the engine; what remains to be done.
pub fn fulfil(state: &mut ViewState, engine: &mut Engine, effect: Effect) -> Option<Effect> {
    match effect {
        Effect::Mark(t_s) => engine.model.mark(t_s, "marker"),
        Effect::Send(command) => send(state, engine, command),
        rest => return Some(rest),
    }
    None
}

/// What is found by the trigger is shown; commands are locked where nobody is there to take them.
pub fn follow_up(state: &mut ViewState, engine: &mut Engine) {
    state.forget_sent(&engine.model);
    let mode = state.layout.trigger.mode;
    match engine.triggered() {
        Some(Found::Hit(span)) => {
            state.stands_at_hit = mode == TriggerMode::Auto && !state.is_paused();
            state.window.show(span);
            state.triggered += 1;
        }
        Some(Found::Sweep(span)) if !state.is_paused() => {
            state.stands_at_hit = false;
            state.window = TimeWindow::new(span.length_s());
        }
        Some(Found::Sweep(_)) | None => {}
    }
    if state.armed && matches!(engine.model.status(), SourceStatus::Complete { .. }) {
        search(state, engine);
    }
    if state.armed && engine.is_trigger_done() && mode == TriggerMode::Single {
        state.armed = false;
    }
    if engine.model.status().is_disconnected() {
        state.command.armed = false;
        state.command.asks_release = false;
    }
}

/// Nothing more comes: what is waited for is looked for behind the left edge of the view, or behind what was found last and is still seen.
fn search(state: &mut ViewState, engine: &Engine) {
    let seen = state.window.visible(engine.model.span());
    let trigger = state.layout.trigger;
    let hit_s = state.hit_s.filter(|t_s| seen.holds(*t_s));
    let from_s = hit_s.map_or(seen.from_s, |at_s| trigger.behind(at_s));
    state.hit_s = trigger.first_after(&engine.model, from_s);
    state.armed = false;
    match state.hit_s {
        Some(at_s) => {
            state.window.show(trigger.around(at_s));
            state.triggered += 1;
        }
        None => state.report(format!("The trigger finds nothing after {from_s:.4} s.")),
    }
}

/// Sends a command: a stop always, everything else only while the lock is off.
fn send(state: &mut ViewState, engine: &Engine, command: ClientCommand) {
    state.command.asks_release = false;
    if !state.command.armed && command != ClientCommand::Stop {
        state.complain("Arm the commands first.");
        return;
    }
    let limit_n = engine.model.info().gripper.and_then(|gripper| gripper.force_max_n);
    if let (ClientCommand::AtLeast(force_n), Some(limit_n)) = (command, limit_n)
        && force_n > limit_n
    {
        return state.complain(format!("{force_n:.2} N is above the limit of {limit_n:.2} N."));
    }
    match engine.command(command) {
        Ok(()) => {
            let text =
                format!("Sent: {command}. Whether it was carried out stands among the events.");
            state.report_sent(text, &engine.model);
        }
        Err(refused) => state.complain(format!("Not sent: {refused}.")),
    }
}

impl ViewState {
    /// Asks for what cannot be done within a frame.
    pub fn ask(&mut self, effect: Effect) {
        self.asked.push(effect);
    }

    /// The part of the time that is seen, for the user to move: what the trigger shows is left.
    pub const fn view(&mut self) -> &mut TimeWindow {
        self.stands_at_hit = false;
        &mut self.window
    }

    /// Holds the view where it is, or follows the newest data.
    pub fn toggle_pause(&mut self, model: &Model) {
        if self.is_paused() { self.view().follow() } else { self.view().hold(model.span()) }
    }

    /// Moves the view by this share of its length; later for positive ones.
    pub fn pan_share(&mut self, share: f64, model: &Model) {
        let data = model.span();
        let by_s = share * self.window.visible(data).length_s();
        self.view().pan(by_s, data);
    }

    /// Shows so many times as much, around the pointer, else the middle of the view.
    pub fn zoom(&mut self, factor: f64, model: &Model) {
        let data = model.span();
        let seen = self.window.visible(data);
        let at_s = self.hover_s.unwrap_or_else(|| f64::midpoint(seen.from_s, seen.to_s));
        self.view().zoom(at_s, factor, data);
    }

    /// Shows this time.
    pub fn jump(&mut self, t_s: f64, model: &Model) {
        self.view().centre(t_s, model.span());
        self.event_s = Some(t_s);
    }

    /// Goes to the event after or before the one that was looked at last, or the part that is seen.
    pub fn step(&mut self, later: bool, model: &Model) {
        let seen = self.window.visible(model.span());
        let edge_s = if later { seen.from_s } else { seen.to_s };
        let at_s = self.event_s.filter(|t_s| seen.holds(*t_s)).unwrap_or(edge_s);
        let marks = &model.events().marks;
        let found = if later { marks.from(at_s.next_up()) } else { marks.at(at_s.next_down()) };
        match found.map(|mark| mark.t_s) {
            Some(t_s) => self.jump(t_s, model),
            None if later => self.report("No later event."),
            None => self.report("No earlier event."),
        }
    }

    /// Puts cursor A (0) or B (1) where the pointer is, else near the middle.
    pub fn put_cursor(&mut self, cursor: usize, model: &Model) {
        let seen = self.window.visible(model.span());
        // Without a pointer A goes to the event that was gone to; else the two stand apart, so that both are seen.
        let share = if cursor == 0 { 0.4 } else { 0.6 };
        let event_s = self.event_s.filter(|t_s| cursor == 0 && seen.holds(*t_s));
        let at_s = self.hover_s.or(event_s).unwrap_or(seen.from_s + share * seen.length_s());
        self.cursors[cursor % 2] = Some(at_s);
    }

    /// Shows what lies between the cursors.
    pub fn zoom_to_cursors(&mut self) {
        match self.between() {
            Some(span) if span.length_s() > 0.0 => self.view().show(span),
            _ => self.report("Set both cursors first."),
        }
    }

    /// Puts a marker where the pointer is, else at the newest sample.
    pub fn mark(&mut self, model: &Model) {
        match self.hover_s.or(model.span().map(|data| data.to_s)) {
            Some(t_s) => self.ask(Effect::Mark(t_s)),
            None => self.report("There is nothing to mark yet."),
        }
    }

    /// Explains the event that was gone to, else the newest that is seen, or closes the explanation; what comes later does not replace it.
    pub fn toggle_explain(&mut self, model: &Model) {
        let seen = self.window.visible(model.span());
        let at_s = self.event_s.filter(|t_s| seen.holds(*t_s)).unwrap_or(seen.to_s);
        self.explain = self.explain.is_none().then_some(at_s);
    }

    /// Arms the trigger, or disarms it.
    pub fn toggle_trigger(&mut self) {
        self.armed = !self.armed;
    }

    /// Shows these values of a plot; `None`: what is seen decides.
    pub fn set_values(&mut self, strip: StripId, scale: Option<Scale>) {
        self.values.retain(|(id, _)| *id != strip);
        self.values.extend(scale.map(|scale| (strip, scale)));
    }

    /// Shows a panel, or closes it.
    pub fn toggle_panel(&mut self, panel: Panel) {
        self.layout.panel = Some(panel).filter(|_| self.layout.panel != Some(panel));
    }

    /// Light or dark.
    pub const fn toggle_theme(&mut self) {
        let dark = matches!(self.layout.theme, Look::Dark);
        self.layout.theme = if dark { Look::Light } else { Look::Dark };
    }

    /// Shows this hint of the tour, from 0 on; the tour ends without one.
    pub fn show_hint(&mut self, hint: Option<usize>) {
        self.help = false;
        self.tour = hint;
    }

    /// Closes what lies over the plots.
    pub fn dismiss(&mut self) {
        self.help = false;
        self.explain = None;
        self.tour = None;
        self.message = None;
        self.select_s = None;
        self.command.asks_release = false;
    }

    /// Looks for the label of the recording that is open; cursor A goes to its onset.
    pub fn open_recording(&mut self, path: &Path) {
        self.recording = Labelled::of(path);
        let Some(labelled) = &mut self.recording else { return };
        let looked = labelled.look();
        if let Some(at) = labelled.label.as_ref().and_then(Label::onset) {
            self.cursors[0] = Some(at.as_seconds());
        }
        looked.unwrap_or_else(|error| self.complain(error.to_string()));
    }

    /// Writes the label of the recording, or takes it away.
    pub fn set_label(&mut self, kind: Option<LabelKind>) {
        match self.recording.as_mut().map(|labelled| labelled.set(kind)) {
            Some(Ok(done)) => self.report(done),
            Some(Err(sentence)) => self.complain(sentence),
            None => {}
        }
    }

    /// Asks for the label of the recording, where it can have it.
    pub fn label_as(&mut self, request: Labelling, model: &Model) {
        match self.kind_of(request, model) {
            Ok(kind) => self.ask(Effect::Label(kind)),
            Err(sentence) => self.complain(sentence),
        }
    }

    fn kind_of(&self, request: Labelling, model: &Model) -> Result<Option<LabelKind>, String> {
        let (Some(_), Some(recording)) = (&self.recording, model.span()) else {
            return Err("Only a recording has a label: open one first.".to_owned());
        };
        match (request, self.cursors[0]) {
            (Labelling::Remove, _) => Ok(None),
            (Labelling::Steady, _) => Ok(Some(LabelKind::Steady)),
            (Labelling::Rest, _) => Ok(Some(LabelKind::Rest)),
            (Labelling::Onset, None) => Err("Set cursor A where the slip begins first.".to_owned()),
            (Labelling::Onset, Some(_)) if !model.is_device_time() => {
                Err("The clock of this recording begins again: an onset has no one time."
                    .to_owned())
            }
            (Labelling::Onset, Some(at_s)) => labels::onset(at_s, recording).map(Some),
        }
    }

    /// Shows this stretch.
    pub fn show(&mut self, span: Span) {
        self.view().show(span);
    }
}
