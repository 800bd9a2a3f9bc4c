//! The text of Rust sources read for their documented structs, those in `settings!` tables included.
//!
//! No Rust parser: it reads what rustfmt has laid out, a field a line or up to the next `,` or `;`.

/// A struct or a table of settings.
#[derive(Clone, Debug)]
pub(super) struct Item {
    /// Its name.
    pub(super) name: String,
    /// Its rows.
    pub(super) rows: Vec<Row>,
}

/// A field.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Its name.
    pub(super) name: String,
    /// Its type.
    pub(super) kind: String,
    /// Its doc comment, or the texts of its row in a table.
    pub(super) about: String,
}

/// Texts of files below `crates`.
macro_rules! sources {
    ($($file:literal)+) => { [$(include_str!(concat!("../../../../crates/", $file))),+] };
}
pub(super) use sources;

/// Every struct.
pub(super) fn items(sources: &[&str]) -> Vec<Item> {
    sources.iter().flat_map(|source| of(source)).collect()
}

fn of(source: &str) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let (mut about, mut row) = (Vec::new(), String::new());
    let (mut in_item, mut attribute, mut skipped) = (false, false, false);
    for line in source.lines().map(str::trim) {
        if let Some(text) = line.strip_prefix("///") {
            about.push(text.trim());
        } else if attribute || line.starts_with("#[") {
            attribute = !line.ends_with(']');
            skipped |= line == "#[serde(skip)]";
        } else if in_item && line == "}" {
            (in_item, skipped) = (false, false);
        } else if in_item {
            row = format!("{row} {line}");
            if line.ends_with([',', ';']) {
                if let (false, Some(item)) = (skipped, items.last_mut()) {
                    item.rows.push(row_of(&row, &about.join(" ")));
                }
                (row, skipped) = (String::new(), false);
                about.clear();
            }
        } else {
            let header = line.strip_prefix("pub struct ").and_then(|line| line.strip_suffix(" {"));
            if let Some(name) = header.and_then(|header| header.split(' ').next()) {
                items.push(Item { name: name.to_owned(), rows: Vec::new() });
            }
            in_item = header.is_some();
            about.clear();
        }
    }
    items
}

fn row_of(text: &str, about: &str) -> Row {
    let mut parts = text.split('"');
    let (name, kind) = parts.next().and_then(|head| head.split_once(':')).unwrap_or_default();
    let kind = kind.split(" = ").next().unwrap_or("").trim().trim_end_matches(',');
    let quoted: Vec<&str> = parts.step_by(2).collect();
    Row {
        name: name.rsplit(' ').next().unwrap_or("").trim_matches(['[', ']']).to_owned(),
        kind: kind.to_owned(),
        about: if about.is_empty() { quoted.join(" ") } else { about.to_owned() },
    }
}
