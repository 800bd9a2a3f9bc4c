//! The system's window around [`Scope`]: its thread, its files, its pictures.

use crate::cli::Cli;
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
pub fn run(cli: &Cli, spec: SourceSpec) -> anyhow::Result<()> {
    let view = cli.view.as_deref().map(ViewFile::read).transpose()?;
    let remembered =
        if view.is_some() { None } else { cli.layout.clone().or_else(layout::default_path) };
    let layout = match (&view, &remembered) {
        (Some(view), _) => view.layout.clone(),
        (None, Some(path)) => Layout::read(path)?,
        (None, None) => Layout::default(),
    };
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title(format!("gripmon - {spec}"))
            .with_app_id("gripmon")
            .with_inner_size(layout.window)
            .with_min_inner_size([480.0, 320.0]),
        ..eframe::NativeOptions::default()
    };
    let remember = Remember::new(remembered, layout.clone());
    remember
        .on_signals(&[SIGTERM, SIGINT, SIGHUP], told_to_end)
        .context("the thread that waits for signals")?;
    let outcome = Arc::new(Mutex::new(None));
    let job = view.map(|view| Job::new(view, cli.picture.clone()));
    let plan = Plan {
        spec,
        layout,
        remember,
        memory_bytes: cli.memory_bytes(),
        job,
        outcome: Arc::clone(&outcome),
    };
    eframe::run_native(
        "gripmon",
        options,
        Box::new(|cc| Ok(Box::new(App::new(&cc.egui_ctx, plan)?))),
    )
    .map_err(|error| anyhow::anyhow!("{}", last_part(&error.to_string())))
    .context("no window could be opened; gripmon needs a display with OpenGL (is DISPLAY set?)")?;
    let failed = outcome.lock().unwrap_or_else(PoisonError::into_inner).take();
    match failed {
        Some(sentence) => bail!(sentence),
        None => Ok(()),
    }
}

/// The last part of a library's message: what stands before it are places in its source.
fn last_part(message: &str) -> &str {
    message.rsplit(": ").next().unwrap_or(message)
}

/// The program is told to end: it ends as it would without us, once the arrangement is written.
fn told_to_end(signal: i32, written: Result<(), LayoutError>) {
    if let Err(error) = written {
        told_last(&error);
    }
    // It does not come back; if it does, the signal had no effect and the next one is waited for.
    let _ended = emulate_default_handler(signal);
}

#[expect(clippy::print_stderr, reason = "nobody is left to tell it")]
fn told_last(error: &LayoutError) {
    eprintln!("gripmon: the arrangement of the window is not remembered: {error}");
}

/// What is to be opened.
struct Plan {
    spec: SourceSpec,
    layout: Layout,
    remember: Remember,
    memory_bytes: usize,
    job: Option<Job>,
    outcome: Arc<Mutex<Option<String>>>,
}

struct App {
    desk: Desk,
    pump: Pump,
    made: Receiver<(Picture, Arc<ColorImage>)>,
    make: Sender<(Picture, Arc<ColorImage>)>,
    outcome: Arc<Mutex<Option<String>>>,
}

impl App {
    fn new(ctx: &egui::Context, plan: Plan) -> anyhow::Result<Self> {
        scope::prepare(ctx, plan.layout.theme);
        let pumping: Arc<OnceLock<Thread>> = Arc::default();
        let woken = Arc::clone(&pumping);
        let wake = move || woken.get().into_iter().for_each(Thread::unpark);
        let source = SourceHandle::spawn(plan.spec.clone(), wake).context("the source's thread")?;
        let engine = Engine::new(Model::new(plan.memory_bytes), Some(source));
        let shared = Arc::new(Shared::new(engine));
        let pump = Pump::start(Arc::clone(&shared), ctx.clone()).context("the pump's thread")?;
        let _first = pump.thread().map(|thread| pumping.set(thread.clone()));
        let mut state = ViewState::new(plan.layout);
        state.no_pointer = plan.job.as_ref().is_some_and(|job| job.picture.is_some());
        if !plan.spec.is_live() {
            state.window.all();
        }
        let (make, made) = channel();
        let desk = Desk::new(Scope::new(shared, state), plan.spec, plan.job, plan.remember);
        Ok(Self { desk, pump, made, make, outcome: plan.outcome })
    }

    fn fulfil(&self, ctx: &egui::Context, ask: Ask) {
        match ask {
            Ask::Picture(picture) => {
                let (make, again) = (self.make.clone(), ctx.clone());
                ctx.request_screenshot(move |image| {
                    // Nobody waits for it any more where the window is closing.
                    let _sent = make.send((picture, image));
                    again.request_repaint();
                });
            }
            Ask::Close => ctx.send_viewport_cmd(ViewportCommand::Close),
            Ask::Repaint(time) => ctx.request_repaint_after(time),
        }
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let hidden = ctx.input(|input| {
            let viewport = input.viewport();
            viewport.minimized.unwrap_or(false) || viewport.occluded.unwrap_or(false)
        });
        self.pump.watch().hidden.store(hidden, Ordering::Relaxed);
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        while let Ok((picture, image)) = self.made.try_recv() {
            self.desk.pictured(&ctx, picture, image);
        }
        for ask in self.desk.ui(ui) {
            self.fulfil(&ctx, ask);
        }
        let paused = self.desk.scope.state.is_paused();
        self.pump.watch().paused.store(paused, Ordering::Relaxed);
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        *self.outcome.lock().unwrap_or_else(PoisonError::into_inner) = self.desk.close();
    }
}
