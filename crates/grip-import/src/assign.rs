//! Streams of named numbers in, one recording and what was taken for what out.
//!
//! 1. `--map OURS=NAME` states what a signal is. `NAME` may be a group: `--map vibration=/imu.linear_acceleration` takes its axes,
//!    `--map pressure=/skin.data` its items as taxels.
//! 2. A signal with the name of a recording's column is that column.
//! 3. Words: a vibration (`vib`, `piezo`, `mic`, ...), a normal force, an array of taxels. The three axes of the only acceleration are the
//!    vibration where there is none else, and the motion reference where there is.
//!
//! What could be two things is refused; what is left over is said. Signals of other topics than that of the vibration
//! are put on its times as they were known then: the last reading before, for at most ten of their steps; a frame of
//! taxels and a travel at the first time that is not earlier.

use crate::{
    ImportOptions,
    arrays::ArrayRows,
    error::ImportError,
    stream::{Stream, Times, reading},
    words,
};
use grip_record::{COLUMN_NAMES, Columns, CsvOptions, Recording};
use slip_core::units::Micros;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// A signal that is used, and as what.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// The column of the recording.
    pub ours: String,
    /// The signal of the file.
    pub theirs: String,
    /// Its unit, as far as it is known or had to be taken for granted.
    pub unit: String,
}

/// A recording, and how it came about.
#[derive(Debug)]
pub struct Imported {
    /// What kind of file it was.
    pub format: &'static str,
    /// Where the times come from.
    pub clock: String,
    /// What was taken for what.
    pub uses: Vec<Use>,
    /// Signals that are not used.
    pub unused: Vec<String>,
    /// What else is to be known.
    pub notes: Vec<String>,
    /// The recording; without its samples, where [`Imported::rows`] gives them.
    pub recording: Recording,
    /// Its samples, as the file is read.
    pub rows: Option<ArrayRows>,
}

/// A signal: number of its stream, and place in it.
pub(crate) type At = (usize, usize);

struct Assignment<'a> {
    file: &'a Path,
    streams: &'a [Stream],
    /// Column of the recording -> signal and what its numbers are multiplied by.
    taken: Taken,
    used: BTreeSet<At>,
    /// What renamings have named.
    mapped: Vec<String>,
}

/// From here on times count from 1970 and are moved to 0 (s).
const FAR_S: f64 = 1e6;
/// A reading is kept for so many steps of its own stream.
const HELD_STEPS: i64 = 10;

/// A signal that is used: where it is, what its numbers are multiplied by, and its unit.
pub(crate) type Taken = BTreeMap<String, (At, f64, String)>;

/// The channels among the signals of streams.
pub(crate) struct Found {
    pub(crate) taken: Taken,
    pub(crate) uses: Vec<Use>,
    pub(crate) unused: Vec<String>,
    /// The stream that gives the times.
    base: usize,
}

/// Finds the channels by the names of the signals.
pub(crate) fn find(
    file: &Path,
    streams: &[Stream],
    options: &ImportOptions,
) -> Result<Found, ImportError> {
    let mapped = options.map.iter().map(|(ours, _)| ours.clone()).collect();
    let (taken, used) = (BTreeMap::new(), BTreeSet::new());
    let mut found = Assignment { file, streams, taken, used, mapped };
    found.by_map(options)?;
    found.by_name()?;
    found.by_words()?;
    let (base, uses, unused) = (found.base()?, found.uses(), found.unused());
    Ok(Found { taken: found.taken, uses, unused, base })
}

/// Finds the channels and makes the recording.
///
/// # Errors
/// Where no signal can show a slip, several could be the one, or the times make no recording.
pub fn assign(
    file: &Path,
    format: &'static str,
    mut streams: Vec<Stream>,
    options: &ImportOptions,
) -> Result<Imported, ImportError> {
    let Found { taken, uses, unused, base } = find(file, &streams, options)?;
    let mut notes: Vec<String> =
        streams.iter_mut().flat_map(|stream| core::mem::take(&mut stream.notes)).collect();
    sort(&mut streams, &mut notes);
    let clock = streams[base].clock.clone();
    let zero_ns = match &streams[base].times {
        Times::Stamps(times) => zero(times, &mut notes),
        _ => 0,
    };
    let columns = columns(streams, base, &taken, zero_ns);
    let csv = CsvOptions { rate_hz: options.rate_hz, map: Vec::new() };
    let recording = Recording::of_columns(file, &columns, &csv)?;
    Ok(Imported { format, clock, uses, unused, notes, recording, rows: None })
}

impl Assignment<'_> {
    fn signals(&self) -> impl Iterator<Item = (At, &str)> {
        self.streams.iter().enumerate().flat_map(|(s, stream)| {
            stream.names.iter().enumerate().map(move |(c, name)| ((s, c), name.as_str()))
        })
    }

    fn free(&self) -> Vec<(At, String)> {
        let free = self.signals().filter(|(at, _)| !self.used.contains(at));
        free.map(|(at, name)| (at, name.to_owned())).collect()
    }

    fn names(&self) -> Vec<String> {
        self.signals().map(|(_, name)| name.to_owned()).collect()
    }

    /// Takes a signal as `ours`, in the unit that its name or format states.
    fn take(&mut self, ours: &str, at: At, name: &str) {
        let base = match ours {
            "stylus" | "stylus2" | "travel_m" => Some("m"),
            "force_n" | "tangential_n" => Some("N"),
            "velocity_m_s" => Some("m/s"),
            _ => None,
        };
        let given = self.streams[at.0].units[at.1];
        let (scale, unit) = match (base, words::scale(name)) {
            (Some(base), Some((scale, unit))) if unit.ends_with(base) => (scale, unit.to_owned()),
            (Some(base), _) => (1.0, format!("taken as {base}")),
            (None, _) if ours == "travel_mm" => (1.0, "mm".to_owned()),
            (None, _) => (1.0, given.unwrap_or("own unit").to_owned()),
        };
        self.used.insert(at);
        self.taken.insert(ours.to_owned(), (at, scale, unit));
    }

    fn by_map(&mut self, options: &ImportOptions) -> Result<(), ImportError> {
        for (ours, theirs) in options.map.iter().filter(|(ours, _)| ours != "t_s") {
            let all: Vec<(At, String)> =
                self.signals().map(|(at, name)| (at, name.to_owned())).collect();
            if let Some((at, name)) = all.iter().find(|(_, name)| name == theirs) {
                self.take(ours, *at, name);
                continue;
            }
            let members: Vec<_> = all
                .iter()
                .filter_map(|(at, name)| {
                    let rest =
                        name.strip_prefix(theirs.as_str())?.trim_start_matches(['.', '_', '[']);
                    let rest = rest.trim_end_matches(']');
                    let numbered = rest.parse::<usize>().is_ok();
                    let fits = if ours == "pressure" {
                        numbered
                    } else {
                        ["x", "y", "z"].contains(&rest) || numbered
                    };
                    fits.then(|| (*at, name.clone(), format!("{ours}_{rest}")))
                })
                .collect();
            if members.is_empty() {
                return Err(ImportError::NotThere {
                    file: self.file.to_owned(),
                    ours: ours.clone(),
                    theirs: theirs.clone(),
                    found: self.names(),
                });
            }
            for (at, name, ours) in members {
                self.take(&ours, at, &name);
            }
        }
        Ok(())
    }

    /// Signals whose names, or formats, state which column they are.
    fn by_name(&mut self) -> Result<(), ImportError> {
        for (at, name) in self.free() {
            let known = self.streams[at.0].known[at.1].clone();
            let bare = name.rsplit(['.', '/']).next().unwrap_or(&name);
            let Some(ours) = known.or_else(|| is_column(bare).then(|| bare.to_owned())) else {
                continue;
            };
            if ours == "t_s" || self.overruled(&ours) {
                continue;
            }
            if let Some((other, ..)) = self.taken.get(&ours) {
                let found = [*other, at].map(|(s, c)| self.streams[s].names[c].clone());
                return Err(self.ambiguous("a column of its name", "NAME", found.to_vec()));
            }
            self.take(&ours, at, &name);
        }
        Ok(())
    }

    /// Whether a renaming has said what the vibration, or the taxels, are.
    fn overruled(&self, ours: &str) -> bool {
        let family = |name: &str| {
            let pressure = (name == "pressure").then_some("pressure_");
            pressure.or_else(|| {
                ["vibration", "reference", "pressure_"].into_iter().find(|f| name.starts_with(f))
            })
        };
        let wanted = family(ours);
        wanted.is_some() && self.mapped.iter().any(|mapped| family(mapped) == wanted)
    }

    fn ambiguous(&self, what: &'static str, ours: &'static str, found: Vec<String>) -> ImportError {
        ImportError::Ambiguous { file: self.file.to_owned(), what, ours, found }
    }

    fn has(&self, start: &str) -> bool {
        self.taken.keys().any(|ours| ours.starts_with(start))
    }

    fn feels(&self) -> bool {
        self.has("vibration") || self.has("stylus")
    }

    fn by_words(&mut self) -> Result<(), ImportError> {
        if !self.feels() {
            self.take_one(words::is_vibration, "the vibration", "vibration")?;
        }
        if !self.has("force_n") {
            self.take_one(words::is_force, "the normal force", "force_n")?;
        }
        let mut groups: BTreeMap<String, Vec<(char, At, String)>> = BTreeMap::new();
        for (at, name) in self.free() {
            if let Some((group, axis)) = words::acceleration(&name) {
                groups.entry(group).or_default().push((axis, at, name));
            }
        }
        // The other axes of what feels the slip show no motion of the robot.
        let used = self.signals().filter(|(at, _)| self.used.contains(at));
        let same: Vec<_> = used.filter_map(|(_, name)| words::acceleration(name)).collect();
        groups.retain(|group, _| same.iter().all(|(own, _)| own != group));
        let felt = self.feels();
        let (what, vector) = if felt {
            ("the motion reference", "reference")
        } else {
            ("the vibration", "vibration")
        };
        let alone = self.has("pressure_") || self.has("travel");
        match groups.len() {
            1 if !(felt && self.has("reference")) => {
                for (axis, at, name) in groups.into_values().flatten() {
                    self.take(&format!("{vector}_{axis}"), at, &name);
                }
            }
            2.. if !felt && !alone => {
                return Err(self.ambiguous(what, vector, groups.into_keys().collect()));
            }
            _ => {}
        }
        self.taxels_by_words()
    }

    fn take_one(
        &mut self,
        is: fn(&str) -> bool,
        what: &'static str,
        ours: &'static str,
    ) -> Result<(), ImportError> {
        let found: Vec<(At, String)> =
            self.free().into_iter().filter(|(_, name)| is(name)).collect();
        match found.as_slice() {
            [] => Ok(()),
            [(at, name)] => {
                self.take(ours, *at, name);
                Ok(())
            }
            _ => Err(self.ambiguous(what, ours, found.into_iter().map(|(_, name)| name).collect())),
        }
    }

    fn taxels_by_words(&mut self) -> Result<(), ImportError> {
        if self.has("pressure_") {
            return Ok(());
        }
        let mut groups: BTreeMap<String, Vec<(usize, At, String)>> = BTreeMap::new();
        for (at, name) in self.free() {
            if let Some((group, number)) = words::taxel(&name) {
                groups.entry(group).or_default().push((number, at, name));
            }
        }
        groups.retain(|_, taxels| taxels.len() > 1);
        if groups.len() > 1 {
            return Err(self.ambiguous("the taxels", "pressure", groups.into_keys().collect()));
        }
        for mut taxels in groups.into_values() {
            taxels.sort();
            for (k, (_, at, name)) in taxels.into_iter().enumerate() {
                self.take(&format!("pressure_{k}"), at, &name);
            }
        }
        Ok(())
    }

    /// The stream that gives the times.
    fn base(&self) -> Result<usize, ImportError> {
        let of = |start: &str| {
            self.taken
                .iter()
                .find(|(ours, _)| ours.starts_with(start))
                .map(|(_, ((stream, _), ..))| *stream)
        };
        let found = ["vibration", "stylus", "pressure_", "travel"].into_iter().find_map(of);
        found.ok_or_else(|| ImportError::NoSignal {
            file: self.file.to_owned(),
            found: self.names(),
        })
    }

    fn uses(&self) -> Vec<Use> {
        self.taken
            .iter()
            .map(|(ours, ((stream, column), _, unit))| Use {
                ours: ours.clone(),
                theirs: self.streams[*stream].names[*column].clone(),
                unit: unit.clone(),
            })
            .collect()
    }

    fn unused(&self) -> Vec<String> {
        self.free().into_iter().map(|(_, name)| name).collect()
    }
}

/// Whether `name` is that of a column of a recording.
fn is_column(name: &str) -> bool {
    COLUMN_NAMES.contains(&name)
        || grip_record::is_axis(name)
        || name.strip_prefix("pressure_").is_some_and(|k| k.parse::<usize>().is_ok())
}

/// Puts rows that are out of order, as messages of several sources may be, into the order of their times.
fn sort(streams: &mut [Stream], notes: &mut Vec<String>) {
    for stream in streams {
        let Times::Stamps(times) = &mut stream.times else { continue };
        if times.is_sorted() {
            continue;
        }
        let mut order: Vec<usize> = (0..times.len()).collect();
        order.sort_by_key(|row| times.get(*row).copied());
        let late = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
        notes.push(format!(
            "{}: {late} rows came out of order and were sorted by their times",
            stream.topic
        ));
        *times = order.iter().filter_map(|row| times.get(*row).copied()).collect();
        for values in &mut stream.values {
            *values = order.iter().filter_map(|row| values.get(*row).copied()).collect();
        }
    }
}

/// What is taken off the times (ns).
fn zero(times: &[i64], notes: &mut Vec<String>) -> i64 {
    first_time(times.first().copied().unwrap_or(0), notes)
}

/// What is taken off times that begin with `first` (ns).
pub(crate) fn first_time(first: i64, notes: &mut Vec<String>) -> i64 {
    let seconds = first as f64 / 1e9;
    if (0.0..FAR_S).contains(&seconds) {
        return 0;
    }
    notes.push(format!(
        "t = 0 is {}.{:09} s of the file",
        first.div_euclid(1_000_000_000),
        first.rem_euclid(1_000_000_000)
    ));
    first
}

fn columns(mut streams: Vec<Stream>, base: usize, taken: &Taken, zero_ns: i64) -> Columns {
    let stamps = |stream: &Stream| match &stream.times {
        Times::Stamps(times) => times.clone(),
        _ => Vec::new(),
    };
    let times = stamps(&streams[base]);
    let mut columns = Columns::default();
    for (ours, (at, scale, _)) in taken {
        let (stream, column) = *at;
        let once = ours.starts_with("pressure_") || ours.starts_with("travel");
        let shared = taken.values().filter(|(other, ..)| other == at).count() > 1;
        let values = if stream == base && !shared {
            core::mem::take(&mut streams[stream].values[column])
        } else if stream == base {
            streams[stream].values[column].clone()
        } else {
            let from = &streams[stream];
            placed(&stamps(from), &from.values[column], &times, once)
        };
        #[expect(clippy::float_cmp, reason = "exactly 1 changes nothing")]
        let same = *scale == 1.0;
        let values = if same {
            values
        } else {
            values.into_iter().map(|x| reading(f64::from(x) * scale)).collect()
        };
        columns.names.push(ours.clone());
        columns.values.push(values);
    }
    if let Times::Stamps(_) = &streams[base].times {
        let micros =
            |ns: &i64| Micros(u64::try_from((ns - zero_ns + 500).div_euclid(1000)).unwrap_or(0));
        columns.times = Some(times.iter().map(micros).collect());
    }
    columns
}

/// Readings at `times` as they were known then.
fn placed(at: &[i64], values: &[f32], times: &[i64], once: bool) -> Vec<f32> {
    let span = at.last().zip(at.first()).map_or(0, |(last, first)| last - first);
    let step = span / i64::try_from(at.len().max(2) - 1).unwrap_or(1);
    let mut next = 0;
    let mut held: Option<(i64, f32)> = None;
    let mut out = Vec::with_capacity(times.len());
    for &t in times {
        let mut updates = false;
        while let Some((&from, &value)) =
            at.get(next).zip(values.get(next)).filter(|(from, _)| **from <= t)
        {
            held = Some((from, value));
            updates = true;
            next += 1;
        }
        let fresh = |(from, _): &(i64, f32)| {
            if once { updates } else { t - from <= HELD_STEPS * step.max(1) }
        };
        out.push(held.filter(fresh).map_or(f32::NAN, |(_, value)| value));
    }
    out
}
