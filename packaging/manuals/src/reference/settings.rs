//! The pages of the keys of the configuration and of a scene, made from their structs with defaults and ranges.
//!
//! Meanings are the doc comments of the fields. Ranges are what a refusal names.

use super::{
    page, plain,
    source::{Item, Row, items, sources},
};
use grip_session::config::{HostConfig, NEEDS_RESTART};
use grip_sim::Scene;
use std::path::Path;
use toml::{Table, Value};

const CONFIGURATION: &[&str] = &sources! {
    "grip-session/src/config/mod.rs" "grip-session/src/config/keys.rs" "slip-core/src/floor.rs" "slip-core/src/health.rs"
    "slip-core/src/detector/config.rs" "slip-core/src/filter.rs" "slip-core/src/detector/reference.rs" "slip-core/src/drift.rs"
    "slip-core/src/distance.rs" "slip-core/src/pressure/mod.rs" "slip-core/src/velocity/mod.rs"
    "slip-core/src/observation.rs" "slip-core/src/grip/config.rs"
};
const SCENE: &[&str] = &sources! {
    "grip-sim/src/scene/mod.rs" "grip-sim/src/scene/load.rs" "grip-sim/src/scene/sensing.rs" "grip-sim/src/scene/texture.rs"
};

/// Values that no key takes; the refusal of one names what it takes.
const WRONG: [&str; 9] =
    ["-1e30", "1e30", "-1", "0", "255", "65535", "4294967295", "\"no\"", "[\"no\"]"];

/// A key as the code describes it.
#[derive(Clone, Debug)]
struct Key {
    /// Its name, dotted.
    name: String,
    is_table: bool,
    note: &'static str,
    about: String,
}

/// The keys of a struct and of the structs within it, in their order.
fn keys(items: &[Item], path: &str, name: &str) -> Vec<Key> {
    let fields = items.iter().filter(|item| item.name == name).flat_map(|item| &item.rows);
    let keys = fields.flat_map(|Row { name, kind, about }| {
        let kind = kind.trim_start_matches("Option<").trim_end_matches('>');
        let name = format!("{path}{name}");
        let is_table = items.iter().any(|item| item.name == kind);
        let within = if is_table { keys(items, &format!("{name}."), kind) } else { Vec::new() };
        let about = format!("{}.", plain(about).trim_end_matches('.'));
        let note = if kind == "Draw" { "drawn" } else { "" };
        [vec![Key { name, is_table, note, about }], within].concat()
    });
    keys.collect()
}

/// A value of single precision with as many digits as the code has.
fn short(value: &Value) -> String {
    match value {
        #[expect(clippy::cast_possible_truncation, reason = "compared with what it was")]
        Value::Float(wide) if f64::from(*wide as f32) == *wide => format!("{:?}", *wide as f32),
        Value::Array(values) => {
            format!("[{}]", values.iter().map(short).collect::<Vec<_>>().join(", "))
        }
        Value::Table(table) => {
            let pairs = table.iter().map(|(key, value)| format!("{key} = {}", short(value)));
            format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

/// What a key takes, by the refusals of other values: a range, or names.
fn range(key: &str, refusal: impl Fn(&str) -> Option<String>) -> String {
    let refusals = WRONG.iter().filter_map(|wrong| refusal(&format!("{key} = {wrong}\n")));
    let between = |text: &str| {
        let refused = text.split_once(&format!("{key} = ")).map_or("", |(_, refused)| refused);
        let range = refused.split_once(" is outside ").or(text.split_once("expected one of "))?.1;
        range.lines().next()?.split(" (").next().map(|range| range.replace("` `", "`, `"))
    };
    refusals.filter_map(|text| between(&text)).next().unwrap_or_default()
}

/// A number of many digits as a power of ten.
fn rounded(word: &str) -> String {
    let number = word.parse::<f64>().ok().filter(|_| word.len() > 8);
    number.map_or_else(|| word.to_owned(), |number| format!("{number:e}"))
}

/// The table of keys, with what `refusal` has against a value.
fn table(keys: &[Key], defaults: &Value, refusal: impl Fn(&str) -> Option<String>) -> String {
    let mut text = "\n| key | default | range | | means |\n|---|---|---|---|---|\n".to_owned();
    for Key { name, is_table, note, about } in keys {
        if *is_table {
            text += &format!("| **{name}** | | | {note} | {about} |\n");
            continue;
        }
        let default = name.split('.').try_fold(defaults, |value, key| value.get(key));
        let default = default.map(|value| format!("`{}`", short(value))).unwrap_or_default();
        let range = range(name, &refusal);
        // The range has a column.
        let about =
            if range.is_empty() { about } else { &about.replace(&format!(", {range}"), "") };
        let range = range.split(' ').map(rounded).collect::<Vec<_>>().join(" ");
        text += &format!("| `{name}` | {default} | {range} | {note} | {about} |\n");
    }
    text
}

/// The page of gripd's configuration.
pub(super) fn configuration() -> String {
    let defaults = Value::Table(Table::try_from(HostConfig::default()).unwrap_or_default());
    let refusal = |text: &str| Some(HostConfig::parse(Path::new("x"), text).err()?.to_string());
    let mut keys = keys(&items(CONFIGURATION), "", "HostConfig");
    for key in &mut keys {
        let first = key.name.split('.').next().unwrap_or("");
        key.note = if NEEDS_RESTART.contains(&first) { "restart" } else { "" };
    }
    let about = "Every key of [gripd.toml](../gripd.toml). Ranges hold with the other keys at their defaults; a key without a \
                 default is absent. *restart*: a running gripd keeps the value until it starts anew \
                 ([configuration](../configuration.md)).";
    page("Keys of the configuration", about) + &table(&keys, &defaults, refusal)
}

/// The page of the keys of a scene.
pub(super) fn scenes() -> String {
    let parse = |text: &str| Scene::from_toml(&format!("name = \"x\"\n{text}"));
    let all = parse("[vibration]\n").ok();
    let defaults = all.and_then(|scene| Table::try_from(scene.config()).ok()).unwrap_or_default();
    let defaults = Value::Table(defaults.into_iter().filter(|(key, _)| key != "name").collect());
    let refusal = |text: &str| Some(parse(text).err()?.to_string());
    let about = "Every key of a [scene](../scenes.md). Ranges hold with the other keys at their defaults; a key without a default \
                 is absent, but `name`, which every scene has. *drawn*: a number or a [distribution](../scenes.md#quantities). \
                 Times of what happens count from the lift.";
    page("Keys of a scene", about)
        + &table(&keys(&items(SCENE), "", "SceneConfig"), &defaults, refusal)
}

#[cfg(test)]
mod tests {
    use super::{CONFIGURATION, SCENE, configuration, items, keys, scenes, short};
    use grip_session::config::HostConfig;
    use std::collections::BTreeSet;
    use toml::{Table, Value};

    /// Names of the values of a table; distributions and bands in a list are values.
    fn names(path: &str, table: &Table) -> BTreeSet<String> {
        let is_draw = |table: &Table| table.keys().any(|key| key.contains("uniform"));
        let of = |(key, value): (&String, &Value)| match value {
            Value::Table(inner) if !is_draw(inner) => names(&format!("{path}{key}."), inner),
            _ => BTreeSet::from([format!("{path}{key}")]),
        };
        table.iter().flat_map(of).collect()
    }

    #[test]
    fn every_value_that_serde_knows_is_a_key_with_a_meaning() {
        let configuration = Table::try_from(HostConfig::default()).unwrap();
        let scene = grip_sim::Scene::from_toml("name = \"x\"\n[vibration]\n").unwrap();
        let scene = Table::try_from(scene.config()).unwrap();
        for (keys, known, absent) in [
            (keys(&items(CONFIGURATION), "", "HostConfig"), configuration, 26),
            (keys(&items(SCENE), "", "SceneConfig"), scene, 3),
        ] {
            let names = names("", &known);
            let keys: Vec<_> = keys.into_iter().filter(|key| !key.is_table).collect();
            let ours: BTreeSet<String> = keys.iter().map(|key| key.name.clone()).collect();
            assert!(names.is_subset(&ours), "{:?}", names.difference(&ours));
            assert_eq!((ours.len(), ours.len() - names.len()), (keys.len(), absent));
            assert!(keys.iter().all(|key| key.about.ends_with('.')), "{keys:?}");
        }
    }

    #[test]
    fn a_key_has_its_default_its_range_and_its_meaning() {
        let pages = configuration() + &scenes();
        for row in [
            "| `drive.lag_ms` | `5.0` | 0.1 to 200 |  | Lag of the drive (ms). |",
            "| `friction_ratio` | `{ uniform = [1.0, 1.2] }` | 1 to 2 | drawn | Static over kinetic friction. |",
            "| `seed` | `0` |  |  | Seed of the object, its surface, the sensor noise and what happens. |",
            "| `detector.gross` | `25.0` | 1.5 to 1e9 |  | Energy of the vibration band, or of one of the two highest octaves, over its floor at which a slip is gross. |",
            "| `log_level` | `\"info\"` | `error`, `warn`, `info`, `debug` |  | What is logged on standard error. |",
            "| `max_clients` | `32` | 1 to 1024 | restart | Clients at a time. |",
        ] {
            assert!(pages.lines().any(|line| line == row), "{row}");
        }
        assert_eq!(short(&Value::Float(f64::from(0.141_421_36_f32))), "0.14142136");
    }
}
