//! `gripctl study`: a report, its numbers and its figures.

use crate::run::{gripctl, number, read};
use serde_json::Value;
use std::{fs, path::Path};

fn numbers(folder: &Path) -> Value {
    serde_json::from_str(&read(folder, "s/study.json")).unwrap()
}

#[test]
fn a_quick_study_writes_a_page_its_numbers_and_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let base = "study --quick --out s --seed 3 --repeats 2 --epochs 60";
    let reported = gripctl(&folder, format!("{base} --json")).done().json();
    let [summary] = reported.as_slice() else { panic!("one line: {reported:?}") };
    assert_eq!((&summary["type"], &summary["conditions"]), (&"study".into(), &7.into()));
    let json = numbers(folder.path());
    assert_eq!((&json["type"], &json["seed"]), (&"study".into(), &3.into()));
    let paper = &json["results"].as_array().unwrap()[1];
    assert_eq!(paper["condition"], "paper");
    let scores = &paper["nets"][2]["scores"][0]["unseen"]["correct"][1];
    assert_eq!(&summary["unseen_within_10pct"]["paper"]["rprop"], scores);
    assert_eq!(
        summary["unseen_within_10pct"]["paper"]["best_possible"],
        paper["ceiling"]["within_10pct"]
    );
    assert!(number(summary, "paper_difference_points") > 0.0);
    let html = read(&folder, "s/report.html");
    for text in ["Table 2.", "Fig. 3.", "Fig. 6.", "Fig. 7.", "All conditions", "<svg"] {
        assert!(html.contains(text), "no {text}");
    }
    for outside in ["src=", "<script", "<link", "@import", "href=\"http"] {
        assert!(!html.contains(outside), "{outside} in the report");
    }
    let figures: Vec<_> = fs::read_dir(folder.path().join("s/figures")).unwrap().collect();
    assert_eq!(figures.len(), html.matches("<figure").count());
    assert_eq!(summary["figures"], figures.len());
    for figure in figures {
        assert!(fs::read(figure.unwrap().path()).unwrap().starts_with(b"\x89PNG"));
    }
    // The rows of the study train like any others.
    let args = "train s/rows/paper-train.npz --test s/rows/paper-unseen.npz";
    let columns = "--inputs slip_speed_m_s,esc_literal_w --target adequate_force_n";
    let more = "--epochs 5 -o m.json --json";
    let trained = gripctl(&folder, format!("{args} {columns} {more}")).done().json();
    assert_eq!((&trained[0]["train_rows"], &trained[0]["test_rows"]), (&100.into(), &2000.into()));
    // The same seed gives the same numbers, in words too.
    let text = gripctl(&folder, base).done();
    assert_eq!(numbers(folder.path()), json);
    assert!(text.out.contains("report s/report.html") && text.err.is_empty(), "{text:?}");
}

#[test]
fn claims_are_reported_with_the_draws_that_decide_them() {
    let folder = tempfile::tempdir().unwrap();
    let few = "--draws 2 --repeats 2 --epochs 30 --rate 0.05";
    let run = |more: &str| {
        let base = "study --claims --out c";
        gripctl(&folder, format!("{base} {few} {more}")).done()
    };
    let claims = run("--json").json();
    assert!(claims.len() > 15 && claims.iter().all(|claim| claim["type"] == "claim"), "{claims:?}");
    let exclude = claims.iter().find(|claim| claim["place"] == "Figs. 3-7").unwrap();
    assert_eq!(exclude["draws"][0], serde_json::json!(["fixed-0", 0, 2]), "{exclude}");
    let text = run("--momentum heavy-ball").out;
    assert!(text.contains("| eq1-trial |") && text.contains("cannot be decided"), "{text}");
    let json: Value = serde_json::from_str(&read(&folder, "c/study.json")).unwrap();
    assert_eq!(
        (&json["type"], json["claims"].as_array().map(Vec::len)),
        (&"claims".into(), Some(claims.len()))
    );
    assert!(read(&folder, "c/report.html").contains("Claims of the source study"));
}
