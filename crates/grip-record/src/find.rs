//! Lookup of what each signal is in a recording, by its name and unit.
//!
//! 1. `--map OURS=NAME` states what a signal is. `NAME` may be a group: `--map vibration=/imu.linear_acceleration` takes its axes,
//!    `--map pressure=/skin.data` its items as taxels.
//! 2. A signal with the name of a recording's column is that column.
//! 3. Words: a vibration (`vib`, `piezo`, `mic`, ...), a normal force, an array of taxels. The three axes of the only acceleration
//!    are the vibration where there is none else. Beside a vibration they are the motion reference only where their name says that
//!    they are those of a robot and of no finger, because a second finger feels the slip too.
//!
//! What could be two things is refused. Forces, lengths, speeds and accelerations are converted from the unit of their name.

use crate::{
    channels::COLUMN_NAMES,
    error::{CsvError, shell},
    is_axis, words,
};
use grip_table::{Quantity, TableError};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// A column of a table, or a signal of another format.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// Its name, with topic and unit where the file has them.
    pub name: String,
    /// Its unit, as far as the file or the format states it.
    pub unit: Option<String>,
    /// What it is in a recording (`vibration`, `pressure_3`), where the format knows it.
    pub known: Option<String>,
    /// Whether it is text, which nothing can be read from.
    pub is_text: bool,
}

/// A signal that is used, and as what.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// Place among the signals.
    pub at: usize,
    /// The column of the recording.
    pub ours: String,
    /// The signal of the file.
    pub theirs: String,
    /// Its unit, as far as it is known or had to be taken for granted.
    pub unit: String,
    /// What its numbers are multiplied by.
    pub scale: f64,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// In the order of the names of the columns.
    pub uses: Vec<Use>,
    /// What could be used, and how.
    pub notes: Vec<String>,
}

/// Finds which of these signals are what.
///
/// # Errors
/// Where a renaming names none, several signals could be the one, or a unit is not known.
pub fn find(file: &Path, signals: &[Signal], map: &[(String, String)]) -> Result<Found, CsvError> {
    check_map(map)?;
    let mut finding = Finding {
        file,
        signals,
        map,
        taken: BTreeMap::new(),
        used: BTreeSet::new(),
        notes: Vec::new(),
    };
    finding.by_map()?;
    finding.by_name()?;
    finding.by_words()?;
    Ok(Found { uses: finding.taken.into_values().collect(), notes: finding.notes })
}

fn check_map(map: &[(String, String)]) -> Result<(), CsvError> {
    for (at, (ours, theirs)) in map.iter().enumerate() {
        if !is_column(ours) {
            return Err(CsvError::UnknownMapName { ours: ours.clone(), theirs: theirs.clone() });
        }
        for (other_ours, other_theirs) in map.iter().take(at) {
            if let Some((name, _)) =
                [(ours, other_ours), (theirs, other_theirs)].into_iter().find(|(a, b)| a == b)
            {
                return Err(CsvError::MapRepeated { name: name.clone() });
            }
        }
    }
    Ok(())
}

/// Whether `name` is that of a column of a recording.
fn is_column(name: &str) -> bool {
    COLUMN_NAMES.contains(&name)
        || is_axis(name)
        || name.strip_prefix("pressure_").is_some_and(|k| k.parse::<usize>().is_ok())
}

/// Pairs of names of which only one can be used.
pub(crate) const EITHER: [[&str; 2]; 2] = [["stylus", "vibration"], ["travel_m", "travel_mm"]];

struct Finding<'a> {
    file: &'a Path,
    signals: &'a [Signal],
    map: &'a [(String, String)],
    /// By column of the recording.
    taken: BTreeMap<String, Use>,
    used: BTreeSet<usize>,
    notes: Vec<String>,
}

impl<'a> Finding<'a> {
    /// Signals that are not used, and no text.
    fn free(&self) -> Vec<(usize, &'a Signal)> {
        let signals = self.signals.iter().enumerate();
        signals.filter(|(at, signal)| !self.used.contains(at) && !signal.is_text).collect()
    }

    /// Takes a signal as `ours`, in the unit that is stated.
    fn take(&mut self, ours: &str, at: usize, signal: &Signal) -> Result<(), CsvError> {
        let wanted = match ours {
            "stylus" | "stylus2" | "travel_m" | "travel_mm" => Some((Quantity::Length, "m")),
            "force_n" | "tangential_n" => Some((Quantity::Force, "N")),
            "velocity_m_s" => Some((Quantity::Speed, "m/s")),
            _ => None,
        };
        let stated = signal.unit.as_deref().filter(|unit| !is_remark(unit));
        let mut ours = ours;
        let (scale, unit) = match (wanted, stated.and_then(grip_table::scale), stated) {
            (Some((quantity, base)), Some((found, scale)), Some(unit)) if found == quantity => {
                if scale == 1.0 {
                    (1.0, base.to_owned())
                } else if ours == "travel_mm" && unit == "mm" {
                    (1.0, "mm".to_owned())
                } else {
                    ours = if ours == "travel_mm" { "travel_m" } else { ours };
                    (scale, unit.to_owned())
                }
            }
            // An ending behind an underscore may be no unit at all.
            (Some((_, base)), _, Some(unit)) if !signal.name.ends_with(unit) => {
                return Err(CsvError::Table(TableError::Unit {
                    file: self.file.to_owned(),
                    column: signal.name.clone(),
                    unit: unit.to_owned(),
                    wanted: known_units(base),
                }));
            }
            (Some(_), ..) if ours == "travel_mm" => (1.0, "mm".to_owned()),
            // A column of a recording has the unit of its name.
            (Some((_, base)), ..) if signal.name == ours => (1.0, base.to_owned()),
            (Some((_, base)), ..) => (1.0, format!("taken as {base}")),
            (None, Some((Quantity::Acceleration, scale)), Some(unit)) if unit.ends_with('g') => {
                (scale, "m/s2".to_owned())
            }
            (None, _, unit) => (1.0, unit.unwrap_or("own unit").to_owned()),
        };
        self.used.insert(at);
        let (ours, theirs) = (ours.to_owned(), signal.name.clone());
        self.taken.insert(ours.clone(), Use { at, ours, theirs, unit, scale });
        Ok(())
    }

    fn by_map(&mut self) -> Result<(), CsvError> {
        for (ours, theirs) in self.map.iter().filter(|(ours, _)| ours != "t_s") {
            let signals = self.signals.iter().enumerate();
            let members: Vec<(usize, &Signal, String)> =
                match signals.clone().find(|(_, signal)| signal.name == *theirs) {
                    Some((at, signal)) => vec![(at, signal, ours.clone())],
                    None => signals
                        .filter(|(_, signal)| !signal.is_text)
                        .filter_map(|(at, signal)| {
                            Some((at, signal, member(ours, theirs, &signal.name)?))
                        })
                        .collect(),
                };
            if members.is_empty() {
                return Err(CsvError::MapColumnAbsent {
                    file: self.file.to_owned(),
                    ours: ours.clone(),
                    theirs: theirs.clone(),
                    found: self.names(),
                });
            }
            for (at, signal, ours) in members {
                if signal.is_text {
                    return Err(CsvError::Text {
                        file: self.file.to_owned(),
                        column: signal.name.clone(),
                        wanted: ours,
                    });
                }
                self.take(&ours, at, signal)?;
            }
        }
        Ok(())
    }

    fn names(&self) -> Vec<String> {
        self.signals.iter().map(|signal| signal.name.clone()).collect()
    }

    /// Signals whose names, or formats, state which column they are.
    fn by_name(&mut self) -> Result<(), CsvError> {
        for (at, signal) in self.free() {
            let bare = signal.name.rsplit(['.', '/']).next().unwrap_or(&signal.name);
            let known = signal.known.clone().or_else(|| is_column(bare).then(|| bare.to_owned()));
            let Some(ours) = known.filter(|ours| ours != "t_s" && !self.is_overruled(ours)) else {
                continue;
            };
            if let Some(other) = self.taken.get(&ours) {
                let found = vec![other.theirs.clone(), signal.name.clone()];
                return Err(self.unclear("a column of its name", &ours, found));
            }
            self.take(&ours, at, signal)?;
        }
        Ok(())
    }

    /// Whether a renaming has said what that is: a whole vector or array, the same, or the other of two that exclude each other.
    fn is_overruled(&self, ours: &str) -> bool {
        let plain = ["vibration", "reference", "pressure"];
        let family = plain.into_iter().find(|plain| {
            ours.strip_prefix(plain).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
        });
        let other = |mapped: &str| {
            let either = EITHER.iter().find(|pair| pair.contains(&mapped));
            either.is_some_and(|pair| pair.iter().any(|name| ours == *name || family == Some(name)))
        };
        let mut mapped = self.map.iter().map(|(mapped, _)| mapped.as_str());
        mapped.any(|mapped| mapped == ours || family == Some(mapped) || other(mapped))
    }

    fn unclear(&self, what: &'static str, ours: &str, found: Vec<String>) -> CsvError {
        let (file, ours) = (self.file.to_owned(), ours.to_owned());
        CsvError::Unclear { file, what, ours, found }
    }

    fn has(&self, start: &str) -> bool {
        self.taken.keys().any(|ours| ours.starts_with(start))
    }

    fn feels(&self) -> bool {
        self.has("vibration") || self.taken.contains_key("stylus")
    }

    fn by_words(&mut self) -> Result<(), CsvError> {
        if !self.feels() {
            self.take_one(words::is_vibration, "the vibration", "vibration")?;
        }
        if !self.has("force_n") {
            self.take_one(words::is_force, "the normal force", "force_n")?;
        }
        let mut groups: BTreeMap<String, Vec<(char, usize, &Signal)>> = BTreeMap::new();
        for (at, signal) in self.free() {
            if let Some((group, axis)) = words::acceleration(&signal.name) {
                groups.entry(group).or_default().push((axis, at, signal));
            }
        }
        // The other axes of what feels the slip show no motion of the robot.
        let own = |used: &Use| words::acceleration(&used.theirs).map(|(group, _)| group);
        groups.retain(|group, _| self.taken.values().all(|used| own(used).as_ref() != Some(group)));
        self.accelerations(groups)?;
        self.taxels_by_words()
    }

    fn accelerations(
        &mut self,
        mut groups: BTreeMap<String, Vec<(char, usize, &Signal)>>,
    ) -> Result<(), CsvError> {
        if !self.feels() && !groups.is_empty() {
            let alone = self.has("pressure_") || self.has("travel");
            let of_finger: Vec<&String> = groups
                .keys()
                .filter(|group| groups.len() == 1 || !words::is_robot(group))
                .collect();
            match of_finger.as_slice() {
                [group] => {
                    let group = (*group).clone();
                    for (axis, at, signal) in groups.remove(&group).into_iter().flatten() {
                        self.take(&format!("vibration_{axis}"), at, signal)?;
                    }
                }
                _ if alone => return Ok(()),
                _ => {
                    let found = groups.into_keys().collect();
                    return Err(self.unclear("the vibration", "vibration", found));
                }
            }
        }
        if self.has("reference") {
            return Ok(());
        }
        let fitting: Vec<String> =
            groups.keys().filter(|group| words::is_robot(group)).cloned().collect();
        if let [group] = fitting.as_slice() {
            for (axis, at, signal) in groups.remove(group).into_iter().flatten() {
                self.take(&format!("reference_{axis}"), at, signal)?;
            }
            return Ok(());
        }
        let own: Vec<_> =
            self.taken.values().filter_map(|used| words::motion(&used.theirs)).collect();
        let free = self.free().into_iter().filter_map(|(_, signal)| words::motion(&signal.name));
        let groups: BTreeSet<String> = free.filter(|group| !own.contains(group)).collect();
        let likely = groups.iter().find(|group| words::is_robot(group)).or(groups.first());
        if let Some(likely) = likely {
            let likely = shell(&format!("reference={likely}"));
            let groups = groups.iter().cloned().collect::<Vec<_>>().join(", ");
            self.notes.push(format!(
                "{groups} may be another finger or the robot: where it is the robot, --map {likely}"
            ));
        }
        Ok(())
    }

    fn take_one(
        &mut self,
        is: fn(&str) -> bool,
        what: &'static str,
        ours: &'static str,
    ) -> Result<(), CsvError> {
        let found: Vec<_> =
            self.free().into_iter().filter(|(_, signal)| is(&signal.name)).collect();
        match found.as_slice() {
            [] => Ok(()),
            [(at, signal)] => self.take(ours, *at, signal),
            _ => {
                let found = found.into_iter().map(|(_, signal)| signal.name.clone()).collect();
                Err(self.unclear(what, ours, found))
            }
        }
    }

    fn taxels_by_words(&mut self) -> Result<(), CsvError> {
        if self.has("pressure_") {
            return Ok(());
        }
        let mut groups: BTreeMap<String, Vec<(usize, usize, &Signal)>> = BTreeMap::new();
        for (at, signal) in self.free() {
            if let Some((group, number)) = words::taxel(&signal.name) {
                groups.entry(group).or_default().push((number, at, signal));
            }
        }
        groups.retain(|_, taxels| taxels.len() > 1);
        if groups.len() > 1 {
            return Err(self.unclear("the taxels", "pressure", groups.into_keys().collect()));
        }
        for mut taxels in groups.into_values() {
            taxels.sort_by_key(|(number, at, _)| (*number, *at));
            for (k, (_, at, signal)) in taxels.into_iter().enumerate() {
                self.take(&format!("pressure_{k}"), at, signal)?;
            }
        }
        Ok(())
    }
}

/// The name for an example: of the first that is neither a time nor a count of rows, else none.
#[must_use]
pub fn example<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<String> {
    const COUNTS: [&str; 9] =
        ["sample", "samples", "index", "count", "counter", "row", "seq", "frame", "id"];
    let is_signal = |name: &&str| {
        let unit = grip_table::of_name(name).map(|(_, unit)| unit);
        !crate::time::is_time(name, unit.as_deref()) && !COUNTS.contains(&&*words::plain(name))
    };
    names.find(is_signal).map(str::to_owned)
}

/// The column that `name` is as a member of the group `theirs`, which is mapped to `ours`.
fn member(ours: &str, theirs: &str, name: &str) -> Option<String> {
    let bare = name.split(['(', '{']).next().unwrap_or(name).trim_end();
    let rest = bare.strip_prefix(theirs)?.trim_start_matches(['.', '_', '[', ' ']);
    let rest = rest.trim_end_matches(']').to_lowercase();
    let is_number = rest.parse::<usize>().is_ok();
    let fits = is_number || (ours != "pressure" && ["x", "y", "z"].contains(&rest.as_str()));
    fits.then(|| format!("{ours}_{rest}"))
}

/// What stands in brackets and is no unit.
fn is_remark(unit: &str) -> bool {
    let words = ["left", "right", "raw", "filtered", "measured", "norm", "total", "sum", "l", "r"];
    unit.parse::<u32>().is_ok() || words.contains(&unit.to_lowercase().as_str())
}

fn known_units(base: &str) -> &'static str {
    match base {
        "m" => "length (m, cm, mm, um, nm, in)",
        "N" => "force (N, mN, kN, gf, kgf, lbf)",
        _ => "speed (m/s, mm/s, um/s)",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(names: &[&str]) -> Result<Found, CsvError> {
        let signal = |name: &&str| Signal { name: (*name).to_owned(), ..Signal::default() };
        find(Path::new("x"), &names.iter().map(signal).collect::<Vec<_>>(), &[])
    }

    #[test]
    fn an_example_is_no_time_and_no_count() {
        let of = |names: &[&str]| example(names.iter().copied());
        assert_eq!(of(&["Sample", "time_ms", "ch0"]).as_deref(), Some("ch0"));
        assert_eq!(of(&["t", "/a.seq"]), None);
    }

    #[test]
    fn only_what_names_the_robot_is_a_motion_reference() {
        for (vibration, other) in [
            ("vibration", "right_finger_acc_"),
            ("mic", "finger2_a"),
            ("vib", "tip2.accel."),
            ("vibration", "right_hand_index_acc_"),
            ("vibration", "robot_palm_acc_"),
            ("vib", "basement_acc_"),
            ("vib", "a"),
            ("vibration", "wrist_imu_"),
        ] {
            let axes = ["x", "y", "z"].map(|axis| format!("{other}{axis}"));
            let found = found(&[vibration, &axes[0], &axes[1], &axes[2]]).unwrap();
            let uses: Vec<_> = found.uses.iter().map(|used| used.ours.as_str()).collect();
            assert_eq!(uses, ["vibration"], "{other}");
            let group = other.trim_end_matches(['_', '.']);
            let way = format!("where it is the robot, --map reference={group}");
            assert!(found.notes.iter().any(|note| note.ends_with(&way)), "{:?}", found.notes);
        }
        for names in [["vibration", "imu2_acc"], ["acc", "hand_acc"], ["vibration", "base_acc"]] {
            let found = found(&names).unwrap();
            let way = format!("--map reference={}", names[1]);
            assert_eq!((found.uses.len(), found.notes.len()), (1, 1), "{names:?}");
            assert!(found.notes[0].ends_with(&way), "{:?}", found.notes);
        }
        for two in [["left_a", "right_hand_a"], ["tip_acc_", "palm_acc_"]] {
            let axes = two.map(|group| ["x", "y", "z"].map(|axis| format!("{group}{axis}")));
            let names: Vec<_> = axes.iter().flatten().map(String::as_str).collect();
            assert!(matches!(found(&names), Err(CsvError::Unclear { .. })), "{two:?}");
        }
        let robot = found(&["mic", "/wrist/imu.accel.x", "/wrist/imu.accel.y"]).unwrap();
        assert_eq!((robot.uses.len(), robot.notes.len()), (3, 0));
    }
}
