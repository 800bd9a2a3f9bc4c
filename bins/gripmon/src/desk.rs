//! The window with its files, and what the command line wants of it, but without a system behind it: frames in, what only the system can
//! do out.

use crate::action::Cursor;
use crate::apply::Effect;
use crate::exports::{self, Exports, Work};
use crate::job::{Job, Step};
use crate::labels::{self, Place};
use crate::remember::Remember;
use crate::scope::Scope;
use core::time::Duration;
use eframe::egui::{ColorImage, Context, Ui};
use grip_record::{Label, LabelKind};
use grip_scope::SourceSpec;
use std::path::PathBuf;
use std::sync::Arc;

/// What only the system's window can do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Make a picture of the next frame and pass it to [`Desk::pictured`].
    Picture(Picture),
    /// Close the window.
    Close,
    /// Paint again, after this time at the latest.
    Repaint(Duration),
    /// Open what was dropped on the window instead of what is open.
    Open(SourceSpec),
}

/// A picture that is to be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Its file.
    pub path: PathBuf,
    /// The program ends with it.
    pub is_last: bool,
}

/// Everything but the system's window.
#[derive(Debug)]
pub struct Desk {
    /// The window's contents.
    pub scope: Scope,
    spec: SourceSpec,
    job: Option<Job>,
    remember: Remember,
    exports: Exports,
    failed: Option<String>,
    /// The material of the label that was removed last.
    material: String,
}

impl Desk {
    /// A window on a source, with a job to do first where there is one.
    #[must_use]
    pub fn new(mut scope: Scope, spec: SourceSpec, job: Option<Job>, remember: Remember) -> Self {
        if let SourceSpec::Recording(path) = &spec {
            scope.state.recording = Place::of(path);
        }
        let (exports, material) = (Exports::default(), String::new());
        Self { scope, spec, job, remember, exports, failed: None, material }
    }

    /// Draws a frame; what is left for the system to do.
    pub fn ui(&mut self, ui: &mut Ui) -> Vec<Ask> {
        let mut asks = Vec::new();
        while let Some(written) = self.exports.written() {
            if written.is_last {
                asks.push(Ask::Close);
                self.failed = Some(&written.message)
                    .filter(|message| message.is_error)
                    .map(|message| message.text.clone());
            }
            self.scope.state.message = Some(written.message);
        }
        self.recall_label();
        let ctx = ui.ctx().clone();
        for effect in self.scope.ui(ui) {
            asks.extend(self.export(&ctx, effect));
        }
        let size = ctx.content_rect().size();
        self.scope.state.layout.window = [size.x, size.y];
        self.remember.note(self.scope.layout());
        asks.extend(self.work(&ctx));
        asks.extend(self.dropped(&ctx));
        asks
    }

    /// The file that was dropped on the window, read as the program's argument would be.
    fn dropped(&mut self, ctx: &Context) -> Option<Ask> {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        let file = files.first()?;
        if files.len() > 1 {
            let sentence =
                "one file at a time: a recording (.mcap, .csv) or the report of a study (.json)";
            self.scope.state.complain(sentence);
            return None;
        }
        let path = file.path().display().to_string();
        match SourceSpec::parse(&path) {
            Ok(spec @ (SourceSpec::Recording(_) | SourceSpec::Study(_))) => {
                return Some(Ask::Open(spec));
            }
            Ok(spec) => self.scope.state.complain(format!("{spec} is no file that can be opened")),
            Err(error) => self.scope.state.complain(error.to_string()),
        }
        None
    }

    /// Looks for the label of the recording, once it is open; cursor A goes to its onset.
    fn recall_label(&mut self) {
        if self.scope.state.label.is_some() {
            return;
        }
        let state = &mut self.scope.state;
        let Some(place) = state.recording.clone() else { return };
        let label = place.read().unwrap_or_else(|error| {
            state.complain(error.to_string());
            None
        });
        if let (Some(at), None) = (label.as_ref().and_then(Label::onset), state.cursor(Cursor::A)) {
            state.set_cursor(Cursor::A, Some(at.as_seconds()));
        }
        state.label = Some(label);
    }

    /// Writes the label of the recording, or takes it away; one that is there is not replaced.
    fn label(&mut self, kind: Option<LabelKind>) {
        let Some(place) = self.scope.state.recording.clone() else { return };
        let written = match kind {
            Some(kind) => place.write(kind, &self.material),
            None => place.remove(),
        };
        let state = &mut self.scope.state;
        match (kind, written) {
            (_, Err(error)) => state.complain(error.to_string()),
            (Some(_), Ok(Some(old))) => {
                let had = labels::words(old.kind);
                state.complain(format!(
                    "The recording has a label already ({had}): remove it first."
                ));
            }
            (Some(kind), Ok(None)) => state.report(format!("Labelled: {}.", labels::words(kind))),
            (None, Ok(None)) => state.complain("The recording has no label."),
            (None, Ok(Some(old))) => {
                state.report(format!("No label any more; it was {}.", labels::words(old.kind)));
                // The next label is one of the same material.
                self.material = old.material;
            }
        }
        // What the list holds now is what is shown.
        state.label = None;
    }

    /// Begins to write what is asked for; a picture has to be made first.
    fn export(&mut self, ctx: &Context, effect: Effect) -> Option<Ask> {
        if let Effect::Label(kind) = effect {
            self.label(kind);
            return None;
        }
        match exports::work(effect, &self.scope, &self.spec) {
            Ok((None, path)) => return Some(Ask::Picture(Picture { path, is_last: false })),
            Ok((Some(work), path)) => self.begin(ctx, work, path),
            Err(error) => self.scope.state.complain(error.to_string()),
        }
        None
    }

    fn begin(&mut self, ctx: &Context, work: Work, path: PathBuf) {
        self.scope.state.report(format!("Writing {} ..", path.display()));
        let (shared, ctx) = (Arc::clone(&self.scope.shared), ctx.clone());
        let begun = self.exports.begin(work, path, shared, move || ctx.request_repaint());
        if let Err(error) = begun {
            self.scope.state.complain(format!("no thread to write with: {error}"));
        }
    }

    /// The picture that was asked for.
    pub fn pictured(&mut self, ctx: &Context, picture: Picture, image: Arc<ColorImage>) {
        let work = if picture.is_last { Work::LastPicture(image) } else { Work::Picture(image) };
        self.begin(ctx, work, picture.path);
        ctx.request_repaint();
    }

    /// Goes where --view wants to look, and asks for the picture there.
    fn work(&mut self, ctx: &Context) -> Option<Ask> {
        let job = self.job.as_mut()?;
        let (frames, time_s) = (self.scope.frames(), ctx.input(|input| input.time));
        let step = {
            let engine = self.scope.shared.engine_first();
            job.step(&mut self.scope.state, &engine.model, frames, time_s)
        };
        let ends = job.picture.is_some();
        if let Step::Wait(time) = step {
            return Some(Ask::Repaint(time));
        }
        self.job = None;
        match step {
            Step::Picture(path) => return Some(Ask::Picture(Picture { path, is_last: true })),
            Step::Failed(sentence) if ends => {
                self.failed = Some(sentence);
                return Some(Ask::Close);
            }
            Step::Failed(sentence) => self.scope.state.complain(sentence),
            Step::Done | Step::Wait(_) => {}
        }
        Some(Ask::Repaint(Duration::ZERO))
    }

    /// The window closes: what is being written is ended, and its arrangement remembered. The sentence of what has failed.
    #[must_use]
    pub fn close(&mut self) -> Option<String> {
        self.exports = Exports::default();
        if let Err(error) = self.remember.write() {
            let sentence = format!("the arrangement of the window is not remembered: {error}");
            self.failed.get_or_insert(sentence);
        }
        self.failed.take()
    }
}
