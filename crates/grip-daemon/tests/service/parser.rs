//! A strict reader of the text format 0.0.4, written from its description and not from our writer.

use std::collections::{BTreeMap, BTreeSet};

/// A sample by its name and labels.
pub(crate) type Samples = BTreeMap<(String, Vec<(String, String)>), f64>;

/// Reads a page; panics where a line does not follow the format.
pub(crate) fn parse(page: &str) -> Samples {
    assert!(page.ends_with('\n'), "the last line must end");
    let mut types: BTreeMap<String, String> = BTreeMap::new();
    let (mut helped, mut closed) = (BTreeSet::new(), BTreeSet::new());
    let (mut samples, mut current) = (Samples::new(), String::new());
    for line in page.lines() {
        if let Some(comment) = line.strip_prefix("# ") {
            let mut words = comment.splitn(3, ' ');
            let (word, name, rest) =
                (words.next().unwrap(), words.next().unwrap(), words.next().unwrap());
            if name != current {
                assert!(closed.insert(name.to_owned()), "{name} stands in two places");
                name.clone_into(&mut current);
            }
            match word {
                "HELP" => assert!(helped.insert(name.to_owned()) && rest.ends_with('.'), "{line}"),
                "TYPE" => {
                    assert!(types.insert(name.to_owned(), rest.to_owned()).is_none(), "{line}")
                }
                _ => panic!("{line}"),
            }
            continue;
        }
        let (name, labels, value) = sample(line);
        let kind = &types[&current];
        let family =
            ["_bucket", "_sum", "_count"].into_iter().find_map(|end| name.strip_suffix(end));
        let family = family.filter(|_| kind == "histogram").unwrap_or(&name);
        assert_eq!(family, current, "{line}");
        assert!(helped.contains(family));
        assert_eq!(kind == "counter", name.ends_with("_total"), "{line}");
        assert!(kind != "counter" || value >= 0.0, "{line}");
        assert!(samples.insert((name, labels), value).is_none(), "twice: {line}");
    }
    samples
}

fn sample(line: &str) -> (String, Vec<(String, String)>, f64) {
    let end = line.find(['{', ' ']).unwrap();
    let name = &line[..end];
    assert!(is_name(name), "{line}");
    let mut rest = &line[end..];
    let mut labels = Vec::new();
    if let Some(mut inner) = rest.strip_prefix('{') {
        while !inner.starts_with('}') {
            let (label, after) = inner.split_once("=\"").unwrap();
            assert!(is_name(label) && !label.contains(':'), "{line}");
            let (value, after) = quoted(after);
            labels.push((label.to_owned(), value));
            inner = after.strip_prefix(',').unwrap_or(after);
        }
        rest = &inner[1..];
    }
    let value = rest.strip_prefix(' ').unwrap();
    let value = match value {
        "NaN" => f64::NAN,
        "+Inf" => f64::INFINITY,
        "-Inf" => f64::NEG_INFINITY,
        number => {
            assert!(number.chars().all(|c| c.is_ascii_digit() || "+-.e".contains(c)), "{line}");
            number.parse().unwrap()
        }
    };
    (name.to_owned(), labels, value)
}

/// The value of a label and what follows its closing quote.
fn quoted(text: &str) -> (String, &str) {
    let (mut value, mut chars) = (String::new(), text.char_indices());
    loop {
        match chars.next().unwrap() {
            (_, '\\') => value.push(match chars.next().unwrap().1 {
                'n' => '\n',
                c @ ('\\' | '"') => c,
                other => panic!("\\{other}"),
            }),
            (at, '"') => return (value, &text[at + 1..]),
            (_, c) => value.push(c),
        }
    }
}

fn is_name(name: &str) -> bool {
    let first = |c: char| c.is_ascii_alphabetic() || c == '_' || c == ':';
    name.starts_with(first) && name.chars().all(|c| first(c) || c.is_ascii_digit())
}
