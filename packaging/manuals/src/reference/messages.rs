//! The tables of messages, codes and bits in; the page of all messages out.

use super::{
    page, plain,
    source::{Item, Row, all},
    wrapped,
};
use core::fmt::Write as _;
use grip_link::message::Kind;

const SOURCES: [&str; 17] = [
    include_str!("../../../../crates/grip-link/src/message/ident.rs"),
    include_str!("../../../../crates/grip-link/src/message/config.rs"),
    include_str!("../../../../crates/grip-link/src/message/control.rs"),
    include_str!("../../../../crates/grip-link/src/message/grip.rs"),
    include_str!("../../../../crates/grip-link/src/message/samples.rs"),
    include_str!("../../../../crates/grip-link/src/message/report.rs"),
    include_str!("../../../../crates/grip-link/src/decoder.rs"),
    include_str!("../../../../crates/grip-link/src/message/daemon/greet.rs"),
    include_str!("../../../../crates/slip-msg/src/message.rs"),
    include_str!("../../../../crates/slip-msg/src/state.rs"),
    include_str!("../../../../crates/slip-msg/src/health.rs"),
    include_str!("../../../../crates/grip-link/src/message/daemon/gripper.rs"),
    include_str!("../../../../crates/grip-link/src/message/daemon/rows.rs"),
    include_str!("../../../../crates/grip-link/src/message/daemon/notice.rs"),
    include_str!("../../../../crates/grip-link/src/message/daemon/model.rs"),
    include_str!("../../../../crates/grip-link/src/message/daemon/command.rs"),
    include_str!("../../../../crates/slip-msg/src/codes.rs"),
];
const FAULTS: &str = include_str!("../../../../crates/slip-msg/src/fault.rs");
const KINDS: &str = include_str!("../../../../crates/grip-link/src/kind.rs");

/// The item that documents the payload of a type, as `GRIP (10)`.
pub(super) fn payload<'a>(items: &'a [Item], name: &str, kind: Kind) -> Option<&'a Item> {
    let named = format!("{name} ({:02X})", kind.0);
    items.iter().find(|item| item.about.join(" ").contains(&named))
}

pub(super) fn sources() -> Vec<Item> {
    all(&SOURCES)
}

/// The page of all messages.
pub(super) fn messages() -> String {
    let items = sources();
    let mut text = page(
        "Messages",
        "Every message of the link and of the client socket, with its fields and codes. How they are framed, when they are \
         sent and what answers them: [SPEC](../../protocol/SPEC.md). A field after a line of *appended* is missing where an older \
         program writes.",
    );
    text += "| type | name | to | |\n|---|---|---|---|\n";
    for (name, kind) in Kind::ALL {
        let known = [
            (kind.is_to_device(), "gripper"),
            (kind.is_to_host(), "host"),
            (kind.is_to_daemon(), "daemon"),
            (kind.is_to_client(), "client"),
        ];
        let to: Vec<&str> = known.iter().filter(|(known, _)| *known).map(|(_, to)| *to).collect();
        let _ = writeln!(
            text,
            "| {:02X} | {} | {} | {} |",
            kind.0,
            named(&items, name, *kind),
            to.join(", "),
            about(name)
        );
    }
    for (name, kind) in Kind::ALL {
        // LOAD and SHADOW share theirs.
        if let Some(item) = payload(&items, name, *kind).filter(|_| *name != "SHADOW") {
            section(&format!("{:02X} {name}", kind.0), item, &items, &mut text);
        }
    }
    let is_payload = |item: &Item| {
        Kind::ALL.iter().any(|(name, kind)| payload(&items, name, *kind) == Some(item))
    };
    let is_public = |item: &&Item| !item.header.starts_with("pub struct ") && !is_payload(item);
    for item in items.iter().filter(is_public) {
        section(&item.name, item, &items, &mut text);
    }
    text += "\n## FaultCode\n\n| code | means |\n|---|---|\n";
    for line in FAULTS.lines().filter_map(|line| line.trim().strip_prefix("/// ")) {
        if let Some((code, about)) = line.split_once(": ").filter(|(code, _)| code.len() == 4) {
            let _ = writeln!(text, "| {code} | {about} |");
        }
    }
    text
}

/// What the table of types means by one.
fn about(name: &str) -> &'static str {
    let line = KINDS.lines().find(|line| line.contains(&format!(" {name}: ")));
    line.and_then(|line| line.split('"').nth(1)).unwrap_or_default()
}

fn named(items: &[Item], name: &str, kind: Kind) -> String {
    match payload(items, name, kind) {
        Some(_) if name == "SHADOW" => format!("[{name}](#ab-load)"),
        Some(_) => format!("[{name}](#{:02x}-{})", kind.0, name.to_lowercase()),
        None => format!("{name}, no payload"),
    }
}

fn section(heading: &str, item: &Item, items: &[Item], text: &mut String) {
    let _ = write!(text, "\n## {heading}\n\n{}\n", wrapped(&item.about));
    if item.header.starts_with("pub struct ") {
        return;
    }
    let is_message = item.rows.iter().any(|row| row.head.contains(':'));
    let is_bits = item.header.contains('(');
    *text += match (is_message, is_bits) {
        (true, _) => "\n| offset | field | type | unit, range | means |\n|---|---|---|---|---|\n",
        (_, true) => "\n| bit | name | means |\n|---|---|---|\n",
        _ => "\n| code | name | means |\n|---|---|---|\n",
    };
    for (at, row) in item.rows.iter().enumerate() {
        if row.appended && !item.rows[at - 1].appended {
            *text += "| | *appended* | | | |\n";
        }
        let texts: Vec<String> = row.texts.iter().map(|text| plain(text)).collect();
        if is_message {
            let (name, kind) = row.field();
            let offset = row.head.split(' ').next().unwrap_or("");
            let _ = writeln!(
                text,
                "| {offset} | `{name}` | {} | {} |",
                shown(kind, items),
                texts.join(" | ")
            );
        } else {
            let _ = writeln!(text, "| {} | {} |", numbered(row), texts.join(" | "));
        }
    }
}

/// Number of a code; number and name of a bit.
fn numbered(row: &Row) -> String {
    let words = row.head.split(' ').filter(|word| word.starts_with(|c: char| c.is_ascii_digit()));
    let number = words.last().unwrap_or("");
    match row.head.contains("=>") {
        true => number.to_owned(),
        false => format!("{number} | {}", row.head.rsplit(' ').next().unwrap_or("")),
    }
}

/// A type, with a link where the page has its table.
fn shown(kind: &str, items: &[Item]) -> String {
    let name = kind.trim_start_matches('[').split([';', ']']).next().unwrap_or("");
    match kind {
        "Micros" => "u64".to_owned(),
        "Kind" => "u8".to_owned(),
        "&'a [u8]" => "u8, then bytes".to_owned(),
        "Option<f32>" | "Option<f64>" => "f32, NaN: not known".to_owned(),
        "Option<u32>" => "u32, 4294967295: not known".to_owned(),
        "FaultCode" => "[FaultCode](#faultcode), u16".to_owned(),
        _ => {
            let inner = kind.trim_start_matches("Option<").trim_end_matches('>');
            let name = if inner == kind { name } else { inner };
            match items.iter().any(|item| item.name == name) {
                true => kind.replace(name, &format!("[{name}](#{})", name.to_lowercase())),
                false => format!("`{kind}`"),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{messages, payload, sources};
    use grip_link::message::{Kind, StatusFlags, daemon::SlipReport};
    use slip_msg::{Operation, Row, Scene, SensorHealth, Unit};

    #[test]
    fn every_type_has_its_payload_and_every_payload_its_fields() {
        let items = sources();
        let without =
            Kind::ALL.iter().filter(|(name, kind)| payload(&items, name, *kind).is_none());
        let without: Vec<&str> = without.map(|(name, _)| *name).collect();
        assert_eq!(without, ["START", "STOP", "ESTOP", "QUERY"]);
        for (name, kind) in Kind::ALL {
            let Some(item) = payload(&items, name, *kind) else { continue };
            let has_table = item.about.iter().any(|line| line.starts_with("| 0 |"));
            let first = item.rows.first().is_some_and(|row| row.head.starts_with("0 "));
            assert!(first || has_table, "{name}: {item:?}");
        }
        let slip = items.iter().find(|item| item.name == "SlipReport").unwrap();
        let last = slip.rows.last().unwrap();
        assert!(
            last.appended && last.head == format!("{} certified_s: Option<f32>", SlipReport::SIZE)
        );
    }

    #[test]
    fn codes_and_bits_are_those_of_the_types() {
        let page = messages();
        let rows = |name: &str| {
            let section = page.split(&format!("\n## {name}\n")).nth(1).unwrap();
            let section = section.split("\n## ").next().unwrap();
            let rows = section.lines().filter(|line| line.starts_with("| ")).skip(1);
            rows.map(str::to_owned).collect::<Vec<_>>()
        };
        let tables: [(&str, &[Row]); 4] = [
            ("Scene", Scene::TABLE),
            ("SensorHealth", SensorHealth::TABLE),
            ("Operation", Operation::TABLE),
            ("Unit", Unit::TABLE),
        ];
        for (name, table) in tables {
            let row = |row: &Row| format!("| {} | {} | {} |", row.code, row.name, row.about);
            assert_eq!(rows(name), table.iter().map(row).collect::<Vec<_>>());
        }
        let flags = rows("StatusFlags");
        assert_eq!(flags.len(), StatusFlags::BITS.len());
        for ((bit, name), row) in StatusFlags::BITS.iter().zip(flags) {
            assert!(row.starts_with(&format!("| {bit} | {name} | ")), "{row}");
        }
    }
}
