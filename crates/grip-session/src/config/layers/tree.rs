//! Tables of TOML with the places of their keys: merged, searched, listed.

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// How many names of a dotted key are set, and where the last of them stands. What lies in an array counts as set.
pub(super) fn depth(root: &DeTable<'_>, key: &str) -> (usize, Option<usize>) {
    let names: Vec<&str> = key.split('.').collect();
    let mut table = root;
    let mut at = None;
    for (depth, name) in names.iter().enumerate() {
        let Some((key, value)) = find(table, name) else { return (depth, at) };
        at = Some(key);
        let DeValue::Table(inner) = value else { return (names.len(), at) };
        table = inner;
    }
    (names.len(), at)
}

fn find<'a, 'i>(table: &'a DeTable<'i>, name: &str) -> Option<(usize, &'a DeValue<'i>)> {
    table
        .iter()
        .find(|(key, _)| key.get_ref().as_ref() == name)
        .map(|(key, value)| (key.span().start, value.get_ref()))
}

/// Puts `top` over `below`: tables key by key, everything else as a whole.
pub(super) fn merge<'i>(below: &mut DeTable<'i>, top: &DeTable<'i>) {
    for (key, value) in top {
        let lower = below.get_mut(key);
        if let (DeValue::Table(top), Some(lower)) = (value.get_ref(), lower)
            && let DeValue::Table(lower) = lower.get_mut()
        {
            merge(lower, top);
            continue;
        }
        // The old key goes too: it bears the place of the layer below.
        below.remove(key);
        below.insert(key.clone(), value.clone());
    }
}

/// Each value that is no table: its dotted name, the byte of its key, and itself as TOML.
pub(super) fn leaves(table: &Spanned<DeTable<'_>>) -> Vec<(String, usize, String)> {
    let mut leaves = Vec::new();
    let mut open = vec![(String::new(), table.get_ref())];
    while let Some((path, table)) = open.pop() {
        for (key, value) in table {
            let name = format!("{path}{}", key.get_ref());
            match value.get_ref() {
                DeValue::Table(inner) => open.push((format!("{name}."), inner)),
                value => leaves.push((name, key.span().start, shown(value))),
            }
        }
    }
    leaves
}

/// A value on one line.
fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(time) => time.to_string(),
        DeValue::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| shown(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        DeValue::Table(table) => {
            let items =
                table.iter().map(|(k, v)| format!("{} = {}", k.get_ref(), shown(v.get_ref())));
            format!("{{ {} }}", items.collect::<Vec<_>>().join(", "))
        }
    }
}
