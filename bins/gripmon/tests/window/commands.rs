//! Commands are locked, limited and asked for; they are refused where nobody is there to take them, and only there.

use super::controls::click;
use super::{fixture, window};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use grip_scope::feed::Feed;
use grip_scope::{Model, SourceStatus};
use gripmon::Scope;
use gripmon::layout::Panel;

#[test]
fn a_locked_button_does_nothing_and_a_refusal_is_reported() {
    let mut harness = window(fixture::grasp(), Panel::Command);
    // A locked button does nothing.
    harness.get_by_label("Hold with this force").click();
    harness.run();
    assert!(harness.state().state.message.is_none());
    click(&mut harness, "Arm commands");
    click(&mut harness, "Hold with this force");
    // This model has no source behind it: the refusal is reported.
    let message = harness.state().state.message.clone().unwrap();
    assert!(message.text.starts_with("Not sent: only a running daemon"), "{message:?}");
}

fn report(harness: &mut Harness<'_, Scope>, status: SourceStatus) {
    harness.state().shared.engine().model.take(Feed::Status(status));
    harness.run();
}

#[test]
fn a_stream_that_stalls_can_be_stopped_and_a_lost_connection_locks() {
    let mut harness = window(fixture::grasp(), Panel::Command);
    click(&mut harness, "Arm commands");
    report(&mut harness, SourceStatus::Stalled { for_s: 1.0 });
    assert!(harness.state().state.command.armed);
    click(&mut harness, "Stop");
    // It was tried: this model has no source behind it.
    let message = harness.state().state.message.clone().unwrap();
    assert!(message.text.starts_with("Not sent: only a running daemon"), "{message:?}");
    let gone = [
        SourceStatus::Connecting { what: "tcp:x".into(), before: String::new() },
        SourceStatus::Connecting { what: "tcp:x".into(), before: "gone".into() },
        SourceStatus::Waiting { reason: "gone".into(), again_in_s: 1.0 },
        SourceStatus::Failed { sentence: "gone".into() },
    ];
    for status in gone {
        report(&mut harness, SourceStatus::Live);
        harness.state_mut().state.command.armed = true;
        harness.run();
        assert!(harness.state().state.command.armed, "{status:?}");
        report(&mut harness, status.clone());
        assert!(!harness.state().state.command.armed, "{status:?}");
        harness.get_by_label("There is no connection to gripd now.");
        assert_eq!(harness.query_all_by_label("Stop").count(), 0, "{status:?}");
    }
}

#[test]
fn before_the_first_contact_it_is_reported_that_no_daemon_has_answered() {
    let mut harness = window(Model::new(1 << 20), Panel::Command);
    harness.get_by_label_contains("this source is none");
    let waiting = SourceStatus::Waiting { reason: "gone".into(), again_in_s: 1.0 };
    for status in
        [SourceStatus::Connecting { what: "tcp:x".into(), before: String::new() }, waiting]
    {
        report(&mut harness, status);
        harness.get_by_label("No gripd has answered yet.");
        assert_eq!(harness.query_all_by_label("Stop").count(), 0);
    }
}

#[test]
fn a_daemon_that_takes_no_commands_is_not_asked_for_any() {
    let mut model = fixture::grasp();
    fixture::greet(&mut model, false);
    let harness = window(model, Panel::Command);
    harness.get_by_label_contains("takes no commands of clients");
    assert_eq!(harness.query_all_by_label("Arm commands").count(), 0);
}
