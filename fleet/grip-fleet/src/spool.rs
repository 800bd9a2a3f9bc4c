//! Store of events, kept over an end of the daemon, with what an earlier run has left.
//!
//! Two files stand for a gripper, `UID.0.events` and `UID.1.events`. Records are put behind the others in one of them until it has
//! half of the room; then the other one begins anew. A file is `GRIPEV2\n`, its number (u64) and records: length of the frame (u16), number
//! and time of the event (24 bytes), frame, CRC-32C of all that (u32), little-endian. A kill costs nothing that was put there; a crash of the
//! machine may cost the end, which is cut off at the next start.

use crate::{
    id::{EventId, Stamp, WallTime},
    log::{EventLog, Logged},
    store::{self, StoreError, at, lock},
};
use core::mem;
use grip_link::crc::crc32c;
use grip_session::config::Uid;
use std::{
    fs::{File, OpenOptions},
    io::{self, Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
};

const MAGIC: [u8; 8] = *b"GRIPEV2\n";
/// Bytes before the first record.
const HEAD: usize = MAGIC.len() + 8;
/// Bytes of a record beside its frame.
const BESIDE: usize = 2 + Stamp::SIZE + 4;

/// A log that may be on disk too.
#[derive(Debug)]
pub struct Spool {
    log: EventLog,
    disk: Option<Disk>,
    trouble: Option<StoreError>,
}

impl Spool {
    /// Keeps events in memory only, at most `room` bytes.
    #[must_use]
    pub const fn in_memory(run: u32, room: usize) -> Self {
        Self { log: EventLog::new(run, room), disk: None, trouble: None }
    }

    /// Opens the events of a gripper for a new run, with what earlier runs have left; the folder is made where it is missing. `room`
    /// (bytes) is for both files. Where an earlier run had the number `run`, the next free one is taken.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn open(folder: &Path, uid: Uid, run: u32, room: usize) -> Result<Self, StoreError> {
        let (disk, events) = Disk::open(folder, uid, room as u64)?;
        let had = |run: u32| events.iter().any(|event| event.id.run == run);
        let run = (0..).map(|step| run.wrapping_add(step)).find(|run| !had(*run)).unwrap_or(run);
        let mut log = EventLog::new(run, room);
        events.into_iter().for_each(|event| log.restore(event));
        Ok(Self { log, disk: Some(disk), trouble: None })
    }

    /// As [`Spool::append_at`], for an event of which it is not known when it happened.
    pub fn append(&mut self, wire: Vec<u8>) -> EventId {
        self.append_at(wire, WallTime::default())
    }

    /// Numbers an event and keeps it. Where the disk refuses, it is kept in memory, and [`Spool::trouble`] states why.
    pub fn append_at(&mut self, wire: Vec<u8>, at: WallTime) -> EventId {
        if let Some(disk) = &mut self.disk
            && let Err(source) = disk.write(&record(self.log.head(), at, &wire))
        {
            self.trouble = Some(store::at(&disk.path(disk.generation))(source));
        }
        self.log.append_at(wire, at)
    }

    /// Leaves numbers out, as [`EventLog::skip`].
    pub const fn skip(&mut self, count: u64) {
        self.log.skip(count);
    }

    /// What has failed since it was asked last.
    pub fn trouble(&mut self) -> Option<StoreError> {
        mem::take(&mut self.trouble)
    }

    /// The events.
    #[must_use]
    pub const fn log(&self) -> &EventLog {
        &self.log
    }
}

/// The two files.
#[derive(Debug)]
struct Disk {
    folder: PathBuf,
    uid: Uid,
    file: File,
    /// The number of the file that is written; its last bit names it.
    generation: u64,
    written: u64,
    room: u64,
    _lock: File,
}

impl Disk {
    /// The files, and what they hold.
    fn open(folder: &Path, uid: Uid, room: u64) -> Result<(Self, Vec<Logged>), StoreError> {
        let by = "another gripd keeps the events of this gripper there";
        let lock = lock(folder, &format!("{uid}.lock"), by)?;
        let files = [path(folder, uid, 0), path(folder, uid, 1)];
        let mut halves = files.iter().map(|file| read(file)).collect::<Result<Vec<_>, _>>()?;
        halves.sort_by_key(|half| half.generation);
        let (generation, written) =
            halves.last().map_or((0, 0), |half| (half.generation, half.good));
        let name = path(folder, uid, generation);
        let file = continue_at(&name, written).map_err(at(&name))?;
        let folder = folder.to_owned();
        let mut disk = Self { folder, uid, file, generation, written, room, _lock: lock };
        if written < HEAD as u64 {
            disk.begin(1).map_err(at(&name))?;
        }
        Ok((disk, halves.into_iter().flat_map(|half| half.events).collect()))
    }

    fn path(&self, generation: u64) -> PathBuf {
        path(&self.folder, self.uid, generation)
    }

    fn write(&mut self, record: &[u8]) -> io::Result<()> {
        if self.written > HEAD as u64 && self.written + record.len() as u64 > self.room / 2 {
            self.begin(self.generation + 1)?;
        }
        let written = self.file.write_all(record);
        if written.is_ok() {
            self.written += record.len() as u64;
        } else {
            // Half a record would hide all that come behind it.
            self.file.set_len(self.written)?;
            self.file.seek(SeekFrom::Start(self.written))?;
        }
        written
    }

    /// Begins a file anew.
    fn begin(&mut self, generation: u64) -> io::Result<()> {
        let mut file = continue_at(&self.path(generation), 0)?;
        file.write_all(&[MAGIC, generation.to_le_bytes()].concat())?;
        (self.file, self.generation, self.written) = (file, generation, HEAD as u64);
        Ok(())
    }
}

fn path(folder: &Path, uid: Uid, generation: u64) -> PathBuf {
    folder.join(format!("{uid}.{}.events", generation % 2))
}

/// Opens a file for writing behind its first `len` bytes; what stands there is cut off.
fn continue_at(path: &Path, len: u64) -> io::Result<File> {
    let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(path)?;
    file.set_len(len)?;
    file.seek(SeekFrom::End(0))?;
    Ok(file)
}

/// A record: the event behind `head`.
fn record(head: EventId, at: WallTime, wire: &[u8]) -> Vec<u8> {
    let id = EventId { seq: head.seq + 1, ..head };
    // A frame has at most 500 bytes.
    let len = u16::try_from(wire.len()).unwrap_or(u16::MAX);
    let mut record = Vec::with_capacity(wire.len() + BESIDE);
    record.extend_from_slice(&len.to_le_bytes());
    record.extend_from_slice(&Stamp { id, at }.to_bytes());
    record.extend_from_slice(wire);
    record.extend_from_slice(&crc32c(&record).to_le_bytes());
    record
}

/// What one file holds.
#[derive(Debug, Default)]
struct Half {
    generation: u64,
    events: Vec<Logged>,
    /// Bytes up to the last whole record.
    good: u64,
}

fn read(path: &Path) -> Result<Half, StoreError> {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|mut file| file.read_to_end(&mut bytes));
    match read {
        Ok(_) => Ok(parse(&bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Half::default()),
        Err(source) => Err(at(path)(source)),
    }
}

/// Whole records up to the first damaged one.
fn parse(bytes: &[u8]) -> Half {
    let head = bytes.strip_prefix(&MAGIC).and_then(|rest| rest.split_first_chunk::<8>());
    let Some((generation, mut rest)) = head else { return Half::default() };
    let mut half =
        Half { generation: u64::from_le_bytes(*generation), good: HEAD as u64, events: Vec::new() };
    while let Some((event, size, behind)) = first(rest) {
        half.events.push(event);
        half.good += size as u64;
        rest = behind;
    }
    half
}

/// The first record, its size, and what stands behind it.
fn first(bytes: &[u8]) -> Option<(Logged, usize, &[u8])> {
    let (len, _) = bytes.split_first_chunk::<2>()?;
    let size = usize::from(u16::from_le_bytes(*len)) + BESIDE;
    let (record, behind) = bytes.split_at_checked(size)?;
    let (covered, crc) = record.split_last_chunk::<4>()?;
    if crc32c(covered) != u32::from_le_bytes(*crc) {
        return None;
    }
    let (stamp, wire) = covered.get(2..)?.split_at_checked(Stamp::SIZE)?;
    let Stamp { id, at } = Stamp::from_bytes(stamp)?;
    Some((Logged { id, at, wire: wire.to_vec() }, size, behind))
}

#[cfg(test)]
mod tests {
    use super::{EventId, HEAD, Spool, StoreError, Uid, WallTime};
    use std::{fs, path::Path};

    const UID: Uid = Uid([3; 16]);
    const ROOM: usize = 1 << 20;
    const AT: WallTime = WallTime { ns: 1_700_000_000_123_456_789, error_us: 20 };

    fn fill(folder: &Path, run: u32, events: u8) -> Spool {
        let mut spool = Spool::open(folder, UID, run, ROOM).unwrap();
        for event in 0..events {
            spool.append_at(vec![event; 20], AT);
        }
        assert!(spool.trouble().is_none());
        spool
    }

    fn ids(spool: &Spool) -> Vec<(u32, u64)> {
        spool.log().from(0).map(|event| (event.id.run, event.id.seq)).collect()
    }

    #[test]
    fn the_next_run_finds_what_the_last_one_left() {
        let folder = tempfile::tempdir().unwrap();
        drop(fill(folder.path(), 1, 2));
        drop(fill(folder.path(), 2, 0));
        let spool = fill(folder.path(), 3, 1);
        assert_eq!(ids(&spool), [(1, 1), (1, 2), (3, 1)]);
        let wires: Vec<u8> = spool.log().from(0).map(|event| event.wire[0]).collect();
        assert_eq!(wires, [0, 1, 0]);
        assert!(spool.log().from(0).all(|event| event.at == AT), "when they happened too");
        drop(spool);
        assert_eq!(fill(folder.path(), 1, 0).log().head().run, 2, "a clock that was set back");
    }

    #[test]
    fn a_damaged_end_is_cut_off_and_written_over() {
        for cut in 1..70 {
            let folder = tempfile::tempdir().unwrap();
            drop(fill(folder.path(), 1, 3));
            let file = folder.path().join(format!("{UID}.1.events"));
            let bytes = fs::read(&file).unwrap();
            assert_eq!(bytes.len(), HEAD + 3 * 50);
            fs::write(&file, &bytes[..bytes.len() - cut]).unwrap();
            let left = 3 - u64::try_from(cut.div_ceil(50)).unwrap();
            drop(fill(folder.path(), 2, 1));
            let spool = fill(folder.path(), 4, 0);
            let mut wanted: Vec<(u32, u64)> = (1..=left).map(|seq| (1, seq)).collect();
            wanted.push((2, 1));
            assert_eq!(ids(&spool), wanted, "{cut} bytes less");
        }
    }

    #[test]
    fn rubbish_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["0", "1"] {
            fs::write(folder.path().join(format!("{UID}.{name}.events")), "rubbish").unwrap();
        }
        assert_eq!(ids(&fill(folder.path(), 1, 1)), [(1, 1)]);
        assert_eq!(ids(&fill(folder.path(), 2, 1)), [(1, 1), (2, 1)]);
    }

    #[test]
    fn the_room_is_never_exceeded_and_the_newest_stay() {
        let folder = tempfile::tempdir().unwrap();
        let room = 1300;
        for run in 1..4 {
            let mut spool = Spool::open(folder.path(), UID, run, room).unwrap();
            for _ in 0..100 {
                spool.append(vec![7; 20]);
                let size: u64 = fs::read_dir(folder.path())
                    .unwrap()
                    .map(|entry| entry.unwrap().metadata().unwrap().len())
                    .sum();
                assert!(size <= room as u64, "{size} bytes");
            }
            assert!(spool.trouble().is_none());
        }
        let spool = Spool::open(folder.path(), UID, 9, room).unwrap();
        let ids = ids(&spool);
        assert!(ids.len() >= 12, "{ids:?}");
        assert_eq!(ids.last(), Some(&(3, 100)));
        assert!(ids.windows(2).all(|pair| pair[0].1 + 1 == pair[1].1), "{ids:?}");
    }

    #[test]
    fn one_daemon_at_a_time_and_folders_that_cannot_be() {
        let folder = tempfile::tempdir().unwrap();
        let first = fill(folder.path(), 1, 1);
        let second = Spool::open(folder.path(), UID, 2, ROOM).unwrap_err();
        assert!(matches!(second, StoreError::Locked { .. }), "{second}");
        drop(first);
        assert_eq!(fill(folder.path(), 2, 0).log().head(), EventId { run: 2, seq: 0 });
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let wrong = Spool::open(&file, UID, 1, ROOM).unwrap_err().to_string();
        assert!(wrong.starts_with(&file.display().to_string()), "{wrong}");
    }
}
