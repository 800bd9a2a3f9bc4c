//! Numbers of a JSON message with their paths.

use serde_json::Value;

/// Most items of an array that are signals, and how deep objects are followed.
const MOST_ITEMS: usize = 256;
const DEEPEST: usize = 16;

/// Gives each number (`true` being 1) of `value` with its path to `leaf`.
pub(crate) fn leaves(value: &Value, path: &mut String, leaf: &mut impl FnMut(&str, f64)) {
    follow(value, path, leaf, 0);
}

fn follow(value: &Value, path: &mut String, leaf: &mut impl FnMut(&str, f64), depth: usize) {
    let before = path.len();
    match value {
        Value::Number(number) => leaf(path, number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(on) => leaf(path, f64::from(u8::from(*on))),
        Value::Array(items) if items.len() <= MOST_ITEMS && depth < DEEPEST => {
            for (k, item) in items.iter().enumerate() {
                path.push_str(&format!("[{k}]"));
                follow(item, path, leaf, depth + 1);
                path.truncate(before);
            }
        }
        Value::Object(fields) if depth < DEEPEST => {
            for (name, field) in fields {
                if before > 0 {
                    path.push('.');
                }
                path.push_str(name);
                follow(field, path, leaf, depth + 1);
                path.truncate(before);
            }
        }
        _ => {}
    }
}
