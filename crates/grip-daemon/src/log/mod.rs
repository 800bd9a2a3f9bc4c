//! Log of sentences with their level, as lines for a terminal, a file or the journal. A sentence that comes again and again is reported
//! once, then counted.
//!
//! `tracing` was weighed: a service thread that states something now and then needs no spans, and its subscriber costs more code
//! than all of this module (docs/results.md).

#[cfg(test)]
mod tests;

use core::fmt::{Display, Write as _};
pub use grip_session::config::LogLevel;
use grip_session::{exit::lines, utc};
use std::io::{self, IsTerminal as _, Write};

/// A sentence is reported again after this time (us), with the number of times it came meanwhile.
const QUIET_US: u64 = 10_000_000;
/// Different sentences that are remembered.
const REMEMBERED: usize = 64;

/// What standard error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogStyle {
    /// A person looks: `gripd: sentence`, with the name of the program.
    Terminal,
    /// The journal of systemd, which knows the time: `<6>sentence key=value`.
    Journal,
    /// A file or a pipe: `time=... level=info msg="sentence" key=value`.
    Plain,
}

impl LogStyle {
    /// What the standard error of this program is.
    #[must_use]
    pub fn of_stderr() -> Self {
        let stderr = io::stderr();
        let journal = std::env::var("JOURNAL_STREAM").ok();
        // Closed, or not to be asked: then it is no journal. Only Linux has one.
        #[cfg(target_os = "linux")]
        let file = rustix::fs::fstat(&stderr).ok().map(|stat| (stat.st_dev, stat.st_ino));
        #[cfg(not(target_os = "linux"))]
        let file = None;
        Self::of(stderr.is_terminal(), journal.as_deref(), file)
    }

    /// What a standard error is: whether it is a terminal, what `JOURNAL_STREAM` states, and its device and inode.
    #[must_use]
    pub fn of(terminal: bool, journal: Option<&str>, stderr: Option<(u64, u64)>) -> Self {
        let named = journal.and_then(|text| {
            let (device, inode) = text.split_once(':')?;
            Some((device.parse::<u64>().ok()?, inode.parse::<u64>().ok()?))
        });
        match (terminal, named.is_some() && named == stderr) {
            (_, true) => Self::Journal,
            (true, _) => Self::Terminal,
            _ => Self::Plain,
        }
    }
}

/// Something to report.
#[derive(Clone, Copy)]
pub struct Entry<'a> {
    /// Its weight.
    pub level: LogLevel,
    /// A whole sentence; a person at a terminal sees nothing else.
    pub text: &'a str,
    /// Names and values for machines.
    pub fields: &'a [(&'a str, &'a dyn Display)],
}

impl core::fmt::Debug for Entry<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Entry").field("level", &self.level).field("text", &self.text).finish()
    }
}

/// The two clocks (us): host time and wall clock since 1970. Only the first one decides anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// Host time (us).
    pub host_us: u64,
    /// Wall clock (us since 1970).
    pub wall_us: u64,
}

/// A sentence that was reported.
#[derive(Clone, Debug)]
struct Reported {
    level: LogLevel,
    text: String,
    at_us: u64,
    since: u64,
}

/// Writes lines and remembers what it reported.
#[derive(Clone, Debug)]
pub struct Log {
    program: &'static str,
    style: LogStyle,
    level: LogLevel,
    reported: Vec<Reported>,
}

impl Log {
    /// Reports entries of `level` and heavier ones of the program of that name.
    #[must_use]
    pub fn new(program: &'static str, style: LogStyle, level: LogLevel) -> Self {
        Self { program, style, level, reported: Vec::with_capacity(REMEMBERED) }
    }

    /// From now on reports entries of `level` and heavier ones.
    pub fn set_level(&mut self, level: LogLevel) {
        self.level = level;
    }

    /// Reports an entry, unless it is too light or was reported within the last 10 s.
    ///
    /// # Errors
    /// What `out` states.
    pub fn report(
        &mut self,
        now: Clocks,
        entry: &Entry<'_>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        if entry.level > self.level {
            return Ok(());
        }
        self.tick(now, out)?;
        let same =
            |reported: &&mut Reported| reported.level == entry.level && reported.text == entry.text;
        if let Some(reported) = self.reported.iter_mut().find(same) {
            reported.since += 1;
            return Ok(());
        }
        if self.reported.len() == REMEMBERED {
            let oldest = self.reported.remove(0);
            self.count(now, &oldest, out)?;
        }
        let (level, text) = (entry.level, entry.text.to_owned());
        self.reported.push(Reported { level, text, at_us: now.host_us, since: 0 });
        self.line(now, entry, out)
    }

    /// Reports how often sentences came again whose 10 s are over; to be called now and then.
    ///
    /// # Errors
    /// What `out` states.
    pub fn tick(&mut self, now: Clocks, out: &mut dyn Write) -> io::Result<()> {
        while self
            .reported
            .first()
            .is_some_and(|reported| now.host_us.saturating_sub(reported.at_us) >= QUIET_US)
        {
            let reported = self.reported.remove(0);
            self.count(now, &reported, out)?;
            if reported.since > 0 {
                // It goes on: the next ones are counted too, until 10 s pass without one.
                self.reported.push(Reported { at_us: now.host_us, since: 0, ..reported });
            }
        }
        Ok(())
    }

    /// Reports what was only counted so far: for the end.
    ///
    /// # Errors
    /// What `out` states.
    pub fn finish(&mut self, now: Clocks, out: &mut dyn Write) -> io::Result<()> {
        let reported = core::mem::take(&mut self.reported);
        reported.iter().try_for_each(|reported| self.count(now, reported, out))
    }

    fn count(&self, now: Clocks, reported: &Reported, out: &mut dyn Write) -> io::Result<()> {
        if reported.since == 0 {
            return Ok(());
        }
        let times = reported.since;
        let text = format!("{} (and {times} times more)", reported.text);
        let fields: [(&str, &dyn Display); 1] = [("repeated", &times)];
        self.line(now, &Entry { level: reported.level, text: &text, fields: &fields }, out)
    }

    fn line(&self, now: Clocks, entry: &Entry<'_>, out: &mut dyn Write) -> io::Result<()> {
        let Entry { level, text, fields } = *entry;
        match self.style {
            LogStyle::Terminal => writeln!(out, "{}: {}", self.program, lines(text)),
            LogStyle::Journal => {
                let priority = priority(level);
                // Every line of the journal needs its own prefix.
                let text = lines(text).replace('\n', &format!("\n<{priority}>"));
                writeln!(out, "<{priority}>{text}{}", logfmt(fields))
            }
            LogStyle::Plain => {
                let (time, level) = (utc::line(now.wall_us), level.name());
                let (text, fields) = (value(text), logfmt(fields));
                writeln!(out, "time={time} level={level} msg={text}{fields}")
            }
        }
    }
}

/// The number that syslog and the journal use.
fn priority(level: LogLevel) -> u8 {
    match level {
        LogLevel::Error => 3,
        LogLevel::Warn => 4,
        LogLevel::Info => 6,
        LogLevel::Debug => 7,
    }
}

/// ` key=value` for each field.
fn logfmt(fields: &[(&str, &dyn Display)]) -> String {
    let fields =
        fields.iter().map(|(name, shown)| format!(" {name}={}", value(&shown.to_string())));
    fields.collect()
}

/// A value as it is, or quoted where it would not be one word.
fn value(text: &str) -> String {
    let plain = |c: char| c.is_ascii_graphic() && !matches!(c, '"' | '=' | '\\');
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    let mut quoted = "\"".to_owned();
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            c if c.is_control() => {
                // A string takes everything.
                let _: core::fmt::Result = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
