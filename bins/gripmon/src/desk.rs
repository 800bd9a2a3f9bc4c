//! The window with its files, and what the command line wants of it, but without a system behind it: frames in, what only the system can
//! do out.

use crate::apply::Effect;
use crate::exports::{self, Exports, Work};
use crate::job::{Job, Step};
use crate::remember::Remember;
use crate::scope::Scope;
use core::time::Duration;
use eframe::egui::{ColorImage, Context, Ui};
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
}

impl Desk {
    /// A window on a source, with a job to do first where there is one.
    #[must_use]
    pub fn new(scope: Scope, spec: SourceSpec, job: Option<Job>, remember: Remember) -> Self {
        Self { scope, spec, job, remember, exports: Exports::default(), failed: None }
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

    /// Begins to write what is asked for; a picture has to be made first.
    fn export(&mut self, ctx: &Context, effect: Effect) -> Option<Ask> {
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
        let so_far = (self.scope.frames(), ctx.input(|input| input.time));
        let step = {
            let engine = self.scope.shared.engine_first();
            job.step(&mut self.scope.state, &engine.model, so_far)
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
