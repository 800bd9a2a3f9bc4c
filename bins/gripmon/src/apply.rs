//! A request of the user in; the state, the model, the source changed: the one place where that happens.

use crate::action::{Action, Cursor, Labelling, Order};
use crate::engine::Engine;
use crate::form::TriggerForm;
use crate::labels;
use crate::layout::Look;
use crate::state::ViewState;
use crate::time::TimeWindow;
use crate::views::HINTS;
use grip_link::message::FaultCode;
use grip_record::LabelKind;
use grip_scope::trigger::{Found, TriggerMode};
use grip_scope::{SourceStatus, Span};
use slip_core::ClientCommand;

/// What cannot be done between two frames: the window does it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
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

/// Carries out a request; what remains to be done.
pub fn apply(state: &mut ViewState, engine: &mut Engine, action: &Action) -> Option<Effect> {
    match *action {
        Action::ExportPicture => return Some(Effect::Picture),
        Action::ExportCsv => return Some(Effect::Csv),
        Action::ExportMcap => return Some(Effect::Mcap),
        Action::ExportReport => return Some(Effect::Report),
        Action::Label(request) => return label(state, engine, request),
        _ => {}
    }
    let done = command(state, engine, action)
        || trigger(state, engine, action)
        || arrange(state, action)
        || measure(state, engine, action);
    if !done {
        time(state, engine, action);
    }
    None
}

/// What is found by the trigger is shown; commands are locked where nobody is there to take them.
pub fn follow_up(state: &mut ViewState, engine: &mut Engine) {
    state.forget_sent(&engine.model);
    match engine.triggered() {
        Some(Found::Hit(span)) => {
            state.stands_at_hit = state.trigger.mode == TriggerMode::Auto && !state.is_paused();
            state.window.show(span);
            state.triggered += 1;
        }
        Some(Found::Sweep(span)) if !state.is_paused() => {
            state.stands_at_hit = false;
            state.window = TimeWindow::new(span.length_s());
        }
        Some(Found::Sweep(_)) | None => {}
    }
    if state.trigger.armed && matches!(engine.model.status(), SourceStatus::Complete { .. }) {
        search(state, engine);
    }
    if state.trigger.armed && engine.is_trigger_done() && state.trigger.mode == TriggerMode::Single
    {
        state.trigger.armed = false;
        engine.watch(None);
    }
    if engine.model.status().is_disconnected() {
        state.command.armed = false;
        state.command.asks_release = false;
    }
}

/// Nothing more comes: what is waited for is looked for behind the left edge of the view, or behind what was found last and is still seen.
fn search(state: &mut ViewState, engine: &mut Engine) {
    let seen = state.window.visible(engine.model.span());
    let trigger = state.trigger.trigger();
    let hit_s = state.hit_s.filter(|t_s| seen.holds(*t_s));
    let from_s = hit_s.map_or(seen.from_s, |at_s| trigger.behind(at_s));
    state.hit_s = trigger.first_after(&engine.model, from_s);
    state.trigger.armed = false;
    engine.watch(None);
    match state.hit_s {
        Some(at_s) => {
            state.window.show(trigger.around(at_s));
            state.triggered += 1;
        }
        None => state.report(format!("The trigger finds nothing after {from_s:.4} s.")),
    }
}

fn time(state: &mut ViewState, engine: &Engine, action: &Action) {
    let data = engine.model.span();
    let seen = state.window.visible(data);
    let paused = state.is_paused();
    state.stands_at_hit = false;
    match *action {
        Action::TogglePause if paused => state.window.follow(),
        Action::TogglePause => state.window.hold(data),
        Action::Follow => state.window.follow(),
        Action::ShowAll => state.window.all(),
        Action::Pan(by_s) => state.window.pan(by_s, data),
        Action::PanShare(share) => state.window.pan(share * seen.length_s(), data),
        Action::Zoom { at_s, factor } => state.window.zoom(at_s, factor, data),
        Action::ZoomKey(factor) => state.window.zoom(pointed(state, seen), factor, data),
        Action::Show(span) => state.window.show(span),
        Action::Length(length_s) => state.window.resize(length_s, data),
        Action::JumpTo(t_s) => jump(state, engine, t_s),
        Action::NextEvent | Action::PreviousEvent => {
            step(state, engine, *action == Action::NextEvent)
        }
        _ => {}
    }
}

/// The pointer's time, else the middle of the view.
fn pointed(state: &ViewState, seen: Span) -> f64 {
    state.hover_s.unwrap_or_else(|| f64::midpoint(seen.from_s, seen.to_s))
}

fn jump(state: &mut ViewState, engine: &Engine, t_s: f64) {
    state.window.centre(t_s, engine.model.span());
    state.event_s = Some(t_s);
}

/// Goes to the event after or before the one that was looked at last, or the part that is seen.
fn step(state: &mut ViewState, engine: &Engine, later: bool) {
    let seen = state.window.visible(engine.model.span());
    let at_s = state.event_s.filter(|t_s| seen.holds(*t_s)).unwrap_or(if later {
        seen.from_s
    } else {
        seen.to_s
    });
    let events = engine.model.events();
    let found = if later { events.next_after(at_s) } else { events.before(at_s) };
    match found.map(|mark| mark.t_s) {
        Some(t_s) => jump(state, engine, t_s),
        None if later => state.report("No later event."),
        None => state.report("No earlier event."),
    }
}

fn measure(state: &mut ViewState, engine: &mut Engine, action: &Action) -> bool {
    let data = engine.model.span();
    let seen = state.window.visible(data);
    match *action {
        Action::CursorHere(cursor) => {
            // Without a pointer A goes to the event that was gone to; else the two stand apart, so that both are seen.
            let share = if cursor == Cursor::A { 0.4 } else { 0.6 };
            let event_s = state.event_s.filter(|t_s| cursor == Cursor::A && seen.holds(*t_s));
            let at_s = state.hover_s.or(event_s).unwrap_or(seen.from_s + share * seen.length_s());
            state.set_cursor(cursor, Some(at_s));
        }
        Action::PlaceCursor(cursor, at_s) if at_s.is_finite() => {
            state.set_cursor(cursor, Some(at_s))
        }
        Action::ClearCursors => state.cursors = [None; 2],
        Action::ZoomToCursors => match state.between() {
            Some(span) if span.length_s() > 0.0 => state.window.show(span),
            _ => state.report("Set both cursors first."),
        },
        Action::MarkHere => match state.hover_s.or(data.map(|data| data.to_s)) {
            Some(t_s) => engine.model.mark(t_s, "marker"),
            None => state.report("There is nothing to mark yet."),
        },
        Action::ToggleExplain => {
            // The event that was gone to, else the newest that is seen; what comes later does not replace it.
            let at_s = state.event_s.filter(|t_s| seen.holds(*t_s)).unwrap_or(seen.to_s);
            state.explain = state.explain.is_none().then_some(at_s);
        }
        Action::Hover(at_s) => state.hover_s = at_s.filter(|_| !state.no_pointer),
        Action::Select(at_s) => state.select_s = at_s,
        _ => return false,
    }
    true
}

fn trigger(state: &mut ViewState, engine: &mut Engine, action: &Action) -> bool {
    match *action {
        Action::ToggleTrigger => state.trigger.armed = !state.trigger.armed,
        Action::SetTrigger(form) => {
            state.trigger = form;
            state.layout.trigger = TriggerForm { armed: false, ..form };
        }
        _ => return false,
    }
    engine.watch(state.trigger.armed.then(|| state.trigger.trigger()));
    true
}

fn arrange(state: &mut ViewState, action: &Action) -> bool {
    let layout = &mut state.layout;
    match *action {
        Action::ToggleStrip(strip) => {
            let found = layout.plots.iter_mut().find(|plot| plot.plot == strip);
            found.into_iter().for_each(|plot| plot.shown = !plot.shown);
        }
        Action::Height(strip, height) if height.is_finite() => {
            let found = layout.plots.iter_mut().find(|plot| plot.plot == strip);
            found.into_iter().for_each(|plot| plot.height = height.clamp(0.3, 8.0));
        }
        Action::MoveStrip(strip, up) => {
            let Some(place) = layout.plots.iter().position(|plot| plot.plot == strip) else {
                return true;
            };
            let to = place.saturating_add_signed(-isize::from(up)).min(layout.plots.len() - 1);
            let plot = layout.plots.remove(place);
            layout.plots.insert(to, plot);
        }
        Action::TogglePanel(panel) => {
            layout.panel = Some(panel).filter(|_| layout.panel != Some(panel))
        }
        Action::PanelWidth(width) => layout.panel_width = width,
        Action::ToggleTheme => {
            layout.theme = if layout.theme == Look::Dark { Look::Light } else { Look::Dark }
        }
        Action::ToggleHelp => state.help = !state.help,
        Action::Dismiss => {
            state.help = false;
            state.explain = None;
            state.tour = None;
            state.message = None;
            state.select_s = None;
            state.command.asks_release = false;
        }
        Action::Tour(hint) => {
            state.help = false;
            state.tour = hint.filter(|hint| *hint < HINTS.len());
        }
        Action::Values(strip, scale) => {
            state.values.retain(|(id, _)| *id != strip);
            state.values.extend(scale.map(|scale| (strip, scale)));
        }
        Action::AutoValues => state.values.clear(),
        Action::ExportStem(ref stem) => state.stem.clone_from(stem),
        _ => return false,
    }
    true
}

/// The label that is to be written, where it can be.
fn label(state: &mut ViewState, engine: &Engine, request: Labelling) -> Option<Effect> {
    let (Some(_), Some(recording)) = (&state.recording, engine.model.span()) else {
        state.complain("Only a recording has a label: open one first.");
        return None;
    };
    let kind = match (request, state.cursor(Cursor::A)) {
        (Labelling::Remove, _) => return Some(Effect::Label(None)),
        (Labelling::Steady, _) => LabelKind::Steady,
        (Labelling::Rest, _) => LabelKind::Rest,
        (Labelling::Onset, None) => {
            state.complain("Set cursor A where the slip begins first.");
            return None;
        }
        (Labelling::Onset, Some(_)) if !engine.model.is_device_time() => {
            state.complain("The clock of this recording begins again: an onset has no one time.");
            return None;
        }
        (Labelling::Onset, Some(at_s)) => match labels::onset(at_s, recording) {
            Ok(kind) => kind,
            Err(sentence) => {
                state.complain(sentence);
                return None;
            }
        },
    };
    Some(Effect::Label(Some(kind)))
}

fn command(state: &mut ViewState, engine: &mut Engine, action: &Action) -> bool {
    match *action {
        Action::Arm(armed) => state.command.armed = armed,
        Action::ForceEntry(force_n) if force_n.is_finite() => {
            state.command.force_n = force_n.max(0.0)
        }
        Action::AskRelease(asks) => state.command.asks_release = asks && state.command.armed,
        Action::Send(order) => {
            state.command.asks_release = false;
            send(state, engine, order);
        }
        _ => return false,
    }
    true
}

/// Sends a command: a stop always, everything else only while the lock is off.
fn send(state: &mut ViewState, engine: &mut Engine, order: Order) {
    if !state.command.armed && order != Order::Stop {
        state.complain("Arm the commands first.");
        return;
    }
    let limit_n = engine
        .model
        .info()
        .gripper
        .and_then(|gripper| gripper.force_max_n)
        .map_or(f64::INFINITY, f64::from);
    let fault = engine.model.info().state.map_or(FaultCode::NONE, |state| state.fault);
    let command = match order {
        Order::AtLeast(force_n) if force_n > limit_n => {
            state.complain(format!("{force_n:.2} N is above the limit of {limit_n:.2} N."));
            return;
        }
        Order::AtLeast(force_n) => ClientCommand::AtLeast(crate::num::narrow(force_n)),
        Order::Release => ClientCommand::Release,
        Order::Grasp => ClientCommand::Grasp,
        Order::Stop => ClientCommand::Stop,
        Order::ClearFault => ClientCommand::ClearFault(fault),
    };
    match engine.command(command) {
        Ok(()) => {
            let text =
                format!("Sent: {command}. Whether it was carried out stands among the events.");
            state.report_sent(text, &engine.model);
        }
        Err(refused) => state.complain(format!("Not sent: {refused}.")),
    }
}
