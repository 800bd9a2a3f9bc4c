//! The demo: grasps in real time, with everything that a daemon reports, and commands.

use crate::rig::Watch;
use grip_link::message::DeviceState;
use grip_scope::{Channel, EventKind, EventMark, Model, Refused, SourceSpec, SourceStatus};
use slip_core::ClientCommand;

#[test]
fn a_grasp_shows_samples_states_bands_events_and_health() {
    let mut watch = Watch::new(SourceSpec::parse("demo").unwrap());
    watch.until(
        || {},
        |model| {
            let has = |kind| model.events().marks.iter().any(|mark| mark.kind == kind);
            let curve = |channel| model.series(channel).is_some_and(|s| s.latest().is_some());
            has(EventKind::Reload)
                && (has(EventKind::Incipient) || has(EventKind::Gross))
                && has(EventKind::Ended)
                && has(EventKind::Reflex)
                && curve(Channel::EscHigh)
                && curve(Channel::EstimateHigh)
                && model.health().latest.is_some()
        },
    );
    assert_eq!(watch.model.status(), &SourceStatus::Live);
    for channel in [
        Channel::Stylus,
        Channel::NormalForce,
        Channel::Statistic,
        Channel::Command,
        Channel::Applied,
        Channel::ForceLimit,
        Channel::Band1,
        Channel::SlipSpeed,
    ] {
        assert!(watch.model.series(channel).is_some(), "{channel:?}");
    }
    let health = watch.model.health().latest.as_deref().unwrap();
    assert!(health.samples > 1000 && health.lost == 0, "{health:?}");
    let appended = health.appended.unwrap();
    assert!(appended.p999_us >= health.latency.p50_us);
    let counted: u64 = appended.histogram.iter().sum();
    assert!(counted > 0);
    assert!(!watch.model.spectrogram().is_empty());
    let all = watch.model.span().unwrap();
    assert!(!watch.model.turns(all, usize::MAX).is_empty());
    assert_eq!(watch.model.health().stray_states, 0);
    // The value reported lies within the enclosure that the observer derives for the same slip.
    watch.handle.orders.send(ClientCommand::Stop).unwrap();
    watch.until(|| {}, |model| model.notices().any(|line| line.starts_with("stop")));
    let refused = watch.handle.orders.send(ClientCommand::AtLeast(f32::NAN));
    assert!(matches!(refused, Err(Refused::NoForce(_))));
}

#[test]
fn a_scene_that_is_none_is_reported() {
    let mut watch = Watch::new(SourceSpec::parse("demo:nowhere").unwrap());
    watch.until(|| {}, |model| matches!(model.status(), SourceStatus::Failed { .. }));
    assert!(watch.model.status().sentence().contains("built in are"));
    let file = Watch::new(SourceSpec::parse("x.mcap").unwrap());
    assert_eq!(file.handle.orders.send(ClientCommand::Grasp), Err(Refused::NotLive));
}

#[test]
fn a_stop_is_an_event_and_holds_until_the_fingers_close_again() {
    let mut watch = Watch::new(SourceSpec::parse("demo").unwrap());
    let objects = |model: &Model| {
        let begun = |mark: &&EventMark| mark.text.starts_with("next object");
        model.events().marks.iter().filter(begun).count()
    };
    watch.until(|| {}, |model| model.end_s() > 0.5);
    watch.handle.orders.send(ClientCommand::Stop).unwrap();
    let answered = |text: &'static str| {
        move |model: &Model| {
            let mut marks = model.events().marks.iter();
            marks.any(|mark| mark.kind == EventKind::Client && mark.text.starts_with(text))
        }
    };
    watch.until(|| {}, answered("stop: "));
    // Without the stop the object is let go after 4 s, and the next one comes.
    watch.until(|| {}, |model| model.end_s() > 5.0);
    let state = watch.model.info().state.unwrap();
    assert_eq!(state.device, DeviceState::Estop);
    assert_eq!(objects(&watch.model), 1);
    watch.handle.orders.send(ClientCommand::Release).unwrap();
    watch.until(|| {}, answered("release: not possible while it is stopped"));
    watch.handle.orders.send(ClientCommand::Grasp).unwrap();
    watch.until(|| {}, |model| objects(model) == 2);
    assert!(answered("grasp: the stop is over")(&watch.model));
}
