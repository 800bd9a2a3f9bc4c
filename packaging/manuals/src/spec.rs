//! The tables of protocol/SPEC.md that the code holds: messages and their fields, codes and bits.
//!
//! Whatever else stands in a table (rows of samples, answers) is written by hand and stays.

use core::fmt::Write as _;
use grip_link::message::{
    Channel, ChannelKind, Clamped, Config, DeviceState, EventKind, FaultCode, ForceClamp, GripMode,
    Kind, LogLevel, LossAction, NackReason, Reaction, ResetReason, SampleFormat, StatusFlags, Unit,
    daemon,
};
use slip_msg::{Field, Row, Wire as _};

/// The page as it stands.
pub(crate) const WRITTEN: &str = include_str!("../../../protocol/SPEC.md");

/// The page with its tables as the code has them.
pub(crate) fn spec() -> String {
    let mut text = String::new();
    let (mut heading, mut table, mut made) = ("", 0, Vec::new());
    for line in WRITTEN.lines() {
        if line.starts_with('#') {
            (heading, table) = (line.trim_start_matches('#').trim(), 0);
        }
        if line.starts_with('|') {
            if line.starts_with("|---") {
                made = rows(heading, table);
                table += 1;
                let _ = writeln!(text, "{line}\n{}", made.join("\n"));
                text.truncate(text.trim_end().len() + 1);
                continue;
            }
            if !made.is_empty() && !is_by_hand(heading, line) {
                continue;
            }
        } else {
            made.clear();
        }
        let _ = writeln!(text, "{line}");
    }
    text
}

/// Whether the code does not have that row: what follows the fields of a message.
fn is_by_hand(heading: &str, line: &str) -> bool {
    let cells: Vec<&str> = cells(line).collect();
    let is_text = |cell: &&str| *cell == "text" || *cell == "bytes";
    Kind::ALL.iter().any(|(name, kind)| heading == format!("{:02X} {name}", kind.0))
        && cells.get(2) == Some(&"")
        && !cells.get(3).is_some_and(is_text)
}

fn cells(line: &str) -> impl Iterator<Item = &str> {
    line.trim_matches('|').split('|').map(str::trim)
}

/// The rows of the table with that number below a heading; none where the code has none.
fn rows(heading: &str, table: usize) -> Vec<String> {
    let named = |(name, kind): &&(&str, Kind)| heading == format!("{:02X} {name}", kind.0);
    match Kind::ALL.iter().find(named) {
        Some((_, Kind::IDENT)) if table == 1 => return fields(Channel::FIELDS, false),
        Some((_, kind)) => return fields(kind.fields(), table == 1),
        None => {}
    }
    match heading {
        "4 Messages on one screen" => screen(|kind| kind.0 < 0xA0),
        "Messages of the daemon on one screen" => screen(|kind| kind.0 >= 0xA0),
        "Fault codes" => FaultCode::TABLE.iter().map(fault).collect(),
        "Clamp bits" => bits(ForceClamp::BITS),
        "Status flags" => bits(StatusFlags::BITS),
        "Clamped fields" => bits(Clamped::BITS),
        "Topics" => bits(daemon::Topics::BITS),
        "Unsure estimates" => bits(daemon::Unsure::BITS),
        "Welcome flags" => bits(daemon::WelcomeFlags::BITS),
        "Row channels" => bits(daemon::RowSet::BITS),
        "Channel kinds" => codes(ChannelKind::TABLE, |code| {
            let unit = ChannelKind::from_code(code).unit().code();
            let unit = Unit::TABLE.iter().find(|row| row.code == unit);
            format!(" {} |", unit.map_or(String::new(), |row| row.constant().collect()))
        }),
        "Sample formats" => codes(SampleFormat::TABLE, |code| {
            format!(" {} |", SampleFormat::from_code(code).map_or(0, SampleFormat::size))
        }),
        _ => codes(table_of(heading), |_| String::new()),
    }
}

fn table_of(heading: &str) -> &'static [Row] {
    match heading {
        "Device states" => DeviceState::TABLE,
        "Reset reasons" => ResetReason::TABLE,
        "Units" => Unit::TABLE,
        "NACK reasons" => NackReason::TABLE,
        "Event kinds" => EventKind::TABLE,
        "Log levels" => LogLevel::TABLE,
        "Grip modes" => GripMode::TABLE,
        "Loss actions" => LossAction::TABLE,
        "Slip phases" => daemon::Phase::TABLE,
        "Slip methods" => daemon::Method::TABLE,
        "Speed sources" => daemon::SpeedSource::TABLE,
        "Readings of E_sc" => daemon::Reading::TABLE,
        "Scenes" => daemon::Scene::TABLE,
        "Grip stages" => daemon::GripState::TABLE,
        "Sensors" => daemon::Sensor::TABLE,
        "Sensor healths" => daemon::SensorHealth::TABLE,
        "Link states" => daemon::LinkState::TABLE,
        "Recording states" => daemon::Recording::TABLE,
        "Real-time grants" => daemon::RealTime::TABLE,
        "Notice kinds" => daemon::NoticeKind::TABLE,
        "Dropped classes" => daemon::DroppedClass::TABLE,
        "Reasons of a goodbye" => daemon::Goodbye::TABLE,
        "Client operations" => daemon::Operation::TABLE,
        _ => &[],
    }
}

fn codes(table: &[Row], more: impl Fn(u8) -> String) -> Vec<String> {
    let row = |row: &Row| {
        let (name, about) = (row.constant().collect::<String>(), row.about.trim_end_matches('.'));
        format!("| {} | {name} |{} {about} |", row.code, more(row.code))
    };
    table.iter().map(row).collect()
}

fn bits(table: &[(u8, &str, &str)]) -> Vec<String> {
    let row = |(bit, name, about): &(u8, &str, &str)| {
        format!("| {bit} | {name} | {} |", about.trim_end_matches('.'))
    };
    table.iter().map(row).collect()
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

/// The rows of a screen; what asks for an answer, and when, stays as it is written.
fn screen(is_here: impl Fn(Kind) -> bool) -> Vec<String> {
    let mut kinds: Vec<_> = Kind::ALL.iter().filter(|(_, kind)| is_here(*kind)).collect();
    kinds.sort_by_key(|(_, kind)| kind.0);
    let row = |(name, kind): &&(&str, Kind)| {
        let begin = format!("| {:02X} | {name} |", kind.0);
        let way = match kind {
            _ if kind.is_to_device() => "to device",
            _ if kind.is_to_host() => "to host",
            _ if kind.is_to_daemon() => "to daemon",
            _ => "to client",
        };
        let written = WRITTEN.lines().find(|line| line.starts_with(&begin)).unwrap_or("");
        let rest: Vec<&str> = written.splitn(6, '|').skip(5).collect();
        format!("{begin} {way} | {} |{}", size(*kind), rest.join(""))
    };
    kinds.iter().map(row).collect()
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
    use super::{WRITTEN, spec};

    #[test]
    fn the_tables_of_the_specification_are_those_of_the_code() {
        let made = spec();
        let differs = made.lines().zip(WRITTEN.lines()).find(|(made, written)| made != written);
        assert!(
            made == WRITTEN,
            "cargo run -p grip-manuals -- --spec protocol/SPEC.md: {differs:?}"
        );
    }
}
