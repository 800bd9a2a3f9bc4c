//! Layout of a row: the place of every channel, by the names of columns in a recording.

use std::path::Path;

use crate::axes;
use crate::channels::{ARRIVAL, COLUMN_NAMES, Channel, ChannelSet, Role, Scale, StylusKind};
use crate::error::CsvError;
use crate::find::{EITHER, Found as Uses};
use crate::plan::{Plan, TEXT};
use crate::taxels::{PREFIX, check_count};

/// Where the channels stand in a row, columns from 0.
#[derive(Debug)]
pub(crate) struct Layout {
    pub(crate) time: Option<usize>,
    pub(crate) stylus: Option<usize>,
    /// Columns of the further axes of the vibration sensor and of the reference.
    pub(crate) axes: Vec<usize>,
    pub(crate) reference_axes: Vec<usize>,
    pub(crate) optional: Vec<(usize, Channel, Scale)>,
    /// Columns of the taxels in their order.
    pub(crate) taxels: Vec<usize>,
    /// Columns of the arrival and the age.
    pub(crate) arrival: Option<[usize; 2]>,
    pub(crate) channels: ChannelSet,
    /// Columns nothing is read from.
    pub(crate) ignored: Vec<String>,
    /// Columns that are in other units, and what their numbers are multiplied by.
    scales: Vec<(usize, f64)>,
}

/// A known name found in the file.
#[derive(Clone, Copy)]
struct Found {
    name: &'static str,
    column: usize,
}

impl Layout {
    /// Whether anything is read from the column.
    pub(crate) fn uses(&self, column: usize) -> bool {
        self.time == Some(column)
            || self.stylus == Some(column)
            || self.taxels.contains(&column)
            || self.axes.contains(&column)
            || self.reference_axes.contains(&column)
            || self.arrival.is_some_and(|columns| columns.contains(&column))
            || self.optional.iter().any(|(used, ..)| *used == column)
    }

    /// What the numbers of a column become.
    pub(crate) fn scale(&self, column: usize) -> Scale {
        let scale = self.scales.iter().find(|(other, _)| *other == column);
        scale.map_or(Scale::Same, |(_, by)| Scale::By(*by))
    }

    pub(crate) fn resolve(file: &Path, plan: &Plan, has_rate: bool) -> Result<Self, CsvError> {
        let Plan { ours: header, names: sources, found: Uses { uses, .. }, .. } = plan;
        let mut found = find(header);
        for [first, second] in EITHER {
            let has = |name: &str| found.iter().any(|found| found.name == name);
            if has(first) && has(second) {
                return Err(CsvError::Ambiguous { file: file.to_owned(), first, second });
            }
        }
        let taxels = taxel_columns(file, header)?;
        let [vibration, reference] = vectors(file, header, &mut found)?;
        let stylus = stylus_of(&found);
        let travels = found
            .iter()
            .any(|found| matches!(Role::of(found.name), Some(Role::Optional(Channel::Travel, _))));
        if stylus.is_none() && taxels.is_empty() && !travels {
            let free = |(name, ours): &(&String, &String)| {
                ours.is_empty() && !name.is_empty() && !name.ends_with(TEXT)
            };
            let free = sources.iter().zip(header).filter(free).map(|(name, _)| name.as_str());
            let example = crate::find::example(free);
            let found = sources.clone();
            return Err(CsvError::NoStylus { file: file.to_owned(), found, example });
        }
        let (stylus_kind, stylus) =
            stylus.map_or((StylusKind::Absent, None), |(kind, column)| (kind, Some(column)));
        let time = found
            .iter()
            .find(|found| Role::of(found.name) == Some(Role::Time))
            .map(|found| found.column);
        if time.is_none() && !has_rate {
            return Err(CsvError::NoTime { file: file.to_owned(), found: sources.clone() });
        }
        let source = |column: usize| sources.get(column).cloned().unwrap_or_default();
        let scales: Vec<(usize, f64)> =
            uses.iter().map(|used| (used.at, used.scale)).filter(|(_, by)| *by != 1.0).collect();
        let scaled = |column: usize| scales.iter().find(|(other, _)| *other == column);
        let optional: Vec<_> = found
            .iter()
            .filter_map(|found| match Role::of(found.name) {
                Some(Role::Optional(channel, scale)) => {
                    let scale = scaled(found.column).map_or(scale, |(_, by)| Scale::By(*by));
                    Some((found.column, channel, scale))
                }
                _ => None,
            })
            .collect();
        let arrival = arrival_columns(sources);
        let channels = ChannelSet {
            axes: names(&vibration),
            reference_axes: names(&reference),
            arrivals: arrival.is_some(),
            taxels: taxels.len(),
            stylus: stylus_kind,
            stylus_source: stylus.map(source),
            time_source: time.map(source),
            optional: optional
                .iter()
                .map(|&(column, channel, _)| (channel, source(column)))
                .collect(),
        };
        let [axes, reference_axes] = [&vibration, &reference]
            .map(|axes| axes.iter().skip(1).map(|(_, column)| *column).collect());
        let mut layout = Self {
            time,
            stylus,
            axes,
            reference_axes,
            optional,
            taxels,
            arrival,
            channels,
            ignored: Vec::new(),
            scales,
        };
        let ignored = sources.iter().enumerate().filter(|(column, _)| !layout.uses(*column));
        layout.ignored = ignored.map(|(_, name)| name.clone()).collect();
        Ok(layout)
    }
}

/// The axes of the vibration, where there is no stylus, and of the reference.
fn vectors(
    file: &Path,
    header: &[String],
    found: &mut Vec<Found>,
) -> Result<[axes::Axes; 2], CsvError> {
    let vibration = if found.iter().any(|found| found.name == "stylus") {
        Vec::new()
    } else {
        axes::columns(file, header, "vibration")?
    };
    let reference = axes::columns(file, header, "reference")?;
    take_first(found, "vibration", &vibration);
    take_first(found, "reference", &reference);
    Ok([vibration, reference])
}

/// The first axis stands where the plain name would.
fn take_first(found: &mut Vec<Found>, name: &'static str, axes: &axes::Axes) {
    let Some((_, column)) = axes.first() else { return };
    found.retain(|found| found.name != name);
    found.push(Found { name, column: *column });
}

/// The names of several axes.
fn names(axes: &axes::Axes) -> Vec<String> {
    let several = if axes.len() > 1 { axes.as_slice() } else { &[] };
    several.iter().map(|(name, _)| name.clone()).collect()
}

/// The columns `pressure_0`, `pressure_1` and so on, which must count up without a gap.
fn taxel_columns(file: &Path, header: &[String]) -> Result<Vec<usize>, CsvError> {
    let number = |name: &String| name.strip_prefix(PREFIX)?.parse::<usize>().ok();
    let named = header.iter().filter(|name| number(name).is_some()).count();
    let mut columns = Vec::new();
    for k in 0..named {
        let missing = format!("{PREFIX}{k}");
        let Some(column) = header.iter().position(|name| *name == missing) else {
            let found = header.iter().rfind(|name| number(name).is_some());
            let found = found.cloned().unwrap_or_default();
            return Err(CsvError::TaxelGap { file: file.to_owned(), missing, found });
        };
        columns.push(column);
    }
    if named > 0 {
        check_count(file, named)?;
    }
    Ok(columns)
}

/// The columns of the arrival, where both are there.
fn arrival_columns(header: &[String]) -> Option<[usize; 2]> {
    let place = |wanted: &str| header.iter().position(|name| name == wanted);
    let [at, age] = ARRIVAL;
    Some([place(at)?, place(age)?])
}

fn stylus_of(found: &[Found]) -> Option<(StylusKind, usize)> {
    found.iter().find_map(|found| match Role::of(found.name) {
        Some(Role::Stylus(kind)) => Some((kind, found.column)),
        _ => None,
    })
}

/// The known names in the file.
fn find(header: &[String]) -> Vec<Found> {
    let place = |wanted: &str| header.iter().position(|column| column == wanted);
    let found = |name| Some(Found { name, column: place(name)? });
    COLUMN_NAMES.into_iter().filter_map(found).collect()
}
