//! A header and the renamings in, the place of every channel in a row out.

use std::path::Path;

use crate::axes;
use crate::channels::{ARRIVAL, COLUMN_NAMES, Channel, ChannelSet, Role, Scale, StylusKind};
use crate::csv_read::CsvOptions;
use crate::error::CsvError;
use crate::taxels::{PREFIX, check_count};

/// Pairs of names of which only one can be used.
const EITHER: [(&str, &str); 2] = [("stylus", "vibration"), ("travel_m", "travel_mm")];

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
}

/// A known name found in the file.
#[derive(Clone, Copy)]
struct Found {
    name: &'static str,
    column: usize,
    mapped: bool,
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

    pub(crate) fn resolve(
        file: &Path,
        header: &[String],
        options: &CsvOptions,
    ) -> Result<Self, CsvError> {
        let mut found = find(file, header, &options.map)?;
        for pair in EITHER {
            keep_one(file, &mut found, pair)?;
        }
        let taxels = taxel_columns(file, header)?;
        let [vibration, reference] = vectors(file, header, &options.map, &mut found)?;
        let stylus = stylus_of(&found);
        let travels = found
            .iter()
            .any(|found| matches!(Role::of(found.name), Some(Role::Optional(Channel::Travel, _))));
        if stylus.is_none() && taxels.is_empty() && !travels {
            return Err(CsvError::NoStylus { file: file.to_owned(), found: header.to_vec() });
        }
        let (stylus_kind, stylus) =
            stylus.map_or((StylusKind::Absent, None), |(kind, column)| (kind, Some(column)));
        let time = found
            .iter()
            .find(|found| Role::of(found.name) == Some(Role::Time))
            .map(|found| found.column);
        if time.is_none() && options.rate_hz.is_none() {
            return Err(CsvError::NoTime { file: file.to_owned(), found: header.to_vec() });
        }
        let source = |column: usize| header.get(column).cloned().unwrap_or_default();
        let optional: Vec<_> = found
            .iter()
            .filter_map(|found| match Role::of(found.name) {
                Some(Role::Optional(channel, scale)) => Some((found.column, channel, scale)),
                _ => None,
            })
            .collect();
        let arrival = arrival_columns(header);
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
        };
        let ignored = header.iter().enumerate().filter(|(column, _)| !layout.uses(*column));
        layout.ignored = ignored.map(|(_, name)| name.clone()).collect();
        Ok(layout)
    }
}

/// The axes of the vibration, where there is no stylus, and of the reference.
fn vectors(
    file: &Path,
    header: &[String],
    map: &[(String, String)],
    found: &mut Vec<Found>,
) -> Result<[axes::Axes; 2], CsvError> {
    let vibration = if found.iter().any(|found| found.name == "stylus") {
        Vec::new()
    } else {
        axes::columns(file, header, map, "vibration")?
    };
    let reference = axes::columns(file, header, map, "reference")?;
    take_first(found, "vibration", &vibration);
    take_first(found, "reference", &reference);
    Ok([vibration, reference])
}

/// The first axis stands where the plain name would.
fn take_first(found: &mut Vec<Found>, name: &'static str, axes: &axes::Axes) {
    let Some((_, column)) = axes.first() else { return };
    let mapped = found.iter().any(|found| found.name == name && found.mapped);
    found.retain(|found| found.name != name);
    found.push(Found { name, column: *column, mapped });
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

/// The known names in the file: renamed ones first looked up under the file's name; a column claimed by a
/// renaming no longer stands for its own name.
fn find(file: &Path, header: &[String], map: &[(String, String)]) -> Result<Vec<Found>, CsvError> {
    check_map(file, header, map)?;
    let position = |wanted: &str| header.iter().position(|column| column == wanted);
    let claimed = |wanted: &str| map.iter().any(|(_, theirs)| theirs == wanted);
    let found = COLUMN_NAMES.into_iter().filter_map(|name| {
        let entry = map.iter().find(|(ours, _)| ours == name);
        let column = match entry {
            Some((_, theirs)) => position(theirs),
            None if claimed(name) => None,
            None => position(name),
        };
        column.map(|column| Found { name, column, mapped: entry.is_some() })
    });
    Ok(found.collect())
}

fn check_map(file: &Path, header: &[String], map: &[(String, String)]) -> Result<(), CsvError> {
    for (index, (ours, theirs)) in map.iter().enumerate() {
        if Role::of(ours).is_none() && !axes::is_axis(ours) {
            return Err(CsvError::UnknownMapName { ours: ours.clone(), theirs: theirs.clone() });
        }
        for (other_ours, other_theirs) in map.iter().take(index) {
            let repeated = [(ours, other_ours), (theirs, other_theirs)]
                .into_iter()
                .find(|(one, other)| one == other);
            if let Some((name, _)) = repeated {
                return Err(CsvError::MapRepeated { name: name.clone() });
            }
        }
        if !header.contains(theirs) {
            return Err(CsvError::MapColumnAbsent {
                file: file.to_owned(),
                ours: ours.clone(),
                theirs: theirs.clone(),
                found: header.to_vec(),
            });
        }
    }
    Ok(())
}

/// Of two names for one channel the renamed one wins; without exactly one renaming the choice is the user's.
fn keep_one(
    file: &Path,
    found: &mut Vec<Found>,
    pair: (&'static str, &'static str),
) -> Result<(), CsvError> {
    let mapped =
        |wanted: &str| found.iter().find(|found| found.name == wanted).map(|found| found.mapped);
    let (Some(first_mapped), Some(second_mapped)) = (mapped(pair.0), mapped(pair.1)) else {
        return Ok(());
    };
    if first_mapped == second_mapped {
        return Err(CsvError::Ambiguous { file: file.to_owned(), first: pair.0, second: pair.1 });
    }
    let dropped = if first_mapped { pair.1 } else { pair.0 };
    found.retain(|found| found.name != dropped);
    Ok(())
}
