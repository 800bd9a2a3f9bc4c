//! The system's window around [`Scope`]: its thread, its files, its pictures.

use crate::cli::WindowArgs;
use crate::desk::Desk;
use crate::engine::Engine;
use crate::job::Job;
use crate::layout::{self, Layout, LayoutError};
use crate::remember::Remember;
use crate::scope::{self, Scope, Shared};
use crate::state::ViewState;
use crate::view_file::ViewFile;
use anyhow::{Context as _, bail};
use eframe::egui::{self, Ui, ViewportCommand};
use grip_scope::{Model, SourceHandle, SourceSpec};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::low_level::emulate_default_handler;
use std::sync::{Arc, Mutex, PoisonError};

/// Opens the window and runs until it is closed.
///
/// # Errors
/// Where a file of the command line cannot be used, there is no display, or the picture that was asked for was not made.
pub fn run(args: &WindowArgs, spec: SourceSpec) -> anyhow::Result<()> {
    let start = Start::of(args)?;
    let outcome = Arc::clone(&start.outcome);
    show(&title(&spec), start.layout.window, &outcome, move |ctx| {
        let mut screen = Screen::open(ctx, spec, &start)?;
        // Pictures and views that are given show what they ask for.
        if start.job.is_none() {
            screen.desk.scope.state.tour_once();
        }
        Ok(Box::new(App { screen, start }))
    })
}

fn title(spec: &SourceSpec) -> String {
    format!("gripmon - {spec}")
}

/// Opens a system's window with this title and size (points) and runs what is in it until it is closed.
///
/// # Errors
/// Where there is no display, or what is left as the outcome: a sentence.
pub fn show(
    title: &str,
    size: [f32; 2],
    outcome: &Outcome,
    make: impl FnOnce(&egui::Context) -> anyhow::Result<Box<dyn eframe::App>> + 'static,
) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title(title)
            .with_app_id("gripmon")
            .with_inner_size(size)
            .with_min_inner_size([480.0, 320.0]),
        ..eframe::NativeOptions::default()
    };
    eframe::run_native("gripmon", options, Box::new(move |cc| Ok(make(&cc.egui_ctx)?)))
        .map_err(|error| anyhow::anyhow!("{}", last_part(&error.to_string())))
        .context(
            "no window could be opened; gripmon needs a display with OpenGL (is DISPLAY set?)",
        )?;
    let failed = outcome.lock().unwrap_or_else(PoisonError::into_inner).take();
    match failed {
        Some(sentence) => bail!(sentence),
        None => Ok(()),
    }
}

/// The sentence with which a window ends, where it has failed.
pub type Outcome = Arc<Mutex<Option<String>>>;

/// What the command line and the files that it names state of the window.
#[derive(Debug)]
pub struct Start {
    /// The arrangement.
    pub layout: Layout,
    /// Where it is remembered.
    pub remember: Remember,
    /// Bytes for the history.
    pub memory_bytes: usize,
    /// The view and picture that are asked for.
    pub job: Option<Job>,
    /// How the window ends.
    pub outcome: Outcome,
}

impl Start {
    /// Reads the files.
    ///
    /// # Errors
    /// Where one cannot be used.
    pub fn of(args: &WindowArgs) -> anyhow::Result<Self> {
        let view = args.view.as_deref().map(ViewFile::read).transpose()?;
        let remembered =
            if view.is_some() { None } else { args.layout.clone().or_else(layout::default_path) };
        let layout = match (&view, &remembered) {
            (Some(view), _) => view.layout.clone(),
            (None, Some(path)) => Layout::read(path)?,
            (None, None) => Layout::default(),
        };
        let remember = Remember::new(remembered, layout.clone());
        remember
            .on_signals(&[SIGTERM, SIGINT, SIGHUP], reported_to_end)
            .context("the thread that waits for signals")?;
        let job = view.map(|view| Job::new(view, args.picture.clone()));
        let outcome = Arc::default();
        Ok(Self { layout, remember, memory_bytes: args.memory_bytes(), job, outcome })
    }
}

/// The last part of a library's message: what stands before it are places in its source.
fn last_part(message: &str) -> &str {
    message.rsplit(": ").next().unwrap_or(message)
}

/// The program is asked to end: it ends as it would without us, once the arrangement is written.
fn reported_to_end(signal: i32, written: Result<(), LayoutError>) {
    if let Err(error) = written {
        reported_last(&error);
    }
    // It does not come back; if it does, the signal had no effect and the next one is waited for.
    let _ended = emulate_default_handler(signal);
}

#[expect(clippy::print_stderr, reason = "nobody is left to tell it")]
fn reported_last(error: &LayoutError) {
    eprintln!("gripmon: the arrangement of the window is not remembered: {error}");
}

/// One source with the thread that fills its model: everything in the window, but not the window.
#[derive(Debug)]
pub struct Screen {
    /// What is shown of it.
    pub desk: Desk,
    _source: SourceHandle,
}

impl Screen {
    /// Opens a source.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn open(ctx: &egui::Context, spec: SourceSpec, start: &Start) -> anyhow::Result<Self> {
        scope::prepare(ctx, start.layout.theme);
        let shared = Arc::new(Shared::new(Engine::new(Model::new(start.memory_bytes), None)));
        let source = shared.open(spec.clone(), ctx).context("the source's thread")?;
        let mut state = ViewState::new(start.layout.clone());
        state.no_pointer = start.job.as_ref().is_some_and(|job| job.picture.is_some());
        if !spec.is_live() {
            state.window.all();
        }
        let (job, remember) = (start.job.clone(), start.remember.clone());
        let desk = Desk::new(Scope::new(shared, state), spec, job, remember);
        Ok(Self { desk, _source: source })
    }

    /// Whether nobody can see it.
    pub fn set_hidden(&self, hidden: bool) {
        self.desk.scope.shared.engine().hidden = hidden;
    }

    /// Draws a frame; what is to be opened instead.
    pub fn ui(&mut self, ui: &mut Ui) -> Option<SourceSpec> {
        self.desk.ui(ui)
    }
}

/// Whether nobody can see the window.
#[must_use]
pub fn is_hidden(ctx: &egui::Context) -> bool {
    ctx.input(|input| {
        let viewport = input.viewport();
        viewport.minimized.unwrap_or(false) || viewport.occluded.unwrap_or(false)
    })
}

struct App {
    screen: Screen,
    start: Start,
}

impl App {
    /// Another source in this window, with the arrangement as it is.
    fn open(&mut self, ctx: &egui::Context, spec: SourceSpec) {
        let title = title(&spec);
        (self.start.layout, self.start.job) = (self.screen.desk.scope.layout(), None);
        match Screen::open(ctx, spec, &self.start) {
            Ok(screen) => {
                let mut before = core::mem::replace(&mut self.screen, screen);
                if let Some(sentence) = before.desk.close() {
                    self.screen.desk.scope.state.complain(sentence);
                }
                ctx.send_viewport_cmd(ViewportCommand::Title(title));
            }
            Err(error) => self.screen.desk.scope.state.complain(format!("{error:#}")),
        }
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.screen.set_hidden(is_hidden(ctx));
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        if let Some(spec) = self.screen.ui(ui) {
            let ctx = ui.ctx().clone();
            self.open(&ctx, spec);
        }
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        *self.start.outcome.lock().unwrap_or_else(PoisonError::into_inner) =
            self.screen.desk.close();
    }
}
