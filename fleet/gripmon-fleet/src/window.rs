//! The system's window around the table and the gripper that is opened: threads, pictures, what is remembered.

use super::hall::Hall;
use super::lobby::{Lobby, Request};
use super::opened::{Lead, opened};
use crate::cli::Cli;
use crate::grippers::Member;
use crate::source::{FleetHandle, FleetPlace, GripperAt, Network};
use anyhow::Context as _;
use core::time::Duration;
use eframe::egui::{self, Ui, ViewportCommand};
use grip_scope::SourceSpec;
use grip_session::exit::WrongArgument;
use gripmon::exports::Exports;
use gripmon::files;
use gripmon::scope;
use gripmon::state::Message;
use gripmon::window::{self, Screen, Start};
use std::sync::{Arc, PoisonError};

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

struct FleetApp {
    lobby: Lobby,
    _network: FleetHandle,
    open: Option<Opened>,
    network: Network,
    start: Start,
    shots: Shots,
}

impl FleetApp {
    fn new(ctx: &egui::Context, place: FleetPlace, mut start: Start) -> anyhow::Result<Self> {
        scope::prepare(ctx, start.layout.theme);
        let hall = Arc::<Hall>::default();
        let (network, name) = (place.network.clone(), place.to_string());
        let (filled, shown, painted) = (Arc::clone(&hall), Arc::clone(&hall), ctx.clone());
        let (take, wake) = (move |feed| filled.take(feed), move || shown.paint(&painted));
        let handle = FleetHandle::spawn(place, take, wake).context("the network's thread")?;
        let lobby = Lobby::new(hall, start.layout.theme, name);
        // The picture is one of the table.
        let shots = Shots::new(start.job.take());
        Ok(Self { lobby, _network: handle, open: None, network, start, shots })
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
        self.start.layout.window = [size.x, size.y];
        self.start.layout.theme = self.lobby.theme;
        self.start.remember.note(self.start.layout.clone());
        self.shots.step(&self.lobby, &ctx);
    }

    fn enter(&mut self, ctx: &egui::Context, member: Member) {
        let name = member.to_string();
        let at = GripperAt { network: self.network.clone(), member };
        match Screen::open(ctx, SourceSpec::Other(Arc::new(at)), &self.start) {
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
            self.start.layout = open.screen.desk.scope.layout();
            self.lobby.theme = self.start.layout.theme;
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
        self.lobby.hall.set_hidden(hidden || self.open.is_some());
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
                self.start.remember.write().err().map(|error| {
                    format!("the arrangement of the window is not remembered: {error}")
                })
            }),
        };
        *self.start.outcome.lock().unwrap_or_else(PoisonError::into_inner) = failed;
    }
}

/// Pictures of the table: by key, and the one of the command line.
struct Shots {
    job: Option<gripmon::job::Job>,
    exports: Exports,
    failed: Option<String>,
}

impl Shots {
    fn new(job: Option<gripmon::job::Job>) -> Self {
        Self { job, exports: Exports::default(), failed: None }
    }

    /// The key for a picture.
    fn begin(&self, lobby: &mut Lobby, ctx: &egui::Context) {
        match files::free_name("gripmon", "png") {
            Ok(path) => self.exports.picture(ctx, path, false),
            Err(error) => lobby.message = Some(Message { text: error.to_string(), is_error: true }),
        }
    }

    /// Reports what was written.
    fn written(&mut self, lobby: &mut Lobby, ctx: &egui::Context) {
        while let Some(written) = self.exports.written(ctx) {
            if written.is_last {
                self.failed = Some(&written.message).filter(|m| m.is_error).map(|m| m.text.clone());
                ctx.send_viewport_cmd(ViewportCommand::Close);
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
            self.exports.picture(ctx, path, true);
        } else if ctx.input(|input| input.time) >= look.patience_s {
            let status = lobby.hall.look(|roster| roster.status().sentence());
            self.failed =
                Some(format!("no picture: no gripper came within {} s: {status}", look.patience_s));
            self.job = None;
            ctx.send_viewport_cmd(ViewportCommand::Close);
        } else {
            ctx.request_repaint_after(LOOK);
        }
    }

    /// The window closes: what is being written is ended. The sentence of what has failed.
    fn close(&mut self) -> Option<String> {
        self.exports = Exports::default();
        self.failed.take()
    }
}
