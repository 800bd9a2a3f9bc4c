//! C identifiers, literals, arrays and comments, made from names and numbers of a model.

use core::fmt::Write as _;

/// `name` with everything that C does not allow in identifiers replaced by underscores.
pub(super) fn identifier(name: &str) -> String {
    let clean = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    name.chars().map(clean).collect()
}

/// Upper-case identifiers for `names`, each different: repeated ones get a number.
pub(super) fn constants<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut known: Vec<String> = Vec::new();
    for name in names {
        let plain = identifier(name).to_uppercase();
        let mut candidate = plain.clone();
        let mut count = 2;
        while known.contains(&candidate) {
            candidate = format!("{plain}_{count}");
            count += 1;
        }
        known.push(candidate);
    }
    known
}

/// `text` for a comment: what could end it, continue a line or reorder it is replaced.
pub(super) fn comment(text: &str) -> String {
    let harmless = |c: char| c.is_alphanumeric() || " _-./^%()+:,=;<>[]°".contains(c);
    text.chars().map(|c| if harmless(c) { c } else { '_' }).collect()
}

/// A constant that is read back as the same `f32`.
pub(super) fn literal(value: f32) -> String {
    format!("{value:e}f")
}

/// The same in parentheses where it is negative, for use behind an operator.
pub(super) fn operand(value: f32) -> String {
    if value.is_sign_negative() { format!("({})", literal(value)) } else { literal(value) }
}

/// `static const float NAME[N] = {...};`, `across` values a line.
pub(super) fn array(name: &str, values: &[f32], across: usize) -> String {
    let mut text = format!("static const float {name}[{}] = {{\n", values.len());
    for line in values.chunks(across.clamp(1, 6)) {
        let line: Vec<String> = line.iter().copied().map(literal).collect();
        let _infallible = writeln!(text, "    {},", line.join(", "));
    }
    text + "};\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers_and_stay_apart() {
        assert_eq!(identifier("v (m/s)"), "v__m_s_");
        let names = ["a b", "a_b", "A-B", "µ"];
        assert_eq!(constants(names.into_iter()), ["A_B", "A_B_2", "A_B_3", "_"]);
    }

    #[test]
    fn comments_can_not_be_left() {
        let text = comment("N */ int x; /* \\\n ??/ m/s^2");
        assert!(!text.contains("*/") && !text.contains("/*"), "{text}");
        assert!(!text.contains(['\n', '\\', '?', '*']) && text.contains("m/s^2"), "{text}");
    }

    #[test]
    fn literals_are_read_back() {
        for value in [0.1, -3.5e-12, f32::MAX, f32::MIN_POSITIVE, 1e-45, -0.0, 7.0] {
            let text = literal(value);
            let back: f32 = text.trim_end_matches('f').parse().unwrap();
            assert_eq!(back.to_bits(), value.to_bits(), "{text}");
        }
        assert_eq!((operand(-1.5), operand(2.0)), ("(-1.5e0f)".to_owned(), "2e0f".to_owned()));
    }
}
