//! The tables of the code in, the pages of the reference that are not command lines out.

mod messages;
mod metrics;
mod settings;
mod source;

/// Name and text of each page.
pub(crate) fn pages() -> [(&'static str, String); 4] {
    [
        ("configuration", settings::configuration()),
        ("messages", messages::messages()),
        ("metrics", metrics::metrics()),
        ("scenes", settings::scenes()),
    ]
}

/// The beginning of a page.
fn page(title: &str, about: &str) -> String {
    let about = wrapped(&[about.to_owned()]);
    format!(
        "# {title}\n\n{about}\n\nMade of the code: `cargo run -p grip-manuals -- --reference docs/reference` writes this page.\n"
    )
}

/// A doc comment without links into the code, for a cell of a table.
fn plain(text: &str) -> String {
    text.replace("[`", "`").replace("`]", "`").replace("\\[", "[").replace('|', "\\|")
}

/// Lines of at most 120 characters; rows of a table and empty lines stay as they are.
fn wrapped(lines: &[String]) -> String {
    let mut text = String::new();
    let mut width = 0;
    for line in lines {
        if line.is_empty() || line.starts_with('|') {
            let line = line.replace("[`", "`").replace("`]", "`");
            text += if width > 0 { "\n" } else { "" };
            text += &format!("{line}\n");
            width = 0;
            continue;
        }
        for word in plain(line).split(' ') {
            let breaks = width > 0 && width + 1 + word.len() > 120;
            text += if breaks {
                "\n"
            } else if width > 0 {
                " "
            } else {
                ""
            };
            width = if breaks || width == 0 { word.len() } else { width + 1 + word.len() };
            text += word;
        }
    }
    text.trim_end().to_owned()
}
