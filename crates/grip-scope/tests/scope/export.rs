//! Exports: what is written is what is shown, and comes back.

use crate::rig::{Watch, recording};
use grip_record::mcap::{Entry, McapReader, Record};
use grip_record::{CsvOptions, read_csv};
use grip_scope::export::{self, ExportError};
use grip_scope::feed::{RowBlock, TaxelBlock};
use grip_scope::{Channel, EventKind, Feed, Model, SourceSpec, SourceStatus, Span};
use std::fs;
use std::path::Path;

fn loaded(path: &Path) -> Watch {
    let mut watch = Watch::new(SourceSpec::Recording(path.to_owned()));
    watch.until(|| {}, |model| matches!(model.status(), SourceStatus::Complete { .. }));
    watch
}

/// Device times (us) and stylus of the samples in a recording.
fn samples(path: &Path) -> Vec<(u64, f32)> {
    let mut reader = McapReader::open(path).unwrap();
    let mut found = Vec::new();
    while let Some(entry) = reader.next_entry().unwrap() {
        if let Entry::Message { record: Record::Sample(row), .. } = entry {
            found.push((row.sample.t.0, row.sample.stylus));
        }
    }
    found
}

#[test]
fn a_csv_of_the_view_reads_back_as_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 5000);
    let watch = loaded(&path);
    let out = folder.path().join("view.csv");
    let channels = [Channel::Stylus, Channel::NormalForce, Channel::Statistic];
    let rows = export::csv(&watch.model, Span::new(1.0, 1.999), &channels, &out).unwrap();
    assert_eq!(rows, 1000);
    let read = read_csv(&out, &CsvOptions::default()).unwrap();
    let wanted = samples(&path);
    let got: Vec<(u64, f32)> = read.samples.iter().map(|s| (s.t.0, s.stylus)).collect();
    assert_eq!(got, wanted[1000..2000]);
    let before = fs::read(&out).unwrap();
    let again = export::csv(&watch.model, Span::new(1.0, 1.5), &channels, &out).unwrap_err();
    assert!(
        again.to_string().contains("view.csv: is there already and is not replaced"),
        "{again}"
    );
    assert_eq!(fs::read(&out).unwrap(), before);
    let nothing = export::csv(&watch.model, Span::new(90.0, 91.0), &channels, &out);
    assert!(matches!(nothing, Err(ExportError::Empty)));
}

#[test]
fn a_slice_of_a_recording_is_that_part_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 5000);
    let out = folder.path().join("slice.mcap");
    let sliced = export::mcap_slice(&path, Span::new(1.0, 1.999), &out).unwrap();
    assert_eq!((sliced.samples, sliced.messages), (1000, 1000));
    assert_eq!(samples(&out), samples(&path)[1000..2000]);
    let again = export::mcap_slice(&path, Span::new(1.0, 1.5), &out);
    assert!(matches!(again, Err(ExportError::Exists { .. })));
    assert_eq!(samples(&out).len(), 1000);
    let (span, none) = (Span::new(70.0, 71.0), folder.path().join("none.mcap"));
    assert!(matches!(export::mcap_slice(&path, span, &none), Err(ExportError::Empty)));
    assert!(!none.exists());
    let same = export::mcap_slice(&path, Span::new(0.0, 1.0), &path);
    assert!(matches!(same, Err(ExportError::Same { .. })));
    assert_eq!(samples(&path).len(), 5000);
}

#[test]
fn what_is_kept_of_a_live_source_becomes_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 5000);
    let watch = loaded(&path);
    let out = folder.path().join("kept.mcap");
    let sliced = export::mcap(&watch.model, Span::new(1.0, 1.999), &out).unwrap();
    assert_eq!(sliced.samples, 1000);
    assert_eq!(samples(&out), samples(&path)[1000..2000]);
    let again = loaded(&out);
    assert_eq!(again.samples(Channel::NormalForce), 1000);
    let none = folder.path().join("none.mcap");
    let span = Span::new(70.0, 71.0);
    for model in [&Model::new(1 << 20), &watch.model] {
        assert!(matches!(export::mcap(model, span, &none), Err(ExportError::Empty)));
        assert!(!none.exists());
    }
    let again = export::mcap(&watch.model, Span::new(1.0, 1.5), &out);
    assert!(matches!(again, Err(ExportError::Exists { .. })));
}

/// A second of an array of two at 1 kHz, of which the rows 300 to 339 were lost.
fn with_an_array_and_a_gap() -> Model {
    let mut model = Model::new(64 << 20);
    for (rows, lost) in [(0..300_u64, 0), (340..1000, 40)] {
        let values: Vec<f32> =
            rows.clone().map(|row| f32::from(u16::try_from(row).unwrap())).collect();
        let frames = values.iter().flat_map(|value| [*value, -value]).collect();
        model.take(Feed::Rows(RowBlock {
            times_us: rows.map(|row| 1000 * row).collect(),
            columns: vec![(Channel::Stylus, values)],
            broken: lost > 0,
            lost,
            taxels: Some(TaxelBlock { count: 2, values: frames }),
        }));
    }
    model
}

#[test]
fn what_is_kept_of_a_live_source_has_its_array_and_its_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("kept.mcap");
    let model = with_an_array_and_a_gap();
    let sliced = export::mcap(&model, Span::new(0.0, 1.0), &out).unwrap();
    assert_eq!(sliced.samples, 960);
    let mut reader = McapReader::open(&out).unwrap();
    let mut frames = 0;
    while let Some(entry) = reader.next_entry().unwrap() {
        let Entry::Message { record: Record::Sample(row), .. } = entry else { continue };
        // Rows are numbered from 0 and a millisecond apart, the lost ones too.
        assert_eq!(u64::from(row.index) * 1000, row.sample.t.0);
        if !row.taxels.is_empty() {
            assert_eq!(row.taxels, [row.sample.stylus, -row.sample.stylus]);
            frames += 1;
        }
    }
    assert!((90..=100).contains(&frames), "{frames}");
    let again = loaded(&out);
    let gaps = again.model.events().iter().filter(|mark| mark.kind == EventKind::Gap);
    let texts: Vec<&str> = gaps.map(|mark| mark.text.as_str()).collect();
    assert_eq!(texts, ["40 rows are missing, 41.0 ms"]);
}
