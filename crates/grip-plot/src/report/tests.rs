use super::*;
use crate::{Axis, Layer};

fn report() -> Report {
    let mut table = Table::new("t-1", "Errors <all>", &["net", "MSE", "correct", "n", "note"]);
    table.push(vec![
        Cell::text("A & B"),
        Cell::Number(0.012_345),
        Cell::Percent(0.6333),
        Cell::Count(7),
    ]);
    table.push(vec![
        Cell::text("C"),
        Cell::Number(f64::NAN),
        Cell::Percent(f64::NAN),
        Cell::Count(0),
    ]);
    let chart = Chart::new("error", Axis::linear("epoch"), Axis::log("MSE"))
        .with(Layer::line("train", vec![(0.0, 1.0), (10.0, 0.1)]));
    let figure = Figure { id: "fig-1".to_owned(), caption: "Error".to_owned(), chart };
    let folded = Block::Folded { title: "more".to_owned(), blocks: vec![figure.into()] };
    let section = Section::new("first", "First").with("A text.").with(table).with(folded);
    let mut report = Report { title: "Study".to_owned(), ..Report::default() };
    report.summary.push("In short.".to_owned());
    report.push(section);
    report
}

#[test]
fn page_and_json_show_the_same_cells() {
    let (report, html) = (report(), report().html().unwrap());
    let json = report.json();
    let table = &json["sections"][0]["tables"][0];
    assert_eq!(table["columns"][1], "MSE");
    assert_eq!(table["rows"][0][1], 0.012_345);
    assert_eq!((&table["rows"][1][1], &table["rows"][1][4]), (&Value::Null, &Value::Null));
    for text in [
        "<td data-value=\"0.012345\">0.0123</td>",
        "<td data-value=\"0.6333\">63.3</td>",
        "<td data-value=\"7\">7</td>",
        "A &#38; B",
        "Errors &#60;all&#62;",
        "<summary>more</summary>",
        "<p>A text.</p>",
        "In short.",
        "<figcaption>Error</figcaption>",
    ] {
        assert!(html.contains(text), "no {text} in {html}");
    }
    assert_eq!(json["sections"][0]["figures"][0]["layers"][0]["points"][1][1], 0.1);
    assert_eq!((report.figures().len(), report.tables().len()), (1, 1));
}

#[test]
fn the_page_needs_nothing_from_elsewhere() {
    let html = report().html().unwrap();
    for name in html.split("url(#").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        assert!(name.starts_with("fig-1-") && html.contains(&format!("id=\"{name}\"")), "{name}");
    }
    let html = html.replace("url(#", "");
    for outside in ["src=", "url(", "<script", "<link", "@import", "href=\"http"] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(html.contains("<svg"));
}

#[test]
fn numbers_keep_the_digits_that_count() {
    let shown = |number| Cell::Number(number).shown();
    assert_eq!(
        [1234.5, 123.4, 12.34, 1.234, 0.1234, 0.012_34].map(shown),
        ["1234", "123", "12.3", "1.23", "0.123", "0.0123"]
    );
    assert_eq!([0.0, 1e-9, -3.0, 2e7].map(shown), ["0", "1.00e-9", "-3.00", "2.00e7"]);
}
