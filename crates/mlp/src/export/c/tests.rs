//! C sources: their names and refusals, and what a model needs of the library. `gripctl export --verify` and its tests compile them.

use super::super::test_models;
use super::*;

#[test]
fn prefixes_are_made_and_checked() {
    for (name, expected) in [
        ("force", "force"),
        ("Force-2.1", "force_2_1"),
        ("2-10-1", "m_2_10_1"),
        ("", "m_"),
        ("a_name_of_very_many_letters", "a_name_of_very_man"),
    ] {
        assert_eq!(prefix_of(name), expected);
    }
    let file = &test_models::all()[0];
    for prefix in ["", "1a", "_a", "a b", "a;b", "ä", "a_name_of_very_many_letters"] {
        let error = source(file, prefix, "m.h", "m.json").unwrap_err();
        assert_eq!(error, ExportError::Prefix { prefix: prefix.to_owned() });
    }
}

#[test]
fn the_mathematics_of_the_library_is_used_for_logarithms_only() {
    let [plain, logarithmic] =
        [0, 2].map(|at| source(&test_models::all()[at], "m", "m.h", "m.json").unwrap().source);
    assert!(!plain.contains("math.h") && !plain.contains("rational_tanh"), "{plain}");
    assert!(logarithmic.contains("math.h") && logarithmic.contains("rational_tanh"));
    assert!(logarithmic.contains("logf(in[0])") && logarithmic.contains("expf("), "{logarithmic}");
    let reciprocal = source(&test_models::all()[8], "m", "m.h", "m.json").unwrap().source;
    assert!(reciprocal.contains("-1.0f / in[0]") && !reciprocal.contains("math.h"), "{reciprocal}");
}

#[test]
fn all_of_many_inputs_have_a_flag() {
    let text = source(&test_models::classifier(), "side", "side.h", "m.json").unwrap();
    assert!(text.source.contains("1u << (i < 31 ? i : 31)"), "{}", text.source);
    assert!(text.header.contains("probabilities of the classes of side"), "{}", text.header);
}
