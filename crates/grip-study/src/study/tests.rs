use super::*;
use crate::Report;
use core::sync::atomic::{AtomicUsize, Ordering};
use rayon::ThreadPoolBuilder;
use serde_json::Value;

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

/// The texts of all cells of a page, row by row: what is shown and the value behind it.
fn cells(html: &str, table: &str) -> Vec<Vec<(String, Option<f64>)>> {
    let start = html.find(&format!("<table id=\"{table}\"")).unwrap();
    let body = html[start..].split("<tbody>").nth(1).unwrap().split("</tbody>").next().unwrap();
    let cell = |cell: &str| {
        let (head, rest) = cell.split_once('>').unwrap();
        let value = head.split("data-value=\"").nth(1).map(|v| v.split('"').next().unwrap());
        let value = value.filter(|v| *v != "null").map(|v| v.parse().unwrap());
        (rest.split('<').next().unwrap().to_owned(), value)
    };
    let rows = body.split("<tr>").skip(1);
    rows.map(|row| row.split("<td").skip(1).map(cell).collect()).collect()
}

fn tables(json: &Value) -> Vec<&Value> {
    let sections = json["sections"].as_array().unwrap().iter();
    sections.flat_map(|section| section["tables"].as_array().unwrap()).collect()
}

fn check_table(html: &str, table: &Value) {
    let shown = cells(html, table["id"].as_str().unwrap());
    let rows = table["rows"].as_array().unwrap();
    assert_eq!(shown.len(), rows.len(), "{table}");
    for (shown, row) in shown.iter().flatten().zip(rows.iter().flat_map(|r| r.as_array().unwrap()))
    {
        match row {
            Value::Number(number) => {
                let number = number.as_f64().unwrap();
                assert_eq!(shown.1, Some(number), "{}", table["id"]);
                let reported: f64 = shown.0.parse().unwrap();
                let near = [reported, reported / 100.0]
                    .into_iter()
                    .any(|reported| (reported - number).abs() <= 0.006 * number.abs().max(0.1));
                assert!(near, "{}: {} for {number}", table["id"], shown.0);
            }
            _ => assert_eq!(shown.1, None, "{}: {row}", table["id"]),
        }
    }
}

#[test]
fn the_page_holds_every_table_with_the_numbers_of_the_json() {
    let study = run(&tiny(), &|| ()).unwrap();
    let claims =
        claims::judge(&StudyConfig { draws: 1, epochs: 5, ..study.config.claims_beside() }, &|| ());
    let report = study.report(Some(&claims.unwrap()), &[]);
    let (html, json) = (report.html().unwrap(), report.json());
    let tables = tables(&json);
    tables.iter().for_each(|table| check_table(&html, table));
    let ids: Vec<&str> = tables.iter().map(|table| table["id"].as_str().unwrap()).collect();
    let first: Vec<&str> = ["table-2", "verdicts", "questions", "all-unseen"].into_iter().collect();
    assert_eq!(ids[..4], first, "what is asked first comes first");
    for condition in ["paper", "default"] {
        for table in ["table-1-", "table-2-"] {
            assert!(ids.contains(&format!("{table}{condition}").as_str()), "{ids:?}");
        }
        for figure in ["3", "4", "5", "6", "6a", "6b", "7"] {
            assert!(html.contains(&format!("<figure id=\"fig-{figure}-{condition}\"")));
        }
    }
    check_against_results(&study, &report, &json);
}

/// Tables come from the results, and the results stand in the JSON too.
fn check_against_results(study: &Study, report: &Report, json: &Value) {
    let paper = &study.result("paper").unwrap().nets[2];
    let table = report.tables().into_iter().find(|table| table.id == "table-2-paper").unwrap();
    // Rows: training, test, unseen of each net; columns: net, rows, then the definitions.
    assert_eq!(table.rows[7][3].json(), paper.scores[0].test.within_10pct());
    assert_eq!(table.rows[7][10].json(), 0.6902);
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
