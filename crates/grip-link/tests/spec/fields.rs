//! The field tables read every vector right: offset, type and name of each field.

use crate::markdown::{Row, headings, table, tables};
use crate::table::rows;
use crate::targets::words::{hex, unhex};
use grip_link::crc::crc32c;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::message::daemon::{Appended, Health, PipelineState, SlipReport};
use std::collections::BTreeMap;

/// A frame of valid.tsv.
pub(crate) struct Vector {
    pub(crate) name: String,
    pub(crate) ack_req: bool,
    case: String,
    fields: BTreeMap<String, String>,
    payload: Vec<u8>,
}

/// All frames that a writer of this version makes.
pub(crate) fn frames() -> Vec<Vector> {
    let made = [rows::<7>("valid.tsv"), rows::<7>("clients.tsv")].concat().into_iter();
    made.filter(|row| row[1] == "both" && row[2] != "cobs")
        .map(|[case, _, way, name, head, fields, wire]| {
            let role = match way.as_str() {
                "to_device" => Role::Device,
                "to_daemon" => Role::Daemon,
                _ => Role::Tap,
            };
            let session = head.split("session=").nth(1).unwrap().parse().unwrap();
            let mut decoder = Decoder::new(role);
            decoder.open_session(session, None);
            let wire = unhex(&wire);
            let Some(Verdict::Frame(frame)) = decoder.next(&mut &wire[..]) else {
                panic!("{case}")
            };
            let pairs = fields.split(' ').filter(|word| *word != "-");
            let own = |(name, value): (&str, &str)| (name.to_owned(), value.to_owned());
            Vector {
                name,
                ack_req: head.contains("ack_req=1"),
                case,
                fields: pairs.map(|word| own(word.split_once('=').unwrap())).collect(),
                payload: frame.payload.to_vec(),
            }
        })
        .collect()
}

fn heading(name: &str) -> &'static str {
    let found: Vec<_> = headings("### ")
        .into_iter()
        .filter(|line| line.split(' ').nth(2) == Some(name) && line.split(' ').count() == 3)
        .filter(|line| line[4..].len() > 2 && u8::from_str_radix(&line[4..6], 16).is_ok())
        .collect();
    assert_eq!(found.len(), 1, "{name}");
    found[0]
}

/// Rows with a number as offset and size, one after the other without holes; an appended table goes on where the first ends.
fn fixed(name: &str, table: &[Row]) -> Vec<(usize, usize, Row)> {
    let fixed: Vec<_> = table
        .iter()
        .filter_map(|row| Some((row[0].parse().ok()?, row[1].parse().ok()?, row.clone())))
        .collect();
    let mut end = match name {
        "HEALTH appended" => Health::SIZE,
        "SLIP appended" => SlipReport::SIZE,
        "STATE appended" => PipelineState::SIZE,
        _ => 0,
    };
    for (at, size, row) in &fixed {
        assert_eq!(*at, end, "{name}: {row:?}");
        end = at + size;
    }
    fixed
}

/// A field as valid.tsv writes it.
fn read(kind: &str, bytes: &[u8]) -> String {
    let mut wide = [0; 8];
    wide[..bytes.len().min(8)].copy_from_slice(&bytes[..bytes.len().min(8)]);
    let value = u64::from_le_bytes(wide);
    let bits = match kind {
        "u8" => 8,
        "u16" => 16,
        "u32" | "i32" => 32,
        "f32" => return hex(&bytes.iter().rev().copied().collect::<Vec<_>>()),
        "u64" => 64,
        "u8[16]" | "u8[32]" => return hex(bytes),
        "u64[24]" => return counts(bytes),
        "i64" => 64,
        other => panic!("no type {other}"),
    };
    assert_eq!(bytes.len() * 8, bits, "{kind}");
    match kind {
        "i32" => i32::from_le_bytes(bytes.try_into().unwrap()).to_string(),
        "i64" => value.cast_signed().to_string(),
        _ => value.to_string(),
    }
}

fn counts(bytes: &[u8]) -> String {
    assert_eq!(bytes.len(), 192);
    let words =
        bytes.chunks(8).map(|word| u64::from_le_bytes(word.try_into().unwrap()).to_string());
    words.collect::<Vec<_>>().join(",")
}

/// Reads `payload` by a table; what the vectors name is compared and taken out of `left`.
fn compare(vector: &Vector, table: &[Row], payload: &[u8], left: &mut BTreeMap<String, String>) {
    compare_as(&vector.name, vector, table, payload, left);
}

/// The same for a table of this name.
fn compare_as(
    name: &str,
    vector: &Vector,
    table: &[Row],
    payload: &[u8],
    left: &mut BTreeMap<String, String>,
) {
    for (at, size, row) in fixed(name, table) {
        let (kind, field) = (row[2].as_str(), row[3].as_str());
        if kind.is_empty() {
            continue;
        }
        let found = read(kind, &payload[at..at + size]);
        let expected = match field {
            "reserved" => "0".to_owned(),
            "entry_size" => "8".to_owned(),
            "table_at" => "72".to_owned(),
            "channel_count" => vector.fields["channels"].split(',').count().to_string(),
            "text_len" => (vector.fields["text"].len() / 2).to_string(),
            "bytes_len" => (vector.fields["bytes"].len() / 2).to_string(),
            "crc" if vector.name == "CONFIG_ACK" => crc32c(&payload[8..36]).to_string(),
            _ => left.remove(field).unwrap_or_else(|| panic!("{}: no field {field}", vector.case)),
        };
        assert_eq!(found, expected, "{}: {field} at {at}", vector.case);
    }
}

/// Entries of the channel table, as valid.tsv writes them.
fn channels(table: &[Row], payload: &[u8]) -> String {
    let entries = payload[72..].chunks(8).map(|entry| {
        let rows = fixed("channel", table);
        let number = |n: usize| read(&rows[n].2[2], &entry[rows[n].0..rows[n].0 + rows[n].1]);
        assert_eq!((rows.len(), rows[4].0, rows[4].2[2].as_str()), (5, 4, "f32"));
        let scale = f32::from_le_bytes(entry[4..8].try_into().unwrap()).to_bits();
        format!("{}:{}:{}:{}:{scale:08x}", number(0), number(1), number(2), number(3))
    });
    entries.collect::<Vec<_>>().join(",")
}

/// Messages that end with bytes of any number: their name, and where they begin.
const TEXTS: [(&str, &str, usize); 7] = [
    ("WELCOME", "text", 26),
    ("NOTICE", "text", 17),
    ("SETUP", "text", 73),
    ("LOAD", "bytes", 41),
    ("OBJECT", "text", 1),
    ("SHADOW", "bytes", 41),
    ("LOG", "text", 10),
];

#[test]
fn vectors_read_by_the_tables_give_their_fields() {
    let mut seen = 0;
    for vector in frames() {
        let mut left = vector.fields.clone();
        let found = tables(heading(&vector.name));
        if let Some(table) = found.first() {
            compare(&vector, table, &vector.payload, &mut left);
        }
        let payload = vector.payload.as_slice();
        match vector.name.as_str() {
            "CONFIG_ACK" => {
                compare(&vector, &table(heading("CONFIG")), &vector.payload[8..], &mut left);
            }
            "IDENT" => {
                let written = channels(&found[1], &vector.payload);
                assert_eq!(left.remove("channels"), Some(written), "{}", vector.case);
            }
            "HEALTH" if payload.len() > Health::SIZE => {
                compare_as("HEALTH appended", &vector, &found[1], payload, &mut left);
            }
            "SLIP" if payload.len() > SlipReport::SIZE => {
                compare_as("SLIP appended", &vector, &found[1], payload, &mut left);
            }
            "STATE" if payload.len() > PipelineState::SIZE => {
                compare_as("STATE appended", &vector, &found[1], payload, &mut left);
            }
            "SAMPLES" | "ROWS" => assert!(left.remove("rows").is_some()),
            _ => {}
        }
        if let Some((_, field, at)) = TEXTS.iter().find(|(name, ..)| *name == vector.name) {
            assert_eq!(left.remove(*field), Some(hex(&payload[*at..])), "{}", vector.case);
        }
        assert!(left.is_empty(), "{}: SPEC.md does not know {left:?}", vector.case);
        seen += 1;
    }
    assert!(seen >= 25, "{seen}");
}

#[test]
fn tables_end_where_the_screen_states() {
    for row in crate::messages::screens() {
        let size: usize = row[3].split(' ').next().unwrap().parse().unwrap();
        let found = tables(&format!("### {} {}", row[0], row[1]));
        let end = found
            .first()
            .map_or(0, |table| fixed(&row[1], table).last().map_or(0, |(at, size, _)| at + size));
        assert_eq!(end, size, "{}", row[1]);
        // A second size is that with the fields that were appended.
        if let Some(grown) = row[3].split(" or ").nth(1) {
            let appended = fixed(&format!("{} appended", row[1]), &found[1]);
            let end = appended.last().map_or(0, |(at, size, _)| at + size);
            assert_eq!(end, grown.parse::<usize>().unwrap(), "{}", row[1]);
            let whole = [SlipReport::WHOLE, PipelineState::WHOLE, Health::SIZE + Appended::SIZE];
            assert!(whole.contains(&end), "{}", row[1]);
        }
    }
}
