use super::{DIFFERS, Figure, Memory, Object, Remembered};
use crate::report::Event;
use proptest::prelude::*;
use slip_core::{Phase, SlipReport, estimate::KAPPA, grip::GripEvent, units::Micros};

fn found(held_n: f32) -> Event {
    Event::Grip { t: Micros(0), event: GripEvent::Found, command_n: Some(held_n) }
}

/// A slip that has passed `count` irregularities of `spacing_um` and `height_um`.
fn slip(count: u32, spacing_um: f32, height_um: f32) -> Event {
    let moved_m = 1e-6 * spacing_um * count as f32;
    Event::Slip(SlipReport {
        phase: Phase::Ended,
        irregularities: Some(count),
        moved_m: Some(moved_m),
        mean_slope: Some(height_um / spacing_um),
        ..SlipReport::UNKNOWN
    })
}

/// One grasp of what needs `needed_n`.
fn grasp(memory: &mut Memory, needed_n: f32) -> Option<Remembered> {
    memory.begin();
    memory.watch(Some(2.0 * needed_n));
    memory.take(&found(KAPPA * needed_n))
}

fn learned(memory: &Memory, name: &str) -> Object {
    memory.objects()[name]
}

#[test]
fn the_first_grasp_begins_with_nothing_and_the_second_with_what_was_found() {
    let mut memory = Memory::default();
    assert_eq!(memory.select("bottle").unwrap(), 0.0);
    assert_eq!(grasp(&mut memory, 4.0), Some(Remembered::Learned("bottle".to_owned())));
    let expected_n = memory.select("bottle").unwrap();
    assert!((KAPPA * 4.0..KAPPA * 4.8).contains(&expected_n), "{expected_n}");
    assert_eq!(memory.select("cup").unwrap(), 0.0);
    assert_eq!(memory.select("").unwrap(), 0.0);
}

#[test]
fn a_grasp_counts_once_with_what_it_has_shown_before_it_was_pulled() {
    let mut memory = Memory::default();
    memory.select("bottle").unwrap();
    grasp(&mut memory, 2.0);
    assert_eq!(memory.take(&found(KAPPA * 4.0)), None);
    let needed = learned(&memory, "bottle").needed_n;
    assert_eq!((needed.grasps, (needed.value - 2.0).abs() < 1e-6), (1, true), "{needed:?}");
}

#[test]
fn a_name_that_is_given_while_an_object_is_held_is_that_of_the_next_one() {
    let mut memory = Memory::default();
    memory.select("bottle").unwrap();
    memory.begin();
    memory.watch(Some(3.0));
    assert_eq!(memory.select("cup").unwrap(), 0.0);
    memory.take(&slip(40, 80.0, 2.0));
    assert_eq!(memory.take(&found(5.0)), Some(Remembered::Learned("bottle".to_owned())));
    assert!(learned(&memory, "bottle").spacing_um.grasps == 1);
    assert_eq!(grasp(&mut memory, 1.0), Some(Remembered::Learned("cup".to_owned())));
}

#[test]
fn what_contradicts_is_another_object_and_what_was_known_is_forgotten() {
    let mut memory = Memory::default();
    memory.select("bottle").unwrap();
    for _ in 0..10 {
        grasp(&mut memory, 4.0);
    }
    assert_eq!(grasp(&mut memory, 5.0), Some(Remembered::Learned("bottle".to_owned())));
    let swapped = grasp(&mut memory, 1.0);
    assert!(matches!(swapped, Some(Remembered::Contradicted { .. })), "{swapped:?}");
    let object = learned(&memory, "bottle");
    assert_eq!((object.forgotten, object.needed_n.grasps), (1, 1));
    assert!((object.needed_n.value - 1.0).abs() < 1e-6);
}

#[test]
fn another_surface_is_another_object_although_it_needs_as_much() {
    let mut memory = Memory::default();
    memory.select("bottle").unwrap();
    for (spacing_um, other) in [(80.0, false), (90.0, false), (20.0, true)] {
        memory.begin();
        memory.take(&slip(40, spacing_um, 2.0));
        let contradicted =
            matches!(memory.take(&found(5.0)), Some(Remembered::Contradicted { .. }));
        assert_eq!(contradicted, other, "{spacing_um}");
    }
}

#[test]
fn without_a_name_the_signature_counts_and_the_force_alone_is_none() {
    let mut memory = Memory::default();
    for (name, spacing_um) in [("rough", 80.0), ("fine", 20.0)] {
        memory.select(name).unwrap();
        memory.begin();
        memory.take(&slip(40, spacing_um, 2.0));
        memory.take(&found(5.0));
    }
    memory.select("").unwrap();
    assert_eq!(grasp(&mut memory, 5.0 / KAPPA), None, "two objects need that");
    memory.begin();
    memory.take(&slip(9, 20.0, 2.0));
    assert_eq!(memory.take(&found(5.0)), None, "too short a slip");
    memory.take(&slip(40, 21.0, 2.1));
    assert_eq!(memory.take(&found(5.0)), Some(Remembered::Recognised("fine".to_owned())));
    assert_eq!(learned(&memory, "fine").spacing_um.grasps, 2);
}

#[test]
fn static_over_kinetic_friction_is_seen_where_the_load_was_there() {
    let mut memory = Memory::default();
    memory.select("bottle").unwrap();
    memory.watch(Some(1.2));
    let first = Event::Slip(SlipReport { first: true, ..SlipReport::UNKNOWN });
    memory.take(&first);
    memory.take(&found(4.8));
    assert!(learned(&memory, "bottle").friction_ratio.is_unknown(), "it slipped in the lift");
    // The next grasp of it begins with enough, and it slips as the force falls.
    memory.begin();
    memory.watch(Some(5.0));
    memory.watch(Some(3.2));
    memory.take(&first);
    // In a slip the command is an answer.
    memory.watch(Some(4.5));
    memory.take(&found(4.8));
    let ratio = learned(&memory, "bottle").friction_ratio.value;
    assert!((ratio - f64::from(4.8 / KAPPA / 3.2)).abs() < 1e-6, "{ratio}");
}

#[test]
fn a_file_is_read_back_as_it_was_written_and_nonsense_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("objects.toml");
    assert_eq!(Memory::read(&file).unwrap(), Memory::default(), "no file, no objects");
    let mut memory = Memory::default();
    for name in ["bottle", "a cup of \"tea\"", "größe.1"] {
        memory.select(name).unwrap();
        memory.begin();
        memory.take(&slip(40, 80.0, 2.0));
        memory.take(&found(5.0));
    }
    memory.write(&file).unwrap();
    assert_eq!(Memory::read(&file).unwrap().objects(), memory.objects());
    for nonsense in [
        "[a]\nneeded_n = { value = -1.0, deviation = 0.1, grasps = 1 }",
        "[a]\nneeded_n = { value = nan, deviation = 0.1, grasps = 1 }",
        "[a]\nneeded_n = { value = 1.0, deviation = inf, grasps = 1 }",
        "[a]\nneeded_n = { value = 1.0, deviation = 0.1, grasps = 0 }",
        "[a]\nneeded_n = { value = 1e9, deviation = 0.1, grasps = 1 }",
        "['']\nneeded_n = { value = 1.0, deviation = 0.1, grasps = 1 }",
        "[\"a\\nb\"]\nneeded_n = { value = 1.0, deviation = 0.1, grasps = 1 }",
        "[a]\nweight = 3",
        "[a]",
        "a = 3",
    ] {
        std::fs::write(&file, nonsense).unwrap();
        let error = Memory::read(&file).unwrap_err().to_string();
        assert!(error.contains("objects.toml: "), "{error}");
    }
    assert!(Memory::read(folder.path()).is_err());
    assert!(Memory::read(&folder.path().join("nowhere/objects.toml")).is_err());
    assert!(Memory::read(std::path::Path::new("")).is_err());
    memory.write(&file).unwrap();
    let link = folder.path().join("link.toml");
    std::os::unix::fs::symlink(&file, &link).unwrap();
    std::fs::write(folder.path().join("objects.toml.new"), "left by a crash").unwrap();
    memory.write(&link).unwrap();
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(Memory::read(&file).unwrap().objects(), memory.objects());
    assert!(memory.select(&"x".repeat(65)).is_err() && memory.select("a\nb").is_err());
}

proptest! {
    /// The figure is the mean of the logarithms, as long as there are few, and its deviation theirs.
    #[test]
    fn a_figure_is_the_geometric_mean(values in prop::collection::vec(0.5_f64..2.0, 1..15)) {
        let figure = values.iter().fold(Figure::default(), |figure, value| figure.with(*value));
        let count = f64::from(u32::try_from(values.len()).unwrap());
        let mean = values.iter().map(|value| value.ln()).sum::<f64>() / count;
        prop_assert!((figure.value.ln() - mean).abs() < 1e-9);
        // As many squares as measurements, and that of the first guess.
        let squares: f64 = values.iter().map(|value| (value.ln() - mean).powi(2)).sum();
        let slow = ((squares + 0.1 * 0.1) / count).sqrt();
        let least = 0.05;
        prop_assert!(figure.deviation >= least - 1e-12);
        if figure.deviation > least + 1e-9 {
            prop_assert!((figure.deviation - slow).abs() < 0.06, "{} {slow}", figure.deviation);
        }
        prop_assert!(figure.deviations(figure.value * (DIFFERS * 3.0).exp()).unwrap() > DIFFERS);
    }
}
