//! A heading of SPEC.md in, the rows of its tables and its fenced text out.

use std::path::Path;
use std::sync::LazyLock;

static SPEC: LazyLock<String> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol/SPEC.md");
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
});

/// Cells of a row, without back-ticks.
pub(crate) type Row = Vec<String>;

/// Headings that begin with `prefix`.
pub(crate) fn headings(prefix: &str) -> Vec<&'static str> {
    SPEC.lines().filter(|line| line.starts_with(prefix)).collect()
}

/// The lines between a heading and the next one.
fn section(heading: &str) -> impl Iterator<Item = &'static str> {
    let found = headings(heading).iter().filter(|line| **line == heading).count();
    assert_eq!(found, 1, "headings {heading:?} in SPEC.md");
    let lines = SPEC.lines().skip_while(move |line| *line != heading).skip(1);
    lines.take_while(|line| !line.starts_with('#'))
}

/// The text of the first fence of this kind, line by line.
pub(crate) fn fence(heading: &str, kind: &str) -> Vec<&'static str> {
    let lines: Vec<&str> =
        section(heading).skip_while(|line| *line != format!("```{kind}")).skip(1).collect();
    assert!(!lines.is_empty(), "no fence {kind} under {heading:?}");
    lines.into_iter().take_while(|line| *line != "```").collect()
}

fn cells(line: &str) -> Row {
    let inner = line.trim_start_matches('|').trim_end_matches('|');
    inner.split('|').map(|cell| cell.trim().replace('`', "")).collect()
}

/// All tables of a section, without their heads.
pub(crate) fn tables(heading: &str) -> Vec<Vec<Row>> {
    let mut tables: Vec<Vec<Row>> = Vec::new();
    let mut fenced = false;
    let mut inside = false;
    for line in section(heading) {
        fenced ^= line.starts_with("```");
        if fenced || !line.starts_with('|') {
            inside = false;
        } else if !inside {
            tables.push(Vec::new());
            inside = true;
        } else if !line.starts_with("|---") {
            tables.last_mut().unwrap().push(cells(line));
        }
    }
    tables
}

/// The first table of a section.
pub(crate) fn table(heading: &str) -> Vec<Row> {
    tables(heading).into_iter().next().unwrap_or_else(|| panic!("no table under {heading:?}"))
}

/// Two columns of a table, as pairs.
pub(crate) fn pairs(heading: &str, key: usize, value: usize) -> Vec<(String, String)> {
    table(heading).into_iter().map(|row| (row[key].clone(), row[value].clone())).collect()
}
