//! C sources: their names, their refusals, and that all parts are there. `gripctl export --verify` and its tests compile them.

use super::super::test_models;
use super::*;
use crate::train::Interval;

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
fn every_model_becomes_a_header_and_a_source() {
    for file in test_models::all() {
        let CSource { header, source } = source(&file, "force", "force.h", "m */ .json").unwrap();
        let inputs = format!("#define FORCE_INPUTS {}", file.inputs.len());
        assert!(header.contains(&inputs) && header.contains("FORCE_IN_INPUT_0_"), "{header}");
        for layer in 1..=file.layers.len() {
            assert!(
                source.contains(&format!("layer(weights_{layer}, biases_{layer}, ")),
                "{source}"
            );
        }
        let text = [header, source].concat();
        assert_eq!(text.matches("/*").count(), text.matches("*/").count(), "{text}");
        assert!(!text.contains("malloc") && !text.contains("tanhf"), "{text}");
        assert_eq!(text.matches('{').count(), text.matches('}').count(), "{text}");
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
fn an_interval_is_a_function_of_the_answers() {
    let mut file = test_models::all()[4].clone();
    assert!(!source(&file, "force", "force.h", "m.json").unwrap().header.contains("_interval"));
    file.interval = Some(Interval {
        level: 0.9,
        widths: vec![1.5, 0.25, 2.0, 0.0],
        from: "tests */".to_owned(),
    });
    let CSource { header, source } = source(&file, "force", "force.h", "m.json").unwrap();
    assert!(header.contains("void force_interval(const float out[FORCE_OUTPUTS], float low["));
    assert!(header.contains("hold 90 % of the truths (tests"), "{header}");
    assert_eq!(header.matches("/*").count(), header.matches("*/").count(), "{header}");
    for line in ["low[0] = out[0] / 1.5e0f;", "high[1] = out[1] + 2.5e-1f;"] {
        assert!(source.contains(line), "{line}: {source}");
    }
}

#[test]
fn a_classifier_ends_in_softmax_and_all_inputs_have_a_flag() {
    let text = source(&test_models::classifier(), "side", "side.h", "m.json").unwrap();
    assert!(text.source.contains("softmax(raw, SIDE_OUTPUTS);") && text.source.contains("math.h"));
    assert!(text.source.contains("1u << (i < 31 ? i : 31)"), "{}", text.source);
    assert!(text.header.contains("probabilities of the classes of side"), "{}", text.header);
}
