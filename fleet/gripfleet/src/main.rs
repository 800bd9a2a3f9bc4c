//! The program that makes the gripper of a gripd one of many, as a client of it; with a command, that of whoever looks after many.

mod cli;
mod clock;
mod commands;
mod common;
mod connection;
mod curator;
mod keeper;
mod lending;
mod network;
#[path = "../../../bins/gripctl/src/print.rs"]
mod output;
mod settings;

use clap::Parser as _;
use cli::Cli;
use clock::Clock;
use common::{Message, pause};
use connection::Connection;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::{
    clients::Stream,
    log::{Entry, Log, LogLevel, LogStyle},
};
use grip_fleet::LastReceived;
use grip_session::exit::{self, Exit};
use settings::Settings;
use std::{
    io::{self, Write as _},
    process::ExitCode,
};

/// Pause between two looks at the log lines of the threads, and between two attempts to reach gripd.
const LOOK: Duration = Duration::from_millis(20);
const RETRY: Duration = Duration::from_millis(100);
/// gripd answers a connection within this time.
const PATIENCE: Duration = Duration::from_secs(2);

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let Some(text) = output::number(&error) else { error.exit() };
            eprint!("{text}");
            return Exit::WrongArguments.into();
        }
    };
    match cli.command.as_ref().map_or_else(|| run(&cli), commands::run) {
        Ok(exit) => exit.into(),
        Err(error) if output::is_closed_pipe(&error) => Exit::Done.into(),
        Err(error) => {
            // A standard error that takes nothing must not turn the reason into a panic; the exit code shows it too.
            let _printed = writeln!(io::stderr(), "gripfleet: {}", exit::message(error.as_ref()));
            Exit::of(error.as_ref()).into()
        }
    }
}

fn run(cli: &Cli) -> anyhow::Result<Exit> {
    let settings = Settings::new(cli)?;
    if cli.check_config {
        eprintln!("the configuration is valid; this gripper is published at {}", settings.site);
        return Ok(Exit::Done);
    }
    let stop = commands::stopped()?;
    let mut console = Console::new(&settings);
    let listen = settings.config.listen.clone();
    let mut received = None;
    let mut complained = false;
    while !stop.load(Ordering::Relaxed) {
        match Stream::connect(&listen, PATIENCE) {
            Ok(stream) => {
                complained = false;
                let connection = Connection::start(&settings, stream, received, console.clock)?;
                received = console.follow(connection, &stop).or(received);
            }
            Err(error) if !complained => {
                complained = true;
                // Of a gripd that comes later nothing was received yet.
                received = received.or(Some(LastReceived::default()));
                let text = format!("no gripd answers at {listen}: {error}; waiting for it");
                console.print(&(LogLevel::Warn, text));
            }
            Err(_) => pause(RETRY),
        }
    }
    Ok(Exit::Done)
}

/// The log on standard error.
struct Console {
    log: Log,
    clock: Clock,
}

impl Console {
    fn new(settings: &Settings) -> Self {
        let log = Log::new("gripfleet", LogStyle::of_stderr(), settings.config.log_level);
        Self { log, clock: Clock::start() }
    }

    fn print(&mut self, message: &Message) {
        let (level, text) = message;
        let entry = Entry { level: *level, text, fields: &[] };
        // Nobody reads any more: the gripper is published all the same.
        let _printed = self.log.report(self.clock.now(), &entry, &mut io::stderr().lock());
    }

    /// Logs for the threads of a connection, until it or the program ends; where gripd was then.
    fn follow(&mut self, connection: Connection, stop: &AtomicBool) -> Option<LastReceived> {
        while !stop.load(Ordering::Relaxed) && !connection.is_over() {
            connection.messages().for_each(|message| self.print(&message));
            pause(LOOK);
        }
        let (messages, received) = connection.finish();
        messages.iter().for_each(|message| self.print(message));
        if !stop.load(Ordering::Relaxed) {
            let text = "gripd has closed the connection; waiting for it".to_owned();
            self.print(&(LogLevel::Warn, text));
            pause(RETRY);
        }
        received
    }
}
