//! The system's window around [`Scope`]: its thread, its files, its pictures.

use crate::cli::WindowArgs;
use crate::desk::{Ask, Desk, Picture};
use crate::engine::Engine;
use crate::job::Job;
use crate::layout::{self, Layout, LayoutError};
use crate::pump::Pump;
use crate::remember::Remember;
use crate::scope::{self, Scope, Shared};
use crate::state::ViewState;
use crate::view_file::ViewFile;
use anyhow::{Context as _, bail};
use core::sync::atomic::Ordering;
use eframe::egui::{self, ColorImage, Ui, ViewportCommand};
use grip_scope::{Model, SourceHandle, SourceSpec};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::low_level::emulate_default_handler;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::Thread;

/// Opens the window and runs until it is closed.
///
/// # Errors
/// Where a file of the command line cannot be used, there is no display, or the picture that was asked for was not made.
pub fn run(args: &WindowArgs, spec: SourceSpec) -> anyhow::Result<()> {
    let start = Start::of(args)?;
    let outcome = Arc::clone(&start.outcome);
    let parts = start.parts(spec);
    show(&title(&parts.spec), parts.layout.window, &outcome, move |ctx| {
        let mut screen = Screen::open(ctx, parts)?;
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

    /// What a screen of this source begins with.
    #[must_use]
    pub fn parts(&self, spec: SourceSpec) -> Parts {
        Parts {
            spec,
            layout: self.layout.clone(),
            remember: self.remember.clone(),
            memory_bytes: self.memory_bytes,
            job: self.job.clone(),
        }
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

/// What is to be opened.
#[derive(Debug)]
pub struct Parts {
    /// The source.
    pub spec: SourceSpec,
    /// The arrangement.
    pub layout: Layout,
    /// Where it is remembered.
    pub remember: Remember,
    /// Bytes for the history.
    pub memory_bytes: usize,
    /// The view and picture that are asked for.
    pub job: Option<Job>,
}

/// One source with the threads that fill its model: everything in the window, but not the window.
#[derive(Debug)]
pub struct Screen {
    /// What is shown of it.
    pub desk: Desk,
    pump: Pump,
    made: Receiver<(Picture, Arc<ColorImage>)>,
    make: Sender<(Picture, Arc<ColorImage>)>,
}

impl Screen {
    /// Opens a source.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub fn open(ctx: &egui::Context, parts: Parts) -> anyhow::Result<Self> {
        scope::prepare(ctx, parts.layout.theme);
        let pumping: Arc<OnceLock<Thread>> = Arc::default();
        let woken = Arc::clone(&pumping);
        let wake = move || woken.get().into_iter().for_each(Thread::unpark);
        let source = SourceHandle::spawn(parts.spec.clone(), grip_sim::mcu::peer, wake)
            .context("the source's thread")?;
        let engine = Engine::new(Model::new(parts.memory_bytes), Some(source));
        let shared = Arc::new(Shared::new(engine));
        let pump = Pump::start(Arc::clone(&shared), ctx.clone()).context("the pump's thread")?;
        let _first = pump.thread().map(|thread| pumping.set(thread.clone()));
        let mut state = ViewState::new(parts.layout);
        state.no_pointer = parts.job.as_ref().is_some_and(|job| job.picture.is_some());
        if !parts.spec.is_live() {
            state.window.all();
        }
        let (make, made) = channel();
        let desk = Desk::new(Scope::new(shared, state), parts.spec, parts.job, parts.remember);
        Ok(Self { desk, pump, made, make })
    }

    /// Whether nobody can see it.
    pub fn set_hidden(&self, hidden: bool) {
        self.pump.watch().hidden.store(hidden, Ordering::Relaxed);
    }

    /// Draws a frame; what is to be opened instead.
    pub fn ui(&mut self, ui: &mut Ui) -> Option<SourceSpec> {
        let mut opens = None;
        let ctx = ui.ctx().clone();
        while let Ok((picture, image)) = self.made.try_recv() {
            self.desk.pictured(&ctx, picture, image);
        }
        for ask in self.desk.ui(ui) {
            match ask {
                Ask::Open(spec) => opens = Some(spec),
                ask => fulfil(&ctx, ask, &self.make),
            }
        }
        let paused = self.desk.scope.state.is_paused();
        self.pump.watch().paused.store(paused, Ordering::Relaxed);
        opens
    }
}

/// Asks the system for what only it can do; pictures come back through `make`.
pub fn fulfil(ctx: &egui::Context, ask: Ask, make: &Sender<(Picture, Arc<ColorImage>)>) {
    match ask {
        Ask::Picture(picture) => {
            let (make, again) = (make.clone(), ctx.clone());
            ctx.request_screenshot(move |image| {
                // Nobody waits for it any more where the window is closing.
                let _sent = make.send((picture, image));
                again.request_repaint();
            });
        }
        Ask::Close => ctx.send_viewport_cmd(ViewportCommand::Close),
        Ask::Repaint(time) => ctx.request_repaint_after(time),
        // A window that shows many sources has no place for another one.
        Ask::Open(_) => {}
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
        let layout = self.screen.desk.scope.layout().clone();
        let parts = Parts { layout, job: None, ..self.start.parts(spec) };
        match Screen::open(ctx, parts) {
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
