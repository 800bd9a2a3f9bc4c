//! What is exported, remembered and pictured, by the buttons for it.

use super::fixture;
use eframe::egui::{Color32, ColorImage, DroppedFile, Key, Modifiers, Ui, ViewportCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use grip_scope::feed::Feed;
use grip_scope::{Model, SourceSpec, SourceStatus};
use gripmon::desk::Desk;
use gripmon::engine::Engine;
use gripmon::job::Job;
use gripmon::layout::{Layout, Look, Panel};
use gripmon::remember::Remember;
use gripmon::scope::{self, Scope, Shared};
use gripmon::state::{Message, ViewState};
use gripmon::view_file::ViewFile;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A desk, what is to be opened instead, and the commands to the system's window.
struct Held {
    desk: Desk,
    opens: Option<SourceSpec>,
    commands: Vec<ViewportCommand>,
    prepared: bool,
}

/// A window whose files begin with `run` in this folder.
#[expect(clippy::unwrap_used, reason = "part of a test")]
fn window(folder: &Path, model: Model, job: Option<Job>) -> Harness<'static, Held> {
    window_of(folder, SourceSpec::parse("demo").unwrap(), model, job)
}

/// The same on another source.
fn window_of(
    folder: &Path,
    spec: SourceSpec,
    model: Model,
    job: Option<Job>,
) -> Harness<'static, Held> {
    let layout = Layout { panel: Some(Panel::Export), ..Layout::default() };
    let remember = Remember::new(Some(folder.join("layout.toml")), layout.clone());
    let mut state = ViewState::new(layout);
    state.window.all();
    state.stem = folder.join("run").to_string_lossy().into_owned();
    let scope = Scope::new(Arc::new(Shared::new(Engine::new(model, None))), state);
    let desk = Desk::new(scope, spec, job, remember);
    let held = Held { desk, opens: None, commands: Vec::new(), prepared: false };
    let frame = |ui: &mut Ui, held: &mut Held| {
        if !core::mem::replace(&mut held.prepared, true) {
            scope::prepare(ui.ctx(), Look::Dark);
        }
        held.opens = held.desk.ui(ui).or(held.opens.take());
        held.commands.extend(ui.ctx().viewport(|window| window.commands.clone()));
    };
    let mut harness = Harness::builder().with_size([1400.0, 1000.0]).build_ui_state(frame, held);
    harness.run_steps(1);
    harness
}

fn click(harness: &mut Harness<'_, Held>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(2);
}

/// Makes the picture that is asked for in one of the next frames.
#[expect(clippy::panic, reason = "part of a test")]
fn pictured(harness: &mut Harness<'_, Held>) {
    for _ in 0..20 {
        harness.run_steps(1);
        for command in harness.state_mut().commands.drain(..) {
            if let ViewportCommand::Screenshot(made) = command {
                let image = Arc::new(ColorImage::filled([4, 3], Color32::GREEN));
                return made.complete(image);
            }
        }
    }
    panic!("no picture is asked for");
}

fn closes(harness: &Harness<'_, Held>) -> bool {
    harness.state().commands.contains(&ViewportCommand::Close)
}

/// Frames until the file that was begun is written.
#[expect(clippy::panic, reason = "part of a test")]
fn written(harness: &mut Harness<'_, Held>) -> Message {
    for _ in 0..60_000 {
        harness.run_steps(1);
        let message = harness.state().desk.scope.state.message.clone();
        if let Some(message) = message.filter(|message| !message.text.starts_with("Writing ")) {
            harness.state_mut().desk.scope.state.message = None;
            return message;
        }
        std::thread::yield_now();
    }
    panic!("it was never written");
}

#[test]
fn what_is_seen_or_lies_between_the_cursors_becomes_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), fixture::grasp(), None);
    click(&mut harness, "Samples as CSV");
    let message = written(&mut harness);
    let name = folder.path().join("run-0001.csv");
    let stated = format!("Written: {} (", name.display());
    assert!(message.text.starts_with(&stated) && !message.is_error, "{}", message.text);
    let text = fs::read_to_string(&name).unwrap();
    let header = text.lines().next().unwrap();
    assert!(header.starts_with("t_s,stylus,") && header.contains("force_n"), "{header}");
    assert!(text.lines().count() > 20_000, "{}", text.lines().count());
    // Between the cursors, into the next free name.
    harness.state_mut().desk.scope.state.cursors = [Some(1.0), Some(1.0995)];
    click(&mut harness, "Samples as CSV");
    assert!(written(&mut harness).text.contains("run-0002.csv"));
    let text = fs::read_to_string(folder.path().join("run-0002.csv")).unwrap();
    let stylus = text.lines().skip(1).filter(|line| line.split(',').nth(1) != Some(""));
    assert_eq!(stylus.count(), 996);
}

#[test]
fn what_is_kept_becomes_a_recording_and_a_page_by_button_or_key() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), fixture::grasp(), None);
    harness.state_mut().desk.scope.state.cursors = [Some(0.5), Some(0.9999)];
    click(&mut harness, "Recording (MCAP)");
    let message = written(&mut harness);
    assert!(message.text.ends_with("(5,000 samples, 5,000 messages)"), "{}", message.text);
    harness.state_mut().desk.scope.state.cursors = [None; 2];
    click(&mut harness, "Report (HTML)");
    let message = written(&mut harness);
    assert!(message.text.contains("run-0001.html (a page of "), "{}", message.text);
    let page = fs::read_to_string(folder.path().join("run-0001.html")).unwrap();
    for text in ["Grasp: demo:default", "Slip at 0.9000 s, 200.0 ms long"] {
        assert!(page.contains(text), "{text} in {page}");
    }
    harness.key_press_modifiers(Modifiers::SHIFT, Key::S);
    harness.run_steps(2);
    assert!(written(&mut harness).text.contains("run-0002.html"));
}

#[test]
fn a_picture_is_asked_for_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), fixture::grasp(), None);
    harness.get_by_label("Picture (PNG)").click();
    pictured(&mut harness);
    let message = written(&mut harness);
    assert!(message.text.ends_with("run-0001.png (this window)"), "{}", message.text);
    assert!(fs::read(folder.path().join("run-0001.png")).unwrap().starts_with(b"\x89PNG"));
    harness.key_press(Key::S);
    pictured(&mut harness);
    assert!(written(&mut harness).text.contains("run-0002.png") && !closes(&harness));
}

#[test]
fn a_recording_is_labelled_once_and_its_label_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let labels = folder.path().join("labels.csv");
    fs::write(&labels, "recording,kind,material,onset_s\nother,rest,cork,\n").unwrap();
    let open = || {
        let spec = SourceSpec::Recording(folder.path().join("run.mcap"));
        window_of(folder.path(), spec, fixture::grasp(), None)
    };
    let said = |harness: &mut Harness<'_, Held>| {
        harness.state_mut().desk.scope.state.message.take().map(|message| message.text)
    };
    let mut harness = open();
    click(&mut harness, "Slip begins at cursor A");
    assert_eq!(said(&mut harness).unwrap(), "Set cursor A where the slip begins first.");
    harness.state_mut().desk.scope.state.cursors[0] = Some(7.0);
    click(&mut harness, "Slip begins at cursor A");
    assert!(said(&mut harness).unwrap().starts_with("Cursor A is at 7.000000 s: the recording"));
    harness.state_mut().desk.scope.state.cursors[0] = Some(0.9125);
    click(&mut harness, "Slip begins at cursor A");
    assert_eq!(said(&mut harness).unwrap(), "Labelled: onset at 0.912500 s.");
    let text = fs::read_to_string(&labels).unwrap();
    assert_eq!(text, "recording,kind,material,onset_s\nother,rest,cork,\nrun,onset,,0.912500\n");
    // Another window finds it, and cursor A goes there; it is not replaced.
    let mut harness = open();
    assert_eq!(harness.state().desk.scope.state.cursors[0], Some(0.9125));
    harness.get_by_label("onset at 0.912500 s");
    assert!(harness.get_by_label("Never slips").accesskit_node().is_disabled());
    // Another program has labelled it meanwhile.
    click(&mut harness, "Remove the label");
    let gone = "No label any more; it was onset at 0.912500 s.";
    assert_eq!(said(&mut harness).unwrap(), gone);
    fs::write(&labels, "recording,kind\nrun,steady\n").unwrap();
    click(&mut harness, "Never slips");
    let refused = "The recording has a label already (steady): remove it first.";
    assert_eq!(said(&mut harness).unwrap(), refused);
    assert_eq!(fs::read_to_string(&labels).unwrap(), "recording,kind\nrun,steady\n");
    harness.run_steps(1);
    harness.get_by_label("steady");
}

#[test]
fn what_cannot_be_written_is_reported_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), fixture::grasp(), None);
    harness.state_mut().desk.scope.state.cursors = [Some(50.0), Some(60.0)];
    for label in ["Samples as CSV", "Recording (MCAP)", "Report (HTML)"] {
        click(&mut harness, label);
        let message = written(&mut harness);
        let (file, sentence) = message.text.split_once(": ").unwrap();
        assert!(message.is_error && file.contains("run-0001."), "{message:?}");
        assert_eq!(sentence, "there are no samples in this span to write");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let nowhere = folder.path().join("nowhere").join("run");
    harness.state_mut().desk.scope.state.stem = nowhere.to_string_lossy().into_owned();
    harness.state_mut().desk.scope.state.cursors = [None; 2];
    click(&mut harness, "Samples as CSV");
    let message = written(&mut harness);
    assert!(message.is_error && message.text.contains("there is no such folder"), "{message:?}");
    // The file is named once, whoever names it.
    assert_eq!(message.text.matches("run-0001.csv").count(), 1, "{message:?}");
}

#[test]
fn without_data_there_is_nothing_to_export_but_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), Model::new(1 << 20), None);
    for label in ["Samples as CSV", "Recording (MCAP)", "Report (HTML)"] {
        assert!(harness.get_by_label(label).accesskit_node().is_disabled());
    }
    harness.get_by_label("Picture (PNG)").click();
    pictured(&mut harness);
    assert!(harness.query_by_label("Never slips").is_none(), "it is no recording");
}

#[test]
fn the_arrangement_is_remembered_when_the_window_closes() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), fixture::grasp(), None);
    click(&mut harness, "Light");
    click(&mut harness, "Trigger");
    harness.state_mut().desk.scope.state.layout.plots.swap(0, 2);
    harness.run_steps(1);
    assert_eq!(harness.state_mut().desk.close(), None);
    let read = Layout::read(&folder.path().join("layout.toml")).unwrap();
    assert_eq!((read.theme, read.panel), (Look::Light, Some(Panel::Trigger)));
    assert_eq!(read.window, [1400.0, 1000.0]);
    assert_eq!(read.plots, harness.state().desk.scope.layout().plots);
    // The width of the panel and the settings of the trigger are those of the next start.
    harness.get_by_label("Resize panel").set_value_accesskit(0.3);
    harness.run_steps(3);
    harness.get_by_label("In all").set_value_accesskit(2.5);
    harness.run_steps(2);
    assert_eq!(harness.state_mut().desk.close(), None);
    let read = Layout::read(&folder.path().join("layout.toml")).unwrap();
    assert!((410.0..425.0).contains(&read.panel_width), "{}", read.panel_width);
    let next = ViewState::new(read.clone());
    assert_eq!((next.layout.trigger.window_s, next.armed), (2.5, false));
    // A window that begins so stays so.
    let scope = Scope::new(Arc::new(Shared::new(Engine::new(fixture::grasp(), None))), next);
    let frame = |ui: &mut Ui, scope: &mut Scope| {
        let _effects = scope.ui(ui);
    };
    let mut again = Harness::builder().with_size([1400.0, 1000.0]).build_ui_state(frame, scope);
    again.run_steps(4);
    assert!((again.state().layout().panel_width - read.panel_width).abs() < 1.0);
    // A file that cannot be written is reported at the end.
    fs::remove_file(folder.path().join("layout.toml")).unwrap();
    fs::create_dir(folder.path().join("layout.toml")).unwrap();
    let reported = harness.state_mut().desk.close().unwrap();
    assert!(
        reported.starts_with("the arrangement of the window is not remembered: "),
        "{reported}"
    );
}

#[test]
fn the_picture_of_the_command_line_closes_the_window_and_so_does_its_failure() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let job = || Some(Job::new(ViewFile::default(), Some(path.clone())));
    let mut model = fixture::grasp();
    model.take(Feed::Status(SourceStatus::Complete { note: String::new() }));
    let mut harness = window(folder.path(), model, job());
    pictured(&mut harness);
    written(&mut harness);
    assert!(closes(&harness));
    assert_eq!(harness.state_mut().desk.close(), None);
    assert!(fs::read(&path).unwrap().starts_with(b"\x89PNG"));
    // A source that fails.
    let mut model = Model::new(1 << 20);
    let sentence = "x.mcap: is no recording".to_owned();
    model.take(Feed::Status(SourceStatus::Failed { sentence }));
    let mut harness = window(folder.path(), model, job());
    assert!(closes(&harness));
    let reported = harness.state_mut().desk.close().unwrap();
    assert_eq!(reported, "no picture: x.mcap: is no recording");
}

/// A file that somebody drops on the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn a_file_that_is_dropped_is_opened_and_what_is_none_is_refused_as_an_argument_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), fixture::grasp(), None);
    let mut drop = |names: &[&str]| {
        for name in names {
            let file = Arc::new(Dropped(folder.path().join(name)));
            harness.input_mut().dropped_files.push(file);
        }
        let held = harness.state_mut();
        (held.opens, held.desk.scope.state.message) = (None, None);
        harness.run_steps(1);
        let held = harness.state();
        (held.opens.clone(), held.desk.scope.state.message.clone().map(|message| message.text))
    };
    for name in ["a.mcap", "study.json"] {
        let spec = SourceSpec::parse(folder.path().join(name).to_str().unwrap()).unwrap();
        assert_eq!(drop(&[name]), (Some(spec), None));
    }
    let (opens, message) = drop(&["notes.pdf"]);
    assert!(opens.is_none() && message.unwrap().contains("neither a recording"));
    let (opens, message) = drop(&["a.mcap", "b.csv"]);
    assert!(opens.is_none() && message.unwrap().contains("one file at a time"));
    assert_eq!(drop(&[]), (None, None));
}
