//! The system's window around the table and the gripper that is opened: threads, pictures, what is remembered.

use super::hall::Hall;
use super::lobby::{Lobby, Request};
use super::opened::{Lead, opened};
use super::pump::FleetPump;
use crate::cli::Cli;
use crate::grippers::{Member, Roster};
use crate::source::{FleetHandle, FleetPlace, GripperAt, Network};
use anyhow::Context as _;
use core::time::Duration;
use eframe::egui::{self, ColorImage, Ui};
use grip_scope::{Model, SourceSpec};
use grip_session::exit::WrongArgument;
use gripmon::desk::{Ask, Picture};
use gripmon::engine::Engine;
use gripmon::exports::{Exports, Work};
use gripmon::files;
use gripmon::layout::Layout;
use gripmon::scope::{self, Shared};
use gripmon::state::Message;
use gripmon::window::{self, Outcome, Parts, Screen, Start};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, OnceLock, PoisonError};
use std::thread::Thread;

/// Time between two looks for a picture, which does not wait for data.
const LOOK: Duration = Duration::from_millis(50);

/// Opens the window on the network of the command line and runs until it is closed.
///
/// # Errors
/// As [`window::run`]; an endpoint or configuration file that can be none is a wrong argument.
pub fn run(cli: &Cli) -> anyhow::Result<()> {
    let network = Network { router: cli.router.clone(), file: cli.network.clone() };
    network.check().map_err(|error| WrongArgument(error.to_string()))?;
    let place = FleetPlace { network, site: cli.site.clone() };
    let start = Start::of(&cli.window)?;
    let (title, size) = (format!("gripmon-fleet - {place}"), start.layout.window);
    let outcome = Arc::clone(&start.outcome);
    window::show(&title, size, &outcome, move |ctx| Ok(Box::new(FleetApp::new(ctx, place, start)?)))
}

/// The gripper that is opened.
struct Opened {
    name: String,
    screen: Screen,
}

/// What is remembered, and what a screen begins with.
struct Keep {
    network: Network,
    layout: Layout,
    remember: gripmon::remember::Remember,
    memory_bytes: usize,
}

struct FleetApp {
    lobby: Lobby,
    pump: FleetPump,
    open: Option<Opened>,
    keep: Keep,
    shots: Shots,
    outcome: Outcome,
}

impl FleetApp {
    fn new(ctx: &egui::Context, place: FleetPlace, start: Start) -> anyhow::Result<Self> {
        scope::prepare(ctx, start.layout.theme);
        let hall = Arc::new(Hall::new(Roster::default(), None));
        let pump = FleetPump::start(Arc::clone(&hall), ctx.clone()).context("the pump's thread")?;
        let pumping: OnceLock<Thread> = OnceLock::new();
        let _first = pump.thread().map(|thread| pumping.set(thread.clone()));
        let wake = move || pumping.get().into_iter().for_each(Thread::unpark);
        let network = place.network.clone();
        let lobby = Lobby::new(Arc::clone(&hall), start.layout.theme, place.to_string());
        hall.watch(FleetHandle::spawn(place, wake).context("the network's thread")?);
        let keep = Keep {
            network,
            layout: start.layout,
            remember: start.remember,
            memory_bytes: start.memory_bytes,
        };
        let shots = Shots::new(start.job);
        Ok(Self { lobby, pump, open: None, keep, shots, outcome: start.outcome })
    }

    fn table(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.shots.written(&mut self.lobby, &ctx);
        for request in self.lobby.ui(ui) {
            match request {
                Request::Open(member) => self.enter(&ctx, member),
                Request::Picture => self.shots.begin(&mut self.lobby, &ctx),
            }
        }
        let size = ctx.content_rect().size();
        self.keep.layout.window = [size.x, size.y];
        self.keep.layout.theme = self.lobby.theme;
        self.keep.remember.note(self.keep.layout.clone());
        self.shots.step(&self.lobby, &ctx);
    }

    fn enter(&mut self, ctx: &egui::Context, member: Member) {
        let name = member.to_string();
        let at = GripperAt { network: self.keep.network.clone(), member };
        let parts = Parts {
            spec: SourceSpec::Other(Arc::new(at)),
            layout: self.keep.layout.clone(),
            remember: self.keep.remember.clone(),
            memory_bytes: self.keep.memory_bytes,
            job: None,
        };
        match Screen::open(ctx, parts) {
            Ok(screen) => self.open = Some(Opened { name, screen }),
            Err(error) => {
                let text = format!("{name} cannot be opened: {error:#}");
                self.lobby.message = Some(Message { text, is_error: true });
            }
        }
        ctx.request_repaint();
    }

    /// Leads back to the table; what is being written is ended first.
    fn leave(&mut self, ctx: &egui::Context) {
        if let Some(mut open) = self.open.take() {
            self.keep.layout = open.screen.desk.scope.layout();
            self.lobby.theme = self.keep.layout.theme;
            if let Some(text) = open.screen.desk.close() {
                self.lobby.message = Some(Message { text, is_error: true });
            }
        }
        ctx.request_repaint();
    }
}

impl eframe::App for FleetApp {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let hidden = window::is_hidden(ctx);
        self.pump.set_hidden(hidden || self.open.is_some());
        if let Some(open) = &self.open {
            open.screen.set_hidden(hidden);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let Some(open) = &mut self.open else { return self.table(ui) };
        let lead = opened(ui, &open.screen.desk.scope, &open.name);
        if open.screen.ui(ui).is_some() {
            let sentence = "a file has a window of its own: gripmon FILE";
            open.screen.desk.scope.state.complain(sentence);
        }
        if lead == Lead::Back {
            let ctx = ui.ctx().clone();
            self.leave(&ctx);
        }
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        let failed = match &mut self.open {
            Some(open) => open.screen.desk.close(),
            None => self.shots.close().or_else(|| {
                self.keep.remember.write().err().map(|error| {
                    format!("the arrangement of the window is not remembered: {error}")
                })
            }),
        };
        *self.outcome.lock().unwrap_or_else(PoisonError::into_inner) = failed;
    }
}

/// Pictures of the table: by key, and the one of the command line.
struct Shots {
    job: Option<gripmon::job::Job>,
    made: Receiver<(Picture, Arc<ColorImage>)>,
    make: Sender<(Picture, Arc<ColorImage>)>,
    exports: Exports,
    failed: Option<String>,
}

impl Shots {
    fn new(job: Option<gripmon::job::Job>) -> Self {
        let (make, made) = channel();
        Self { job, made, make, exports: Exports::default(), failed: None }
    }

    /// The key for a picture.
    fn begin(&self, lobby: &mut Lobby, ctx: &egui::Context) {
        match files::free_name("gripmon", "png") {
            Ok(path) => self.ask(ctx, path, false),
            Err(error) => lobby.message = Some(Message { text: error.to_string(), is_error: true }),
        }
    }

    fn ask(&self, ctx: &egui::Context, path: PathBuf, is_last: bool) {
        window::fulfil(ctx, Ask::Picture(Picture { path, is_last }), &self.make);
    }

    /// Writes what was made, and reports what was written.
    fn written(&mut self, lobby: &mut Lobby, ctx: &egui::Context) {
        while let Ok((picture, image)) = self.made.try_recv() {
            let work =
                if picture.is_last { Work::LastPicture(image) } else { Work::Picture(image) };
            // A picture needs no model.
            let shared = Arc::new(Shared::new(Engine::new(Model::new(0), None)));
            let again = ctx.clone();
            let wake = move || again.request_repaint();
            if let Err(error) = self.exports.begin(work, picture.path, shared, wake) {
                let text = format!("no thread to write with: {error}");
                lobby.message = Some(Message { text, is_error: true });
            }
        }
        while let Some(written) = self.exports.written() {
            if written.is_last {
                self.failed = Some(&written.message).filter(|m| m.is_error).map(|m| m.text.clone());
                window::fulfil(ctx, Ask::Close, &self.make);
            }
            lobby.message = Some(written.message);
        }
    }

    /// The picture of --view and --picture: as soon as so much time has passed with grippers there.
    fn step(&mut self, lobby: &Lobby, ctx: &egui::Context) {
        let Some(job) = &self.job else { return };
        let Some(path) = job.picture.clone() else { return };
        let look = &job.view.look;
        let ready =
            lobby.hall.look(|roster| !roster.rows().is_empty() && roster.now_s() >= look.after_s);
        if ready {
            self.job = None;
            self.ask(ctx, path, true);
        } else if ctx.input(|input| input.time) >= look.patience_s {
            let status = lobby.hall.look(|roster| roster.status().sentence());
            self.failed =
                Some(format!("no picture: no gripper came within {} s: {status}", look.patience_s));
            self.job = None;
            window::fulfil(ctx, Ask::Close, &self.make);
        } else {
            window::fulfil(ctx, Ask::Repaint(LOOK), &self.make);
        }
    }

    /// The window closes: what is being written is ended. The sentence of what has failed.
    fn close(&mut self) -> Option<String> {
        self.exports = Exports::default();
        self.failed.take()
    }
}
