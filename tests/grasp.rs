//! A grasp. Somebody starts gripd on the built-in gripper, as the README states first.
//!
//! The gripper closes with too little force and lifts. The object slips; gripd reports it with what it knows, and presses harder. At the end the object
//! is held with a little more than it needs, and the last line reports it.

use serde_json::Value;
use stories::{Ended, Program, folder, in_one_of_some_runs};

/// gripd with the built-in gripper for some seconds, until in one run the slip has ended and the object is held: a machine that stood still meanwhile
/// leaves too little of them.
fn grasp(more: &[&str]) -> Ended {
    let folder = folder();
    let args = [&["--port", "sim", "--duration", "3", "--listen", "off"], more].concat();
    in_one_of_some_runs(|| {
        let ended = Program::gripd(folder.path(), &args).ended().done();
        let states = |words: [&str; 2]| words.iter().any(|words| ended.out.contains(words));
        let over = states(["\"slip_end\"", "slip ended after"]);
        let held = states(["\"held\":true", "object HELD"]);
        if over && held { Ok(ended) } else { Err(ended.out) }
    })
}

#[test]
fn a_slip_is_reported_and_the_object_is_held() {
    let ended = grasp(&["--json"]);
    let summary = ended.summary();
    let (lines, number) = (ended.lines(), |name: &str| summary[name].as_f64().unwrap());
    let reported = |what: &str| lines.iter().position(|line: &Value| line["type"] == what);
    assert!(reported("slip").unwrap() < reported("slip_end").unwrap(), "{}", ended.out);
    assert!(number("slips") >= 1.0 && number("samples") > 1000.0, "{summary}");
    assert!(summary["dropped"] == false && summary["crushed"] == false, "{summary}");
    assert!(number("force_final_n") > number("force_needed_n"), "{summary}");
    assert!(number("force_final_n") < 60.0 && number("slip_mm") < 30.0, "{summary}");
    // 3 states that a busy machine lost samples; otherwise none is missing.
    let lossy = ["lost", "untold_notes"].iter().any(|name| summary[*name] != 0);
    assert_eq!(ended.code, if lossy { 3 } else { 0 }, "{summary}");
}

#[test]
fn a_person_reads_the_same_in_sentences() {
    let ended = grasp(&[]);
    assert!(ended.err.contains("gripper found"), "{}", ended.err);
    for words in ["slip (", "slip ended after", "latency from frame to command", "object HELD"] {
        assert!(ended.out.contains(words), "no {words:?} in {}", ended.out);
    }
}
