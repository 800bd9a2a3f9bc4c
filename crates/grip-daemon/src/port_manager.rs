//! The thread that finds ports, because that may take its time: open lines to a gripper, one after the other, from where it may be.

use crate::hot::{Lost, Shared};
use core::{sync::atomic::Ordering, time::Duration};
use grip_port::{Backoff, Line, PortError, Source, UsbFilter};
use grip_session::exit::message;
use rtrb::{Consumer, Producer};
use rustix::event::{Timespec, poll};
use std::sync::{
    Arc,
    mpsc::{Receiver, RecvTimeoutError, Sender},
};

/// The thread looks this often whether it is to end, or a line was lost.
const LOOK_EVERY: Duration = Duration::from_millis(25);

/// What the configuration states of `auto`, for the search.
#[must_use]
pub fn usb_filter(config: &grip_session::config::UsbFilter) -> UsbFilter {
    let grip_session::config::UsbFilter { vid, pid, serial, product } = config.clone();
    UsbFilter { vid, pid, serial, product }
}

/// What a person may want to know of the search.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortUpdate {
    /// There is no line, and why; reported once for each reason.
    Waiting(String),
    /// A line is open. FTDI adapters gather bytes for so long (ms) before they hand them over; `None` for others.
    Opened {
        /// What is known of the device, where it is a USB device.
        device: Option<String>,
        /// Time (ms) for which the adapter gathers bytes.
        latency_timer_ms: Option<u16>,
    },
    /// The gripper that answered is another one.
    Other,
}

/// The ends that lead to the hot loop and to the service thread.
#[derive(Debug)]
pub struct PortManagerEnds {
    /// Open lines to the loop.
    pub lines: Producer<Line>,
    /// Lines it has lost.
    pub lost: Consumer<Lost>,
    /// Updates for people.
    pub updates: Sender<PortUpdate>,
    /// What is shared with the loop.
    pub shared: Arc<Shared>,
}

/// Where lines come from.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one of it")]
pub enum Lines {
    /// A port that is looked for, and looked for again.
    Port(Source),
    /// A thread of this program; where it sends none any more, that is the end.
    Made(Receiver<Line>),
}

/// Finds, opens and replaces lines.
#[derive(Debug)]
pub struct PortManager {
    lines: Lines,
    patient: bool,
    ends: PortManagerEnds,
    backoff: Backoff,
    attached: bool,
    /// The last reason that was reported.
    reported: Option<String>,
}

impl PortManager {
    /// Gives the lines on. Where it is not `patient`, the first line of a port must be had at once.
    #[must_use]
    pub fn new(lines: Lines, patient: bool, ends: PortManagerEnds) -> Self {
        Self { lines, patient, ends, backoff: Backoff::default(), attached: false, reported: None }
    }

    /// Runs until it is asked to stop.
    ///
    /// # Errors
    /// Where the first line cannot be had and nobody wants to wait, or the choice of the port is a mistake; the loop is then asked to stop.
    pub fn run(mut self) -> Result<(), PortError> {
        while !self.stops() {
            let line = match &mut self.lines {
                Lines::Port(source) => source.line(),
                Lines::Made(made) => match made.recv_timeout(LOOK_EVERY) {
                    Ok(line) => Ok(line),
                    Err(RecvTimeoutError::Timeout) => continue,
                    Err(RecvTimeoutError::Disconnected) => {
                        self.ends.shared.stop.store(true, Ordering::Relaxed);
                        return Ok(());
                    }
                },
            };
            match line {
                Ok(line) => self.hand_over(line),
                Err(error) if self.waits_after(&error) => {
                    self.report_once(message(&error));
                    let pause = self.backoff.pause();
                    wait(&self.ends.shared, pause);
                }
                Err(error) => {
                    self.ends.shared.stop.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    fn stops(&self) -> bool {
        self.ends.shared.stop.load(Ordering::Relaxed)
    }

    fn waits_after(&self, error: &PortError) -> bool {
        self.attached || (self.patient && error.is_temporary())
    }

    /// Hands a line over and waits until it comes back.
    fn hand_over(&mut self, line: Line) {
        self.reported = None;
        let device = match &self.lines {
            Lines::Port(source) => source.finder().chosen().map(grip_port::describe_usb),
            Lines::Made(_) => None,
        };
        self.report(PortUpdate::Opened { device, latency_timer_ms: line.latency_timer_ms() });
        if self.ends.lines.push(line).is_err() {
            return;
        }
        while !self.stops() {
            if let Ok(Lost { line, attached, other }) = self.ends.lost.pop() {
                drop(line);
                self.attached |= attached;
                if other {
                    self.report(PortUpdate::Other);
                } else if attached {
                    self.backoff.reset();
                }
                let pause = self.backoff.pause();
                wait(&self.ends.shared, pause);
                return;
            }
            wait(&self.ends.shared, LOOK_EVERY);
        }
    }

    fn report_once(&mut self, reason: String) {
        if self.reported.as_ref() != Some(&reason) {
            self.report(PortUpdate::Waiting(reason.clone()));
            self.reported = Some(reason);
        }
    }

    fn report(&self, updates: PortUpdate) {
        // Nobody listens any more: the program ends.
        let _reported = self.ends.updates.send(updates);
    }
}

/// Waits for `time`, but not beyond the end of the program.
pub(crate) fn wait(shared: &Shared, time: Duration) {
    let mut left = time;
    while !left.is_zero() && !shared.stop.load(Ordering::Relaxed) {
        let slice = left.min(LOOK_EVERY);
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(slice.subsec_nanos()) };
        let _ended = poll(&mut [], Some(&timeout));
        left -= slice;
    }
}
