//! Filter of log records of the server's library: what people should know of them.

use log::{LevelFilter, Log, Metadata, Record};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Complaints that wait; more are as good as these.
const ROOM: usize = 64;
/// The part of the library that states when it drops messages for an app, at most every 30 s and in no other way.
const DROPS: &str = "foxglove::websocket::connected_client::send_lossy";

/// Something that the library states.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Complaint {
    /// Messages were dropped for an app.
    TooSlow,
    /// Anything else that is wrong.
    Other(String),
}

/// Everything that is said.
pub(super) struct Complaints(Receiver<Complaint>);

impl Complaints {
    /// Receives what the library states from now on; once in a program.
    pub(super) fn listen() -> Result<Self, log::SetLoggerError> {
        let (stated, receive) = sync_channel(ROOM);
        log::set_boxed_logger(Box::new(Ear(stated)))?;
        log::set_max_level(LevelFilter::Info);
        Ok(Self(receive))
    }

    /// The next one, where there is one.
    pub(super) fn next(&mut self) -> Option<Complaint> {
        self.0.try_recv().ok()
    }
}

struct Ear(SyncSender<Complaint>);

impl Log for Ear {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target() == DROPS || metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let complaint = match record.target() {
                DROPS => Complaint::TooSlow,
                _ => Complaint::Other(record.args().to_string()),
            };
            // Without room there are enough already.
            let _full = self.0.try_send(complaint);
        }
    }

    fn flush(&self) {}
}
