//! Every control, found by its label and used: what it does. A control that is not in the table makes a test fail.

use super::{fixture, window};
use eframe::egui::{Role, vec2};
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};
use egui_kittest::{Harness, Node};
use grip_link::message::FaultCode;
use grip_scope::feed::Feed;
use grip_scope::trigger::Condition;
use grip_scope::trigger::TriggerMode;
use grip_scope::{Channel, EventKind, Span};
use gripmon::Scope;
use gripmon::labels::Labelled;
use gripmon::layout::{Look, Panel};
use gripmon::plot::{Kind, Scale};
use gripmon::strip::StripId;
use gripmon::time::Following;
use std::path::Path;

/// How a control is used.
#[derive(Clone, Copy)]
enum Use {
    Click,
    /// A number is put in.
    Set(f64),
    /// One of its choices is taken.
    Choose(&'static str),
    /// It is dragged by so many points to the right and down.
    Drag(f32, f32),
    /// A text is typed into it.
    Type(&'static str),
}

/// A control, what has to be so before it is there, how it is used and what is so then.
struct Case {
    panel: Panel,
    label: &'static str,
    before: fn(&mut Scope),
    used: Use,
    done: Done,
}

/// Whether a control has done what it reports.
type Done = fn(&Scope) -> bool;

const fn case(
    panel: Panel,
    label: &'static str,
    before: fn(&mut Scope),
    used: Use,
    done: Done,
) -> Case {
    Case { panel, label, before, used, done }
}

fn nothing(_: &mut Scope) {}

fn length_s(scope: &Scope) -> f64 {
    let span = scope.state.window.visible(scope.shared.engine().model.span());
    span.to_s - span.from_s
}

fn half_a_second(scope: &mut Scope) {
    scope.state.window.show(Span::new(1.0, 1.5));
}

fn both_cursors(scope: &mut Scope) {
    scope.state.cursors = [Some(1.0), Some(1.25)];
}

fn markers(scope: &Scope) -> usize {
    let engine = scope.shared.engine();
    engine.model.events().marks.iter().filter(|mark| mark.kind == EventKind::Marker).count()
}

fn stated(scope: &Scope, text: &str) -> bool {
    scope.state.message.as_ref().is_some_and(|message| message.text.contains(text))
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

fn toolbar() -> Vec<Case> {
    use Use::{Click, Set};
    let at = Panel::Health;
    vec![
        case(at, "Pause", |s| s.state.window.follow(), Click, |s| s.state.is_paused()),
        case(at, "Follow", half_a_second, Click, |s| {
            s.state.window.following() == Following::Newest
        }),
        case(at, "View", nothing, Set(1.25), |s| near(length_s(s), 1.25)),
        case(at, "-", half_a_second, Click, |s| near(length_s(s), 1.0)),
        case(at, "+", half_a_second, Click, |s| near(length_s(s), 0.25)),
        case(at, "All", half_a_second, Click, |s| s.state.window.following() == Following::All),
        case(at, "< Event", half_a_second, Click, |s| s.state.event_s == Some(1.1)),
        case(at, "Event >", half_a_second, Click, |s| s.state.event_s == Some(1.1)),
        case(at, "Mark", nothing, Click, |s| markers(s) == 1),
        case(at, "A", half_a_second, Click, |s| s.state.cursors[0].is_some()),
        case(at, "B", half_a_second, Click, |s| s.state.cursors[1].is_some()),
        case(at, "Clear cursors", both_cursors, Click, |s| s.state.cursors == [None; 2]),
        case(at, "Health", nothing, Click, |s| s.state.layout.panel.is_none()),
        case(at, "Events", nothing, Click, |s| s.state.layout.panel == Some(Panel::Events)),
        case(at, "Cursors", nothing, Click, |s| s.state.layout.panel == Some(Panel::Cursors)),
        case(at, "Trigger", nothing, Click, |s| s.state.layout.panel == Some(Panel::Trigger)),
        case(at, "Export", nothing, Click, |s| s.state.layout.panel == Some(Panel::Export)),
        case(at, "Command", nothing, Click, |s| s.state.layout.panel == Some(Panel::Command)),
        case(at, "Light", nothing, Click, |s| s.state.layout.theme == Look::Light),
        case(
            at,
            "Dark",
            |s| s.state.layout.theme = Look::Light,
            Click,
            |s| s.state.layout.theme == Look::Dark,
        ),
        case(at, "?", nothing, Click, |s| s.state.help),
        case(at, "Close", |s| s.state.help = true, Click, |s| !s.state.help),
        case(at, "Tour", |s| s.state.help = true, Click, |s| s.state.tour == Some(0)),
        case(at, "Next (Enter)", |s| s.state.tour = Some(0), Click, |s| s.state.tour == Some(1)),
        case(at, "Done (Enter)", |s| s.state.tour = Some(2), Click, |s| s.state.tour.is_none()),
        case(
            at,
            "End the tour (Esc)",
            |s| s.state.tour = Some(0),
            Click,
            |s| s.state.tour.is_none(),
        ),
        case(at, "Close message", |s| s.state.report("x"), Click, |s| s.state.message.is_none()),
    ]
}

fn plots() -> Vec<Case> {
    use Use::{Click, Drag, Set};
    let at = Panel::Health;
    let by_hand = |s: &mut Scope| {
        s.state.values = vec![(StripId::Force, Scale::new(Kind::Linear, 0.0, 1.0))];
    };
    vec![
        case(at, "values by hand", by_hand, Click, |s| s.state.values.is_empty()),
        case(at, "Force axis", nothing, Drag(0.0, 20.0), |s| s.state.values.len() == 1),
        case(at, "Stylus height", nothing, Drag(0.0, 20.0), |s| {
            s.state.layout.plots[0].height > StripId::Stylus.weight() * 1.05
        }),
        case(at, "Force plot", half_a_second, Drag(-100.0, 0.0), |s| {
            s.state.window.visible(None).from_s > 1.02
        }),
        case(at, "Cursor A", both_cursors, Drag(50.0, 0.0), |s| s.state.cursors[0] > Some(1.02)),
        case(at, "Cursor B", both_cursors, Drag(50.0, 0.0), |s| s.state.cursors[1] > Some(1.27)),
        case(at, "Overview of all data", half_a_second, Click, |s| {
            // In its middle are the middle of the data.
            let seen = s.state.window.visible(None);
            near(seen.to_s - seen.from_s, 0.5) && (seen.from_s - 0.75).abs() < 0.02
        }),
        // A share of the window.
        case(at, "Resize panel", nothing, Set(0.3), |s| {
            (410.0..425.0).contains(&s.state.layout.panel_width)
        }),
    ]
}

fn panels() -> Vec<Case> {
    use Use::{Click, Type};
    let cursors = Panel::Cursors;
    vec![
        case(cursors, "Set A", half_a_second, Click, |s| s.state.cursors[0].is_some()),
        case(cursors, "Set B", half_a_second, Click, |s| s.state.cursors[1].is_some()),
        case(cursors, "Clear", both_cursors, Click, |s| s.state.cursors == [None; 2]),
        case(cursors, "Zoom", both_cursors, Click, |s| near(length_s(s), 0.25)),
        case(Panel::Events, "Previous event", half_a_second, Click, |s| {
            s.state.event_s == Some(1.1)
        }),
        case(Panel::Events, "Next event", half_a_second, Click, |s| s.state.event_s == Some(1.1)),
        case(Panel::Events, "Explain", half_a_second, Click, |s| s.state.explain == Some(1.5)),
        case(Panel::Events, "     0.9500 s  gross slip", nothing, Click, |s| {
            s.state.event_s == Some(0.95)
        }),
        case(Panel::Export, "Names begin with (folders are allowed)", nothing, Type("run/"), |s| {
            s.state.stem.contains("run/")
        }),
    ]
}

fn waits_for(scope: &Scope, event: EventKind) -> bool {
    let form = scope.state.layout.trigger;
    (form.condition, form.event) == (Condition::Event, event)
}

fn trigger() -> Vec<Case> {
    use Use::{Choose, Click, Set};
    let at = Panel::Trigger;
    let rising = |s: &mut Scope| s.state.layout.trigger.condition = Condition::RisingEdge;
    let mut cases = vec![
        case(at, "Arm", nothing, Click, |s| s.state.armed),
        case(at, "Disarm", |s| s.state.armed = true, Click, |s| !s.state.armed),
        case(at, "Channel", rising, Choose("normal force"), |s| {
            // The level is one of the new channel.
            let form = s.state.layout.trigger;
            form.channel == Channel::NormalForce && (4.0..6.0).contains(&form.level)
        }),
        case(at, "Level", rising, Set(2.5), |s| near(s.state.layout.trigger.level, 2.5)),
        case(at, "Single", nothing, Click, |s| s.state.layout.trigger.mode == TriggerMode::Single),
        case(at, "Auto", nothing, Click, |s| s.state.layout.trigger.mode == TriggerMode::Auto),
        case(
            at,
            "Normal",
            |s| s.state.layout.trigger.mode = TriggerMode::Auto,
            Click,
            |s| s.state.layout.trigger.mode == TriggerMode::Normal,
        ),
        case(at, "Before it", nothing, Set(0.25), |s| near(s.state.layout.trigger.before_s, 0.25)),
        case(at, "In all", nothing, Set(2.0), |s| near(s.state.layout.trigger.window_s, 2.0)),
    ];
    let conditions: [(&'static str, Done); 10] = [
        ("rising edge", |s| s.state.layout.trigger.condition == Condition::RisingEdge),
        ("falling edge", |s| s.state.layout.trigger.condition == Condition::FallingEdge),
        ("above the level", |s| s.state.layout.trigger.condition == Condition::Above),
        ("below the level", |s| s.state.layout.trigger.condition == Condition::Below),
        ("incipient slip", |s| waits_for(s, EventKind::Incipient)),
        ("slip ended", |s| waits_for(s, EventKind::Ended)),
        ("reflex", |s| waits_for(s, EventKind::Reflex)),
        ("gap", |s| waits_for(s, EventKind::Gap)),
        ("fault", |s| waits_for(s, EventKind::Fault)),
        ("marker", |s| waits_for(s, EventKind::Marker)),
    ];
    let conditions = conditions.into_iter();
    cases.extend(conditions.map(|(name, done)| case(at, "Condition", nothing, Choose(name), done)));
    cases
}

fn commands() -> Vec<Case> {
    use Use::{Click, Set};
    let at = Panel::Command;
    let armed = |s: &mut Scope| s.state.command.armed = true;
    let asks = |s: &mut Scope| {
        s.state.command.armed = true;
        s.state.command.asks_release = true;
    };
    let fault = |s: &mut Scope| {
        s.state.command.armed = true;
        let state = slip_core::PipelineState { fault: FaultCode(0x2103), ..fixture::state(1.99) };
        s.shared.engine().model.take(Feed::State(state));
    };
    // This model has no source behind it: what was tried is refused, and reported.
    let tried = |s: &Scope| stated(s, "Not sent: only a running daemon");
    vec![
        case(at, "Stop", nothing, Click, tried),
        case(at, "Arm commands", nothing, Click, |s| s.state.command.armed),
        case(at, "At least", armed, Set(7.5), |s| near(s.state.command.force_n, 7.5)),
        case(at, "Hold with this force", armed, Click, tried),
        case(at, "Grasp", armed, Click, tried),
        case(at, "Release ..", armed, Click, |s| s.state.command.asks_release),
        case(at, "Clear the fault", fault, Click, tried),
        case(at, "Keep holding", asks, Click, |s| {
            !s.state.command.asks_release && s.state.message.is_none()
        }),
        case(at, "Yes, release", asks, Click, tried),
    ]
}

fn all() -> Vec<Case> {
    [toolbar(), plots(), panels(), trigger(), commands()].into_iter().flatten().collect()
}

fn is_control(role: Role) -> bool {
    matches!(
        role,
        Role::Button
            | Role::CheckBox
            | Role::RadioButton
            | Role::ComboBox
            | Role::Slider
            | Role::SpinButton
            | Role::Splitter
            | Role::TextInput
            | Role::ListBoxOption
            | Role::MenuItem
    )
}

/// The control of this label; others, as names beside plots, may be called so as well.
#[expect(clippy::panic, reason = "part of a test")]
pub(crate) fn control<'a>(harness: &'a Harness<'_, Scope>, label: &'a str) -> Node<'a> {
    let mut found: Vec<Node<'a>> = harness.query_all_by_label(label).collect();
    found.sort_by_key(|node| !is_control(node.accesskit_node().role()));
    found.into_iter().next().unwrap_or_else(|| panic!("there is no {label:?}"))
}

/// The texts that are painted, those of plots included, which are no labels.
pub(crate) fn painted(harness: &Harness<'_, Scope>) -> Vec<String> {
    let mut texts = Vec::new();
    for clipped in &harness.output().shapes {
        if let eframe::egui::Shape::Text(text) = &clipped.shape {
            texts.push(text.galley.text().to_owned());
        }
    }
    texts
}

fn click(harness: &mut Harness<'_, Scope>, label: &str) {
    control(harness, label).click();
    harness.run();
}

fn drag(harness: &mut Harness<'_, Scope>, label: &str, by: (f32, f32)) {
    let from = control(harness, label).rect().center();
    let to = from + vec2(by.0, by.1);
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run();
}

fn apply(harness: &mut Harness<'_, Scope>, label: &str, used: Use) {
    match used {
        Use::Click => click(harness, label),
        Use::Set(value) => {
            control(harness, label).set_value_accesskit(value);
            harness.run();
        }
        Use::Choose(choice) => {
            click(harness, label);
            click(harness, choice);
        }
        Use::Drag(x, y) => drag(harness, label, (x, y)),
        Use::Type(text) => {
            click(harness, label);
            control(harness, label).type_text(text);
            harness.run();
        }
    }
}

#[test]
fn every_control_does_what_its_label_states() {
    for Case { panel, label, before, used, done } in all() {
        let mut harness = window(fixture::grasp(), panel);
        before(harness.state_mut());
        harness.run();
        assert!(!done(harness.state()), "{label}: it is so already");
        apply(&mut harness, label, used);
        let choice = if let Use::Choose(choice) = used { choice } else { "" };
        assert!(done(harness.state()), "{label} {choice}: {:?}", harness.state().state);
    }
}

#[test]
fn every_plot_is_chosen_and_moved_by_the_menu() {
    for strip in StripId::ALL {
        let mut harness = window(fixture::grasp(), Panel::Health);
        let place = |harness: &Harness<'_, Scope>| {
            let plots = harness.state().state.layout.plots.clone();
            plots.iter().position(|plot| plot.plot == strip && plot.shown)
        };
        let before = place(&harness).unwrap();
        click(&mut harness, "Plots");
        if before > 0 {
            click(&mut harness, &format!("Move {} up", strip.title()));
            assert_eq!(place(&harness), Some(before - 1), "{strip:?}");
            click(&mut harness, "Plots");
        }
        click(&mut harness, strip.title());
        assert_eq!(place(&harness), None, "{strip:?}");
        harness.state_mut().state.values = vec![(strip, Scale::new(Kind::Linear, 0.0, 1.0))];
        harness.run();
        click(&mut harness, "Plots");
        click(&mut harness, "Scale values to what is seen");
        assert!(harness.state().state.values.is_empty());
    }
}

/// What is used by other tests: files and pictures by those of the desk.
const ELSEWHERE: [&str; 10] = [
    "Plots",
    "Samples as CSV",
    "Recording (MCAP)",
    "Report (HTML)",
    "Picture (PNG)",
    "Slip begins at cursor A",
    "Slips all the time",
    "Never slips",
    "Remove the label",
    "Scale values to what is seen",
];

fn is_known(label: &str) -> bool {
    let chosen = |used: Use| matches!(used, Use::Choose(choice) if choice == label);
    let known = |case: &Case| case.label == label || chosen(case.used);
    // Controls of which each plot or each event has one.
    let of_each = StripId::ALL.iter().any(|strip| {
        let title = strip.title();
        label == title || label == format!("{title} height") || label == format!("Move {title} up")
    });
    let is_event =
        EventKind::ALL.iter().any(|kind| label.ends_with(&format!(" s  {}", kind.name())));
    all().iter().any(known) || ELSEWHERE.contains(&label) || of_each || is_event
}

/// The labels of the controls that are there; each must have one.
fn labels(harness: &Harness<'_, Scope>) -> Vec<String> {
    let controls = harness.query_all(By::new().predicate(|node| is_control(node.role())));
    let label = |node: Node<'_>| {
        let label = node.accesskit_node().label().unwrap_or_default();
        assert!(!label.is_empty(), "without a label: {:?}", node.rect());
        label
    };
    controls.map(label).collect()
}

#[test]
fn no_control_is_without_a_label_or_missing_in_the_table() {
    let overlays: [fn(&mut Scope); 6] = [
        nothing,
        both_cursors,
        |s| s.state.help = true,
        |s| s.state.explain = Some(1.5),
        |s| {
            s.state.tour = Some(0);
            s.state.recording = Labelled::of(Path::new("run.mcap"));
        },
        |s| {
            s.state.command.armed = true;
            s.state.command.asks_release = true;
            s.state.layout.trigger.condition = Condition::Above;
            s.state.report("x");
            s.state.values = vec![(StripId::Force, Scale::new(Kind::Linear, 0.0, 1.0))];
        },
    ];
    for panel in Panel::ALL {
        for overlay in overlays {
            let mut harness = window(fixture::grasp(), panel);
            overlay(harness.state_mut());
            harness.run();
            let found = labels(&harness);
            assert!(found.len() > 20, "{found:?}");
            for label in found {
                assert!(is_known(&label), "{panel:?}: {label:?} is not used by any test");
            }
        }
    }
    let mut harness = window(fixture::grasp(), Panel::Health);
    click(&mut harness, "Plots");
    assert!(labels(&harness).iter().all(|label| is_known(label)));
}
