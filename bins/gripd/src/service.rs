//! Service of everything that people and programs see: lines, answers to clients, numbers and dumps, from items of the hot thread.

mod models;
mod objects;

use crate::{
    accepted::Accepted,
    clock::Clock,
    console::Console,
    figures,
    notify::Notify,
    recording::{Recorded, Reported},
    settings::{Loaded, Settings},
};
use anyhow::anyhow;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::{
    Board, HotCounters, Item,
    board::Grant,
    clients::{Clients, Loading, health},
    dump::{Cause, Dumped, FlightRecorder},
    exposition::Exposition,
    hot::{self, Shared},
    http::HttpServer,
    live::Feed,
    log::{Clocks, LogLevel},
    pages::page,
    port_manager::PortUpdate,
    realtime::{Granted, Outcome},
    rings::{Dropped, Inbox},
    rows::Back,
};
use grip_record::mcap::Attached;
use grip_session::{
    HostEstimator,
    exit::{WrongArgument, message},
};
use objects::Objects;
use rtrb::{Consumer, Producer};
use slip_core::ClientCommand;
use std::{
    collections::VecDeque,
    sync::{Arc, mpsc::Receiver},
    thread,
};

/// Pause between two looks into the rings where somebody is connected, and where nobody is.
const PAUSE: Duration = Duration::from_millis(10);
const LONG_PAUSE: Duration = Duration::from_millis(20);
/// The same where a program waits for the events of its rows.
const ROWS_PAUSE: Duration = Duration::from_millis(1);
/// Figures for clients are made this often (us).
const FIGURES_EVERY_US: u64 = 1_000_000;

/// The sentence about a connection that does not begin as that of a client does.
const STRANGER: &str = "a connection to the client socket did not begin with SUBSCRIBE and was closed: a web page, a port scan or another program; `listen = \"unix:PATH\"` keeps pages out";

/// The ends that lead to the other threads.
#[derive(Debug)]
pub(crate) struct ServiceEnds {
    /// What happened.
    pub(crate) inbox: Inbox,
    /// Counters of the hot thread.
    pub(crate) pulses: Consumer<HotCounters>,
    /// Updates of the port.
    pub(crate) ports: Receiver<PortUpdate>,
    /// Settings to be put in force.
    pub(crate) settings: Producer<Box<hot::Settings>>,
    /// Settings that were replaced or refused.
    pub(crate) replaced: Consumer<Box<hot::Settings>>,
    /// Commands of clients.
    pub(crate) commands: Producer<ClientCommand>,
    /// What the recorder reports, where there is one.
    pub(crate) recorded: Option<Recorded>,
    /// What the thread of the rows has to report, where rows are the sensor.
    pub(crate) rows: Option<Receiver<String>>,
    /// The way back to their program.
    pub(crate) back: Option<Back>,
    /// What is shared with the hot loop.
    pub(crate) shared: Arc<Shared>,
}

/// Sockets and what stands behind them.
#[derive(Debug)]
pub(crate) struct Servers {
    /// Clients; none where `listen` is off or its place is taken.
    pub(crate) clients: Option<Clients>,
    /// The server of figures.
    pub(crate) http: Option<HttpServer>,
}

/// Settings that were sent and not yet answered.
#[derive(Debug)]
enum Pending {
    /// Those of the files, and what they change, for people.
    Files(Box<Settings>, Vec<String>),
    /// Those in force with another model: of this client's file, or of the configuration.
    Model(Box<(Loading, Option<Loaded>)>),
}

/// The service thread.
#[derive(Debug)]
pub(crate) struct Service {
    settings: Settings,
    clock: Clock,
    ends: ServiceEnds,
    servers: Servers,
    console: Console,
    board: Board,
    exposition: Exposition,
    flight: FlightRecorder,
    notify: Notify,
    reload: Arc<AtomicBool>,
    figures_us: u64,
    /// What pages in browsers have received.
    feed: Feed,
    /// It was reported that dumps have no folder.
    no_folder: bool,
    /// What a reload asked for that is on its way to the hot thread.
    pending: VecDeque<Pending>,
    /// What is remembered of objects.
    objects: Option<Objects>,
    /// Models of clients that were in force here.
    accepted: Accepted,
    /// A model of a client that is asked about slips and moves nothing.
    shadow: Option<HostEstimator>,
}

impl Service {
    /// A service with its sockets open.
    pub(crate) fn new(
        settings: Settings,
        clock: Clock,
        ends: ServiceEnds,
        servers: Servers,
    ) -> anyhow::Result<Self> {
        let mut console = Console::new(settings.json, settings.config.log_level, clock);
        if let Some(back) = &ends.back {
            console.set_rows(back.clone());
        }
        if settings.observe {
            console.set_observing();
        }
        let objects = Objects::open(&settings.config.memory)
            .map_err(|error| WrongArgument(error.to_string()))?;
        let flight = FlightRecorder::new(settings.dump_folder());
        let accepted = Accepted::open(settings.dump_folder()).unwrap_or_else(|error| {
            let text = format!("models that were in force here are not known: {error}");
            console.log(LogLevel::Warn, &text);
            Accepted::default()
        });
        let reload = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(signal_hook::consts::SIGHUP, Arc::clone(&reload))?;
        Ok(Self {
            board: Board::new(settings.about(clock.run_id())),
            settings,
            clock,
            ends,
            servers,
            console,
            exposition: Exposition::default(),
            flight,
            notify: Notify::new(),
            reload,
            figures_us: 0,
            feed: Feed::default(),
            no_folder: false,
            pending: VecDeque::new(),
            objects,
            accepted,
            shadow: None,
        })
    }

    /// Reports a sentence before anything runs.
    pub(crate) fn log(&mut self, level: LogLevel, text: &str) {
        self.console.log(level, text);
    }

    /// What the hot thread was granted, as soon as it has asked.
    pub(crate) fn granted(&mut self, granted: &Receiver<Granted>) {
        // The thread ended before it could ask: what it reports at its end is reported instead.
        let Ok(granted) = granted.recv() else { return };
        for attempt in granted.attempts() {
            let refused = match attempt.outcome {
                Outcome::NotAsked => continue,
                Outcome::Granted => None,
                Outcome::Refused(error) => Some(error.to_string()),
            };
            let level = if refused.is_some() { LogLevel::Warn } else { LogLevel::Info };
            self.console.log(level, &format!("real time: {attempt}"));
            let what = attempt.measure.name().to_owned();
            self.board.about.grants.push(Grant { what, refused });
        }
        if let Some(clients) = &mut self.servers.clients {
            clients.set_about(figures::about(&self.settings, self.clock.run_id(), &granted));
        }
    }

    /// Runs until the hot thread has let go of its rings and they are empty.
    pub(crate) fn run(&mut self) {
        self.notify.ready();
        loop {
            let last = self.ends.inbox.is_finished();
            self.turn();
            if last {
                break;
            }
        }
        self.notify.stopping();
        self.console.clear_status();
    }

    /// Takes leave of clients; what the hot thread reported and did not fit.
    pub(crate) fn close(mut self) -> Dropped {
        if let Some(clients) = &mut self.servers.clients {
            clients.close(self.clock.now_us());
        }
        self.ends.inbox.drops().now()
    }

    /// A thread ended with a panic: what it did last is written down.
    pub(crate) fn dump_after_panic(&mut self, thread: &str) {
        self.dump(&Cause::Panic(format!("the {thread} thread")));
    }

    /// One look at everything.
    fn turn(&mut self) {
        self.wait();
        self.drain();
        while let Ok(counters) = self.ends.pulses.pop() {
            self.board.count(&counters);
            self.notify.alive(counters.turns, self.clock.now_us());
        }
        while let Ok(updates) = self.ends.ports.try_recv() {
            self.console.port(&updates);
        }
        for text in self.ends.rows.iter().flat_map(Receiver::try_iter) {
            self.console.log(LogLevel::Warn, &text);
        }
        self.receive_recorder();
        self.serve_objects();
        self.pass_commands();
        self.receive_settings();
        self.serve_models();
        let now_us = self.clock.now_us();
        if now_us >= self.figures_us {
            self.figures_us = now_us + FIGURES_EVERY_US;
            self.report_figures();
        }
        self.console.tick();
    }

    /// Waits for sockets and time, and serves the sockets.
    fn wait(&mut self) {
        let now_us = self.clock.now_us();
        let connected = self.servers.clients.as_ref().is_some_and(|clients| clients.count() > 0);
        let pause = match (&self.ends.back, connected) {
            (Some(_), _) => ROWS_PAUSE,
            (None, true) => PAUSE,
            (None, false) => LONG_PAUSE,
        };
        match &mut self.servers.clients {
            Some(clients) => {
                if let Err(error) = clients.poll(now_us, pause) {
                    self.console
                        .log(LogLevel::Error, &format!("clients cannot be served: {error}"));
                    sleep(pause);
                }
            }
            None => sleep(pause),
        }
        if let Some(http) = &mut self.servers.http {
            let Self { board, exposition, .. } = self;
            http.serve(now_us, &mut |path| page(board, now_us, exposition, path));
            if let Some(message) = self.feed.next(board, now_us, http.streams()) {
                http.publish(now_us, &message);
            }
        }
        let wants = self.servers.clients.as_ref().is_some_and(|clients| clients.wants_samples());
        self.ends.shared.wants_samples.store(wants, Ordering::Relaxed);
    }

    fn drain(&mut self) {
        let Self { ends, console, board, servers, flight, objects, shadow, .. } = self;
        let (mut cause, mut remembered) = (None, Vec::new());
        ends.inbox.drain(&mut |item| {
            board.take(&item);
            if let Some(clients) = &mut servers.clients {
                clients.take(&item);
                if let (Item::Evidence { host_us, evidence }, Some(shadow)) = (&item, &*shadow) {
                    clients.estimates(*host_us, &evidence.beside(shadow));
                }
            }
            cause = flight.take(&item).or_else(|| cause.take());
            console.take(&item);
            remembered.extend(objects.as_mut().and_then(|objects| objects.take(&item)));
        });
        self.remember(&remembered);
        if let Some(cause) = cause {
            self.dump(&cause);
        }
    }

    /// Writes the last frames and the state down.
    fn dump(&mut self, cause: &Cause) {
        let now = Clocks { host_us: self.clock.now_us(), wall_us: self.clock.wall_ns() / 1000 };
        let (level, text) = match self.flight.write(cause, &self.board, now) {
            Ok(Dumped::File(file)) => (
                LogLevel::Info,
                format!("the last frames and the state were written to {}", file.display()),
            ),
            Ok(Dumped::NoFolder) if !core::mem::replace(&mut self.no_folder, true) => {
                let text = "the last frames and the state are not written down: no dump_dir";
                (LogLevel::Info, text.to_owned())
            }
            Ok(Dumped::NoFolder | Dumped::TooMany) => return,
            Err(error) => (LogLevel::Warn, message(&error)),
        };
        self.console.log(level, &text);
    }

    fn receive_recorder(&mut self) {
        let Some(recorded) = &self.ends.recorded else { return };
        while let Ok(reported) = recorded.reported.try_recv() {
            let state = &mut self.board.recording;
            match reported {
                Reported::Began(file) => {
                    let text = format!("recording to {}", file.display());
                    state.file = Some(file);
                    state.failure = None;
                    self.console.log(LogLevel::Info, &text);
                }
                Reported::Stopped(reason) => {
                    state.file = None;
                    state.failure = Some(reason.clone());
                    let text = format!("{reason}; the object is held without a recording");
                    self.console.log(LogLevel::Error, &text);
                }
                Reported::Deleted(file) => {
                    let text =
                        format!("deleted {}: newer recordings need the room", file.display());
                    self.console.log(LogLevel::Info, &text);
                }
                Reported::Kept(file, reason) => {
                    let text = format!("cannot delete {}: {reason}", file.display());
                    self.console.log(LogLevel::Warn, &text);
                }
                Reported::Counters(counters) => {
                    state.files = u64::from(counters.files);
                    state.bytes = counters.bytes;
                    state.dropped = counters.dropped + counters.stopped;
                }
            }
        }
    }

    /// Hands the commands of clients on.
    fn pass_commands(&mut self) {
        let Some(clients) = &mut self.servers.clients else { return };
        for _ in 0..clients.take_strangers() {
            self.console.log(LogLevel::Warn, STRANGER);
        }
        // What finds no place waits: a STOP that was answered is never lost.
        while !self.ends.commands.is_full()
            && let Some(command) = clients.next_command()
        {
            let Ok(()) = self.ends.commands.push(command) else { return };
        }
    }

    /// Reads the settings again where that was asked for, and receives what became of those that were sent.
    fn receive_settings(&mut self) {
        while let Ok(replaced) = self.ends.replaced.pop() {
            // What happened before is reported before.
            self.drain();
            match self.pending.pop_front() {
                None => {}
                Some(Pending::Files(settings, changes)) => {
                    self.reloaded(*settings, &changes, replaced.refused.as_ref());
                }
                Some(Pending::Model(wanted)) => {
                    let (load, model) = *wanted;
                    self.model_swapped(&load, model, replaced.refused.as_ref());
                }
            }
        }
        // Settings are read beside the model in force: which one that is must be known.
        if self.pending.iter().any(|pending| matches!(pending, Pending::Model(..))) {
            return;
        }
        if self.reload.swap(false, Ordering::Relaxed) {
            self.notify.reloading();
            if let Err(error) = self.reload() {
                self.board.about.reloads.1 += 1;
                let text = format!("the settings in force stay: {}", message(error.as_ref()));
                self.console.log(LogLevel::Error, &text);
            }
            self.notify.ready();
        }
    }

    /// The hot thread has taken settings, or has not.
    fn reloaded(
        &mut self,
        settings: Settings,
        changes: &[String],
        refused: Option<&grip_session::SessionError>,
    ) {
        let (level, text) = if let Some(error) = refused {
            self.board.about.reloads.1 += 1;
            self.attach(&self.settings.attachments());
            (LogLevel::Error, format!("the settings in force stay: {}", message(error)))
        } else {
            self.board.about.reloads.0 += 1;
            self.board.about.config_files = settings.about(self.clock.run_id()).config_files;
            self.console.set_level(settings.config.log_level);
            self.settings = settings;
            (LogLevel::Info, format!("the new settings are in force: {}", changes.join(", ")))
        };
        self.console.log(level, &text);
        if refused.is_none() {
            self.settings_changed(changes.iter().any(|change| change.starts_with("model: ")));
        }
    }

    /// Reads the settings again and sends them to the hot thread. On an error nothing has changed.
    fn reload(&mut self) -> anyhow::Result<()> {
        let reload = self.settings.reload()?;
        if reload.changes.is_empty() {
            self.console.log(LogLevel::Info, "nothing has changed in the settings");
            return Ok(());
        }
        let files = reload.settings.attachments()?;
        let live = reload.changes.iter().filter(|change| change.needs_restart().is_none());
        let changes: Vec<String> = live.map(ToString::to_string).collect();
        for key in &reload.restart {
            let text = format!("{key} has changed; it is taken over at the next start");
            self.console.log(LogLevel::Warn, &text);
        }
        let config = reload.settings.live();
        let settings = hot::Settings { config, estimator: reload.estimator, refused: None };
        if self.ends.settings.is_full() {
            return Err(anyhow!("earlier settings still wait to be taken over; try again"));
        }
        // First to the recorder: the pipeline that begins with them comes after.
        self.attach(&Ok(files));
        // There is room: nobody else sends settings.
        let _sent = self.ends.settings.push(Box::new(settings));
        self.pending.push_back(Pending::Files(Box::new(reload.settings), changes));
        Ok(())
    }

    /// Configuration, model and calibration for the recording. A recorder that has ended is reported elsewhere, and what cannot be read
    /// any more was read before.
    fn attach(&self, files: &anyhow::Result<Vec<Attached>>) {
        if let (Some(recorded), Ok(files)) = (&self.ends.recorded, files) {
            for file in files {
                let _sent = recorded.attach.send(file.clone());
            }
        }
    }

    /// Figures of the last second.
    fn report_figures(&mut self) {
        let Some(clients) = &mut self.servers.clients else { return };
        self.board.clients = figures::clients(clients);
        clients.health(&health(&self.board, self.clock.now_us()));
    }
}

#[expect(clippy::disallowed_methods, reason = "the driver may wait; only the service thread does")]
fn sleep(pause: Duration) {
    thread::sleep(pause);
}
