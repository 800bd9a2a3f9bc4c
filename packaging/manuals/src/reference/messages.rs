//! The tables of messages, codes and bits in; the page of all messages out.

use super::{
    page, plain,
    source::{Item, Row, items, sources},
    wrapped,
};
use core::fmt::Write as _;
use grip_link::message::{Kind, daemon::Appended};

const SOURCES: &[&str] = &sources! {
    "grip-link/src/message/ident.rs" "grip-link/src/message/config.rs" "grip-link/src/message/control.rs"
    "grip-link/src/message/grip.rs" "grip-link/src/message/samples.rs" "grip-link/src/message/report.rs"
    "grip-link/src/decoder.rs" "grip-link/src/message/daemon/greet.rs" "slip-msg/src/message.rs"
    "slip-msg/src/state.rs" "slip-msg/src/health.rs" "grip-link/src/message/daemon/gripper.rs"
    "grip-link/src/message/daemon/rows.rs" "grip-link/src/message/daemon/notice.rs"
    "grip-link/src/message/daemon/model.rs" "grip-link/src/message/daemon/command.rs" "slip-msg/src/codes.rs"
};
const FAULTS: [&str; 1] = sources! { "slip-msg/src/fault.rs" };

/// The item that documents the payload of a type, as `GRIP (10)`.
fn payload<'a>(items: &'a [Item], name: &str, kind: Kind) -> Option<&'a Item> {
    let named = format!("{name} ({:02X})", kind.0);
    items.iter().find(|item| item.about.join(" ").contains(&named))
}

/// The page of all messages.
pub(super) fn messages() -> String {
    let items = items(SOURCES);
    let about = "Every message of the link and of the client socket with its fields, then what they are made of and every code. \
                 How they are framed, when they are sent and what answers them: [SPEC](../../protocol/SPEC.md). START (04), \
                 STOP (05), ESTOP (12) and QUERY (AA) have no payload. Older programs do not send what was *appended*.";
    let mut text = page("Messages", about);
    let mut rest: Vec<&Item> = items.iter().filter(|item| !item.is_struct()).collect();
    for (name, kind) in Kind::ALL {
        let Some(item) = payload(&items, name, *kind) else { continue };
        rest.retain(|other| *other != item);
        // LOAD and SHADOW share theirs.
        if *name != "SHADOW" {
            section(&format!("{:02X} {name}", kind.0), item, &items, &mut text);
        }
    }
    for item in &rest {
        section(&item.name, item, &items, &mut text);
    }
    text += "\n## FaultCode\n\n| code | means |\n|---|---|\n";
    for line in FAULTS[0].lines().filter_map(|line| line.trim().strip_prefix("/// ")) {
        if let Some((code, about)) = line.split_once(": ").filter(|(code, _)| code.len() == 4) {
            let _ = writeln!(text, "| {code} | {about} |");
        }
    }
    // Names of codes in the words of others.
    for Item { name, .. } in rest {
        text = text.replace(&format!("`{name}`"), &format!("[{name}](#{})", name.to_lowercase()));
    }
    text
}

fn section(heading: &str, item: &Item, items: &[Item], text: &mut String) {
    let _ = write!(text, "\n## {heading}\n\n{}\n", wrapped(&item.about));
    // Of a struct the doc comment has the table.
    if item.is_struct() {
        return;
    }
    let is_message = item.rows.iter().any(|row| row.head.contains(':'));
    *text += match (is_message, item.header.contains('(')) {
        (true, _) => "\n| offset | field | type | unit, range | means |\n|---|---|---|---|---|\n",
        (_, true) => "\n| bit | name | means |\n|---|---|---|\n",
        _ => "\n| code | name | means |\n|---|---|---|\n",
    };
    for Row { head, texts, appended } in &item.rows {
        let texts: Vec<String> = texts.iter().map(|text| plain(text)).collect();
        let texts = texts.join(" | ");
        let mut words = head.split(' ');
        let number = words.find(|word| word.starts_with(|c: char| c.is_ascii_digit()));
        let number = number.unwrap_or("");
        let _ = match (Row::field(head), words.next()) {
            ((name, kind), _) if is_message => {
                let appended = if *appended { ", *appended*" } else { "" };
                writeln!(
                    text,
                    "| {number}{appended} | `{name}` | {} | {texts} |",
                    shown(kind, items)
                )
            }
            (_, Some("=>")) => writeln!(text, "| {number} | {texts} |"),
            (_, name) => writeln!(text, "| {number} | {} | {texts} |", name.unwrap_or("")),
        };
    }
}

/// A type, with a link where the page has its table.
fn shown(kind: &str, items: &[Item]) -> String {
    match kind {
        "Micros" => "u64".to_owned(),
        "Kind" => "u8".to_owned(),
        "&'a [u8]" => "u8, then bytes".to_owned(),
        "Option<f32>" | "Option<f64>" => "f32, NaN: not known".to_owned(),
        "Option<u32>" => "u32, 4294967295: not known".to_owned(),
        "Option<ClockOffset>" => "f32, then i64".to_owned(),
        "FaultCode" => "u16, [FaultCode](#faultcode)".to_owned(),
        _ => {
            let kind = kind.trim_start_matches("Option<").trim_end_matches('>');
            let kind = kind.replace("Appended::BUCKETS", &Appended::BUCKETS.to_string());
            let inner = kind.trim_start_matches('[').split([';', ']']).next().unwrap_or("");
            let link = format!("[{inner}](#{})", inner.to_lowercase());
            match items.iter().any(|item| item.name == inner && !item.is_struct()) {
                true => kind.replace(inner, &link),
                false => kind,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SOURCES, items, messages, payload};
    use grip_link::message::{Kind, StatusFlags, daemon::SlipReport};
    use slip_msg::{Operation, Row, Scene, SensorHealth, Unit};

    #[test]
    fn every_type_has_its_payload_and_every_payload_its_fields() {
        let items = items(SOURCES);
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
