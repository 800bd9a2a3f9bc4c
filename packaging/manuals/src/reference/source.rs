//! The text of a Rust source in; its documented structs and the tables of its macros out.
//!
//! No Rust parser: it reads what rustfmt has laid out, a row a line or up to the next `,` or `;`.

/// What an item begins with; in a macro a name alone too.
const KINDS: [&str; 3] = ["pub struct ", "open ", "closed "];

/// A struct, a message, a table of codes or bits.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Item {
    /// Its name.
    pub(super) name: String,
    /// Its doc comment, line by line.
    pub(super) about: Vec<String>,
    /// What stands before the brace, as `open Scene`.
    pub(super) header: String,
    /// Its rows.
    pub(super) rows: Vec<Row>,
}

/// A field, a code or a bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Row {
    /// What stands before the first text: `0 kind: Kind`, `2 => Gross`, `pub port: Option<String>`.
    pub(super) head: String,
    /// The texts between quotation marks; of a field of a struct its doc comment.
    pub(super) texts: Vec<String>,
    /// Whether older writers do not send it.
    pub(super) appended: bool,
}

impl Item {
    /// Whether it is written as a struct, and not in a table of a macro.
    pub(super) fn is_struct(&self) -> bool {
        self.header.starts_with("pub struct ")
    }
}

impl Row {
    /// Name and type of a field.
    pub(super) fn field(head: &str) -> (&str, &str) {
        let (name, kind) = head.split_once(':').unwrap_or((head, ""));
        let kind = kind.split(" = ").next().unwrap_or("");
        (
            name.trim().rsplit(' ').next().unwrap_or("").trim_matches(['[', ']']),
            kind.trim().trim_end_matches(','),
        )
    }
}

/// Texts of files below `crates`.
macro_rules! sources {
    ($($file:literal)+) => { [$(include_str!(concat!("../../../../crates/", $file))),+] };
}
pub(super) use sources;

/// Every item with a doc comment.
pub(super) fn items(sources: &[&str]) -> Vec<Item> {
    sources.iter().flat_map(|source| of(source)).collect()
}

fn of(source: &str) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let (mut about, mut row) = (Vec::new(), String::new());
    let (mut in_macro, mut in_item, mut attribute, mut appended) = (false, false, false, false);
    let mut skipped = false;
    for line in source.lines() {
        in_macro = (in_macro || line.ends_with("! {")) && line != "}";
        let line = line.trim();
        if let Some(text) = line.strip_prefix("///") {
            about.push(text.strip_prefix(' ').unwrap_or(text).to_owned());
        } else if attribute || line.starts_with("#[") {
            attribute = !line.ends_with(']');
            skipped |= line == "#[serde(skip)]";
        } else if in_item && line == "}" {
            (in_item, skipped) = (false, false);
            about.clear();
        } else if in_item {
            row = format!("{row} {line}");
            if line.ends_with([',', ';']) {
                let texts = core::mem::take(&mut about);
                if let (false, Some(item)) = (skipped, items.last_mut()) {
                    item.rows.push(row_of(&row, &texts.join(" "), appended));
                }
                (row, skipped) = (String::new(), false);
            }
        } else {
            appended = line == "appended {";
            let header = line.trim_end_matches(" {");
            let kind = KINDS.iter().any(|kind| header.starts_with(kind));
            let named = kind || (in_macro && header.starts_with(char::is_uppercase));
            let named = named && line.ends_with('{') && !about.is_empty();
            if named {
                items.push(item_of(header, core::mem::take(&mut about)));
            }
            in_item = named || appended;
            about.clear();
        }
    }
    items
}

fn item_of(header: &str, about: Vec<String>) -> Item {
    let name = KINDS.iter().find_map(|kind| header.strip_prefix(kind)).unwrap_or(header);
    let name = name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
    Item { name: name.to_owned(), about, header: header.to_owned(), rows: Vec::new() }
}

fn row_of(text: &str, about: &str, appended: bool) -> Row {
    let mut parts = text.split('"');
    let head = parts.next().unwrap_or("").trim().trim_end_matches(',').to_owned();
    let quoted: Vec<String> = parts.step_by(2).map(str::to_owned).collect();
    let texts = if about.is_empty() { quoted } else { vec![about.to_owned()] };
    Row { head, texts, appended }
}
