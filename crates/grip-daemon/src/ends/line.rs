//! An end and its port in; the end served over a line that is opened again whenever it is lost.

use super::{EndContext, EndFault};
use crate::{hot::Shared, port_manager::wait};
use core::{sync::atomic::Ordering, time::Duration};
use grip_port::{Backoff, Line, Source};
use std::sync::Arc;

/// Longest wait for bytes: an order waits no longer.
const WAIT: Duration = Duration::from_millis(1);
/// An end that was not ready after this time (us) is not there.
const PATIENCE_US: u64 = 3_000_000;
/// Bytes read at once.
const INPUT: usize = 4096;

/// How an end is, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Condition {
    /// It works.
    Ready,
    /// It does not, and why.
    Waiting(String),
    /// It is on its way, whatever time that takes.
    Busy(&'static str),
}

/// The protocol of an end, sans-IO.
pub(super) trait End: Send {
    /// The line was opened (anew).
    fn opened(&mut self, now_us: u64);
    /// The line is gone.
    fn closed(&mut self, now_us: u64);
    /// Takes bytes.
    fn receive(&mut self, now_us: u64, bytes: &[u8]);
    /// The next bytes that are due; `false` where there are none.
    fn poll_transmit(&mut self, now_us: u64, out: &mut Vec<u8>) -> bool;
    /// How it is.
    fn condition(&self, now_us: u64) -> Condition;

    /// What is odd about a line that works; each note is reported once.
    fn note(&self) -> Option<&'static str> {
        None
    }

    /// Whether the line is to be opened again.
    fn is_lost(&self) -> bool;
}

/// The loop of an end.
#[derive(Debug)]
pub(super) struct LineLoop<E, C> {
    name: String,
    source: Source,
    end: E,
    context: EndContext<C>,
    backoff: Backoff,
    was_ready: bool,
    /// The last condition that was reported.
    reported: Option<Condition>,
    noted: Option<&'static str>,
    begun_us: u64,
}

impl<E: End, C: Fn() -> u64> LineLoop<E, C> {
    pub(super) fn new(name: String, source: Source, end: E, context: EndContext<C>) -> Self {
        let begun_us = (context.clock)();
        Self {
            name,
            source,
            end,
            context,
            backoff: Backoff::default(),
            was_ready: false,
            reported: None,
            noted: None,
            begun_us,
        }
    }

    pub(super) fn shared(&self) -> Arc<Shared> {
        Arc::clone(&self.context.shared)
    }

    fn stops(&self) -> bool {
        self.context.shared.stop.load(Ordering::Relaxed)
    }

    /// Runs until the program ends.
    ///
    /// # Errors
    /// Where the end is not there at the start and nobody waits for it.
    pub(super) fn run(&mut self) -> Result<(), EndFault> {
        while !self.stops() {
            match self.source.line() {
                Ok(line) => self.serve(line)?,
                Err(source)
                    if self.was_ready || (self.context.patient && source.is_temporary()) =>
                {
                    self.report(Condition::Waiting(source.to_string()));
                }
                Err(source) => return Err(EndFault::Port { end: self.name.clone(), source }),
            }
            let pause = self.backoff.pause();
            wait(&self.context.shared, pause);
        }
        Ok(())
    }

    /// Serves a line until it is lost.
    fn serve(&mut self, mut line: Line) -> Result<(), EndFault> {
        let (mut input, mut out) = ([0; INPUT], Vec::with_capacity(INPUT));
        self.end.opened((self.context.clock)());
        let error = loop {
            if self.stops() {
                return Ok(());
            }
            let now_us = (self.context.clock)();
            let mut written = Ok(());
            while written.is_ok() && self.end.poll_transmit(now_us, &mut out) {
                written = line.write_frame(&out).map(drop);
            }
            let read = written.and_then(|()| line.read(&mut input, WAIT));
            match read {
                Ok(0) => {}
                Ok(count) => {
                    let now_us = (self.context.clock)();
                    self.end.receive(now_us, input.get(..count).unwrap_or(&[]));
                }
                Err(error) => break Some(error),
            }
            self.judge()?;
            if self.end.is_lost() {
                break None;
            }
        };
        self.end.closed((self.context.clock)());
        let reason = error.map_or_else(|| "no answer".to_owned(), |error| error.to_string());
        self.report(Condition::Waiting(reason));
        Ok(())
    }

    /// Reports what has changed. At the start only a patient program waits.
    fn judge(&mut self) -> Result<(), EndFault> {
        let now_us = (self.context.clock)();
        let condition = self.end.condition(now_us);
        match &condition {
            Condition::Ready => {
                self.backoff.reset();
                self.report(condition);
                self.was_ready = true;
            }
            Condition::Busy(_) => {
                self.begun_us = now_us;
                self.report(condition);
            }
            Condition::Waiting(text) if !self.was_ready => {
                if now_us.saturating_sub(self.begun_us) > PATIENCE_US {
                    if !self.context.patient {
                        let (end, text) = (self.name.clone(), text.clone());
                        return Err(EndFault::Device { end, text });
                    }
                    self.report(condition);
                }
            }
            Condition::Waiting(_) => self.report(condition),
        }
        let note = self.end.note().filter(|note| self.noted != Some(note));
        if let Some(text) = note {
            self.noted = note;
            let _sent = self.context.reports.send(format!("{}: {text}", self.name));
        }
        Ok(())
    }

    fn report(&mut self, condition: Condition) {
        if self.reported.as_ref() == Some(&condition) {
            return;
        }
        let name = &self.name;
        let text = match &condition {
            Condition::Ready if self.was_ready => format!("{name}: found again"),
            Condition::Ready => format!("{name}: found"),
            Condition::Waiting(text) => format!("{name}: {text}"),
            Condition::Busy(text) => format!("{name}: {text}"),
        };
        // Nobody listens any more where the program ends.
        let _sent = self.context.reports.send(text);
        self.reported = Some(condition);
    }
}
