//! The pages of the reference that are not command lines, made from the tables of the code.

mod metrics;
mod settings;
mod source;

/// Name and text of each page.
pub(crate) fn pages() -> [(&'static str, String); 3] {
    [
        ("configuration", settings::configuration()),
        ("metrics", metrics::metrics()),
        ("scenes", settings::scenes()),
    ]
}

/// The beginning of a page.
fn page(title: &str, about: &str) -> String {
    let about = wrapped(about);
    format!(
        "# {title}\n\n{about}\n\nMade of the code: `cargo run -p grip-manuals -- --reference docs/reference` writes this page.\n"
    )
}

/// A doc comment without links into the code, for a cell of a table.
fn plain(text: &str) -> String {
    text.replace("[`", "`").replace("`]", "`").replace("\\[", "[").replace('|', "\\|")
}

/// Lines of at most 120 characters.
fn wrapped(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= 120 => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}
