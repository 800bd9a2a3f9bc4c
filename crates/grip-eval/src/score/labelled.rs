//! A folder with `labels.csv` in, its checked recordings with their labels and companions out.

use super::{ScoreError, companions};
use grip_record::{
    CsvError, CsvOptions, Label, LabelError, LabelKind, Phase, Recording, Travel, read_alarms,
    read_labels, read_phases, read_recording,
};
use grip_session::recording::read_mcap;
use slip_core::units::Micros;
use std::path::{Path, PathBuf};

/// A recording of the folder and what is known of it.
pub(super) struct Labelled {
    /// Its only label, or that of its first slip.
    pub(super) label: Label,
    /// Onsets of further slips, in rising order.
    pub(super) further: Vec<Micros>,
    pub(super) recording: Recording,
    /// The same with what lies beside it as further channels.
    joined: Option<Recording>,
    pub(super) travel: Option<Travel>,
    /// Alarms of a detector of one's own in it, by their begin; `None` where the folder has none.
    pub(super) own: Option<Vec<Phase>>,
    /// What else went on in it.
    pub(super) phases: Vec<Phase>,
}

impl Labelled {
    /// With its companions, where they were read.
    pub(super) fn recording(&self, companions: bool) -> &Recording {
        self.joined.as_ref().filter(|_| companions).unwrap_or(&self.recording)
    }
}

/// Every labelled recording, in the order of the labels.
pub(super) fn load(
    directory: &Path,
    options: &CsvOptions,
    companions: bool,
) -> Result<Vec<Labelled>, ScoreError> {
    let mut all: Vec<Labelled> = Vec::new();
    let labels = directory.join("labels.csv");
    let all_phases = read_phases(&directory.join("phases.csv"))?;
    let all_alarms = read_alarms(&directory.join("alarms.csv"))?;
    for label in read_labels(&labels).map_err(|error| labels_error(&labels, error))? {
        let same = |one: &&mut Labelled| one.label.recording == label.recording;
        if let Some(first) = all.iter_mut().find(same) {
            check_onset(&label, &first.recording)?;
            first.further.extend(label.onset());
            continue;
        }
        let file = file(&label, directory);
        let recording = match file.extension() {
            Some(ending) if ending == "mcap" => read_mcap(&file)?,
            _ => read_recording(&file, options)?,
        };
        check_onset(&label, &recording)?;
        let travel = Travel::read_beside(&file)?;
        let joined =
            companions.then(|| companions::join(&file, &recording, travel.as_ref())).transpose()?;
        let of = |phases: &Vec<Phase>| {
            let its = phases.iter().filter(|phase| phase.recording == label.recording);
            its.cloned().collect::<Vec<_>>()
        };
        let (phases, own) = (of(&all_phases), all_alarms.as_ref().map(of));
        all.push(Labelled { label, further: Vec::new(), recording, joined, travel, own, phases });
    }
    let first =
        all.first().ok_or_else(|| ScoreError::Nothing { directory: directory.to_owned() })?;
    check_alike(first, &all)?;
    Ok(all)
}

/// `NAME.csv`, or `NAME.npz` or `NAME.mcap` where only that is there.
fn file(label: &Label, directory: &Path) -> PathBuf {
    let csv = label.file(directory);
    let other = |ending| csv.with_file_name(format!("{}.{ending}", label.recording));
    let others = ["npz", "mcap"].map(other).into_iter().find(|file| file.exists());
    others.filter(|_| !csv.exists()).unwrap_or(csv)
}

/// What a recording would be asked to put on its first line is wrong advice for labels.
fn labels_error(file: &Path, error: LabelError) -> ScoreError {
    match error {
        LabelError::Table(CsvError::Empty { .. }) => {
            ScoreError::Unlabelled { file: file.to_owned() }
        }
        LabelError::Table(CsvError::NoRows { .. }) => {
            ScoreError::Nothing { directory: file.parent().unwrap_or(file).to_owned() }
        }
        error => error.into(),
    }
}

fn check_onset(label: &Label, recording: &Recording) -> Result<(), ScoreError> {
    let (Some(onset), Some(first), Some(last)) =
        (label.onset(), recording.samples.first(), recording.samples.last())
    else {
        return Ok(());
    };
    if (first.t..=last.t).contains(&onset) {
        return Ok(());
    }
    Err(ScoreError::OnsetOutside {
        recording: label.recording.clone(),
        onset_s: onset.as_seconds(),
        first_s: first.t.as_seconds(),
        last_s: last.t.as_seconds(),
    })
}

fn check_alike(first: &Labelled, all: &[Labelled]) -> Result<(), ScoreError> {
    let reference = &first.recording;
    for Labelled { recording, .. } in all {
        let same_rate = (recording.rate_hz / reference.rate_hz - 1.0).abs() < 0.01;
        if !same_rate || recording.channels.stylus != reference.channels.stylus {
            return Err(ScoreError::Mixed {
                recording: recording.name.clone(),
                rate_hz: recording.rate_hz,
                first: reference.name.clone(),
                first_hz: reference.rate_hz,
            });
        }
    }
    Ok(())
}

/// Time up to which a recording is labelled as rest (s).
pub(super) fn rest_until(label: &Label, guard_ms: f64) -> f64 {
    match label.kind {
        LabelKind::Onset { at } => at.as_seconds() - 1e-3 * guard_ms,
        LabelKind::Rest => f64::INFINITY,
        LabelKind::Steady => f64::NEG_INFINITY,
    }
}
