//! The pages of the protocol, asked for a row or a phrase that a test expects there.

use std::path::Path;

/// A page of `protocol`, or the README of the crate, in one line.
fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Each phrase stands on the page, one behind the other.
pub(crate) fn assert_states(name: &str, phrases: &[String]) {
    let text = page(name);
    let mut rest = &text[..];
    for phrase in phrases {
        let at = rest.find(phrase.as_str());
        let at = at.unwrap_or_else(|| {
            panic!("protocol/{name} does not have {phrase:?} where it is expected")
        });
        rest = &rest[at + phrase.len()..];
    }
}

/// The beginning of a row of a table.
pub(crate) fn row(cells: &[&str]) -> String {
    format!(" | {} |", cells.join(" | "))
}
