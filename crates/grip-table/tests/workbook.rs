//! Workbooks of Excel: the first sheet with numbers is read as a table of text is.
#![expect(clippy::unwrap_used, reason = "helpers of the tests stand outside the test functions")]

use std::io::{Cursor, Write as _};
use std::path::Path;

use grip_table::Table;
use zip::{ZipWriter, write::SimpleFileOptions};

/// A workbook of these sheets, rows of cells: numbers, or text where they begin with a quotation mark; `@C7` is a 2 in that place.
fn workbook(sheets: &[&[&[&str]]]) -> Vec<u8> {
    let main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    let relations = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let package = "http://schemas.openxmlformats.org/package/2006";
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let mut put = |name: &str, text: &str| {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    };
    put("[Content_Types].xml", &format!("<Types xmlns=\"{package}/content-types\"/>"));
    put(
        "_rels/.rels",
        &format!(
            "<Relationships xmlns=\"{package}/relationships\"><Relationship Id=\"r\" Type=\"{relations}/officeDocument\" \
             Target=\"xl/workbook.xml\"/></Relationships>"
        ),
    );
    let (mut names, mut targets) = (String::new(), String::new());
    for (k, rows) in sheets.iter().enumerate() {
        names += &format!("<sheet name=\"s{k}\" sheetId=\"{}\" r:id=\"r{k}\"/>", k + 1);
        targets += &format!(
            "<Relationship Id=\"r{k}\" Type=\"{relations}/worksheet\" Target=\"worksheets/s{k}.xml\"/>"
        );
        let cell = |text: &&str| match text.strip_prefix('"') {
            Some(text) => format!("<c t=\"inlineStr\"><is><t>{text}</t></is></c>"),
            None if text.is_empty() => "<c/>".to_owned(),
            None if text.starts_with('@') => format!("<c r=\"{}\"><v>2</v></c>", &text[1..]),
            None => format!("<c><v>{text}</v></c>"),
        };
        let row =
            |cells: &&[&str]| format!("<row>{}</row>", cells.iter().map(cell).collect::<String>());
        let rows: String = rows.iter().map(row).collect();
        put(
            &format!("xl/worksheets/s{k}.xml"),
            &format!("<worksheet xmlns=\"{main}\"><sheetData>{rows}</sheetData></worksheet>"),
        );
    }
    put(
        "xl/workbook.xml",
        &format!(
            "<workbook xmlns=\"{main}\" xmlns:r=\"{relations}\"><sheets>{names}</sheets></workbook>"
        ),
    );
    put(
        "xl/_rels/workbook.xml.rels",
        &format!("<Relationships xmlns=\"{package}/relationships\">{targets}</Relationships>"),
    );
    zip.finish().unwrap().into_inner()
}

#[test]
fn the_first_sheet_with_numbers_is_the_table() {
    let remarks: &[&[&str]] = &[&["\"Recorded by hand, see s1"]];
    let rows: &[&[&str]] = &[
        &["\"Scope 7"],
        &["\"Time", "\"phase", "\"vibration, raw"],
        &["\"(ms)", "\"", "\"(mV)"],
        &["0", "\"hold", "0.25"],
        &["0.625", "\"hold", "-1.5E-3"],
        &["1.25", "", ""],
    ];
    let bytes = workbook(&[remarks, rows]);
    let mut table = Table::open(Path::new("x.xlsx"), bytes.as_slice()).unwrap();
    assert_eq!(table.header(), ["Time", "phase", "vibration, raw"]);
    assert_eq!(table.columns()[0].unit.as_deref(), Some("ms"));
    let mut values = Vec::new();
    while let Some(row) = table.next_row().unwrap() {
        values.push((row.value(0).unwrap(), row.value(2).unwrap()));
    }
    assert_eq!(values, [(Some(0.0), Some(0.25)), (Some(0.625), Some(-0.0015)), (Some(1.25), None)]);

    for (bytes, words) in [
        (workbook(&[remarks]), "no sheet has numbers"),
        (bytes[..200].to_vec(), "save the sheet as CSV"),
    ] {
        let message = Table::open(Path::new("x.xlsx"), bytes.as_slice()).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// A file of some kB can ask for any memory and work.
#[test]
fn a_workbook_that_grows_beyond_measure_is_refused() {
    let spaces = " ".repeat(17 << 20);
    let packed = workbook(&[&[&["1", &format!("\"{spaces}")]]]);
    let far = workbook(&[&[&["1"], &["@XFD1048576"]]]);
    for (bytes, words) in
        [(packed, "unpacks to more than 16 MiB"), (far, "more than 67108864 cells")]
    {
        let message = Table::open(Path::new("x.xlsx"), bytes.as_slice()).unwrap_err().to_string();
        assert!(message.contains(words) && message.contains("as CSV"), "{message}");
    }
}
