//! Reader of a topic: its messages as a stream of numbers.

use crate::{
    error::ImportError,
    json,
    ros::{Decoder, Leaves},
    stream::{Room, Stream, Times, joined, reading},
    zstd::unpack,
};
use std::{collections::HashMap, path::Path};

/// How a frame of zstd begins, and how long a message in one may be (bytes).
const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";
const MOST_UNPACKED: u64 = 64 << 20;
/// Most signals of one topic.
const MOST_SIGNALS: usize = 1024;

/// Topic, type and definition: what makes two channels one.
type Key = (String, String, Vec<u8>);

/// The topics of a recording, whatever their numbers in its files.
#[derive(Debug, Default)]
pub(crate) struct Topics {
    keys: HashMap<Key, usize>,
    /// `None` where the topic cannot be read.
    all: Vec<Option<Topic>>,
    notes: Vec<String>,
    room: Room,
}

impl Topics {
    /// The place of a topic; `make` reads its type the first time.
    pub(crate) fn place(
        &mut self,
        key: Key,
        make: impl FnOnce() -> Result<Topic, String>,
    ) -> Option<usize> {
        let at = self.keys.get(&key).copied().unwrap_or_else(|| {
            self.all
                .push(make().map_err(|fault| self.notes.push(format!("{} {fault}", key.0))).ok());
            self.keys.insert(key, self.all.len() - 1);
            self.all.len() - 1
        });
        self.all.get(at).is_some_and(Option::is_some).then_some(at)
    }

    /// Takes the next message of the topic at this place.
    ///
    /// # Errors
    /// Where there is no room for more numbers.
    pub(crate) fn push(
        &mut self,
        file: &Path,
        at: usize,
        log_ns: i64,
        data: &[u8],
    ) -> Result<(), ImportError> {
        match self.all.get_mut(at) {
            Some(Some(topic)) => topic.push(file, &mut self.room, log_ns, data),
            _ => Ok(()),
        }
    }

    pub(crate) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// What was read.
    ///
    /// # Errors
    /// Where no topic can be read.
    pub(crate) fn finish(self, file: &Path) -> Result<Vec<Stream>, ImportError> {
        let mut streams = joined(self.all.into_iter().flatten().map(Topic::finish).collect());
        let Some(first) = streams.first_mut() else {
            let what = match self.notes.is_empty() {
                true => "it has no topics with messages".to_owned(),
                false => format!("no topic can be read: {}", self.notes.join("; ")),
            };
            return Err(ImportError::nothing(file, &what));
        };
        first.notes.extend(self.notes);
        Ok(streams)
    }
}

/// How its messages are read.
#[derive(Debug)]
enum Kind {
    Ros { decoder: Box<Decoder>, leaves: Leaves, places: Vec<Place>, shape: Option<Vec<usize>> },
    Json,
}

/// Where a number of a message goes.
#[derive(Clone, Copy, Debug)]
enum Place {
    Signal(usize),
    StampSeconds,
    StampNanos,
    Nowhere,
}

/// A topic that is being read.
#[derive(Debug)]
pub(crate) struct Topic {
    kind: Kind,
    stream: Stream,
    places: HashMap<String, usize>,
    log_ns: Vec<i64>,
    stamps: Vec<i64>,
    bad: usize,
    first_fault: String,
}

/// The header of a message, as the time of its readings.
const STAMPS: [(&str, Place); 4] = [
    ("header.stamp.sec", Place::StampSeconds),
    ("header.stamp.nanosec", Place::StampNanos),
    ("stamp.sec", Place::StampSeconds),
    ("stamp.nanosec", Place::StampNanos),
];

impl Topic {
    /// A topic of ROS 2 messages of this type.
    ///
    /// # Errors
    /// As [`Decoder::new`].
    pub(crate) fn ros(topic: &str, kind: &str, definition: &str) -> Result<Self, String> {
        let decoder = Box::new(Decoder::new(kind, definition)?);
        let (leaves, places) = (Leaves::default(), Vec::new());
        Ok(Self::new(topic, Kind::Ros { decoder, leaves, places, shape: None }))
    }

    /// A topic of JSON messages.
    pub(crate) fn json(topic: &str) -> Self {
        Self::new(topic, Kind::Json)
    }

    fn new(topic: &str, kind: Kind) -> Self {
        Self {
            kind,
            stream: Stream::new(topic, Vec::new()),
            places: HashMap::new(),
            log_ns: Vec::new(),
            stamps: Vec::new(),
            bad: 0,
            first_fault: String::new(),
        }
    }

    /// Takes the next message; one that cannot be read is counted.
    ///
    /// # Errors
    /// Where there is no room for more numbers.
    pub(crate) fn push(
        &mut self,
        file: &Path,
        room: &mut Room,
        log_ns: i64,
        data: &[u8],
    ) -> Result<(), ImportError> {
        let rows = self.log_ns.len();
        // A bag may pack each message by itself; neither CDR nor JSON begins so.
        let unpacked = data.starts_with(ZSTD).then(|| unpack("zstd", data, MOST_UNPACKED));
        let data = match &unpacked {
            Some(Ok(data)) => data,
            _ => data,
        };
        let mut row =
            Row { topic: &mut self.stream, places: &mut self.places, rows, stamp: [0; 2] };
        let numbers = match &mut self.kind {
            Kind::Json => row.json(data),
            Kind::Ros { decoder, leaves, places, shape } => {
                decoder.decode(data, leaves).and_then(|()| {
                    if shape.as_ref() != Some(&leaves.shape) {
                        let paths = decoder.paths(data)?;
                        *places = paths.iter().map(|path| row.place(path)).collect();
                        *shape = Some(leaves.shape.clone());
                    }
                    Ok(places.iter().copied().zip(leaves.values.iter().copied()).collect())
                })
            }
        };
        let numbers: Vec<(Place, f64)> = match numbers {
            Ok(numbers) => numbers,
            Err(fault) => {
                if self.bad == 0 {
                    self.first_fault = fault;
                }
                self.bad += 1;
                return Ok(());
            }
        };
        for (place, value) in numbers {
            row.put(place, value);
        }
        let [seconds, nanos] = row.stamp;
        let width = self.stream.names.len();
        room.take(file, width + 4)?;
        for values in &mut self.stream.values {
            values.resize(rows + 1, f32::NAN);
        }
        self.log_ns.push(log_ns);
        self.stamps.push(seconds.saturating_mul(1_000_000_000).saturating_add(nanos));
        Ok(())
    }

    /// What was read.
    pub(crate) fn finish(mut self) -> Stream {
        let stamped = self.stamps.iter().any(|stamp| *stamp != 0);
        let (clock, times) = if stamped {
            ("stamps of the headers", self.stamps)
        } else {
            ("log times", self.log_ns)
        };
        self.stream.clock = clock.to_owned();
        self.stream.times = Times::Stamps(times);
        let prefix = self.stream.topic.clone();
        for name in &mut self.stream.names {
            *name = format!("{prefix}.{name}");
        }
        if self.bad > 0 {
            let text =
                format!("{prefix}: {} messages could not be read ({})", self.bad, self.first_fault);
            self.stream.notes.push(text);
        }
        self.stream
    }
}

/// The row of a message.
struct Row<'a> {
    topic: &'a mut Stream,
    places: &'a mut HashMap<String, usize>,
    rows: usize,
    stamp: [i64; 2],
}

impl Row<'_> {
    fn place(&mut self, path: &str) -> Place {
        if let Some((_, place)) = STAMPS.iter().find(|(stamp, _)| *stamp == path) {
            return *place;
        }
        if let Some(at) = self.places.get(path) {
            return Place::Signal(*at);
        }
        if self.places.len() >= MOST_SIGNALS {
            return Place::Nowhere;
        }
        let at = self.topic.place(path, self.rows);
        self.places.insert(path.to_owned(), at);
        Place::Signal(at)
    }

    fn json(&mut self, data: &[u8]) -> Result<Vec<(Place, f64)>, String> {
        let value = serde_json::from_slice(data).map_err(|error| error.to_string())?;
        let mut numbers = Vec::new();
        json::leaves(&value, &mut String::new(), &mut |path, value| {
            numbers.push((self.place(path), value));
        });
        Ok(numbers)
    }

    #[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
    fn put(&mut self, place: Place, value: f64) {
        match place {
            Place::Signal(at) => {
                if let Some(values) = self.topic.values.get_mut(at) {
                    values.resize(self.rows, f32::NAN);
                    values.push(reading(value));
                }
            }
            Place::StampSeconds => self.stamp[0] = value as i64,
            Place::StampNanos => self.stamp[1] = value as i64,
            Place::Nowhere => {}
        }
    }
}
