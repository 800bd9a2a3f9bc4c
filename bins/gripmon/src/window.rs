//! The system's window around [`Scope`]: its thread, its files, its pictures.

use crate::apply::Effect;
use crate::cli::Cli;
use crate::engine::Engine;
use crate::files;
use crate::job::{Job, Step};
use crate::layout::{self, Layout};
use crate::pump::Pump;
use crate::scope::{self, Scope, Shared};
use crate::state::{Message, ViewState};
use crate::view_file::ViewFile;
use anyhow::{Context as _, bail};
use core::sync::atomic::Ordering;
use eframe::egui::{self, ColorImage, Ui, ViewportCommand};
use grip_scope::{Channel, Model, SourceHandle, SourceSpec, Span, export};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, Thread};

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
    let outcome = Arc::new(Mutex::new(None));
    let job = view.map(|view| Job::new(view, cli.picture.clone()));
    let plan = Plan {
        spec,
        layout,
        remembered,
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

/// What is to be opened.
struct Plan {
    spec: SourceSpec,
    layout: Layout,
    remembered: Option<PathBuf>,
    memory_bytes: usize,
    job: Option<Job>,
    outcome: Arc<Mutex<Option<String>>>,
}

struct App {
    scope: Scope,
    pump: Pump,
    remembered: Option<PathBuf>,
    spec: SourceSpec,
    job: Option<Job>,
    told: Receiver<Message>,
    tell: Sender<Message>,
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
        let (tell, told) = channel();
        let scope = Scope::new(shared, state);
        let (remembered, spec) = (plan.remembered, plan.spec);
        Ok(Self { scope, pump, remembered, spec, job: plan.job, told, tell, outcome: plan.outcome })
    }

    fn effect(&mut self, ctx: &egui::Context, effect: Effect) {
        match effect {
            Effect::Picture => match files::free_name(&self.scope.state.stem, "png") {
                Ok(path) => self.picture(ctx, path, false),
                Err(error) => self.scope.state.complain(error.to_string()),
            },
            Effect::Csv | Effect::Mcap => self.export(ctx, effect),
        }
    }

    /// Asks for the next frame as a picture; another thread writes it.
    fn picture(&self, ctx: &egui::Context, path: PathBuf, ends: bool) {
        let (tell, outcome, again) = (self.tell.clone(), Arc::clone(&self.outcome), ctx.clone());
        ctx.request_screenshot(move |image: Arc<ColorImage>| {
            let message = written(
                &path,
                files::write_png(&path, &image)
                    .map(|()| "this window".to_owned())
                    .map_err(anyhow::Error::from),
            );
            if ends && message.is_error {
                *outcome.lock().unwrap_or_else(PoisonError::into_inner) =
                    Some(message.text.clone());
            }
            // Nobody listens any more where the window is closing.
            let _sent = tell.send(message);
            if ends {
                again.send_viewport_cmd(ViewportCommand::Close);
            }
            again.request_repaint();
        });
    }

    /// Writes what is seen, on a thread of its own.
    fn export(&mut self, ctx: &egui::Context, effect: Effect) {
        let shared = Arc::clone(&self.scope.shared);
        let span = {
            let engine = shared.engine_first();
            self.scope
                .state
                .between()
                .unwrap_or_else(|| self.scope.state.window.visible(engine.model.span()))
        };
        let ending = if effect == Effect::Csv { "csv" } else { "mcap" };
        let path = match files::free_name(&self.scope.state.stem, ending) {
            Ok(path) => path,
            Err(error) => return self.scope.state.complain(error.to_string()),
        };
        self.scope.state.tell(format!("Writing {} ..", path.display()));
        let (tell, ctx, spec) = (self.tell.clone(), ctx.clone(), self.spec.clone());
        let channels = shown_channels(&self.scope);
        let work = move || {
            let result = write((effect, &path), (&shared, &spec), (span, &channels));
            let _sent = tell.send(written(&path, result));
            ctx.request_repaint();
        };
        if let Err(error) = thread::Builder::new().name("export".to_owned()).spawn(work) {
            self.scope.state.complain(format!("no thread to write with: {error}"));
        }
    }

    /// Goes where --view wants to look, and makes the picture there.
    fn work(&mut self, ctx: &egui::Context) {
        let Some(job) = &mut self.job else { return };
        let so_far = (self.scope.frames(), ctx.input(|input| input.time));
        let step = {
            let engine = self.scope.shared.engine_first();
            job.step(&mut self.scope.state, &engine.model, so_far)
        };
        let ends = job.picture.is_some();
        if let Step::Wait(time) = step {
            return ctx.request_repaint_after(time);
        }
        self.job = None;
        match step {
            Step::Picture(path) => self.picture(ctx, path, true),
            Step::Failed(sentence) if ends => {
                *self.outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(sentence);
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            Step::Failed(sentence) => {
                self.scope.state.complain(sentence);
                ctx.request_repaint();
            }
            Step::Done | Step::Wait(_) => ctx.request_repaint(),
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
        while let Ok(message) = self.told.try_recv() {
            self.scope.state.message = Some(message);
        }
        let ctx = ui.ctx().clone();
        for effect in self.scope.ui(ui) {
            self.effect(&ctx, effect);
        }
        let size = ctx.content_rect().size();
        self.scope.state.layout.window = [size.x, size.y];
        self.pump.watch().paused.store(self.scope.state.is_paused(), Ordering::Relaxed);
        self.work(&ctx);
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        let Some(path) = &self.remembered else { return };
        if let Err(error) = self.scope.layout().write(path) {
            let sentence = format!("the arrangement of the window is not remembered: {error}");
            *self.outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(sentence);
        }
    }
}

fn shown_channels(scope: &Scope) -> Vec<Channel> {
    let engine = scope.shared.engine_first();
    let plots = scope.state.layout.plots.iter().filter(|plot| plot.shown);
    plots
        .flat_map(|plot| crate::strip::curves(plot.plot, &engine.model))
        .map(|curve| curve.channel)
        .collect()
}

/// Writes a file of what is asked for; the sentence that tells it.
fn write(
    (effect, path): (Effect, &Path),
    (shared, spec): (&Shared, &SourceSpec),
    (span, channels): (Span, &[Channel]),
) -> anyhow::Result<String> {
    match (effect, spec) {
        (Effect::Csv, _) => {
            // A copy, so that the window and the pump go on while it is written.
            let model = shared.engine_first().model.clone();
            let rows = export::csv(&model, span, channels, path)?;
            Ok(format!("{} rows", crate::format::count(rows)))
        }
        (_, SourceSpec::Recording(from))
            if from.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap")) =>
        {
            Ok(sliced(export::mcap_slice(from, span, path)?))
        }
        _ => {
            let model = shared.engine_first().model.clone();
            Ok(sliced(export::mcap(&model, span, path)?))
        }
    }
}

fn sliced(slice: export::Sliced) -> String {
    let count = crate::format::count;
    format!("{} samples, {} messages", count(slice.samples), count(slice.messages))
}

fn written(path: &Path, result: anyhow::Result<String>) -> Message {
    match result {
        Ok(what) => {
            Message { text: format!("Written: {} ({what})", path.display()), is_error: false }
        }
        Err(error) => {
            let (name, told) = (path.display().to_string(), error.to_string());
            // Some errors name the file themselves.
            let text = if told.starts_with(&name) { told } else { format!("{name}: {told}") };
            Message { text, is_error: true }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::written;
    use std::path::Path;

    #[test]
    fn an_error_names_its_file_once() {
        let path = Path::new("run-0001.csv");
        let told = |error: &str| written(path, Err(anyhow::anyhow!(error.to_owned()))).text;
        assert_eq!(told("run-0001.csv: cannot be written"), "run-0001.csv: cannot be written");
        assert_eq!(told("there are no samples"), "run-0001.csv: there are no samples");
    }
}
