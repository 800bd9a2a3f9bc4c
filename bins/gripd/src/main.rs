//! The daemon that feels an object slip and holds it with just enough force.

mod cli;
mod clock;
mod hot;
mod notes;
mod service;
mod settings;
mod summary;

use anyhow::Context as _;
use clap::Parser as _;
use cli::Cli;
use clock::Clock;
use core::sync::atomic::AtomicBool;
use grip_host::{
    Session, SessionOptions,
    exit::{self, Exit},
};
use grip_port::Source;
use hot::Hot;
use service::Service;
use settings::Settings;
use std::{io, process::ExitCode, sync::Arc, thread};
use summary::Summary;

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(exit) => exit.into(),
        Err(error) => {
            eprintln!("gripd: {}", exit::message(error.as_ref()));
            Exit::of(error.as_ref()).into()
        }
    }
}

fn run(cli: &Cli) -> anyhow::Result<Exit> {
    let settings = Settings::new(cli)?;
    if cli.check_config {
        eprintln!("{}", settings.origin()?);
        return Ok(Exit::Done);
    }
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .context("cannot take over Ctrl-C")?;
    }
    let options = SessionOptions {
        dry_run: cli.dry_run,
        no_skip: cli.no_skip,
        uid: settings.config.uid.map(|uid| uid.0),
    };
    let session = Session::new(settings.config.clone(), settings.estimator()?, options)?;
    let clock = Clock::start();
    let mut source = Source::open(&settings.port_args(), move || clock.now_us())?;
    let line = source.line()?;
    let (notes, inbox) = notes::channel(cli.record.is_some());
    let mut service = Service::new(cli, inbox)?;
    let mut hot = Hot::new(session, clock, notes, cli.duration)?;
    let dropped = service.dropped();
    let printing =
        thread::Builder::new().name("service".to_owned()).spawn(move || service.run())?;
    let ended = hot.run(line, &stop);
    // The service prints what is left and returns once the other end of its rings is gone.
    let report = hot.finish();
    let printed = printing.join().map_err(|_| anyhow::anyhow!("the service thread failed"))?;
    ended?;
    let summary = Summary::new(&report, source.close()?, &dropped);
    match summary.print(cli.json) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        shown => shown?,
    }
    printed?;
    Ok(if summary.lost_data() { Exit::DataLost } else { Exit::Done })
}
