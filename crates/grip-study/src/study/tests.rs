use super::*;
use core::sync::atomic::{AtomicUsize, Ordering};
use rayon::ThreadPoolBuilder;

fn tiny() -> StudyConfig {
    let conditions = ["paper", "varied-0", "default"].map(|name| Condition::named(name).unwrap());
    StudyConfig {
        repeats: 3,
        draws: 2,
        epochs: 40,
        known_rows: 1000,
        conditions: conditions.to_vec(),
        ..StudyConfig::quick(7)
    }
}

fn on_threads(threads: usize) -> Study {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| run(&tiny(), &|| ())).unwrap()
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let one = on_threads(1);
    let four = on_threads(4);
    assert_eq!(one.report(None, &[]).json().to_string(), four.report(None, &[]).json().to_string());
    assert_eq!(one, four);
    let other = run(&StudyConfig { seed: 8, ..tiny() }, &|| ()).unwrap();
    assert_ne!(one.results, other.results);
}

#[test]
fn progress_counts_every_training() {
    let (done, config) = (AtomicUsize::new(0), tiny());
    run(&config, &|| _ = done.fetch_add(1, Ordering::Relaxed)).unwrap();
    assert_eq!((done.into_inner(), config.trainings()), (3 * 2 * 7 * 3, 3 * 2 * 7 * 3));
}

/// How tables stand in a page is for the tests of grip-plot.
#[test]
fn the_report_holds_the_numbers_of_the_results() {
    let study = run(&tiny(), &|| ()).unwrap();
    let claims = StudyConfig { draws: 1, epochs: 5, ..study.config.claims_beside() };
    let claims = claims::judge(&claims, &|| ()).unwrap();
    let report = study.report(Some(&claims), &[]);
    let (html, json) = (report.html().unwrap(), report.json());
    let ids: Vec<&str> = report.tables().iter().map(|table| table.id.as_str()).collect();
    assert_eq!(ids, ["table-2", "claims", "questions", "all-unseen"]);
    for condition in ["paper", "default"] {
        for figure in ["3", "4", "5", "6", "6a", "6b", "6c", "7"] {
            assert!(html.contains(&format!("<figure id=\"fig-{figure}-{condition}\"")));
        }
    }
    let paper = &study.result("paper").unwrap().nets[2];
    let rprop = &report.tables()[0].rows[2];
    assert_eq!(rprop[3].json(), paper.mean(|scores| scores.test.within_10pct()));
    assert_eq!(rprop[4].json(), 0.6902);
    let found = &json["results"][0];
    assert_eq!(
        (&found["condition"], &found["nets"][2]["trainer"]),
        (&"paper".into(), &"RPROP".into())
    );
    assert_eq!(
        found["nets"][2]["scores"][0]["test"]["correct"][1],
        paper.scores[0].test.within_10pct()
    );
    let distances = json["distances"].as_array().unwrap();
    assert_eq!(distances.len(), 3 * 7);
    let points = |at: usize| distances[at]["points"].as_f64().unwrap();
    assert!(points(0) > 0.0 && points(0) < points(20), "{distances:?}");
    let share = 100.0 * paper.mean(|scores| scores.unseen.within_10pct());
    assert!(report.summary[1].contains(&format!("RPROP {share:.0}")), "{:?}", report.summary);
    let gp = study.result("paper").unwrap().unseen().pop().unwrap();
    assert!(gp.0 == "GP" && (0.3..0.7).contains(&gp.1), "{gp:?}");
}

#[test]
fn settings_out_of_range_are_refused() {
    let message = |config: StudyConfig| run(&config, &|| ()).unwrap_err().to_string();
    assert_eq!(message(StudyConfig { repeats: 0, ..tiny() }), "repeats is 0: it must be 1 or more");
    assert_eq!(
        message(StudyConfig { known_rows: 10, ..tiny() }),
        "known_rows is 10: it must be 1000 or more"
    );
    assert_eq!(
        message(StudyConfig { conditions: vec![], ..tiny() }),
        "conditions is 0: it must be 1 or more"
    );
}
