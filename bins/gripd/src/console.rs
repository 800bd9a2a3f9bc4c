//! Lines for the person at the keyboard about what happens: events on standard output, the rest on standard error.

use crate::clock::Clock;
use grip_daemon::{
    Item, LinkNote,
    log::{Clocks, Entry, Log, LogLevel, LogStyle},
    port_manager::PortUpdate,
    rows::Back,
};
use grip_link::{
    host::{CloseReason, LinkState},
    message::{Clamped, EventKind, FaultCode},
};
use grip_session::{
    report::{ClockHealth, Condition, Event, statistic_text},
    session::explain,
};
use slip_core::{ClientCommand, PipelineState};
use std::io::{self, IsTerminal as _, Write as _};

/// A sentence and its weight.
type Reported = (LogLevel, String);

/// Samples that were late or missing, where a force is commanded and where none is.
const DEGRADED: &str = "samples were late or missing, so the force was not raised meanwhile; further times are only counted";
const DEGRADED_OBSERVING: &str = "samples were late or missing; further times are only counted";

/// The live line is drawn at most this often (us).
const LIVE_EVERY_US: u64 = 50_000;

/// Commands of clients that are reported one by one in a second.
const MOST_ASKED: u32 = 5;

/// Prints.
#[derive(Debug)]
pub(crate) struct Console {
    log: Log,
    clock: Clock,
    json: bool,
    live: bool,
    status_shown: bool,
    live_us: u64,
    degraded: u64,
    /// Whether a gripper was attached before.
    attached: bool,
    /// The last event of the gripper, so that a thousand equal ones a second are reported once.
    device_event: Option<(EventKind, FaultCode)>,
    /// The last reason why the link closed, for the same end.
    closed: Option<CloseReason>,
    /// The second of the last command of a client (host time), and how many came in it.
    asked: (u64, u32),
    /// The way back to the program whose rows are the sensor.
    rows: Option<Back>,
    /// What is said of samples that were late or missing, once.
    degraded_words: &'static str,
}

impl Console {
    /// Events as JSON or as sentences; a live line where standard error is a terminal.
    pub(crate) fn new(json: bool, level: LogLevel, clock: Clock) -> Self {
        let err = io::stderr();
        Self {
            log: Log::new("gripd", LogStyle::of_stderr(), level),
            clock,
            json,
            live: !json && err.is_terminal(),
            status_shown: false,
            live_us: 0,
            degraded: 0,
            attached: false,
            device_event: None,
            closed: None,
            asked: (0, 0),
            rows: None,
            degraded_words: DEGRADED,
        }
    }

    /// Rows are the sensor: their program gets the events too.
    pub(crate) fn set_rows(&mut self, back: Back) {
        self.rows = Some(back);
    }

    /// Nothing is commanded: the sentences speak of no force.
    pub(crate) fn set_observing(&mut self) {
        self.degraded_words = DEGRADED_OBSERVING;
        self.log(LogLevel::Info, "only observing: no force is commanded");
    }

    /// Prints what is worth it.
    pub(crate) fn take(&mut self, item: &Item<'_>) {
        match item {
            Item::Event { event, .. } => {
                self.event(event);
                if let Event::Health { condition: Condition::Clock(health), .. } = event {
                    self.log(clock_level(*health), clock_words(*health));
                }
            }
            Item::State(state) => self.show(state),
            Item::Link { note, .. } => {
                if let Some((level, text)) = self.sentence(note) {
                    self.log(level, &text);
                }
            }
            Item::Client { host_us, command } => {
                let second = host_us / 1_000_000;
                let count = if self.asked.0 == second { self.asked.1.saturating_add(1) } else { 1 };
                self.asked = (second, count);
                if count <= MOST_ASKED {
                    // What is expected may come from the memory or the configuration, too.
                    let expects = matches!(command, ClientCommand::Expect(_));
                    let from = if expects { "the next grasp" } else { "a client asked" };
                    self.log(LogLevel::Info, &format!("{from}: {command}"));
                } else {
                    self.log(LogLevel::Info, "clients ask more often than is reported one by one");
                }
            }
            _ => {}
        }
    }

    /// How much is reported from now on.
    pub(crate) fn set_level(&mut self, level: LogLevel) {
        self.log.set_level(level);
    }

    fn event(&mut self, line: &Event) {
        self.clear_status();
        if let Some((rows, text)) = self.rows.as_ref().zip(serde_json::to_string(line).ok()) {
            // A program that does not read them misses them.
            let _sent = rows.line(text);
        }
        match write_event(line, self.json) {
            // Nobody reads any more: the object is held and recorded all the same.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                self.log(LogLevel::Error, &format!("events cannot be printed: {error}"));
            }
            _ => {}
        }
    }

    /// A sentence on standard error.
    pub(crate) fn log(&mut self, level: LogLevel, text: &str) {
        self.clear_status();
        let now = self.now();
        let entry = Entry { level, text, fields: &[] };
        ignored(self.log.report(now, &entry, &mut io::stderr().lock()));
    }

    /// Reports how often sentences came that were not repeated.
    pub(crate) fn tick(&mut self) {
        let now = self.now();
        ignored(self.log.tick(now, &mut io::stderr().lock()));
    }

    fn now(&self) -> Clocks {
        Clocks { host_us: self.clock.now_us(), wall_us: self.clock.wall_ns() / 1000 }
    }

    /// What the search for the port reported.
    pub(crate) fn port(&mut self, updates: &PortUpdate) {
        match updates {
            PortUpdate::Waiting(reason) => {
                self.log(LogLevel::Warn, &format!("{reason}; waiting for it"));
            }
            PortUpdate::Opened { device, latency_timer_ms } => {
                if let Some(ms @ 2..) = latency_timer_ms {
                    let text = format!(
                        "the USB adapter gathers bytes for {ms} ms before it hands them over; `gripctl doctor` says how to change that"
                    );
                    self.log(LogLevel::Warn, &text);
                }
                if let Some(device) = device {
                    self.log(LogLevel::Info, &format!("port open: {device}"));
                }
            }
            PortUpdate::Other => self.log(
                LogLevel::Warn,
                "another gripper answered and was left alone; looking for the one that was attached before",
            ),
        }
    }

    /// What a person should know of the link.
    fn sentence(&mut self, note: &LinkNote) -> Option<Reported> {
        use LogLevel::{Info, Warn};
        Some(match *note {
            LinkNote::Identified { rebooted: false, .. } if self.rows.is_some() => {
                (Info, "the first row is there".to_owned())
            }
            // The limits are those of this configuration, and the rate is that of the header. A program is not clocked to the 5 ms after
            // which a board is late: what is missing or stands still is named, and so is what came too late for a command.
            LinkNote::Configured(_) | LinkNote::PortLost | LinkNote::State(LinkState::Degraded)
                if self.rows.is_some() =>
            {
                return None;
            }
            LinkNote::Identified { rebooted: false, .. } => {
                self.closed = None;
                let again = core::mem::replace(&mut self.attached, true);
                (Info, if again { "gripper found again" } else { "gripper found" }.to_owned())
            }
            LinkNote::Identified { rebooted: true, .. } | LinkNote::Rebooted => {
                let text = "the gripper has restarted; the noise floor is learned again";
                (Warn, text.to_owned())
            }
            LinkNote::Configured(clamped) => {
                let names = clamped_names(clamped);
                let text = format!(
                    "the gripper does not allow what the configuration asks for: it limits {names}"
                );
                (!names.is_empty()).then_some((Warn, text))?
            }
            LinkNote::State(LinkState::Degraded) => (Warn, self.degraded()?),
            LinkNote::Device(event) => {
                let event_now = (event.kind, event.fault);
                if self.device_event.replace(event_now) == Some(event_now) {
                    return None;
                }
                (Warn, device_event(event.kind, event.fault))
            }
            LinkNote::Refused(nack) => {
                (Warn, format!("the gripper refused a request: {:?}", nack.reason))
            }
            LinkNote::Closed(reason) => (Warn, self.closed(reason)?),
            LinkNote::Late(late_us) => (
                Warn,
                format!(
                    "readings were {} ms late at a command, so the force was not raised",
                    late_us / 1000
                ),
            ),
            LinkNote::Steady => (Warn, note.text()?),
            LinkNote::PortLost if self.attached => {
                (Warn, "the port is gone; the gripper holds by itself until it is back".to_owned())
            }
            _ => return None,
        })
    }

    fn degraded(&mut self) -> Option<String> {
        self.degraded += 1;
        (self.degraded == 1).then(|| self.degraded_words.to_owned())
    }

    fn closed(&mut self, reason: CloseReason) -> Option<String> {
        let new = reason != CloseReason::Requested && self.closed != Some(reason);
        self.closed = Some(reason);
        new.then(|| explain(&reason))
    }

    /// One line that is written over by the next.
    fn show(&mut self, state: &PipelineState) {
        if !self.live || state.host.0 < self.live_us {
            return;
        }
        self.live_us = state.host.0 + LIVE_EVERY_US;
        let shown =
            |value: Option<f32>| value.map_or_else(|| "-".to_owned(), |n| format!("{n:.2}"));
        let doubt = if state.is_informative() { "" } else { "?" };
        let esc = state.esc.map_or_else(|| "-".to_owned(), |esc| format!("{esc:.3}{doubt}"));
        let (estimate, command) = (shown(state.estimate_n), shown(state.command_n));
        let mut err = io::stderr().lock();
        let shown = write!(
            err,
            "\r\x1b[K{:8} {:6.2} s  {} Hz  slip {:>7}  E_sc {esc} W  estimate {estimate} N  command {command} N  stylus {}  lost {}",
            state.scene.name(),
            state.t.as_seconds(),
            state.rate_hz,
            statistic_text(state.statistic.unwrap_or(0.0)),
            state.sensors[0].name(),
            state.lost,
        );
        self.status_shown = true;
        ignored(shown.and_then(|()| err.flush()));
    }

    /// Takes the live line away.
    pub(crate) fn clear_status(&mut self) {
        if self.status_shown {
            self.status_shown = false;
            let mut err = io::stderr().lock();
            ignored(write!(err, "\r\x1b[K").and_then(|()| err.flush()));
        }
    }
}

/// A standard error that is closed or full is no reason to let go of the object, and there is nobody left to inform.
fn ignored(_: io::Result<()>) {}

fn write_event(line: &Event, json: bool) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, line)?;
        writeln!(out)?;
    } else {
        writeln!(out, "{line}")?;
    }
    out.flush()
}

/// How grave a state of the gripper's clock is.
fn clock_level(health: ClockHealth) -> LogLevel {
    if health == ClockHealth::Good { LogLevel::Info } else { LogLevel::Warn }
}

/// A state of the gripper's clock as a sentence.
fn clock_words(health: ClockHealth) -> &'static str {
    match health {
        ClockHealth::Good => "the clock of the gripper is good again",
        ClockHealth::Stopped => {
            "the clock of the gripper has stopped; its rows are timed by their numbers"
        }
        ClockHealth::Back => "the clock of the gripper went back; time goes on from where it was",
        ClockHealth::Forward => {
            "the clock of the gripper jumped forward; time goes on from where it was"
        }
        ClockHealth::Fast => {
            "the clock of the gripper runs more than 1 % fast; of rows, more come than rate= says"
        }
        ClockHealth::Slow => {
            "the clock of the gripper runs more than 1 % slow; of rows, fewer come than rate= says"
        }
    }
}

/// What the gripper reports of itself, as a sentence.
fn device_event(kind: EventKind, fault: FaultCode) -> String {
    let why = fault_words(fault).map_or_else(String::new, |words| format!(", {words}"));
    let what = match kind {
        EventKind::Fault => "the gripper has stopped with fault",
        EventKind::FaultCleared => "the gripper is free of fault",
        EventKind::CommandRejected => "the gripper takes no command because of fault",
        _ => "the gripper reports something, with fault",
    };
    format!("{what} {:04X}{why}", fault.0)
}

/// What a fault means, as far as the specification states it.
fn fault_words(fault: FaultCode) -> Option<&'static str> {
    Some(match fault {
        FaultCode::ESTOP => "a stop was commanded",
        FaultCode::SENSOR_DEAD => "the last slip sensor delivers nothing",
        FaultCode::SENSOR_FROZEN => "the last slip sensor delivers the same value for too long",
        FaultCode::SENSOR_SATURATED => "the last slip sensor is at the end of its range",
        FaultCode::TASK_HUNG => "a task of its firmware did not run",
        FaultCode::OBJECT_LOST => "the object is gone",
        FaultCode::POSITION_UNDEFINED => "the finger position is not known",
        FaultCode::OVER_TEMPERATURE => "motor or driver is too hot",
        FaultCode::OVER_CURRENT => "the motor current is too high",
        FaultCode::DRIVE => "the motor driver reports a fault",
        FaultCode::SUPPLY => "the supply voltage is out of range",
        _ => return None,
    })
}

/// The limits a gripper changed, the mask of channels left out: all there are is what was asked for.
fn clamped_names(clamped: Clamped) -> String {
    const NAMES: [&str; 8] = [
        "sample rate",
        "batch",
        "",
        "largest force",
        "slew rate",
        "ttl",
        "hold cap",
        "time to the loss action",
    ];
    let named = NAMES
        .iter()
        .enumerate()
        .filter(|(bit, name)| clamped.0 >> bit & 1 == 1 && !name.is_empty());
    named.map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}
