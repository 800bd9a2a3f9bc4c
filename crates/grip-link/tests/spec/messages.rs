//! The screens of messages: each message has its section, and asks for an answer where its row states so.

use crate::markdown::{Row, headings, table};
use crate::table::rows;
use std::collections::BTreeMap;

#[test]
fn each_message_has_its_section_and_asks_as_its_vectors_do() {
    let screens = ["## 4 Messages on one screen", "### Messages of the daemon on one screen"];
    let screens: Vec<Row> = screens.into_iter().flat_map(table).collect();
    let mut asks = BTreeMap::new();
    for row in [rows::<7>("valid.tsv"), rows::<7>("clients.tsv")].concat() {
        if row[1] == "both" {
            asks.entry(row[3].clone()).or_insert(row[4].contains("ack_req=1"));
        }
    }
    for row in &screens {
        let heading = format!("### {} {}", row[0], row[1]);
        assert_eq!(headings(&heading), [heading.as_str()]);
        assert_eq!(row[4] == "yes", asks[&row[1]], "{}", row[1]);
    }
}
