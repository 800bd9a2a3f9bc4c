//! Exports: what is written is what is shown, and comes back.

use crate::rig::{damaged, loaded, recording};
use grip_record::mcap::{Entry, McapReader, McapWriter, Record, SampleRecord};
use grip_record::outputs::OutputError;
use grip_record::{CsvOptions, read_csv};
use grip_scope::export::{self, ExportError, Part, Sliced};
use grip_scope::feed::{RowBlock, TaxelBlock};
use grip_scope::report::grasp;
use grip_scope::{Channel, EventKind, Feed, Model, Span};
use slip_core::{Sample, units::Micros};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

/// What is kept of a span as a recording.
fn kept(model: &Model, span: Span, path: &Path) -> Result<Sliced, ExportError> {
    export::mcap(Part::of(model, span, &Channel::ROWS), path)
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
    let model = loaded(&path);
    let out = folder.path().join("view.csv");
    let channels = [Channel::Stylus, Channel::NormalForce, Channel::Statistic];
    let rows = export::csv(Part::of(&model, Span::new(1.0, 1.999), &channels), &out).unwrap();
    assert_eq!(rows, 1000);
    let read = read_csv(&out, &CsvOptions::default()).unwrap();
    let wanted = samples(&path);
    let got: Vec<(u64, f32)> = read.samples.iter().map(|s| (s.t.0, s.stylus)).collect();
    assert_eq!(got, wanted[1000..2000]);
    let before = fs::read(&out).unwrap();
    let again = export::csv(Part::of(&model, Span::new(1.0, 1.5), &channels), &out).unwrap_err();
    assert!(again.to_string().contains("view.csv: is there already"), "{again}");
    assert_eq!(fs::read(&out).unwrap(), before);
    let nothing = export::csv(Part::of(&model, Span::new(90.0, 91.0), &channels), &out);
    assert!(matches!(nothing, Err(ExportError::Empty)));
}

#[test]
fn a_slice_of_a_recording_is_that_part_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 5000);
    let out = folder.path().join("slice.mcap");
    let sliced = export::mcap_slice(&path, Span::new(1.0, 1.999), &out).unwrap();
    // A state follows each hundredth sample.
    assert_eq!((sliced.samples, sliced.messages), (1000, 1010));
    assert_eq!(samples(&out), samples(&path)[1000..2000]);
    let (span, none) = (Span::new(70.0, 71.0), folder.path().join("none.mcap"));
    assert!(matches!(export::mcap_slice(&path, span, &none), Err(ExportError::Empty)));
    assert!(!none.exists());
    let same = export::mcap_slice(&path, Span::new(0.0, 1.0), &path);
    assert!(matches!(same, Err(ExportError::Output(OutputError::Input { .. }))));
    assert_eq!(samples(&path).len(), 5000);
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
    assert_eq!(kept(&model, Span::new(0.0, 1.0), &out).unwrap().samples, 960);
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
    let none = folder.path().join("none.mcap");
    for model in [&Model::new(1 << 20), &model] {
        let nothing = kept(model, Span::new(70.0, 71.0), &none);
        assert!(matches!(nothing, Err(ExportError::Empty)) && !none.exists());
    }
    let again = loaded(&out);
    let gaps = again.events().marks.iter().filter(|mark| mark.kind == EventKind::Gap);
    let texts: Vec<&str> = gaps.map(|mark| mark.text.as_str()).collect();
    assert_eq!(texts, ["40 rows are missing, 41.0 ms"]);
}

/// A recording of three runs of a second at 1 kHz, the gripper having restarted between them; the stylus counts all samples (nm).
fn restarted(path: &Path) {
    let mut writer =
        McapWriter::new(BufWriter::new(File::create(path).unwrap()), "test", 0).unwrap();
    for count in 0..3000_u32 {
        let (run, index) = (count / 1000, count % 1000);
        // The device's time begins at 5 s, at 0.2 s and at 0.7 s.
        let t = [5_000_000, 200_000, 700_000][run as usize] + 1000 * u64::from(index);
        let sample = Sample::stylus(Micros(t), 1e-9 * f32::from(u16::try_from(count).unwrap()));
        let record = Record::Sample(SampleRecord { index, sample, taxels: &[] });
        writer.write(1000 * u64::from(count), &record).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn a_span_behind_a_leap_of_time_backwards_is_the_one_that_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    restarted(&path);
    let model = loaded(&path);
    let begins: Vec<f64> = (model.events().marks.iter())
        .filter(|mark| mark.kind == EventKind::Clock)
        .map(|mark| mark.t_s)
        .collect();
    assert_eq!(begins.len(), 2);
    let counts = |path: &Path| -> Vec<f32> { samples(path).iter().map(|row| row.1).collect() };
    let all = counts(&path);
    for (number, (from_s, rows)) in
        [(begins[0] + 0.1, 1100..1300), (begins[1] + 0.3, 2300..2500), (5.5, 500..700)]
            .into_iter()
            .enumerate()
    {
        let span = Span::new(from_s - 0.0005, from_s + 0.1995);
        let [slice, of_model] =
            ["slice", "kept"].map(|name| folder.path().join(format!("{name}{number}.mcap")));
        assert_eq!(export::mcap_slice(&path, span, &slice).unwrap().samples, 200);
        assert_eq!(counts(&slice), all[rows.clone()]);
        assert_eq!(kept(&model, span, &of_model).unwrap().samples, 200);
        assert_eq!(counts(&of_model), all[rows]);
    }
    // All of it, both leaps included; what is kept goes on where the axis does.
    let (span, out) = (Span::new(0.0, 100.0), folder.path().join("all.mcap"));
    assert_eq!(export::mcap_slice(&path, span, &out).unwrap().samples, 3000);
    assert_eq!(samples(&out), samples(&path));
    let of_model = folder.path().join("kept.mcap");
    assert_eq!(kept(&model, span, &of_model).unwrap().samples, 3000);
    assert!(samples(&of_model).is_sorted_by(|a, b| a.0 < b.0));
    assert_eq!(counts(&of_model), all);
}

#[test]
fn a_slice_of_a_damaged_recording_leaves_out_what_cannot_be_read_and_counts_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let (chunks, bytes) = damaged(&path);
    let slice = |name: &str, from_s, to_s| {
        export::mcap_slice(&path, Span::new(from_s, to_s), &folder.path().join(name))
    };
    let both = slice("both.mcap", 1.0, 6.999).unwrap();
    assert_eq!((both.samples, both.damaged), (5800, 2));
    assert_eq!(samples(&folder.path().join("both.mcap")).len(), 5800);
    // Damage before the span is nobody's loss.
    let behind = slice("behind.mcap", 7.0, 7.999).unwrap();
    assert_eq!((behind.samples, behind.damaged), (1000, 0));
    // All of the span lies in the damaged part.
    let gone = slice("gone.mcap", 2.01, 2.09).unwrap_err();
    assert!(gone.to_string().contains("damaged"), "{gone}");
    assert!(!folder.path().join("gone.mcap").exists());
    // A recording that was cut off: what was read of the span is written, and its end counts.
    fs::write(&path, &bytes[..usize::try_from(chunks[50]).unwrap() + 30]).unwrap();
    let end = slice("end.mcap", 4.0, 9.0).unwrap();
    assert_eq!((end.samples, end.damaged), (1000, 1));
    let whole = slice("whole.mcap", 3.0, 3.5).unwrap();
    assert_eq!((whole.samples, whole.damaged), (501, 0));
    let nothing = slice("nothing.mcap", 8.0, 9.0).unwrap_err();
    assert!(matches!(nothing, ExportError::Read(_)), "{nothing}");
}

/// Rows of stylus and force at 10 kHz.
fn rows(from: u32, to: u32) -> Feed {
    let values: Vec<f32> = (from..to).map(|row| (row % 7919) as f32).collect();
    let columns = vec![(Channel::Stylus, values.clone()), (Channel::NormalForce, values)];
    let times_us = (from..to).map(|row| 100 * u64::from(row)).collect();
    Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() })
}

#[test]
fn what_comes_and_goes_while_a_file_is_written_does_not_change_it() {
    const ROWS: u32 = 100_000;
    let folder = tempfile::tempdir().unwrap();
    let mut model = Model::new(2 << 20);
    model.take(rows(0, ROWS));
    let span = Span::new(0.0, 9.99995);
    let channels = [Channel::Stylus, Channel::NormalForce];
    let (table, recorded) =
        (Part::of(&model, span, &channels), Part::of(&model, span, &Channel::ROWS));
    model.take(rows(ROWS, 9 * ROWS));
    assert!(model.span().unwrap().from_s > 9.99995, "all of it was dropped");
    let (out, of_model) = (folder.path().join("a.csv"), folder.path().join("a.mcap"));
    assert_eq!(export::csv(table, &out).unwrap(), u64::from(ROWS));
    assert_eq!(export::mcap(recorded, &of_model).unwrap().samples, u64::from(ROWS));
    let read = read_csv(&out, &CsvOptions::default()).unwrap();
    let got: Vec<(u64, f32)> = read.samples.iter().map(|s| (s.t.0, s.stylus)).collect();
    let wanted: Vec<(u64, f32)> =
        (0..ROWS).map(|row| (100 * u64::from(row), (row % 7919) as f32)).collect();
    assert!(got == wanted && samples(&of_model) == wanted);
    let forces = loaded(&of_model).series(Channel::NormalForce).and_then(|s| s.stats(s.span()?));
    assert_eq!(forces.unwrap().count, u64::from(ROWS));
    assert!(read.samples.iter().all(|s| s.normal_force_n == Some(s.stylus)));
}

#[test]
fn a_page_of_samples_only_states_so_and_leaves_nothing_where_it_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 5000);
    let model = loaded(&path);
    let page = |span, out: &Path| export::html(grasp(&model, span, "run.mcap").as_ref(), out);
    let out = folder.path().join("run.html");
    let bytes = page(Span::new(0.0, 9.0), &out).unwrap();
    let text = fs::read_to_string(&out).unwrap();
    assert_eq!(text.len(), bytes);
    assert!(text.contains("<h1>Grasp: run.mcap</h1>") && text.ends_with("</html>"), "{text}");
    assert!(text.contains("The source has samples only"), "{text}");
    let nowhere = page(Span::new(0.0, 1.0), &folder.path().join("no").join("run.html"));
    assert!(matches!(nowhere, Err(ExportError::Output(OutputError::Write { .. }))));
    let none = folder.path().join("none.html");
    assert!(matches!(page(Span::new(70.0, 71.0), &none), Err(ExportError::Empty)));
    assert!(!none.exists());
}
