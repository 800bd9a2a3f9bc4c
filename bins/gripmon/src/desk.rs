//! The window with its files, and what the command line wants of it, but without a system behind it.

use crate::apply::Effect;
use crate::exports::{Exports, Wanted};
use crate::files;
use crate::job::{Job, Step};
use crate::remember::Remember;
use crate::scope::Scope;
use eframe::egui::{Context, Ui, ViewportCommand};
use grip_scope::SourceSpec;
use std::sync::Arc;

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
    pub fn new(mut scope: Scope, spec: SourceSpec, job: Option<Job>, remember: Remember) -> Self {
        if let SourceSpec::Recording(path) = &spec {
            scope.state.open_recording(path);
        }
        Self { scope, spec, job, remember, exports: Exports::default(), failed: None }
    }

    /// Draws a frame; what was dropped on the window is to be opened instead of what is open.
    pub fn ui(&mut self, ui: &mut Ui) -> Option<SourceSpec> {
        let ctx = ui.ctx().clone();
        while let Some(written) = self.exports.written(&ctx) {
            if written.is_last {
                ctx.send_viewport_cmd(ViewportCommand::Close);
                self.failed = Some(&written.message)
                    .filter(|message| message.is_error)
                    .map(|message| message.text.clone());
            }
            self.scope.state.message = Some(written.message);
        }
        for effect in self.scope.ui(ui) {
            self.export(&ctx, effect);
        }
        let size = ctx.content_rect().size();
        self.scope.state.layout.window = [size.x, size.y];
        self.remember.note(self.scope.layout());
        self.work(&ctx);
        self.dropped(&ctx)
    }

    /// The file that was dropped on the window, read as the program's argument would be.
    fn dropped(&mut self, ctx: &Context) -> Option<SourceSpec> {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        let file = files.first()?;
        let sentence = if files.len() > 1 {
            "one file at a time: a recording (.mcap, .csv) or the report of a study (.json)"
                .to_owned()
        } else {
            match SourceSpec::parse(&file.path().display().to_string()) {
                Ok(spec) if !spec.is_live() => return Some(spec),
                Ok(spec) => format!("{spec} is no file that can be opened"),
                Err(error) => error.to_string(),
            }
        };
        self.scope.state.complain(sentence);
        None
    }

    /// Begins to write what is asked for; a picture has to be made first.
    fn export(&mut self, ctx: &Context, effect: Effect) {
        if let Effect::Label(kind) = effect {
            return self.scope.state.set_label(kind);
        }
        let ending = match effect {
            Effect::Csv => "csv",
            Effect::Mcap => "mcap",
            Effect::Report => "html",
            _ => "png",
        };
        let path = match files::free_name(&self.scope.state.stem, ending) {
            Ok(path) => path,
            Err(error) => return self.scope.state.complain(error.to_string()),
        };
        if effect == Effect::Picture {
            return self.exports.picture(ctx, path, false);
        }
        self.scope.state.report(format!("Writing {} ..", path.display()));
        let wanted = Wanted::of(&self.scope, self.spec.clone());
        let shared = Arc::clone(&self.scope.shared);
        self.exports.begin(ctx, path, false, move |path| wanted.write(effect, &shared, path));
    }

    /// Goes where --view wants to look, and asks for the picture there.
    fn work(&mut self, ctx: &Context) {
        let Some(job) = &mut self.job else { return };
        let (frames, time_s) = (self.scope.frames(), ctx.input(|input| input.time));
        let step = {
            let engine = self.scope.shared.engine();
            job.step(&mut self.scope.state, &engine.model, frames, time_s)
        };
        let ends = job.picture.is_some();
        if let Step::Wait(time) = step {
            return ctx.request_repaint_after(time);
        }
        self.job = None;
        match step {
            Step::Picture(path) => self.exports.picture(ctx, path, true),
            Step::Failed(sentence) if ends => {
                self.failed = Some(sentence);
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            Step::Failed(sentence) => self.scope.state.complain(sentence),
            Step::Done | Step::Wait(_) => {}
        }
        ctx.request_repaint();
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
