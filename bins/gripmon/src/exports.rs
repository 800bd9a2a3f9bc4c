//! Files of what is to be kept, written on threads of their own.

use crate::apply::Effect;
use crate::files;
use crate::scope::{Scope, Shared};
use crate::state::Message;
use eframe::egui::{ColorImage, Context};
use grip_record::outputs::{OutputKind, OutputPath};
use grip_scope::export::{self, ExportError, Part, Sliced};
use grip_scope::{Channel, SourceSpec, Span, format, report};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

/// A picture of the command line takes the place of an earlier one.
const PICTURE: OutputKind = OutputKind {
    endings: &["png"],
    strict: false,
    is_ours: |head| head.starts_with(b"\x89PNG\r\n\x1a\n"),
};

/// What is to be written.
#[derive(Clone, Debug)]
pub enum Work {
    /// The samples of these channels as CSV.
    Csv(Span, Vec<Channel>),
    /// A recording: a part of the file where the source is one, else what is kept of it.
    Mcap(Span, SourceSpec),
    /// A page about the grasp.
    Report(Span, SourceSpec),
    /// A picture of the window.
    Picture(Arc<ColorImage>),
    /// The picture of the command line: it replaces the one before, and the program ends with it.
    LastPicture(Arc<ColorImage>),
}

/// A file that was written, or was not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The sentence about it.
    pub message: Message,
    /// It was the picture of the command line.
    pub is_last: bool,
}

/// A picture that the system's window has made: its file, and what is to be done with it.
type Made = (PathBuf, Work);

/// The threads that write; dropping it waits for them, so that no file is left in halves.
#[derive(Debug)]
pub struct Exports {
    report: Sender<Written>,
    reported: Receiver<Written>,
    make: Sender<Made>,
    made: Receiver<Made>,
    threads: Vec<JoinHandle<()>>,
}

impl Default for Exports {
    fn default() -> Self {
        let ((report, reported), (make, made)) = (channel(), channel());
        Self { report, reported, make, made, threads: Vec::new() }
    }
}

impl Exports {
    /// Begins to write; `wake` is called when it is done.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn begin(
        &mut self,
        work: Work,
        path: PathBuf,
        shared: Arc<Shared>,
        wake: impl FnOnce() + Send + 'static,
    ) -> io::Result<()> {
        self.threads.retain(|thread| !thread.is_finished());
        let report = self.report.clone();
        let run = move || {
            let is_last = matches!(work, Work::LastPicture(_));
            let message = sentence(&path, write(work, &path, &shared));
            // Nobody listens any more where the window is closing.
            let _sent = report.send(Written { message, is_last });
            wake();
        };
        self.threads.push(thread::Builder::new().name("export".to_owned()).spawn(run)?);
        Ok(())
    }

    /// Asks the system's window for a picture of the next frame, which is written then; with the last one the program ends.
    pub fn picture(&self, ctx: &Context, path: PathBuf, is_last: bool) {
        let (make, again) = (self.make.clone(), ctx.clone());
        ctx.request_screenshot(move |image| {
            let work = if is_last { Work::LastPicture(image) } else { Work::Picture(image) };
            // Nobody waits for it any more where the window is closing.
            let _sent = make.send((path, work));
            again.request_repaint();
        });
    }

    /// What was written since the last call. Pictures that were made meanwhile begin to be written.
    pub fn written(&mut self, ctx: &Context, shared: &Arc<Shared>) -> Option<Written> {
        while let Ok((path, work)) = self.made.try_recv() {
            let again = ctx.clone();
            let begun = self.begin(work, path, Arc::clone(shared), move || again.request_repaint());
            if let Err(error) = begun {
                return Some(Written { message: no_thread(&error), is_last: false });
            }
        }
        self.reported.try_recv().ok()
    }
}

/// The system starts no thread to write with.
#[must_use]
pub fn no_thread(error: &io::Error) -> Message {
    Message { text: format!("no thread to write with: {error}"), is_error: true }
}

impl Drop for Exports {
    fn drop(&mut self) {
        for thread in self.threads.drain(..) {
            // A thread that has panicked has left nothing to wait for.
            let _ended = thread.join();
        }
    }
}

/// What an effect of the window writes, and the ending of its file; `None` where the window makes a picture first.
#[must_use]
pub fn work(effect: Effect, scope: &Scope, spec: &SourceSpec) -> (Option<Work>, &'static str) {
    match effect {
        Effect::Csv => (Some(Work::Csv(span(scope), shown_channels(scope))), "csv"),
        Effect::Mcap => (Some(Work::Mcap(span(scope), spec.clone())), "mcap"),
        Effect::Report => (Some(Work::Report(span(scope), spec.clone())), "html"),
        _ => (None, "png"),
    }
}

/// Between the cursors, else what is seen.
fn span(scope: &Scope) -> Span {
    let engine = scope.shared.engine();
    let state = &scope.state;
    state.between().unwrap_or_else(|| state.window.visible(engine.model.span()))
}

fn shown_channels(scope: &Scope) -> Vec<Channel> {
    let engine = scope.shared.engine();
    let plots = scope.state.layout.plots.iter().filter(|plot| plot.shown);
    plots
        .flat_map(|plot| crate::strip::curves(plot.plot, &engine.model))
        .map(|curve| curve.channel)
        .collect()
}

/// Writes the file: what it holds.
fn write(work: Work, path: &Path, shared: &Shared) -> Result<String, ExportError> {
    let part = |span, channels: &[Channel]| Part::of(&shared.engine().model, span, channels);
    match work {
        Work::Csv(span, channels) => {
            let rows = export::csv(part(span, &channels), path)?;
            Ok(format!("{} rows", format::count(rows)))
        }
        Work::Mcap(span, SourceSpec::Recording(from)) if is_mcap(&from) => {
            Ok(held(export::mcap_slice(&from, span, path)?))
        }
        Work::Mcap(span, _) => Ok(held(export::mcap(part(span, &Channel::ROWS), path)?)),
        Work::Report(span, source) => {
            let page = report::grasp(&shared.engine().model, span, &source.to_string());
            let bytes = export::html(page.as_ref(), path)?;
            Ok(format!("a page of {} kB", bytes.div_ceil(1000)))
        }
        Work::Picture(image) => {
            let failed = |source| ExportError::Write { file: path.to_owned(), source };
            export::fill(path, None, |file| files::write_png(file, &image).map_err(failed))?;
            Ok("this window".to_owned())
        }
        Work::LastPicture(image) => {
            let mut file = OutputPath::new(path, PICTURE, [], None)?.create()?;
            files::write_png(&mut file, &image)
                .map_err(|source| ExportError::Write { file: path.to_owned(), source })?;
            file.finish()?;
            Ok("this window".to_owned())
        }
    }
}

fn is_mcap(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"))
}

fn held(slice: Sliced) -> String {
    let count = format::count;
    let left_out = match slice.damaged {
        0 => String::new(),
        1 => "; a damaged part is left out".to_owned(),
        parts => format!("; {parts} damaged parts are left out"),
    };
    format!("{} samples, {} messages{left_out}", count(slice.samples), count(slice.messages))
}

fn sentence(path: &Path, result: Result<String, ExportError>) -> Message {
    match result {
        Ok(what) => {
            Message { text: format!("Written: {} ({what})", path.display()), is_error: false }
        }
        Err(error) => {
            let (name, reported) = (path.display().to_string(), error.to_string());
            // Some errors name the file themselves.
            let text =
                if reported.starts_with(&name) { reported } else { format!("{name}: {reported}") };
            Message { text, is_error: true }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ExportError, Exports, Work, sentence};
    use crate::engine::Engine;
    use crate::scope::Shared;
    use eframe::egui::{Color32, ColorImage, Context};
    use grip_record::outputs::OutputError;
    use grip_scope::{Channel, Model, Span};
    use std::fs;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::mpsc::channel;

    fn shared() -> Arc<Shared> {
        Arc::new(Shared::new(Engine::new(Model::new(1 << 20), None)))
    }

    #[test]
    fn an_error_names_its_file_once() {
        let path = Path::new("run-0001.csv");
        let reported = |error| sentence(path, Err(error)).text;
        let there = OutputError::Exists { file: path.to_owned(), has_force: false };
        let there = reported(there.into());
        assert!(there.starts_with("run-0001.csv: is there already"), "{there}");
        let empty = reported(ExportError::Empty);
        assert!(empty.starts_with("run-0001.csv: there are no samples"), "{empty}");
    }

    #[test]
    fn a_picture_replaces_nothing_but_where_the_command_line_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, b"\x89PNG\r\n\x1a\n of before").unwrap();
        let image = Arc::new(ColorImage::filled([3, 2], Color32::from_rgb(1, 2, 3)));
        let mut exports = Exports::default();
        let mut done = |work: Work| {
            let (wake, woken) = channel();
            let wake = move || wake.send(()).unwrap();
            exports.begin(work, path.clone(), shared(), wake).unwrap();
            woken.recv().unwrap();
            exports.written(&Context::default(), &shared()).unwrap()
        };
        let refused = done(Work::Picture(Arc::clone(&image)));
        assert!(refused.message.is_error && !refused.is_last, "{refused:?}");
        assert!(refused.message.text.contains("is there already"), "{refused:?}");
        assert!(fs::read(&path).unwrap().ends_with(b" of before"));
        let written = done(Work::LastPicture(Arc::clone(&image)));
        assert!(!written.message.is_error && written.is_last, "{written:?}");
        assert!(!fs::read(&path).unwrap().ends_with(b" of before"));
        fs::write(&path, "no picture").unwrap();
        assert!(done(Work::LastPicture(image)).message.is_error);
        assert_eq!(fs::read(&path).unwrap(), b"no picture");
    }

    #[test]
    fn what_was_begun_is_written_when_the_window_closes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let shared = shared();
        let values: Vec<f32> = vec![1e-6; 200_000];
        let times_us = (0..200_000).map(|row| 100 * row).collect();
        let columns = vec![(Channel::Stylus, values)];
        let rows = grip_scope::feed::RowBlock { times_us, columns, ..Default::default() };
        shared.engine().model = Model::new(64 << 20);
        shared.engine().model.take(grip_scope::Feed::Rows(rows));
        let mut exports = Exports::default();
        let work = Work::Csv(Span::new(0.0, 100.0), vec![Channel::Stylus]);
        exports.begin(work, path.clone(), shared, || {}).unwrap();
        drop(exports);
        assert_eq!(fs::read_to_string(&path).unwrap().lines().count(), 200_001);
    }
}
