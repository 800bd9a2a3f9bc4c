//! Files of what is to be kept, written on threads of their own.

use crate::apply::Effect;
use crate::files;
use crate::scope::{Scope, Shared};
use crate::state::Message;
use eframe::egui::{ColorImage, Context};
use grip_record::outputs::{OutputKind, OutputPath};
use grip_scope::export::{self, ExportError, Part, Sliced};
use grip_scope::{Channel, SourceSpec, Span, format, report};
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

/// A file that was written, or was not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The sentence about it.
    pub message: Message,
    /// It was the picture of the command line.
    pub is_last: bool,
}

/// A picture that the system's window has made, its file, and whether the program ends with it.
type Made = (PathBuf, bool, Arc<ColorImage>);

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
    /// Begins to write a file: `write` gives back what it holds. The program ends with the last one.
    pub fn begin(
        &mut self,
        ctx: &Context,
        path: PathBuf,
        is_last: bool,
        write: impl FnOnce(&Path) -> Result<String, ExportError> + Send + 'static,
    ) {
        self.threads.retain(|thread| !thread.is_finished());
        let (report, ctx) = (self.report.clone(), ctx.clone());
        let run = move || {
            let message = sentence(&path, write(&path));
            // Nobody listens any more where the window is closing.
            let _sent = report.send(Written { message, is_last });
            ctx.request_repaint();
        };
        match thread::Builder::new().name("export".to_owned()).spawn(run) {
            Ok(thread) => self.threads.push(thread),
            Err(error) => {
                let text = format!("no thread to write with: {error}");
                let message = Message { text, is_error: true };
                let _sent = self.report.send(Written { message, is_last });
            }
        }
    }

    /// Asks the system's window for a picture of the next frame, which is written then; with the last one the program ends.
    pub fn picture(&self, ctx: &Context, path: PathBuf, is_last: bool) {
        let (make, again) = (self.make.clone(), ctx.clone());
        ctx.request_screenshot(move |image| {
            // Nobody waits for it any more where the window is closing.
            let _sent = make.send((path, is_last, image));
            again.request_repaint();
        });
    }

    /// What was written since the last call. Pictures that were made meanwhile begin to be written.
    pub fn written(&mut self, ctx: &Context) -> Option<Written> {
        while let Ok((path, is_last, image)) = self.made.try_recv() {
            self.begin(ctx, path, is_last, move |path| picture(path, is_last, &image));
        }
        self.reported.try_recv().ok()
    }
}

impl Drop for Exports {
    fn drop(&mut self) {
        for thread in self.threads.drain(..) {
            // A thread that has panicked has left nothing to wait for.
            let _ended = thread.join();
        }
    }
}

/// Of what a file is written.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Between the cursors, else what is seen.
    pub span: Span,
    /// The channels of the plots that are shown, for a table.
    pub channels: Vec<Channel>,
    /// Where the data come from.
    pub source: SourceSpec,
}

impl Wanted {
    /// What is wanted of a window.
    #[must_use]
    pub fn of(scope: &Scope, source: SourceSpec) -> Self {
        let (engine, state) = (scope.shared.engine(), &scope.state);
        let seen = || state.window.visible(engine.model.span());
        let plots = state.layout.plots.iter().filter(|plot| plot.shown);
        let curves = plots.flat_map(|plot| crate::strip::curves(plot.plot, &engine.model));
        let channels = curves.map(|curve| curve.channel).collect();
        Self { span: state.between().unwrap_or_else(seen), channels, source }
    }

    /// Writes a table, a recording (a part of the file where the source is one, else what is kept of it) or a page: what it holds.
    ///
    /// # Errors
    /// Where it has nothing to write, or cannot.
    pub fn write(self, what: Effect, shared: &Shared, path: &Path) -> Result<String, ExportError> {
        let span = self.span;
        let part = |channels: &[Channel]| Part::of(&shared.engine().model, span, channels);
        match (what, self.source) {
            (Effect::Csv, _) => {
                let rows = export::csv(part(&self.channels), path)?;
                Ok(format!("{} rows", format::count(rows)))
            }
            (Effect::Mcap, SourceSpec::Recording(from)) if is_mcap(&from) => {
                Ok(held(export::mcap_slice(&from, span, path)?))
            }
            (Effect::Mcap, _) => Ok(held(export::mcap(part(&Channel::ROWS), path)?)),
            (_, source) => {
                let page = report::grasp(&shared.engine().model, span, &source.to_string());
                let bytes = export::html(page.as_ref(), path)?;
                Ok(format!("a page of {} kB", bytes.div_ceil(1000)))
            }
        }
    }
}

/// Writes a picture of the window; the one of the command line takes the place of an earlier one.
fn picture(path: &Path, is_last: bool, image: &ColorImage) -> Result<String, ExportError> {
    let kind = if is_last { PICTURE } else { OutputKind::ANY };
    let mut file = OutputPath::new(path, kind, [], None)?.create()?;
    files::write_png(&mut file, image)?;
    file.finish()?;
    Ok("this window".to_owned())
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
        Err(error) => Message { text: error.about(path), is_error: true },
    }
}

#[cfg(test)]
mod tests {
    use super::{Exports, picture};
    use eframe::egui::{Color32, ColorImage, Context};
    use std::fs;

    #[test]
    fn a_picture_replaces_nothing_but_where_the_command_line_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, b"\x89PNG\r\n\x1a\n of before").unwrap();
        let image = ColorImage::filled([3, 2], Color32::from_rgb(1, 2, 3));
        let refused = picture(&path, false, &image).unwrap_err().to_string();
        assert!(refused.contains("is there already"), "{refused}");
        assert!(fs::read(&path).unwrap().ends_with(b" of before"));
        picture(&path, true, &image).unwrap();
        assert!(!fs::read(&path).unwrap().ends_with(b" of before"));
        fs::write(&path, "no picture").unwrap();
        assert!(picture(&path, true, &image).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"no picture");
    }

    #[test]
    fn what_was_begun_is_written_when_the_window_closes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let mut exports = Exports::default();
        exports.begin(&Context::default(), path.clone(), false, |path| {
            std::thread::park_timeout(core::time::Duration::from_millis(50));
            fs::write(path, "all of it").unwrap();
            Ok(String::new())
        });
        drop(exports);
        assert_eq!(fs::read_to_string(&path).unwrap(), "all of it");
    }
}
