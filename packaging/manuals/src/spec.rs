//! protocol/MESSAGES.md: the messages of the link with fields, codes and bits, and an example of each from the vectors.

use core::fmt::Write as _;
use grip_link::message::{
    Channel, ChannelKind, Clamped, Config, DeviceState, EventKind, FaultCode, ForceClamp, GripMode,
    Kind, LogLevel, LossAction, NackReason, Reaction, ResetReason, SampleFormat, StatusFlags, Unit,
    daemon,
};
use slip_msg::{Field, Row, Wire as _};

const HEAD: &str = "\
# Messages, fields and codes

Printed from the code by `cargo run -p grip-manuals -- --spec protocol/MESSAGES.md`; do not edit. The rules stand in
[SPEC.md](SPEC.md) and, for programs at the socket of the daemon, in [CLIENTS.md](CLIENTS.md). Types, fault codes and
bytes are hexadecimal, all other numbers decimal. The example of a message is a row of [vectors](vectors): its fields,
then the frame on the wire.
";
const VECTORS: [&str; 2] = [
    include_str!("../../../protocol/vectors/valid.tsv"),
    include_str!("../../../protocol/vectors/clients.tsv"),
];
/// A heading, and who knows the types below it.
type Way = (&'static str, fn(Kind) -> bool);
/// Number, name and meaning of a bit.
type Bit = (u8, &'static str, &'static str);
/// A column between name and meaning, and its cell for a code.
type Column = (&'static str, fn(u8) -> String);

const WAYS: [Way; 4] = [
    ("To the device", Kind::is_to_device),
    ("To the host", Kind::is_to_host),
    ("To the daemon", Kind::is_to_daemon),
    ("To the client", |kind| kind.is_to_client() && !kind.is_to_host()),
];

/// The whole page.
pub(crate) fn page() -> String {
    let mut text = HEAD.to_owned();
    for (heading, knows) in WAYS {
        let mut kinds: Vec<_> = Kind::ALL.iter().filter(|(_, kind)| knows(*kind)).collect();
        kinds.sort_by_key(|(_, kind)| kind.0);
        let rows: Vec<String> = kinds.iter().map(|(name, kind)| screen(name, *kind)).collect();
        let columns = ["type", "name", "bytes of payload", "meaning"];
        let _ = write!(text, "\n## {heading}\n{}", table(&columns, &rows));
        for (name, kind) in kinds {
            text += &message(name, *kind);
        }
    }
    let faults: Vec<String> = FaultCode::TABLE.iter().map(fault).collect();
    let faults = table(&["code", "name", "reaction", "meaning"], &faults);
    let _ = write!(
        text,
        "\n## Fault codes\n{faults}\nAny other code is major: its reaction is passive.\n"
    );
    for (heading, rows) in BITS {
        let rows: Vec<String> = rows.iter().map(bit).collect();
        let _ = write!(text, "\n## {heading}\n{}", table(&["bit", "name", "meaning"], &rows));
    }
    for (heading, rows) in CODES {
        text += &codes(heading, rows);
    }
    text
}

fn table(columns: &[&str], rows: &[String]) -> String {
    let rule = "|---".repeat(columns.len());
    format!("\n| {} |\n{rule}|\n{}\n", columns.join(" | "), rows.join("\n"))
}

/// The section of a message.
fn message(name: &str, kind: Kind) -> String {
    const COLUMNS: [&str; 5] = ["offset", "size", "type", "field", "unit, range"];
    let mut text = format!("\n### {:02X} {name}\n", kind.0);
    let mut rows = fields(kind.fields(), false);
    rows.extend(behind(kind).map(str::to_owned));
    if !rows.is_empty() {
        text += &table(&COLUMNS, &rows);
    }
    let appended = fields(kind.fields(), true);
    if !appended.is_empty() {
        let _ = write!(text, "\nAppended:\n{}", table(&COLUMNS, &appended));
    }
    if kind == Kind::IDENT {
        let entry = table(&COLUMNS, &fields(Channel::FIELDS, false));
        let _ = write!(text, "\nOne entry of the channel table:\n{entry}");
    }
    text + &example(name)
}

/// What follows the fields of a message.
fn behind(kind: Kind) -> Option<&'static str> {
    match kind {
        Kind::IDENT => Some("| 72 | 8 n | | channel table | n entries |"),
        Kind::CONFIG_ACK => {
            Some("| 8 | 28 | | CONFIG in force | the payload of CONFIG, after clamping |")
        }
        Kind::SAMPLES | Kind::ROWS => Some("| 20 | n x row | | rows | one after the other |"),
        _ => None,
    }
}

/// The first row of the vectors with that message that has nothing but what a peer also writes.
fn example(name: &str) -> String {
    let rows = VECTORS.iter().flat_map(|file| file.lines());
    let mut rows = rows.map(|line| line.split('\t').collect::<Vec<_>>());
    let Some(row) = rows.find(|row| row.len() > 6 && row[1] == "both" && row[3] == name) else {
        return String::new();
    };
    let wire: Vec<&str> =
        row[6].as_bytes().chunks(2).filter_map(|hex| str::from_utf8(hex).ok()).collect();
    let wire: Vec<String> = wire.chunks(32).map(|line| line.join(" ").to_uppercase()).collect();
    let mut lines = vec![String::new()];
    for word in
        [row[4], row[5]].into_iter().flat_map(|cell| cell.split(' ')).filter(|word| *word != "-")
    {
        match lines.last_mut() {
            Some(line) if line.len() + word.len() < 100 => *line = format!("{line} {word}"),
            _ => lines.push(format!(" {word}")),
        }
    }
    let fields: String = lines.iter().map(|line| format!("{}\n", line.trim())).collect();
    format!("\n```text\n{fields}{}\n```\n", wire.join("\n"))
}

const BITS: [(&str, &[Bit]); 7] = [
    ("Clamp bits", ForceClamp::BITS),
    ("Status flags", StatusFlags::BITS),
    ("Clamped fields", Clamped::BITS),
    ("Topics", daemon::Topics::BITS),
    ("Unsure estimates", daemon::Unsure::BITS),
    ("Welcome flags", daemon::WelcomeFlags::BITS),
    ("Row channels", daemon::RowSet::BITS),
];
const CODES: [(&str, &[Row]); 25] = [
    ("Device states", DeviceState::TABLE),
    ("Reset reasons", ResetReason::TABLE),
    ("Channel kinds", ChannelKind::TABLE),
    ("Units", Unit::TABLE),
    ("Sample formats", SampleFormat::TABLE),
    ("NACK reasons", NackReason::TABLE),
    ("Event kinds", EventKind::TABLE),
    ("Log levels", LogLevel::TABLE),
    ("Grip modes", GripMode::TABLE),
    ("Loss actions", LossAction::TABLE),
    ("Slip phases", daemon::Phase::TABLE),
    ("Slip methods", daemon::Method::TABLE),
    ("Speed sources", daemon::SpeedSource::TABLE),
    ("Readings of E_sc", daemon::Reading::TABLE),
    ("Scenes", daemon::Scene::TABLE),
    ("Grip stages", daemon::GripState::TABLE),
    ("Sensors", daemon::Sensor::TABLE),
    ("Sensor healths", daemon::SensorHealth::TABLE),
    ("Link states", daemon::LinkState::TABLE),
    ("Recording states", daemon::Recording::TABLE),
    ("Real-time grants", daemon::RealTime::TABLE),
    ("Notice kinds", daemon::NoticeKind::TABLE),
    ("Dropped classes", daemon::DroppedClass::TABLE),
    ("Reasons of a goodbye", daemon::Goodbye::TABLE),
    ("Client operations", daemon::Operation::TABLE),
];

/// A table of codes, with what belongs to each besides its meaning.
fn codes(heading: &str, all: &[Row]) -> String {
    let more: Option<Column> = match heading {
        "Channel kinds" => Some(("unit", |code| {
            let unit = ChannelKind::from_code(code).unit().code();
            let unit = Unit::TABLE.iter().find(|row| row.code == unit);
            unit.map_or(String::new(), |row| row.constant().collect())
        })),
        "Sample formats" => Some(("bytes", |code| {
            SampleFormat::from_code(code).map_or(0, SampleFormat::size).to_string()
        })),
        _ => None,
    };
    let row = |row: &Row| {
        let (name, about) = (row.constant().collect::<String>(), row.about.trim_end_matches('.'));
        let more = more.map_or(String::new(), |(_, of)| format!(" {} |", of(row.code)));
        format!("| {} | {name} |{more} {about} |", row.code)
    };
    let rows: Vec<String> = all.iter().map(row).collect();
    let columns: Vec<&str> =
        ["code", "name"].into_iter().chain(more.map(|(name, _)| name)).chain(["meaning"]).collect();
    format!("\n## {heading}\n{}", table(&columns, &rows))
}

fn bit(row: &Bit) -> String {
    let (bit, name, about) = row;
    format!("| {bit} | {name} | {} |", about.trim_end_matches('.'))
}

fn fault(row: &(FaultCode, &str, &str)) -> String {
    let (code, name, about) = row;
    let reaction = match (*code, code.reaction()) {
        (FaultCode::NONE, _) => "",
        (FaultCode::ESTOP, _) => " as configured",
        (_, Reaction::Hold) => " hold",
        (_, Reaction::Passive) => " passive",
    };
    format!("| {:04X} | {name} |{reaction} | {} |", code.0, about.trim_end_matches('.'))
}

/// The rows of a message, or those that were appended to it.
fn fields(fields: &[Field], appended: bool) -> Vec<String> {
    let mut rows = Vec::new();
    Field::each(fields, &mut |field| {
        if field.appended != appended {
            return;
        }
        let Field { at, size, kind, name, text, .. } = field;
        let text = if text.is_empty() { String::new() } else { format!(" {text}") };
        match (kind, size) {
            ("text", _) => {
                let count = if name == "text" { "m" } else { "n" };
                rows.push(format!("| {at} | 1 | u8 | `{name}_len` | {count} |"));
                rows.push(format!("| {} | {count} | | {name} |{text} |", at + 1));
            }
            ("", _) => rows.push(format!("| {at} | {size} | u{} | {name} |{text} |", 8 * size)),
            _ if size > Field::bytes(kind) => {
                let kind = format!("{kind}[{}]", size / Field::bytes(kind));
                rows.push(format!("| {at} | {size} | {kind} | `{name}` |{text} |"));
            }
            _ => rows.push(format!("| {at} | {size} | {kind} | `{name}` |{text} |")),
        }
    });
    rows
}

fn screen(name: &str, kind: Kind) -> String {
    let about = kind.about().trim_end_matches('.');
    format!("| {:02X} | {name} | {} | {about} |", kind.0, size(kind))
}

/// Bytes of a payload, of what was appended too, and what follows.
fn size(kind: Kind) -> String {
    let (first, whole) = kind.sizes();
    let text = kind.fields().last().filter(|field| field.kind == "text");
    let more = text.map_or(String::new(), |text| format!(" + {}", text.name));
    match kind {
        Kind::IDENT => format!("{first} + 8 n"),
        Kind::CONFIG_ACK => format!("{}", first + Config::SIZE),
        Kind::SAMPLES | Kind::ROWS => format!("{first} + rows"),
        _ if whole > first => format!("{first} or {whole}"),
        _ => format!("{first}{more}"),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_of_messages_is_that_of_the_code() {
        let written = include_str!("../../../protocol/MESSAGES.md");
        let made = super::page();
        let differs = made.lines().zip(written.lines()).find(|(made, written)| made != written);
        assert!(
            made == written,
            "cargo run -p grip-manuals -- --spec protocol/MESSAGES.md: {differs:?}"
        );
    }
}
