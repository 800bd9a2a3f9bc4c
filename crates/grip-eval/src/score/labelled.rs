//! The checked recordings of a folder with `labels.csv`, with their labels and companions.
//!
//! Small folders stay in memory, and of larger ones the labelled rest as far as it fits. What does not is read again
//! wherever it is needed, a few recordings at a time: a folder of any size takes as much memory as [`Memory`] states; a
//! recording that is larger than [`Memory::open`] takes its own in place of that.

use super::{Decides, Detector, ScoreError, companions};
use grip_record::{
    Channel, ChannelSet, CsvError, CsvOptions, Label, LabelError, LabelKind, Phase, Recording,
    StylusKind, Taxels, Travel, read_alarms, read_labels, read_phases, read_recording,
};
use grip_session::recording::read_mcap;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use slip_core::{Sample, alarm::Method, units::Micros};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Condvar, Mutex, PoisonError},
};

/// How much of the recordings is held at once (bytes).
#[derive(Clone, Copy, Debug)]
pub(super) struct Memory {
    /// Whole recordings, from the first reading to the end, and as much again for the labelled rest of others.
    pub(super) kept: usize,
    /// Beside that while it is worked on; a recording that is larger is alone.
    pub(super) open: usize,
}

impl Memory {
    pub(super) const DEFAULT: Self = Self { kept: 128 << 20, open: 512 << 20 };
}

/// Before it was read nobody knows how much memory a recording takes: about so many times the bytes of a file of gripd,
/// and of others, which may be a text of one short number a sample.
const GROWS_MCAP: usize = 4;
const GROWS: usize = 40;

/// What is known of a recording of the folder.
pub(super) struct Labelled {
    /// Its only label, or that of its first slip.
    pub(super) label: Label,
    /// Onsets of further slips, in rising order.
    further: Vec<Micros>,
    /// Alarms of a detector of one's own in it, by their begin; `None` where the folder has none.
    pub(super) own: Option<Vec<Phase>>,
    /// What else went on in it.
    pub(super) phases: Vec<Phase>,
    file: PathBuf,
    /// Of the recording itself, and with what lies beside it.
    seen: [Seen; 2],
    pub(super) rate_hz: f32,
    /// Which of [`Recordings::kins`] it belongs to.
    pub(super) kin: usize,
    /// Time of the first and of the last sample.
    span: Option<(Micros, Micros)>,
    bytes: usize,
    /// All of it, or its labelled rest.
    kept: Option<Arc<Contents>>,
    is_whole: bool,
}

/// What the samples of a recording have.
struct Seen {
    channels: ChannelSet,
    taxels: bool,
}

/// A recording in memory.
pub(super) struct Contents {
    recording: Recording,
    /// The same with what lies beside it as further channels.
    joined: Option<Recording>,
    pub(super) travel: Option<Travel>,
}

impl Contents {
    /// With its companions, where they were read.
    pub(super) fn recording(&self, companions: bool) -> &Recording {
        self.joined.as_ref().filter(|_| companions).unwrap_or(&self.recording)
    }

    /// Keeps the samples before a time (s) alone; whether that is everything.
    fn truncate(&mut self, until_s: f64) -> bool {
        let count = self.recording.samples.partition_point(|s| s.t.as_seconds() < until_s);
        if count == self.recording.samples.len() {
            return true;
        }
        self.travel = None;
        for recording in [Some(&mut self.recording), self.joined.as_mut()].into_iter().flatten() {
            recording.truncate(count);
        }
        false
    }

    fn read(file: &Path, options: &CsvOptions, companions: bool) -> Result<Self, ScoreError> {
        let recording = match file.extension() {
            Some(ending) if ending == "mcap" => read_mcap(file)?,
            _ => read_recording(file, options)?,
        };
        let travel = Travel::read_beside(file)?;
        let joined =
            companions.then(|| companions::join(file, &recording, travel.as_ref())).transpose()?;
        Ok(Self { recording, joined, travel })
    }

    /// What it takes while a detector looks at it, the statistic of each sample included (bytes).
    fn bytes(&self) -> usize {
        let of = |recording: &Recording| {
            // Those of a file beside it are no channel of the recording.
            let taxels = recording.taxels.as_ref().map_or(0, Taxels::count) * size_of::<f32>();
            recording.samples.len() * (size_of::<Sample>() + taxels + size_of::<(f64, f32)>())
        };
        let points = self.travel.as_ref().map_or(0, |travel| travel.points().len());
        of(&self.recording) + self.joined.as_ref().map_or(0, of) + points * size_of::<(f64, f64)>()
    }
}

impl Labelled {
    /// Whether it has a channel.
    pub(super) fn has(&self, channel: Channel) -> bool {
        let [own, _] = &self.seen;
        own.channels.has(channel)
    }

    /// Whether it has taxels, in itself or beside it.
    pub(super) fn has_taxels(&self, companions: bool) -> bool {
        self.seen[usize::from(companions)].taxels
    }

    /// Whether it has what a method looks at.
    pub(super) fn serves(&self, method: Method, companions: bool) -> bool {
        let Seen { channels, taxels } = &self.seen[usize::from(companions)];
        match method {
            Method::Travel => channels.has(Channel::Travel),
            Method::Pressure => *taxels,
            _ => channels.stylus != StylusKind::Absent,
        }
    }

    /// Where slips begin in it, in rising order.
    pub(super) fn onsets(&self) -> impl Iterator<Item = Micros> {
        self.label.onset().into_iter().chain(self.further.iter().copied())
    }

    /// What its stylus measures.
    pub(super) fn stylus(&self) -> StylusKind {
        let [own, _] = &self.seen;
        own.channels.stylus
    }

    /// Those that are judged with the same floors: kin of one material.
    pub(super) fn group(&self) -> (usize, &str) {
        (self.kin, &self.label.material)
    }

    /// Whether a pipeline for the one serves the other: the same stylus, at a rate within 1 %.
    fn is_kin(&self, other: &Self) -> bool {
        self.stylus() == other.stylus() && (self.rate_hz / other.rate_hz - 1.0).abs() < 0.01
    }

    /// Whether the rest of the one is a floor for the other. That of a stylus has bands, which follow the rate; the
    /// noise of taxels alone does not.
    pub(super) fn shares_rest(&self, other: &Self) -> bool {
        self.kin == other.kin
            || self.stylus() == StylusKind::Absent && other.stylus() == StylusKind::Absent
    }

    fn check_onset(&self, onset: Micros) -> Result<(), ScoreError> {
        let Some((first, last)) = self.span else { return Ok(()) };
        if (first..=last).contains(&onset) {
            return Ok(());
        }
        Err(ScoreError::OnsetOutside {
            recording: self.label.recording.clone(),
            onset_s: onset.as_seconds(),
            first_s: first.as_seconds(),
            last_s: last.as_seconds(),
        })
    }
}

/// Every labelled recording of a folder, in the order of the labels.
pub(super) struct Recordings {
    pub(super) all: Vec<Labelled>,
    /// The first recording of each rate and stylus, as a place in `all`.
    kins: Vec<usize>,
    options: CsvOptions,
    companions: bool,
    room: Room,
}

impl Recordings {
    /// Reads and checks all of them, as far as `detectors` want it; the rest before an onset ends `guard_ms` before it.
    pub(super) fn load(
        directory: &Path,
        options: &CsvOptions,
        detectors: &[Detector],
        guard_ms: f64,
        memory: Memory,
    ) -> Result<Self, ScoreError> {
        if !directory.is_dir() {
            return Err(ScoreError::NoFolder { directory: directory.to_owned() });
        }
        let labels = directory.join("labels.csv");
        if !labels.exists() {
            return Err(ScoreError::Unlabelled { file: labels });
        }
        let all_phases = read_phases(&directory.join("phases.csv"))?;
        let companions = detectors.iter().any(|detector| detector.companions);
        let own = detectors.iter().any(|detector| detector.decides == Decides::Own);
        let all_alarms =
            if own { read_alarms(&directory.join("alarms.csv"))? } else { Default::default() };
        let mut named: Vec<(Label, Vec<Micros>)> = Vec::new();
        for label in read_labels(&labels).map_err(|error| labels_error(&labels, error))? {
            match named.iter_mut().find(|(first, _)| first.recording == label.recording) {
                Some((_, further)) => further.extend(label.onset()),
                None => named.push((label, Vec::new())),
            }
        }
        // A name that is spelt wrongly would be a slip that was missed.
        let absent = |name: &str| !file(name, directory).exists();
        if let Some(alarm) = all_alarms.iter().flatten().find(|alarm| absent(&alarm.recording)) {
            let recording = alarm.recording.clone();
            return Err(ScoreError::Absent { file: directory.join("alarms.csv"), recording });
        }
        let room = Room::new(memory.open);
        let (whole, rests) = (Mutex::new(memory.kept), Mutex::new(memory.kept));
        let read = |(label, further): (Label, Vec<Micros>)| {
            let of = |phases: &Vec<Phase>| {
                let its = phases.iter().filter(|phase| phase.recording == label.recording);
                its.cloned().collect::<Vec<_>>()
            };
            let (phases, own) = (of(&all_phases), all_alarms.as_ref().map(of));
            let file = file(&label.recording, directory);
            let length = fs::metadata(&file).map_or(0, |file| file.len());
            let is_mcap = file.extension().is_some_and(|ending| ending == "mcap");
            let grows = if is_mcap { GROWS_MCAP } else { GROWS };
            let _place =
                room.take(usize::try_from(length).map_or(usize::MAX, |n| n.saturating_mul(grows)));
            let mut contents = Contents::read(&file, options, companions)?;
            let bytes = contents.bytes();
            let seen = [false, true].map(|companions| {
                let recording = contents.recording(companions);
                Seen { channels: recording.channels.clone(), taxels: recording.taxels.is_some() }
            });
            let Recording { samples, rate_hz, .. } = &contents.recording;
            let span = samples.first().zip(samples.last()).map(|(first, last)| (first.t, last.t));
            let rate_hz = *rate_hz;
            let fits = take(&whole, bytes);
            let is_whole = fits || contents.truncate(rest_until(&label, guard_ms));
            let is_kept = fits || take(&rests, contents.bytes());
            let kept = is_kept.then(|| Arc::new(contents));
            let one = Labelled {
                label,
                further,
                own,
                phases,
                file,
                seen,
                rate_hz,
                kin: 0,
                span,
                bytes,
                kept,
                is_whole,
            };
            one.onsets().try_for_each(|onset| one.check_onset(onset))?;
            Ok(one)
        };
        // In the order of their first labels: of several faults the first is reported.
        let all: Vec<Result<Labelled, ScoreError>> = named.into_par_iter().map(read).collect();
        let mut all = all.into_iter().collect::<Result<Vec<Labelled>, ScoreError>>()?;
        if all.is_empty() {
            return Err(ScoreError::Nothing { directory: directory.to_owned() });
        }
        let kins = sort_by_kin(&mut all);
        Ok(Self { all, kins, options: options.clone(), companions, room })
    }

    /// The first recording of each rate and stylus.
    pub(super) fn kins(&self) -> impl Iterator<Item = &Labelled> {
        self.kins.iter().filter_map(|place| self.all.get(*place))
    }

    /// A recording for as long as it is used; waits where others have to go first. One thread uses one at a time.
    pub(super) fn open(&self, one: &Labelled) -> Result<Open<'_>, ScoreError> {
        if let Some(kept) = one.kept.as_ref().filter(|_| one.is_whole) {
            return Ok(Open { contents: Arc::clone(kept), _place: None });
        }
        let place = self.room.take(one.bytes);
        let contents = Contents::read(&one.file, &self.options, self.companions)?;
        if contents.bytes() != one.bytes {
            return Err(ScoreError::Changed { recording: one.label.recording.clone() });
        }
        Ok(Open { contents: Arc::new(contents), _place: Some(place) })
    }

    /// The same for its labelled rest; what comes after may be missing.
    pub(super) fn open_rest(&self, one: &Labelled) -> Result<Open<'_>, ScoreError> {
        match &one.kept {
            Some(kept) => Ok(Open { contents: Arc::clone(kept), _place: None }),
            None => self.open(one),
        }
    }
}

/// A recording in use.
pub(super) struct Open<'a> {
    contents: Arc<Contents>,
    _place: Option<Place<'a>>,
}

impl core::ops::Deref for Open<'_> {
    type Target = Contents;

    fn deref(&self) -> &Contents {
        &self.contents
    }
}

/// Memory for the recordings in use.
struct Room {
    all: usize,
    free: Mutex<usize>,
    more: Condvar,
}

/// A part of it.
struct Place<'a> {
    room: &'a Room,
    bytes: usize,
}

impl Room {
    fn new(all: usize) -> Self {
        Self { all, free: Mutex::new(all), more: Condvar::new() }
    }

    /// Waits until so much is free; all of it for what is larger.
    fn take(&self, bytes: usize) -> Place<'_> {
        let bytes = bytes.min(self.all);
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.more.wait_while(free, |free| *free < bytes);
        *waited.unwrap_or_else(PoisonError::into_inner) -= bytes;
        Place { room: self, bytes }
    }
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        *self.room.free.lock().unwrap_or_else(PoisonError::into_inner) += self.bytes;
        self.room.more.notify_all();
    }
}

/// Takes so much of what is left, if it is.
fn take(left: &Mutex<usize>, bytes: usize) -> bool {
    let mut left = left.lock().unwrap_or_else(PoisonError::into_inner);
    let rest = left.checked_sub(bytes);
    *left = rest.unwrap_or(*left);
    rest.is_some()
}

/// `NAME.csv`, or `NAME.npz` or `NAME.mcap` where only that is there.
fn file(recording: &str, directory: &Path) -> PathBuf {
    let [csv, npz, mcap] =
        ["csv", "npz", "mcap"].map(|ending| directory.join(format!("{recording}.{ending}")));
    let whole = directory.join(recording);
    let others = [npz, mcap, whole].into_iter().find(|file| file.is_file());
    others.filter(|_| !csv.exists()).unwrap_or(csv)
}

/// What a recording would be asked to put on its first line is wrong advice for labels.
fn labels_error(file: &Path, error: LabelError) -> ScoreError {
    match error {
        LabelError::Table(error) if error.is_empty_file() => {
            ScoreError::Unlabelled { file: file.to_owned() }
        }
        LabelError::Table(CsvError::NoRows { .. }) => {
            ScoreError::Nothing { directory: file.parent().unwrap_or(file).to_owned() }
        }
        error => error.into(),
    }
}

/// Gives each its kin, and the place of the first of each.
fn sort_by_kin(all: &mut [Labelled]) -> Vec<usize> {
    let mut kins: Vec<usize> = Vec::new();
    for place in 0..all.len() {
        let known = kins.iter().position(|first| all[*first].is_kin(&all[place]));
        all[place].kin = known.unwrap_or(kins.len());
        if known.is_none() {
            kins.push(place);
        }
    }
    kins
}

/// Time up to which a recording is labelled as rest (s).
pub(super) fn rest_until(label: &Label, guard_ms: f64) -> f64 {
    match label.kind {
        LabelKind::Onset { at } => at.as_seconds() - 1e-3 * guard_ms,
        LabelKind::Rest => f64::INFINITY,
        LabelKind::Steady => f64::NEG_INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::{Contents, Room};
    use core::{
        fmt::Write as _,
        sync::atomic::{AtomicUsize, Ordering},
    };
    use grip_record::CsvOptions;
    use std::{fs, thread};

    #[test]
    fn taxels_of_a_file_beside_a_recording_count_as_memory() {
        let dir = tempfile::tempdir().unwrap();
        let (mut rows, mut frames) =
            ("t_s,vibration\n".to_owned(), "t_s,a,b,c,d,e,f,g,h\n".to_owned());
        for i in 0..100 {
            writeln!(rows, "{},1", f64::from(i) / 1000.0).unwrap();
            writeln!(frames, "{},1,1,1,1,1,1,1,1", f64::from(i) / 1000.0).unwrap();
        }
        let file = dir.path().join("a.csv");
        fs::write(&file, rows).unwrap();
        let bytes =
            |companions| Contents::read(&file, &CsvOptions::default(), companions).unwrap().bytes();
        let alone = bytes(false);
        fs::write(dir.path().join("a_taxels.csv"), frames).unwrap();
        assert_eq!(bytes(true), 2 * alone + 100 * 8 * 4);
    }

    #[test]
    fn no_more_is_in_use_than_there_is_room_and_what_is_larger_is_alone() {
        let (room, used) = (Room::new(1000), AtomicUsize::new(0));
        thread::scope(|threads| {
            for nth in 0..40 {
                let (room, used) = (&room, &used);
                threads.spawn(move || {
                    let bytes = if nth % 4 == 0 { 5000 } else { 300 };
                    let _place = room.take(bytes);
                    let taken = bytes.min(1000);
                    assert!(used.fetch_add(taken, Ordering::SeqCst) + taken <= 1000);
                    thread::yield_now();
                    used.fetch_sub(taken, Ordering::SeqCst);
                });
            }
        });
        assert_eq!(*room.free.lock().unwrap(), 1000);
    }
}
