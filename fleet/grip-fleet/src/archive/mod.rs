//! Archive of events and HEALTH of many grippers in MCAP files of JSON messages, one or more a day (UTC); each event once, through kills. No network
//! and no clock.
//!
//! A folder holds finished files, `2026-11-26.mcap`, `2026-11-26-0001.mcap`, .., at most one that is being written, `..mcap.part`, and
//! `archive.json`: which file that is, how many of its bytes count, and the last event of each run of each gripper in all files. Bytes are on disk
//! before that file reports it, and it is replaced as a whole. What a kill left behind these bytes is cut off at the next start; the grippers are asked
//! for its events again, from where `archive.json` stands.

use crate::{
    follower::{Follower, Since, Verdict},
    id::{EventId, Stamp},
    json,
    key::Member,
    message::Message,
    store::{StoreError, at, content, lock, read, rename, write},
};
use grip_record::mcap::{JsonTimes, JsonWriter, McapWriteError, Recovered, no_unpack, recover};
use grip_session::{exit::message, utc};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{self, BufWriter, Read as _, Write as _},
    path::{Path, PathBuf},
};

/// A file of more bytes is finished, and the next one of the day begun: its index is in memory until then, and takes no more than it.
const LARGEST: u64 = 128 << 20;
const STATE: &str = "archive.json";
/// Messages of one kind: the end of their topic, the name of their JSON Schema and that schema.
#[derive(Clone, Copy, Debug)]
struct Kind {
    topic: &'static str,
    name: &'static str,
    schema: &'static str,
}

const EVENT: Kind =
    Kind { topic: "events", name: "grip.Event", schema: include_str!("event.schema.json") };
const HEALTH: Kind =
    Kind { topic: "health", name: "grip.Health", schema: include_str!("health.schema.json") };

/// Where the archive stands.
#[derive(Debug, Default, Serialize, Deserialize)]
struct State {
    /// The file that is being written, and how many of its bytes count.
    file: Option<String>,
    bytes: u64,
    /// The last event of each run, by gripper.
    received: BTreeMap<Member, Vec<EventId>>,
}

/// The file that is being written.
#[derive(Debug)]
struct Open {
    day: String,
    name: String,
    writer: JsonWriter<BufWriter<File>>,
    /// The same file, to sync it.
    file: File,
}

/// A folder of files by day.
#[derive(Debug)]
pub struct Archive {
    folder: PathBuf,
    program: String,
    state: State,
    followers: BTreeMap<Member, Follower>,
    open: Option<Open>,
    recovered: Option<(PathBuf, Recovered)>,
    /// What was written since the last commit: anything, and events.
    written: bool,
    events: bool,
    _lock: File,
}

impl Archive {
    /// Opens a folder, which is made where it is missing, and finishes what a kill has left. `program` names who writes, with its version.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn open(folder: &Path, program: &str) -> Result<Self, StoreError> {
        let lock = lock(folder, "archive.lock", "another archive is being written there")?;
        let path = folder.join(STATE);
        let state: State = read(&path)?;
        let resumed = |ids: &Vec<EventId>| Follower::resumed(Since::Start, ids.iter().copied());
        let followers = state.received.iter().map(|(member, ids)| (member.clone(), resumed(ids)));
        let followers = followers.collect();
        let mut archive = Self {
            folder: folder.to_owned(),
            program: program.to_owned(),
            state,
            followers,
            open: None,
            recovered: None,
            written: false,
            events: false,
            _lock: lock,
        };
        archive.finish_left()?;
        Ok(archive)
    }

    /// The last event of each run of each gripper, to go on from.
    pub fn received(&self) -> impl Iterator<Item = (Member, Vec<EventId>)> {
        self.followers.iter().map(|(member, it)| (member.clone(), it.received().collect()))
    }

    /// The file that a kill had left, and what was saved of it: everything, unless the disk has damaged it.
    #[must_use]
    pub const fn recovered(&self) -> Option<&(PathBuf, Recovered)> {
        self.recovered.as_ref()
    }

    /// Whether there are events that a kill would cost now: they are asked for again then.
    #[must_use]
    pub const fn has_events_open(&self) -> bool {
        self.events
    }

    /// Writes an event at a time (ns since 1970), unless it is there already; before it how many are `missing`.
    ///
    /// # Errors
    /// [`StoreError`]: nothing more can be written then.
    pub fn event(
        &mut self,
        now_ns: u64,
        member: &Member,
        stamp: Stamp,
        missing: u64,
        message: &Message,
    ) -> Result<(), StoreError> {
        let follower = self.followers.entry(member.clone());
        let follower = follower.or_insert_with(|| Follower::new(Since::Start));
        if follower.answer(stamp.id) == Verdict::Known {
            return Ok(());
        }
        let ids = follower.received().collect();
        if missing > 0 {
            let what =
                BTreeMap::from([("type", Value::from("missing")), ("events", missing.into())]);
            let json =
                json::object(member, None, &what).map(|object| Value::from(object).to_string());
            let json = json.map_err(|error| content(&self.folder, &error))?;
            self.write(now_ns, member, EVENT, stamp, &json)?;
        }
        let json = json::of_message(member, stamp, message);
        let json = json.map_err(|error| content(&self.folder, &error))?;
        self.write(now_ns, member, EVENT, stamp, &json)?;
        self.state.received.insert(member.clone(), ids);
        self.events = true;
        Ok(())
    }

    /// Writes HEALTH.
    ///
    /// # Errors
    /// [`StoreError`]: nothing more can be written then.
    pub fn health(
        &mut self,
        now_ns: u64,
        member: &Member,
        stamp: Stamp,
        message: &Message,
    ) -> Result<(), StoreError> {
        let json = json::of_message(member, stamp, message);
        let json = json.map_err(|error| content(&self.folder, &error))?;
        self.write(now_ns, member, HEALTH, stamp, &json)
    }

    /// Puts everything on disk: a kill costs nothing of it from here on.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn commit(&mut self) -> Result<(), StoreError> {
        if let Some(open) = self.open.as_mut().filter(|_| self.written) {
            let part = part(&self.folder, &open.name);
            open.writer.flush().map_err(in_mcap(&part))?;
            open.file.sync_data().map_err(at(&part))?;
            self.state.file = Some(open.name.clone());
            self.state.bytes = open.writer.bytes();
            self.save()?;
            (self.written, self.events) = (false, false);
        }
        Ok(())
    }

    /// Finishes the file that is being written; the next message begins another one.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn close(&mut self) -> Result<(), StoreError> {
        self.commit()?;
        let Some(open) = self.open.take() else { return Ok(()) };
        let part = part(&self.folder, &open.name);
        open.writer.finish().map_err(in_mcap(&part))?;
        rename(&part, &open.file, &self.folder, &open.name)?;
        self.settle()
    }

    /// A message in the file of its day.
    fn write(
        &mut self,
        log_ns: u64,
        member: &Member,
        kind: Kind,
        stamp: Stamp,
        json: &str,
    ) -> Result<(), StoreError> {
        let day = utc::day(log_ns / 1_000_000_000);
        let goes_on = |open: &Open| open.day == day && open.writer.bytes() < LARGEST;
        if !self.open.as_ref().is_some_and(goes_on) {
            self.close()?;
            self.begin(day)?;
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        let publish_ns = if stamp.at.ns > 0 { stamp.at.ns } else { log_ns };
        let wrong = in_mcap(&part(&self.folder, &open.name));
        let channel =
            open.writer.channel(&format!("/{member}/{}", kind.topic), kind.name, kind.schema);
        let times = JsonTimes { log_ns, publish_ns };
        channel.and_then(|channel| open.writer.write(channel, times, json)).map_err(wrong)?;
        self.written = true;
        Ok(())
    }

    /// Begins the next file of a day; what a kill has left of it before its first commit is replaced.
    fn begin(&mut self, day: String) -> Result<(), StoreError> {
        let names = (0..).map(|number: u32| match number {
            0 => format!("{day}.mcap"),
            _ => format!("{day}-{number:04}.mcap"),
        });
        let free = |name: &String| !self.folder.join(name).exists();
        let name = names.into_iter().find(free).unwrap_or_default();
        let part = part(&self.folder, &name);
        let file = File::create(&part).map_err(at(&part))?;
        let out = BufWriter::new(file.try_clone().map_err(at(&part))?);
        let writer = JsonWriter::new(out, &self.program).map_err(in_mcap(&part))?;
        self.open = Some(Open { day, name, writer, file });
        Ok(())
    }

    /// Makes a whole file of what a kill has left.
    fn finish_left(&mut self) -> Result<(), StoreError> {
        let Some(name) = self.state.file.clone() else { return Ok(()) };
        let left = part(&self.folder, &name);
        match File::open(&left) {
            Ok(input) => {
                let whole = self.folder.join(format!("{name}.whole"));
                let out = File::create(&whole).map_err(at(&whole))?;
                let input = io::BufReader::new(input).take(self.state.bytes);
                let mut buffered = BufWriter::new(&out);
                let saved = recover(&left, input, &mut buffered, &self.program, no_unpack)
                    .map_err(|error| content(&left, &message(&error)))?;
                buffered.flush().map_err(at(&whole))?;
                drop(buffered);
                rename(&whole, &out, &self.folder, &name)?;
                fs::remove_file(&left).map_err(at(&left))?;
                self.recovered = Some((self.folder.join(&name), saved));
            }
            // It was finished, and the kill came before the state was written.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(source) => return Err(at(&left)(source)),
        }
        self.settle()
    }

    /// No file is being written.
    fn settle(&mut self) -> Result<(), StoreError> {
        (self.state.file, self.state.bytes) = (None, 0);
        self.save()
    }

    fn save(&self) -> Result<(), StoreError> {
        let state = serde_json::to_vec(&self.state);
        write(&self.folder, STATE, &state.map_err(|error| content(&self.folder, &error))?)
    }
}

/// The name of a file that is not whole yet.
fn part(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.part"))
}

fn in_mcap(path: &Path) -> impl Fn(McapWriteError) -> StoreError + use<> {
    let path = path.to_owned();
    move |error| content(&path, &message(&error))
}

#[cfg(test)]
mod tests;
