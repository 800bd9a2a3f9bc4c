//! The one table of all commands: rows that serialise for machines, as columns for people.

use crate::output;
use grip_plot::report::Cell;
use grip_session::exit::escape;
use serde::Serialize;
use serde_json::Value;

/// Prints a column for each of `columns`: the path of a field, with another head before `=`, in percent with `%` behind it. Of an object
/// its quantiles stand, of a flag that is set its head.
pub(crate) fn print<T: Serialize>(rows: &[T], columns: &[&str]) -> anyhow::Result<()> {
    let rows = rows.iter().map(serde_json::to_value).collect::<Result<Vec<_>, _>>()?;
    lines(&rows, columns).iter().try_for_each(|line| Ok(output::line(line)?))
}

fn lines(rows: &[Value], columns: &[&str]) -> Vec<String> {
    let mut lines = vec![String::new(); rows.len() + 1];
    for (at, column) in columns.iter().enumerate() {
        let (head, field) = column.split_once('=').unwrap_or((column, column));
        let (path, scale) = field.strip_suffix('%').map_or((field, 1.0), |path| (path, 100.0));
        let (path, head) = (format!("/{}", path.replace('.', "/")), head.replace('_', " "));
        let values: Vec<&Value> =
            rows.iter().map(|row| row.pointer(&path).unwrap_or(&Value::Null)).collect();
        let cells = values.iter().map(|value| shown(value, scale, &head));
        let cells: Vec<String> = core::iter::once(head.clone()).chain(cells).collect();
        let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
        let is_text = values.iter().all(|value| !value.is_number() && !value.is_object());
        let gap = if at == 0 { "" } else { "  " };
        for (line, cell) in lines.iter_mut().zip(cells) {
            *line += gap;
            *line += &if is_text { format!("{cell:width$}") } else { format!("{cell:>width$}") };
        }
    }
    lines.into_iter().map(|line| line.trim_end().to_owned()).collect()
}

fn shown(value: &Value, scale: f64, head: &str) -> String {
    let all = |values: Vec<&Value>| {
        values.into_iter().map(|value| shown(value, scale, head)).collect::<Vec<_>>().join(" / ")
    };
    match value {
        Value::Null => "-".to_owned(),
        Value::Bool(set) => {
            if *set {
                head.to_uppercase()
            } else {
                String::new()
            }
        }
        Value::Number(number) => match number.as_f64() {
            Some(float) if !number.is_u64() || scale > 1.0 => digits(scale * float),
            _ => number.to_string(),
        },
        Value::String(text) => escape(text),
        Value::Array(values) => all(values.iter().collect()),
        Value::Object(fields) => {
            all(["p50", "p95", "max"].iter().filter_map(|name| fields.get(*name)).collect())
        }
    }
}

/// Three significant digits, and three places behind the point of what is longer: times, too, differ by milliseconds.
fn digits(value: f64) -> String {
    if (100.0..1e6).contains(&value.abs()) {
        let text = format!("{value:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    Cell::Number(value).shown()
}

#[cfg(test)]
mod tests {
    use super::lines;
    use serde_json::json;

    #[test]
    fn a_time_keeps_its_milliseconds() {
        let shown = [123.456, 99.9561, 100.0, -2_345.5, 0.001_234_5].map(super::digits);
        assert_eq!(shown, ["123.456", "100.0", "100", "-2345.5", "0.00123"]);
    }

    #[test]
    fn every_kind_of_field_has_its_column() {
        let rows = [
            json!({"name": "a", "n": 3, "mm": {"max": 3.0, "p50": 0.123_45, "p95": null}, "share": [0.5, 1.0], "lost": true}),
            json!({"name": "long\nname", "n": 12, "mm": {}, "share": null, "lost": false, "in": {"er": 7}}),
        ];
        let columns = ["name", "n", "slip mm=mm", "%=share%", "lost", "deep=in.er"];
        assert_eq!(
            lines(&rows, &columns),
            [
                "name         n           slip mm  %           lost  deep",
                "a            3  0.123 / - / 3.00  50.0 / 100  LOST     -",
                "long\\nname  12                    -                    7",
            ]
        );
    }
}
