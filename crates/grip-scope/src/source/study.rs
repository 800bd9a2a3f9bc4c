//! The report of a study in a file: another JSON file is reported as such.

use super::outlet::Outlet;
use crate::feed::{Feed, SourceStatus, Study};
use serde_json::error::Category;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest report that is read (bytes): read into memory it takes some ten times as much.
const MOST: u64 = 16 << 20;

/// Reads the report.
pub(super) fn run(file: &Path, outlet: &mut Outlet) {
    outlet.status(SourceStatus::Loading { done: 0.0 });
    let status = match read(file) {
        Ok(study) => {
            outlet.offer(Feed::Study(Box::new(study)));
            SourceStatus::Complete { note: String::new() }
        }
        Err(sentence) => SourceStatus::Failed { sentence },
    };
    outlet.status(status);
}

fn read(file: &Path) -> Result<Study, String> {
    let name = file.display();
    let mut text = String::new();
    // Not by its length: a pipe has none.
    let read = File::open(file).and_then(|input| input.take(MOST + 1).read_to_string(&mut text));
    read.map_err(|error| {
        format!("{name}: cannot be read ({error}); check the path and its permissions")
    })?;
    if text.len() as u64 > MOST {
        let most_mb = MOST >> 20;
        return Err(format!(
            "{name}: is larger than {most_mb} MiB: no report of a study has so much"
        ));
    }
    serde_json::from_str(&text).map_err(|error| match error.classify() {
        Category::Data => {
            format!("{name}: is no report of a study: `gripctl study --out DIR` writes one")
        }
        _ => format!("{name}: is no JSON: {error}"),
    })
}
