//! Writer of numbers in the text format 0.0.4 of Prometheus.
//!
//! Source: the exposition formats page of the Prometheus documentation. By hand: docs/decisions/0056-watching.md.

use crate::latency::Latency;
use core::fmt::{self, Display, Write as _};

/// The media type of the text.
pub const MEDIA_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// A page that grows metric by metric. Its memory is kept from page to page.
#[derive(Clone, Debug, Default)]
pub struct Exposition {
    text: String,
}

impl Exposition {
    /// Forgets the page, not its memory.
    pub fn clear(&mut self) {
        self.text.clear();
    }

    /// The page.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A metric that rises, or begins anew with the program.
    pub fn counter<'a>(&'a mut self, name: &'a str, help: &'a str) -> Metric<'a> {
        Metric { page: self, kind: "counter", name, help }
    }

    /// A metric that goes up and down.
    pub fn gauge<'a>(&'a mut self, name: &'a str, help: &'a str) -> Metric<'a> {
        Metric { page: self, kind: "gauge", name, help }
    }

    /// A metric of value 1 whose labels state something.
    pub fn info(&mut self, name: &str, help: &str, labels: &[(&str, &str)]) {
        self.header("gauge", name, help);
        self.write(format_args!("{name}{{"));
        for (index, (label, value)) in labels.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            self.write(format_args!("{comma}{label}=\"{}\"", Quoted(value)));
        }
        self.write(format_args!("}} 1\n"));
    }

    /// A histogram in seconds.
    pub fn histogram(&mut self, name: &str, help: &str, latency: &Latency) {
        self.header("histogram", name, help);
        for (upper_ns, count) in latency.cumulative() {
            self.write(format_args!("{name}_bucket{{le=\"{}\"}} {count}\n", seconds(upper_ns)));
        }
        let count = latency.count();
        self.write(format_args!("{name}_bucket{{le=\"+Inf\"}} {count}\n"));
        self.write(format_args!("{name}_sum {}\n", seconds(latency.sum_ns())));
        self.write(format_args!("{name}_count {count}\n"));
    }

    fn header(&mut self, kind: &str, name: &str, help: &str) {
        self.write(format_args!("# HELP {name} {help}\n# TYPE {name} {kind}\n"));
    }

    fn write(&mut self, text: fmt::Arguments<'_>) {
        // A string takes everything.
        let _: fmt::Result = self.text.write_fmt(text);
    }
}

/// A metric whose values are still to be written.
#[derive(Debug)]
pub struct Metric<'a> {
    page: &'a mut Exposition,
    kind: &'static str,
    name: &'a str,
    help: &'a str,
}

impl Metric<'_> {
    /// One value.
    pub fn one(self, value: impl Display) {
        let Self { page, kind, name, help } = self;
        page.header(kind, name, help);
        page.write(format_args!("{name} {value}\n"));
    }

    /// One value, or nothing where it is not known.
    pub fn known(self, value: Option<impl Display>) {
        if let Some(value) = value {
            self.one(value);
        }
    }

    /// A value for each value of the label `label`.
    pub fn each<L: AsRef<str>, V: Display>(
        self,
        label: &str,
        values: impl IntoIterator<Item = (L, V)>,
    ) {
        let Self { page, kind, name, help } = self;
        page.header(kind, name, help);
        for (value_of_label, value) in values {
            let quoted = Quoted(value_of_label.as_ref());
            page.write(format_args!("{name}{{{label}=\"{quoted}\"}} {value}\n"));
        }
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

/// The value of a label, escaped.
struct Quoted<'a>(&'a str);

impl Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '\\' => f.write_str("\\\\"),
            '"' => f.write_str("\\\""),
            '\n' => f.write_str("\\n"),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Exposition;

    #[test]
    fn labels_are_escaped() {
        let mut page = Exposition::default();
        page.gauge("a", "An a.").each("file", [("x\"\\\ny", 1.5)]);
        let expected = "# HELP a An a.\n# TYPE a gauge\na{file=\"x\\\"\\\\\\ny\"} 1.5\n";
        assert_eq!(page.text(), expected);
        page.clear();
        page.info("b", "A b.", &[("x", "1"), ("y", "")]);
        assert!(page.text().ends_with("\nb{x=\"1\",y=\"\"} 1\n"), "{}", page.text());
    }
}
