//! Plan of a table, from its header and first rows: what its columns are and where its times come from.

use std::io::Read;
use std::path::Path;

use grip_table::{Column, Header, Table, TableError};
use slip_core::sample::FURTHER_AXES;

use crate::clock;
use crate::csv_read::CsvOptions;
use crate::error::CsvError;
use crate::find::{self, Found, Signal};
use crate::pace::Pace;
use crate::time::{self, TimeUnit};
use crate::tsf85;

/// Rows that are looked at, which is as many as show how evenly stamps come.
const ROWS: usize = 1 << 16;

/// What stands behind the name of a column of text.
pub(crate) const TEXT: &str = " (text)";

/// What is known of a table before its first sample.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// Its columns, with a remark where one is text; empty where one has no name and is not used.
    pub(crate) names: Vec<String>,
    /// What each is in a recording; empty where it is not used.
    pub(crate) ours: Vec<String>,
    pub(crate) found: Found,
    pub(crate) format: &'static str,
    /// Where the times come from, for people; empty where there are none.
    pub(crate) clock: String,
    pub(crate) unit: Option<TimeUnit>,
    pub(crate) pace: Option<Pace>,
    /// Rows of which the times were looked at.
    pub(crate) timed: usize,
    /// Rows at the start that are none.
    pub(crate) skip: usize,
}

/// The columns of a file, before anything is known of them.
#[derive(Clone, Debug)]
pub(crate) struct Head {
    pub(crate) signals: Vec<Signal>,
    /// Whether their names mean something: not those of arrays (`,0,1`), and not those of columns without.
    pub(crate) named: bool,
    /// Columns without a name of their own.
    pub(crate) nameless: Vec<usize>,
}

impl Head {
    fn of<R: Read>(table: &Table<R>) -> Self {
        let columns = table.columns();
        let signal = |column: &Column| Signal {
            name: column.name.clone(),
            unit: column.unit.clone(),
            known: None,
            is_text: column.is_text,
        };
        let nameless = columns.iter().enumerate().filter(|(_, column)| column.given.is_empty());
        Self {
            signals: columns.iter().map(signal).collect(),
            named: matches!(table.header_line(), Header::Line(_)),
            nameless: nameless.map(|(at, _)| at).collect(),
        }
    }

    fn names(&self) -> Vec<String> {
        self.signals.iter().map(|signal| signal.name.clone()).collect()
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|signal| signal.name == name)
    }

    /// The column of times: named by the caller, or by itself, or the first of several without names.
    fn time(&self, file: &Path, options: &CsvOptions) -> Result<Option<usize>, CsvError> {
        if let Some((ours, theirs)) = options.map.iter().find(|(ours, _)| ours == "t_s") {
            let (file, ours, theirs) = (file.to_owned(), ours.clone(), theirs.clone());
            return match self.place(&theirs) {
                None => Err(CsvError::MapColumnAbsent { file, ours, theirs, found: self.names() }),
                Some(at) if self.signals.get(at).is_some_and(|signal| signal.is_text) => {
                    Err(CsvError::Text { file, column: theirs, wanted: ours })
                }
                at => Ok(at),
            };
        }
        let mapped = |name: &str| options.map.iter().any(|(_, theirs)| theirs == name);
        let free = |signal: &Signal| !signal.is_text && !mapped(&signal.name);
        let own = |signal: &Signal| free(signal) && signal.name == "t_s";
        let is_time =
            |signal: &Signal| free(signal) && time::is_time(&signal.name, signal.unit.as_deref());
        let named = self.signals.iter().position(own);
        if let Some(named) = named.or_else(|| self.signals.iter().position(is_time)) {
            return Ok(Some(named));
        }
        let is_first = self.signals.first().filter(|first| free(first)).is_some_and(|first| {
            let nameless = !self.named || self.nameless.contains(&0);
            // A name in another language, but a unit that everybody knows.
            let unit = first.unit.as_deref().filter(|unit| !first.name.ends_with(unit));
            (nameless && self.signals.len() > 1) || unit.and_then(TimeUnit::of_unit).is_some()
        });
        Ok(is_first.then_some(0))
    }
}

impl Plan {
    /// Of a table, of which the first rows are read.
    pub(crate) fn of<R: Read>(
        file: &Path,
        mut table: Table<R>,
        options: &CsvOptions,
    ) -> Result<Self, CsvError> {
        let head = Head::of(&table);
        let columns = table.columns().to_vec();
        let (mut times, mut blank) = (Vec::new(), vec![0; columns.len()]);
        let plan = Self::find(file, &head, options, |column| {
            // A fault is reported where the rows are read for good, with all that is known then.
            while times.len() < ROWS
                && let Ok(Some(row)) = table.next_row()
            {
                times.push(row.value(column).ok().flatten().unwrap_or(f64::NAN));
                for (at, blank) in blank.iter_mut().enumerate().filter(|_| !head.named) {
                    *blank += usize::from(row.cell(at).is_empty());
                }
            }
            let few = |(at, blank): (usize, &usize)| (2 * blank > times.len()).then_some(at);
            let sparse = blank.iter().enumerate().filter_map(few).collect();
            (times, sparse)
        })?;
        table.check_repeated(|name| {
            let mut used = columns.iter().zip(&plan.ours).filter(|(_, ours)| !ours.is_empty());
            used.any(|(column, _)| column.given == name)
        })?;
        Ok(plan)
    }

    /// Of a file with these columns; `look` gives the first numbers of one, and the columns that are mostly blank where none has a
    /// name.
    pub(crate) fn find(
        file: &Path,
        head: &Head,
        options: &CsvOptions,
        look: impl FnOnce(usize) -> (Vec<f64>, Vec<usize>),
    ) -> Result<Self, CsvError> {
        let names = head.names();
        let finger = tsf85::Layout::of(&names, options.finger);
        let finger = finger.map_err(|fault| CsvError::Finger { file: file.to_owned(), fault })?;
        let mut plan = Self {
            ours: vec![String::new(); names.len()],
            format: if finger.is_some() { "Robotiq TSF-85" } else { "CSV" },
            skip: usize::from(finger.is_some()),
            names,
            ..Self::default()
        };
        let time = head.time(file, options)?;
        let mut sparse = Vec::new();
        let time = match time {
            Some(at) => {
                let times;
                (times, sparse) = look(at);
                let rows = times.get(plan.skip..).unwrap_or_default();
                plan.time(file, head, at, rows, options)?
            }
            None => None,
        };
        let mut signals = head.signals.clone();
        if let Some(time) = time.and_then(|time| signals.get_mut(time)) {
            // Nothing else is found in it.
            time.is_text = true;
        }
        if !head.named {
            name_axes(&mut signals, &sparse);
            let name = |at: &usize| Some(&signals.get(*at)?.name);
            plan.found.notes.extend(sparse.iter().filter_map(name).map(|name| {
                format!("{name} is mostly blank and no axis; --map OURS={name} says what it is")
            }));
        }
        if let Some(finger) = &finger {
            plan.found.notes.extend(finger.apply(&mut signals));
        }
        let found = find::find(file, &signals, &options.map)?;
        plan.found.notes.extend(found.notes);
        plan.found.uses = found.uses;
        for used in &plan.found.uses {
            if let Some(ours) = plan.ours.get_mut(used.at) {
                ours.clone_from(&used.ours);
            }
        }
        for (at, name) in plan.names.iter_mut().enumerate() {
            if head.signals.get(at).is_some_and(|signal| signal.is_text) {
                name.push_str(TEXT);
            } else if head.named
                && head.nameless.contains(&at)
                && plan.ours.get(at).is_some_and(String::is_empty)
            {
                name.clear();
            }
        }
        Ok(plan)
    }

    /// Finds unit and pace of the column of times; the column that is none of the signals.
    fn time(
        &mut self,
        file: &Path,
        head: &Head,
        at: usize,
        times: &[f64],
        options: &CsvOptions,
    ) -> Result<Option<usize>, CsvError> {
        let Some(Signal { name, unit, .. }) = head.signals.get(at) else { return Ok(None) };
        let stated = match (options.time_unit, unit) {
            (Some(unit), _) => Some(unit),
            (None, _) if name == "t_s" => Some(TimeUnit::Seconds),
            (None, Some(unit)) => match TimeUnit::of_unit(unit) {
                None if !name.ends_with(unit.as_str()) => {
                    return Err(CsvError::Table(TableError::Unit {
                        file: file.to_owned(),
                        column: name.clone(),
                        unit: unit.clone(),
                        wanted: "time (s, ms, us, ns)",
                    }));
                }
                stated => stated,
            },
            (None, None) => TimeUnit::of_word(name),
        };
        self.timed = times.len();
        let stamps = clock::stamps(name, times, stated);
        let rate_hz = options.rate_hz.filter(|rate_hz| *rate_hz > 0.0);
        match (stamps, stated) {
            (Ok((unit, stamps)), _) => {
                self.pace = match (Pace::of(&stamps), rate_hz) {
                    (Some(pace), Some(rate_hz)) => Some(pace.with_rate(rate_hz)),
                    (None, Some(rate_hz)) if stamps.len() > 1 => Some(Pace::at_rate(rate_hz)),
                    (pace, _) => pace,
                };
                if let (Some(pace), None, None) = (&self.pace, rate_hz, options.time_unit) {
                    self.found.notes.extend(unit.doubt(name, pace.period_ns));
                }
                self.unit = Some(unit);
            }
            // With a rate, and for want of another meaning: rows are counted, or never in order.
            (Err(_), None) if rate_hz.is_some() => {
                return Ok(Some(at).filter(|_| times.is_sorted()));
            }
            (Err(_), None) if !head.named && !times.is_sorted() => return Ok(None),
            (Err(fault), None) => {
                let found = self.names.clone();
                return Err(CsvError::Times { file: file.to_owned(), fault, found });
            }
            // Which row it is, is reported with its line.
            (Err(_), Some(unit)) => self.unit = Some(unit),
        }
        self.clock =
            self.unit.map_or_else(String::new, |unit| format!("{name:?} ({})", unit.name()));
        if let Some(ours) = self.ours.get_mut(at) {
            "t_s".clone_into(ours);
        }
        Ok(Some(at))
    }
}

/// Where no signal has a name of its own, up to three are the axes of a vibration.
pub(crate) fn name_axes(signals: &mut [Signal], sparse: &[usize]) {
    let signals = signals.iter_mut().enumerate();
    let free = signals.filter(|(at, signal)| !signal.is_text && !sparse.contains(at));
    let mut signals: Vec<&mut Signal> = free.map(|(_, signal)| signal).collect();
    match signals.as_mut_slice() {
        [one] => one.known = Some("vibration".to_owned()),
        few if few.len() <= 1 + FURTHER_AXES => {
            for (k, signal) in few.iter_mut().enumerate() {
                signal.known = Some(format!("vibration_{}", k + 1));
            }
        }
        _ => {}
    }
}
