//! docs/gripd.toml holds every key with its default; docs/reference/configuration.md marks every key that needs a restart.

use grip_session::config::{HostConfig, NEEDS_RESTART};
use std::{collections::BTreeSet, path::Path};

const DOCUMENTED: &str = include_str!("../../../../docs/gripd.toml");
const REFERENCE: &str = include_str!("../../../../docs/reference/configuration.md");

fn parse(text: &str) -> Result<HostConfig, String> {
    HostConfig::parse(Path::new("x"), text).map_err(|error| error.to_string())
}

/// The keys that a table may hold, as the reader of the file knows them.
fn keys(table: &str) -> Vec<String> {
    let header = if table.is_empty() { String::new() } else { format!("[{table}]\n") };
    let error = parse(&format!("{header}no_such_key = 1\n")).unwrap_err();
    let (first, _) = error.split_once('\n').unwrap();
    let (_, known) = first.split_once("expected ").unwrap();
    known.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The lines of a table in the documented file, also those that are commented out.
fn documented(table: &str) -> Vec<&'static str> {
    let mut within = table.is_empty();
    let mut lines = Vec::new();
    for line in DOCUMENTED.lines() {
        if line.starts_with('[') {
            within = line.starts_with(&format!("[{table}]"));
        } else if within {
            lines.push(line);
        }
    }
    lines
}

#[test]
fn the_documented_file_is_the_default() {
    let documented = parse(DOCUMENTED).unwrap();
    let changes = HostConfig::default().diff(&documented);
    assert!(changes.is_empty(), "docs/gripd.toml has another value than the program: {changes:?}");
    assert_eq!(documented, HostConfig::default());
}

#[test]
fn the_documented_file_names_every_key_there_is() {
    let tables = [
        "",
        "link",
        "recording",
        "realtime",
        "usb",
        "fleet",
        "floor",
        "detector",
        "detector.gate",
        "health",
        "health.drift",
    ];
    let others = ["travel", "pressure", "velocity", "observation", "observation.speed", "grip"];
    let mut seen = 0;
    for table in tables.into_iter().chain(others) {
        let lines = documented(table);
        for key in keys(table) {
            let starts = [format!("{key} ="), format!("# {key} =")];
            let here = lines.iter().any(|line| starts.iter().any(|start| line.starts_with(start)));
            let header =
                if table.is_empty() { format!("[{key}]") } else { format!("[{table}.{key}]") };
            assert!(here || DOCUMENTED.contains(&header), "{table}: {key} is not documented");
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen} keys: the message that lists them has changed");
}

/// The setting of a line that is commented out. A calibration and a model would have to exist.
fn hidden(line: &str) -> Option<&str> {
    let setting = line.strip_prefix("# ")?;
    let (name, _) = setting.split_once(" = ")?;
    let is_name = name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    (is_name && !["calibration", "model"].contains(&name)).then_some(setting)
}

#[test]
fn a_value_that_is_commented_out_is_valid_too() {
    let lines = DOCUMENTED.lines().map(|line| format!("{}\n", hidden(line).unwrap_or(line)));
    let config = parse(&lines.collect::<String>()).unwrap();
    assert_eq!(DOCUMENTED.lines().filter_map(hidden).count(), 24);
    assert!(config.uid.is_some() && config.metrics.is_some() && config.usb.vid == Some(0x2341));
    assert!(config.record.is_some() && config.realtime.cpu == Some(3));
    assert_eq!(config.allow_unsigned_models, Some(true));
    assert!(config.fleet.site.is_some() && config.fleet.network.is_some());
}

#[test]
fn the_reference_marks_what_needs_a_restart() {
    let marked = REFERENCE.lines().filter(|line| line.contains(" | restart | "));
    let keys = marked.filter_map(|line| line.strip_prefix("| `")?.split(['.', '`']).next());
    let marked: BTreeSet<&str> = keys.collect();
    assert_eq!(marked, BTreeSet::from(NEEDS_RESTART));
}
