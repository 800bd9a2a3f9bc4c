//! A rosbag2 of the SQLite storage in: a stream for each topic with ROS 2 messages.

use crate::{
    ImportOptions,
    error::ImportError,
    topic::{Topic, Topics},
};
use grip_record::files;
use rusqlite::{Connection, OpenFlags, config::DbConfig, limits::Limit};
use std::{collections::BTreeMap, io::Read as _, path::Path};

/// Longest message, text or row (bytes); rosbag2 writes some kB.
const LONGEST: i32 = 1 << 26;
/// Steps of SQLite's machine between two looks at how many were taken, and most steps for each byte of the file: reading takes a few.
const STEPS: i32 = 100_000;
const STEPS_A_BYTE: u64 = 100;
/// Most topics with messages that are read at once: each takes some 14 kB.
const MOST_TOPICS: usize = 10_000;

pub(crate) fn read(
    file: &Path,
    options: &ImportOptions,
    topics: &mut Topics,
) -> Result<(), ImportError> {
    let mut magic = [0; 16];
    let opened = files::open(file).and_then(|mut input| {
        input.read_exact(&mut magic)?;
        Ok(input.metadata()?.len())
    });
    let size = opened.map_err(ImportError::unreadable(file))?;
    let unusable = |error: rusqlite::Error| {
        ImportError::nothing(file, &format!("is no rosbag2 that can be read: {error}"))
    };
    if &magic != b"SQLite format 3\0" {
        return Err(ImportError::nothing(file, "is no SQLite file, which a rosbag2 .db3 is"));
    }
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let mut bag = Connection::open_with_flags(file, flags).map_err(unusable)?;
    bound(&mut bag, size).map_err(unusable)?;
    for name in ["topics", "messages"] {
        if !is_table(&bag, name) {
            return Err(ImportError::nothing(
                file,
                &format!("is no rosbag2: it has no table {name}"),
            ));
        }
    }
    let Some(places) = places(&bag, options, topics).map_err(unusable)? else {
        let what = format!(
            "has messages of more than {MOST_TOPICS} topics; choose some with --topic NAME"
        );
        return Err(ImportError::nothing(file, &what));
    };
    let mut rows = bag
        .prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp")
        .map_err(unusable)?;
    let mut rows = rows.query([]).map_err(unusable)?;
    while let Some(row) = rows.next().map_err(unusable)? {
        let (id, ns): (i64, i64) = (row.get(0).map_err(unusable)?, row.get(1).map_err(unusable)?);
        if let Some(at) = places.get(&id) {
            let data = row.get_ref(2).map_err(unusable)?;
            topics.push(file, *at, ns, data.as_blob().unwrap_or_default())?;
        }
    }
    Ok(())
}

/// A file can ask for any work and memory: texts and blobs of 2 GB, pages that stand for each other.
fn bound(bag: &mut Connection, size: u64) -> rusqlite::Result<()> {
    bag.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    bag.set_limit(Limit::SQLITE_LIMIT_LENGTH, LONGEST)?;
    let mut left = 1000 + size.saturating_mul(STEPS_A_BYTE) / u64::from(STEPS.unsigned_abs());
    let ends = move || {
        left = left.saturating_sub(1);
        left == 0
    };
    bag.progress_handler(STEPS, Some(ends))
}

/// Whether `name` is a table with pages of its own. A view may have rows without end.
fn is_table(bag: &Connection, name: &str) -> bool {
    let text =
        "SELECT count(*) FROM sqlite_schema WHERE name = ?1 AND type = 'table' AND rootpage > 0";
    bag.query_row(text, [name], |row| row.get::<_, i64>(0)).is_ok_and(|found| found == 1)
}

/// The topics with messages that can be read, by their number; `None` where they are too many.
fn places(
    bag: &Connection,
    options: &ImportOptions,
    topics: &mut Topics,
) -> rusqlite::Result<Option<BTreeMap<i64, usize>>> {
    let definitions = definitions(bag);
    let (mut places, mut chosen) = (BTreeMap::new(), 0);
    let text = "SELECT id, name, type, serialization_format FROM topics \
                WHERE id IN (SELECT topic_id FROM messages) ORDER BY id";
    let mut rows = bag.prepare(text)?;
    let mut rows = rows.query([])?;
    while let Some(row) = rows.next()? {
        let (name, kind, format): (String, String, String) =
            (row.get(1)?, row.get(2)?, row.get(3)?);
        if !(options.topics.is_empty() || options.topics.contains(&name)) {
            continue;
        }
        chosen += 1;
        if chosen > MOST_TOPICS {
            return Ok(None);
        }
        let definition = definitions.get(&kind).map_or("", String::as_str);
        let key = (name.clone(), format!("{format} {kind}"), definition.as_bytes().to_vec());
        let place = topics.place(key, || match format.as_str() {
            "cdr" => Topic::ros(&name, &kind, definition),
            _ => Err(format!("is serialised as {format:?}; cdr is read")),
        });
        if let Some(at) = place {
            places.insert(row.get(0)?, at);
        }
    }
    Ok(Some(places))
}

/// Definitions by type, where the bag carries them.
fn definitions(bag: &Connection) -> BTreeMap<String, String> {
    let text = "SELECT topic_type, encoded_message_definition FROM message_definitions WHERE encoding = 'ros2msg'";
    let prepared = bag.prepare(text).ok().filter(|_| is_table(bag, "message_definitions"));
    let Some(mut rows) = prepared else { return BTreeMap::new() };
    let found = rows.query_map([], |row| Ok((row.get(0)?, row.get(1)?)));
    found.map(|rows| rows.flatten().collect()).unwrap_or_default()
}
