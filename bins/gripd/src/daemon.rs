//! Threads of the daemon, started with its settings, and what they did at the end.
//!
//! hot: bytes to commands. port: finds and opens lines. recorder: files. This thread: everything that people and programs see.

use crate::{
    cli::Cli,
    clock::Clock,
    notify::Notify,
    recording::Recording,
    service::{Servers, Service, ServiceEnds},
    settings::Settings,
    summary::{Ended, Summary},
};
use anyhow::{Context as _, anyhow};
use core::sync::atomic::Ordering;
use grip_daemon::{
    HotCounters,
    clients::Clients,
    ends::{EndContext, SensorAddress, start_gripper, start_sensor},
    hot::{Ends, Hot, HotOptions, Shared},
    http::HttpServer,
    log::LogLevel,
    port_manager::{Lines, PortManager, PortManagerEnds, usb_filter},
    realtime::{self, Granted, RealtimeConfig},
    rings::{Sizes, rings},
    rows::{Commanded, RowSource, Rows},
};
use grip_port::{PortError, Source};
use grip_session::{
    Session, SessionOptions,
    exit::{Exit, message},
};
use grip_sim::port::Simulator;
use rtrb::RingBuffer;
use std::{
    io,
    sync::{Arc, mpsc},
    thread::{self, JoinHandle},
};

/// Stack of a thread (bytes): locked memory holds all of it.
const STACK: usize = if cfg!(debug_assertions) { 4 } else { 1 } * 1024 * 1024;
/// Lines on their way; there is one at a time.
const LINES: usize = 4;
/// Settings on their way.
const SETTINGS: usize = 4;
/// Copies of the counters on their way.
const PULSES: usize = 8;
/// Commands of clients on their way.
const COMMANDS: usize = 64;

/// Runs until a signal, the end of the duration or a failure.
pub(crate) fn run(cli: &Cli, settings: Settings) -> anyhow::Result<Exit> {
    let clock = Clock::start();
    let shared = shared()?;
    let realtime = settings.realtime();
    let options = HotOptions {
        end_us: end_us(cli.duration),
        patient: cli.wait || Notify::is_asked_for(),
        spin_us: realtime.spins_us(),
    };
    let session = session(cli, &settings)?;
    let weakness = settings.weakness();
    let source = realtime::starting(&realtime, || source(cli, &settings, clock, &shared))??;
    // Opened before anything moves: an address or a file that cannot be had is reported at once.
    let (servers, complaint) = servers(&settings, clock)?;
    let started = Recording::start(&settings, clock)?;
    let (recorder, recording, recorded) = started
        .map_or((None, None, None), |(ring, thread, recorded)| {
            (Some(ring), Some(thread), Some(recorded))
        });
    let fleet = settings.config.fleet.site.is_some();
    let (outbox, inbox) = rings(Sizes::SERVICE);
    let (line_in, line_out) = RingBuffer::new(LINES);
    let (lost_in, lost_out) = RingBuffer::new(LINES);
    let (settings_in, settings_out) = RingBuffer::new(SETTINGS);
    let (replaced_in, replaced_out) = RingBuffer::new(SETTINGS);
    let (command_in, command_out) = RingBuffer::new(COMMANDS);
    let (pulse_in, pulse_out) = RingBuffer::new(PULSES);
    let (updates_in, updates_out) = mpsc::channel();
    let mut service = Service::new(
        settings,
        clock,
        ServiceEnds {
            inbox,
            pulses: pulse_out,
            ports: updates_out,
            settings: settings_in,
            replaced: replaced_out,
            commands: command_in,
            recorded,
            rows: source.reports,
            back: source.rows.as_ref().map(Rows::back),
            shared: Arc::clone(&shared),
        },
        servers,
    )?;
    for complaint in complaint.into_iter().chain(weakness) {
        service.log(LogLevel::Warn, &complaint);
    }
    if fleet {
        service.log(LogLevel::Info, "fleet.site is set: gripfleet publishes it, where that runs");
    }
    let ends = Ends {
        lines: line_out,
        lost: lost_in,
        settings: settings_out,
        replaced: replaced_in,
        commands: command_out,
        service: outbox,
        recorder,
        pulses: pulse_in,
        shared: Arc::clone(&shared),
    };
    let hot = Hot::new(session, move || clock.now_ns(), options, ends);
    let lines = PortManagerEnds {
        lines: line_in,
        lost: lost_out,
        updates: updates_in,
        shared: Arc::clone(&shared),
    };
    let manager = PortManager::new(source.lines, options.patient, lines);
    let port = realtime::starting(&realtime, || start_port(manager, Arc::clone(&shared)))??;
    let (hot, granted) = start_hot(hot, realtime, shared)?;
    service.granted(&granted);
    service.run();
    let others = Others { simulator: source.simulator, rows: source.rows, recording };
    finish(cli, hot, port, others, service)
}

/// What the threads share; Ctrl-C and the service manager stop all of them.
fn shared() -> anyhow::Result<Arc<Shared>> {
    let shared = Arc::new(Shared::default());
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&shared.stop))
            .context("cannot take over Ctrl-C")?;
    }
    // A limit on the size of files is a full disk to the recording, and must not end the grip: the write then fails.
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())
        .context("cannot take over the signal of large files")?;
    Ok(shared)
}

/// Where lines come from, and what is at their other end where that is a thread of this program.
struct From {
    lines: Lines,
    simulator: Option<Simulator>,
    rows: Option<Rows>,
    reports: Option<mpsc::Receiver<String>>,
}

fn source(
    cli: &Cli,
    settings: &Settings,
    clock: Clock,
    shared: &Arc<Shared>,
) -> anyhow::Result<From> {
    if let Some(sensor) = &settings.sensor {
        return joined(cli, settings, sensor, clock, shared);
    }
    let simulator = Simulator::at(&settings.port, cli.seed, move || clock.now_us())?;
    let port = simulator.as_ref().map_or(settings.port.as_str(), Simulator::port);
    let source = Source::open(port, settings.baud, usb_filter(&settings.config.usb))?;
    Ok(From { lines: Lines::Port(source), simulator, rows: None, reports: None })
}

/// Rows of a program or of a sensor, and the gripper that follows them, as one board.
fn joined(
    cli: &Cli,
    settings: &Settings,
    sensor: &SensorAddress,
    clock: Clock,
    shared: &Arc<Shared>,
) -> anyhow::Result<From> {
    let (report_in, reports) = mpsc::channel();
    let context = || EndContext {
        clock: move || clock.now_us(),
        shared: Arc::clone(shared),
        patient: cli.wait || Notify::is_asked_for(),
        config: settings.config.clone(),
        baud: settings.baud,
        usb: usb_filter(&settings.config.usb),
        reports: report_in.clone(),
    };
    let gripper = settings.gripper.as_ref().map(|gripper| start_gripper(gripper, context()));
    let commanded = match (gripper.transpose()?, settings.actuator()) {
        (Some(gripper), Some(actuator)) => Commanded::Gripper(gripper, actuator),
        (None, Some(actuator)) => Commanded::Program(actuator),
        (_, None) => Commanded::Nobody,
    };
    let started = start_sensor(sensor, context())?;
    let source = match (sensor, started) {
        (SensorAddress::Rows(address), _) => RowSource::Program(address.clone()),
        (_, Some(started)) => RowSource::Sensor { name: sensor.to_string(), started },
        (_, None) => return Err(anyhow!("{sensor}: it has no line")),
    };
    let (rows, lines) =
        Rows::start(source, commanded, move || clock.now_us(), Arc::clone(shared), report_in)?;
    let lines = Lines::Made(lines);
    Ok(From { lines, simulator: None, rows: Some(rows), reports: Some(reports) })
}

fn named(name: &str) -> thread::Builder {
    thread::Builder::new().name(name.to_owned()).stack_size(STACK)
}

fn session(cli: &Cli, settings: &Settings) -> anyhow::Result<Session> {
    let options = SessionOptions {
        dry_run: cli.dry_run,
        observe: settings.observe,
        no_skip: cli.no_skip,
        uid: settings.config.uid.map(|uid| uid.0),
    };
    Ok(Session::new(settings.live(), settings.estimator(), options)?)
}

/// The sockets; what there is to complain about them where that is no reason to stop.
fn servers(settings: &Settings, clock: Clock) -> anyhow::Result<(Servers, Option<String>)> {
    let (config, asked) = settings.clients()?;
    let about = settings.client_about(clock.run_id());
    let (mut clients, complaint) = match Clients::listen(config, about) {
        Ok(clients) => {
            let warning = clients.warning().map(str::to_owned);
            (Some(clients), warning)
        }
        Err(error) if asked => return Err(error.into()),
        Err(error) => (None, Some(format!("{}; going on without clients", message(&error)))),
    };
    let http = settings
        .config
        .metrics
        .map(|address| HttpServer::bind(address, settings.config.allow_remote))
        .transpose()?;
    if let Some(clients) = &mut clients {
        clients.set_setup(settings.setup(0));
    }
    Ok((Servers { clients, http }, complaint))
}

/// The time at which the loop ends (us).
fn end_us(duration_s: Option<f64>) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, checked; the cast saturates"
    )]
    let end_us = duration_s.map_or(u64::MAX, |s| (s * 1e6) as u64);
    end_us
}

/// Counters, rows lost and the last command.
type HotEnd = anyhow::Result<(HotCounters, u64, Option<f32>)>;
type HotThread = JoinHandle<HotEnd>;
type PortThread = JoinHandle<Result<(), PortError>>;

/// The port thread. With its end everything ends.
fn start_port(manager: PortManager, shared: Arc<Shared>) -> io::Result<PortThread> {
    let ending = Ending(shared);
    named("port").spawn(move || {
        let _ending = ending;
        manager.run()
    })
}

/// The hot thread, and where it reports what it was granted. With its end everything ends.
fn start_hot<C: Fn() -> u64 + Send + 'static>(
    hot: Hot<C>,
    wanted: RealtimeConfig,
    shared: Arc<Shared>,
) -> io::Result<(HotThread, mpsc::Receiver<Granted>)> {
    let (granted_in, granted) = mpsc::channel();
    let ending = Ending(shared);
    let thread = named("hot").spawn(move || {
        let _ending = ending;
        run_hot(hot, &wanted, &granted_in)
    })?;
    Ok((thread, granted))
}

/// Asks the other threads to end when the hot thread or the port thread does, even by a panic.
struct Ending(Arc<Shared>);

impl Drop for Ending {
    fn drop(&mut self) {
        self.0.stop.store(true, Ordering::Relaxed);
    }
}

/// The hot thread: asks for real time, reports what was granted, and runs.
fn run_hot<C: Fn() -> u64>(
    mut hot: Hot<C>,
    wanted: &RealtimeConfig,
    granted: &mpsc::Sender<Granted>,
) -> HotEnd {
    let given = realtime::enter(wanted);
    let _reported = granted.send(given);
    given.check(wanted.mode)?;
    hot.run()?;
    let command_n = hot.session().latest().and_then(|step| step.command).map(|command| command.0);
    Ok((*hot.counters(), hot.session().lost(), command_n))
}

/// Threads beside those of every run.
struct Others {
    simulator: Option<Simulator>,
    rows: Option<Rows>,
    recording: Option<Recording>,
}

/// Gathers the threads and prints what they did. What went wrong first is what is reported.
fn finish(
    cli: &Cli,
    hot: HotThread,
    port: PortThread,
    others: Others,
    mut service: Service,
) -> anyhow::Result<Exit> {
    let Others { simulator, rows, recording } = others;
    let mut fallen = |thread: &str| {
        service.dump_after_panic(thread);
        anyhow!("the {thread} thread failed")
    };
    let hot = hot.join().map_err(|_| fallen("hot"));
    // Whole, also where the hot thread fell: it has let go of the ring.
    let recorded = recording.map(Recording::finish);
    let hot = hot?;
    let port = port.join().map_err(|_| fallen("port"))?;
    let closed = service.close();
    port?;
    let (counters, lost, command_n) = hot?;
    let recorded = recorded.transpose()?;
    let counted = rows.as_ref().map(Rows::ended).transpose()?;
    let ended = Ended { counters, lost, command_n, service: closed, recorded, rows: counted };
    let summary = Summary::new(&ended, simulator.map(Simulator::stop).transpose()?);
    if let Some(rows) = rows {
        let _sent = rows.back().line(serde_json::to_string(&summary)?);
        rows.finish();
    }
    match summary.print(cli.json) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        shown => shown?,
    }
    Ok(if summary.lost_data() { Exit::DataLost } else { Exit::Done })
}
