//! Assignment of streams of named numbers to one recording, and how each was interpreted.
//!
//! Signals of other topics than that of the vibration are put on its times as they were known then: the last reading before, for at
//! most ten of their steps; a frame of taxels and a travel at the first time that is not earlier.

use crate::{
    ArrayRows, ImportOptions,
    error::ImportError,
    stream::{Stream, Times, reading},
};
use grip_record::{
    Columns, CsvError, CsvOptions, Recording, Signal, Use,
    clock::Clock,
    find::{example, find},
    pace::Pace,
    time::TimeUnit,
};
use slip_core::units::Micros;
use std::path::Path;

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

/// A reading is kept for so many steps of its own stream.
const HELD_STEPS: i64 = 10;

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
    let places: Vec<[usize; 2]> = streams
        .iter()
        .enumerate()
        .flat_map(|(s, stream)| (0..stream.names.len()).map(move |c| [s, c]))
        .collect();
    let signals: Vec<Signal> = streams
        .iter()
        .flat_map(|stream| stream.names.iter().zip(&stream.units).zip(&stream.known))
        .map(|((name, unit), known)| Signal {
            name: name.clone(),
            unit: unit.map(str::to_owned).or_else(|| Some(grip_table::of_name(name)?.1)),
            known: known.clone(),
            is_text: false,
        })
        .collect();
    let found = find(file, &signals, &options.map)?;
    let is_used = |at: &usize| found.uses.iter().any(|used| used.at == *at);
    let free = (0..signals.len()).filter(|at| !is_used(at));
    let unused: Vec<String> =
        free.filter_map(|at| signals.get(at)).map(|signal| signal.name.clone()).collect();
    let uses: Vec<(&Use, [usize; 2])> =
        found.uses.iter().filter_map(|used| Some((used, *places.get(used.at)?))).collect();
    let base = ["vibration", "stylus", "pressure_", "travel"].into_iter().find_map(|start| {
        uses.iter().find(|(used, _)| used.ours.starts_with(start)).map(|(_, [stream, _])| *stream)
    });
    let base = base.ok_or_else(|| CsvError::NoStylus {
        file: file.to_owned(),
        example: example(signals.iter().map(|signal| signal.name.as_str())),
        found: signals.iter().map(|signal| signal.name.clone()).collect(),
    })?;
    let mut notes: Vec<String> =
        streams.iter_mut().flat_map(|stream| core::mem::take(&mut stream.notes)).collect();
    notes.extend(found.notes.iter().cloned());
    sort(&mut streams, &mut notes);
    let clock = streams.get(base).map_or_else(String::new, |stream| stream.clock.clone());
    let stream = streams.get_mut(base);
    let timing = stream.map(|stream| timing(stream, options.rate_hz, &mut notes));
    let Timing { times, rate_hz, coarse_hz } = timing.unwrap_or_default();
    let csv = CsvOptions { rate_hz: options.rate_hz.or(rate_hz), ..CsvOptions::default() };
    let columns = columns(streams, base, &uses, times);
    let mut recording = Recording::of_columns(file, &columns, &csv)?;
    if let Some(rate_hz) = coarse_hz {
        let notes = &mut recording.notes;
        (notes.given_rate_hz, notes.measured_rate_hz) = (options.rate_hz, Some(rate_hz));
    }
    Ok(Imported { format, clock, uses: found.uses, unused, notes, recording, rows: None })
}

/// The times of the rows of a stream.
#[derive(Default)]
struct Timing {
    times: Option<Vec<Micros>>,
    /// Their rate, where the stamps do not show it.
    rate_hz: Option<f32>,
    /// The same where rows were placed by it.
    coarse_hz: Option<f32>,
}

fn timing(stream: &mut Stream, given_hz: Option<f32>, notes: &mut Vec<String>) -> Timing {
    let mut timing = Timing::default();
    match &mut stream.times {
        Times::Stamps(stamps) => {
            let mut pace = Pace::of(stamps);
            if let Some(rate_hz) = given_hz {
                pace = pace.map(|pace| pace.with_rate(rate_hz));
                pace = pace.or((stamps.len() > 1).then(|| Pace::at_rate(rate_hz)));
            }
            if let Some(pace) = pace {
                notes.extend(Some(pace.to_string()).filter(|text| !text.is_empty()));
                *stamps = pace.placed(core::mem::take(stamps));
                timing.coarse_hz = pace.coarse.then(|| pace.rate_hz());
                timing.rate_hz = timing.coarse_hz;
            }
            let mut clock = Clock::new(TimeUnit::Nanos, false, None);
            let times = stamps.iter().map(|ns| clock.time(*ns).unwrap_or_default());
            timing.times = Some(times.collect());
            notes.extend(clock.notes());
        }
        Times::Unknown => {}
    }
    timing
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

fn columns(
    mut streams: Vec<Stream>,
    base: usize,
    uses: &[(&Use, [usize; 2])],
    times: Option<Vec<Micros>>,
) -> Columns {
    let stamps = |stream: Option<&Stream>| match stream.map(|stream| &stream.times) {
        Some(Times::Stamps(times)) => times.clone(),
        _ => Vec::new(),
    };
    let at = stamps(streams.get(base));
    let mut columns = Columns { times, ..Columns::default() };
    for (Use { ours, scale, .. }, [stream, column]) in uses {
        let once = ours.starts_with("pressure_") || ours.starts_with("travel");
        let from = stamps(streams.get(*stream).filter(|_| *stream != base));
        let values = streams.get_mut(*stream).and_then(|stream| stream.values.get_mut(*column));
        let values = values.map(core::mem::take).unwrap_or_default();
        let mut values = if *stream == base { values } else { placed(&from, &values, &at, once) };
        #[expect(clippy::float_cmp, reason = "exactly 1 changes nothing")]
        if *scale != 1.0 {
            values.iter_mut().for_each(|x| *x = reading(f64::from(*x) * scale));
        }
        columns.names.push(ours.clone());
        columns.values.push(values);
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
