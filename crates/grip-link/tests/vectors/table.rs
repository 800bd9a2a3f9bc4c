//! Rows of a vector file.

use std::path::Path;

pub(crate) fn rows<const N: usize>(file: &str) -> Vec<[String; N]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol/vectors").join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let rows: Vec<_> = lines
        .map(|line| {
            let columns: Vec<String> = line.split('\t').map(str::to_owned).collect();
            <[String; N]>::try_from(columns).unwrap_or_else(|got| panic!("{N} columns: {got:?}"))
        })
        .collect();
    assert!(rows.len() >= 20, "{} rows in {file}", rows.len());
    rows
}
