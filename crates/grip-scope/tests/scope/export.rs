//! Exports: what is written is what is shown, and comes back.

use crate::rig::{Watch, recording};
use grip_record::mcap::{Entry, McapReader, Record};
use grip_record::{CsvOptions, read_csv};
use grip_scope::export::{self, ExportError};
use grip_scope::{Channel, Model, SourceSpec, SourceStatus, Span};
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
    let span = Span::new(70.0, 71.0);
    assert!(matches!(export::mcap_slice(&path, span, &out), Err(ExportError::Empty)));
    assert!(!out.exists());
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
    let empty = export::mcap(&Model::new(1 << 20), Span::new(0.0, 1.0), &out);
    assert!(matches!(empty, Err(ExportError::Empty)));
}
