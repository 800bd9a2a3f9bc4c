//! Recordings and studies: whole, cut off, foreign, of every rate, with readings that are none.

use crate::rig::{Watch, damaged, loaded, recording, samples};
use grip_scope::export::{self, Part};
use grip_scope::feed::StudyNet;
use grip_scope::{Channel, EventKind, EventMark, Model, SourceSpec, SourceStatus, Span};
use std::fs;
use std::io::Write as _;
use std::path::Path;

fn sentence(model: &Model) -> String {
    model.status().sentence()
}

/// Any file, on a thread of its own.
fn study(path: &Path) -> Watch {
    let mut watch = Watch::new(SourceSpec::parse(path.to_str().unwrap()).unwrap());
    let ended = |model: &Model| {
        matches!(model.status(), SourceStatus::Complete { .. } | SourceStatus::Failed { .. })
    };
    watch.until(|| {}, ended);
    watch
}

#[test]
fn a_recording_is_all_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 12_345);
    let model = loaded(&path);
    assert_eq!(model.status(), &SourceStatus::Complete { note: String::new() });
    assert_eq!(
        (samples(&model, Channel::Stylus), samples(&model, Channel::NormalForce)),
        (12_345, 12_345)
    );
    let (file, extent) = model.info().recording.clone().unwrap();
    assert_eq!((file, extent.from_s, extent.to_s), (path, 0.0, 12.344));
    assert_eq!(model.series(Channel::Stylus).unwrap().at(1.0405), Some(40e-9));
    assert!(model.events().marks.is_empty());
    let fan = [Channel::NeedLow, Channel::Need, Channel::NeedHigh];
    let found = fan.map(|channel| model.series(channel).unwrap().latest().unwrap().1);
    assert_eq!(found, [1.5, 1.75, 2.5]);
    assert_eq!(samples(&model, Channel::Need), 123);
}

#[test]
fn a_recording_that_was_cut_off_shows_what_is_whole_and_states_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    recording(&path, 10_000);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let model = loaded(&path);
    assert!(sentence(&model).contains("gripctl recover"), "{}", sentence(&model));
    assert!((2_000..8_000).contains(&samples(&model, Channel::Stylus)));
}

#[test]
fn damaged_parts_are_passed_over_counted_and_leave_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let (chunks, _) = damaged(&path);
    let model = loaded(&path);
    let stated = sentence(&model);
    assert!(
        stated.starts_with("loaded; 2 damaged parts were passed over, the first one:"),
        "{stated}"
    );
    assert!(stated.contains(&format!("damaged at byte {}:", chunks[20])), "{stated}");
    assert_eq!(samples(&model, Channel::Stylus), 9_800);
    let reported =
        |mark: &&EventMark| mark.kind == EventKind::Gap && mark.text.contains("passed over");
    assert_eq!(model.events().marks.iter().filter(reported).count(), 2);
    assert_eq!(model.events().gaps.within(Span::new(0.0, 10.0)).count(), 2);
}

#[test]
fn what_is_no_recording_is_reported_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let model = loaded(&path);
        assert!(matches!(model.status(), SourceStatus::Failed { .. }), "{name}");
        assert_eq!(samples(&model, Channel::Stylus), 0);
        sentence(&model)
    };
    assert!(file("a.mcap", b"\x89PNG and more").contains("no MCAP file"));
    for table in ["time_s,height\n1,2\n2,2\n", "t_s,stylus,vibration\n1,2,3\n2,2,3\n"] {
        // The scope itself has no such flag.
        let stated = file("b.csv", table.as_bytes());
        assert!(stated.contains("--map") && stated.contains("`gripctl import"), "{stated}");
    }
    assert!(file("c.csv", b"").contains("c.csv"));
    assert!(
        file("h.csv", b"\x7fELF\x02\x01\x00\n\x00\x01\n").contains("is no table but a program")
    );
    assert!(file("n.csv", b"stylus\n1\n2\n").contains("no column of times and no rate"));
    for (rows, reported) in
        [("", "has a header but no rows"), ("0,1\n0,2\n", "cannot be told from 2 rows")]
    {
        let stated = file("o.csv", format!("t_s,stylus\n{rows}").as_bytes());
        assert!(stated.contains(reported), "{stated}");
    }
    for (text, reported) in [("{\"results\": 4}", "no report of a study"), ("{", "no JSON")] {
        let path = folder.path().join("e.json");
        fs::write(&path, text).unwrap();
        assert!(study(&path).model.status().sentence().contains(reported), "{text}");
    }
    let mut foreign = Vec::new();
    let mut writer = mcap::Writer::new(std::io::Cursor::new(&mut foreign)).unwrap();
    let schema = writer.add_schema("other", "ros2msg", b"int32 a\n").unwrap();
    writer.add_channel(schema, "/other", "cdr", &std::collections::BTreeMap::new()).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let stated = file("g.mcap", &foreign);
    assert!(
        stated.contains("was not recorded by gripd") && stated.contains("gripctl import"),
        "{stated}"
    );
    let gone = loaded(&folder.path().join("gone.mcap"));
    assert!(sentence(&gone).contains("cannot be read"), "{}", sentence(&gone));
}

/// A file of so many bytes that takes no room on the disk: all of them are 0.
fn hollow(path: &Path, bytes: u64) {
    fs::File::create(path).unwrap().set_len(bytes).unwrap();
}

#[test]
fn a_huge_foreign_file_is_reported_in_a_sentence_and_not_read_into_memory() {
    let folder = tempfile::tempdir().unwrap();
    for (name, reported) in [
        ("a.csv", "a.csv: it is no table: a line has more than 1048576 bytes"),
        ("b.json", "b.json: is larger than 16 MiB: no report of a study has so much"),
    ] {
        let path = folder.path().join(name);
        hollow(&path, 1 << 30);
        let stated = study(&path).model.status().sentence();
        assert!(stated.ends_with(reported), "{stated}");
    }
    // Rows, then NULs without an end.
    let path = folder.path().join("c.csv");
    csv(&path, 1000.0, 300_000, |_| "0.0000012".to_owned());
    let rows = fs::metadata(&path).unwrap().len();
    fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(rows + (1 << 30)).unwrap();
    let model = loaded(&path);
    let stated = sentence(&model);
    assert!(
        samples(&model, Channel::Stylus) > 100_000 && stated.contains("stand in the place of rows"),
        "{stated}"
    );
}

fn csv(path: &Path, rate_hz: f64, rows: u32, value: impl Fn(u32) -> String) {
    let mut out = std::io::BufWriter::new(fs::File::create(path).unwrap());
    writeln!(out, "t_s,stylus,force_n").unwrap();
    for row in 0..rows {
        writeln!(out, "{:.6},{},2.5", f64::from(row) / rate_hz, value(row)).unwrap();
    }
}

/// From -0.5 to 0.5, the same each time.
fn noise() -> impl FnMut() -> f64 {
    let mut seed = 1_u32;
    move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
    }
}

/// A vibration is in a unit of its own: it is called neither a stylus nor metres, on the page neither, and exported as what it is.
#[test]
fn a_vibration_of_three_axes_has_no_metres_and_names_the_axis_that_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("imu.csv");
    let mut text = "t_s,vibration_x,vibration_y,vibration_z\n".to_owned();
    for row in 0..3000_u32 {
        let (t_s, value) = (f64::from(row) / 1000.0, 0.3 * f64::from(row % 7));
        text += &format!("{t_s:.6},{value},0,9.81\n");
    }
    fs::write(&path, text).unwrap();
    let model = loaded(&path);
    let info = model.info();
    assert_eq!((info.unit(Channel::Stylus), info.name(Channel::Stylus)), ("", "vibration"));
    assert_eq!(info.stylus_title(), "Vibration, own units: vibration_x of 3 axes");
    let page =
        grip_scope::report::grasp(&model, Span::new(0.0, 3.0), "imu").unwrap().html().unwrap();
    assert!(page.contains("own units: vibration_x of 3 axes"));
    assert!(![">mm<", ">m<", "Stylus", ">stylus<"].iter().any(|text| page.contains(text)));
    let out = folder.path().join("view.csv");
    let part = Part::of(&model, Span::new(1.0, 2.0), &[Channel::Stylus]);
    export::csv(part, &out).unwrap();
    assert!(fs::read_to_string(&out).unwrap().starts_with("t_s,vibration\n"));
    let metres = folder.path().join("m.csv");
    csv(&metres, 1000.0, 3000, |row| format!("{}", 1e-7 * f64::from(row % 7)));
    let model = loaded(&metres);
    let info = model.info();
    assert_eq!((info.unit(Channel::Stylus), info.stylus_title()), ("m", "Stylus".to_owned()));
}

#[test]
fn every_rate_from_ten_hertz_to_twenty_kilohertz_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    for rate_hz in [10.0, 100.0, 317.0, 2200.0, 20_000.0] {
        let path = folder.path().join("x.csv");
        csv(&path, rate_hz, 3000, |row| format!("{}", 1e-7 * f64::from(row % 7)));
        let model = loaded(&path);
        assert_eq!(samples(&model, Channel::Stylus), 3000, "{rate_hz}: {}", sentence(&model));
        assert!(model.events().marks.iter().all(|mark| mark.kind != EventKind::Gap), "{rate_hz}");
        assert!(!model.spectrogram().is_empty());
        // Below 20 Hz there is nothing that the detector could receive, and the window reports it.
        let reported = model.notices().any(|line| line.contains("only spectra"));
        let derived = model.series(Channel::Band0).is_some();
        assert_eq!((derived, reported), (rate_hz >= 20.0, rate_hz < 20.0), "{rate_hz}");
        assert_eq!(model.series(Channel::Statistic).is_some(), derived);
    }
}

#[test]
fn rows_before_a_bad_one_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    for rows in [500_u32, 300_000] {
        let path = folder.path().join("x.csv");
        let bad = rows * 9 / 10;
        let text = |row| if row == bad { "many".to_owned() } else { "0.0000012".to_owned() };
        csv(&path, 10_000.0, rows, text);
        let model = loaded(&path);
        assert_eq!(samples(&model, Channel::Stylus), u64::from(bad), "{}", sentence(&model));
        let stated = sentence(&model);
        assert!(
            stated.starts_with(&format!("loaded; only the first {bad} rows can be")),
            "{stated}"
        );
        let line = format!("line {}, column stylus: \"many\" is not a number", bad + 2);
        assert!(stated.contains(&line), "{stated}");
    }
}

#[test]
fn a_large_table_comes_in_pieces_and_gaps_and_bad_readings_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    let mut out = std::io::BufWriter::new(fs::File::create(&path).unwrap());
    writeln!(out, "t_s,stylus").unwrap();
    let rows = 600_000_u32;
    for row in 0..rows {
        let late = if row >= rows / 2 { 0.5 } else { 0.0 };
        let value = match row % 100_000 {
            77 => "NaN",
            78 => "1e30",
            _ => "0.0000012",
        };
        writeln!(out, "{:.5},{value}", f64::from(row) / 10_000.0 + late).unwrap();
    }
    drop(out);
    assert!(fs::metadata(&path).unwrap().len() > 2 * (4 << 20));
    let model = loaded(&path);
    assert_eq!(samples(&model, Channel::Stylus), u64::from(rows) - 6);
    assert_eq!((model.health().huge, model.health().nan), (6, 6));
    let gaps = model.events().marks.iter().filter(|mark| mark.kind == EventKind::Gap);
    let texts: Vec<&str> = gaps.map(|mark| mark.text.as_str()).collect();
    assert_eq!(texts.len(), 1, "{texts:?}");
    assert!(texts[0].starts_with("5000 rows are missing"), "{texts:?}");
}

#[test]
fn states_and_slips_of_a_slow_table_with_gaps_stand_where_they_belong() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    let mut out = std::io::BufWriter::new(fs::File::create(&path).unwrap());
    writeln!(out, "t_s,stylus,force_n").unwrap();
    // 14 s at 1 kHz; 5 rows are missing every 1.5 s, and 4 s at once; from 8 s on it slips for 0.3 s.
    let mut noise = noise();
    for row in (0..14_000_u32).filter(|row| row % 1500 >= 5 && !(2000..6000).contains(row)) {
        let height = if (8000..8300).contains(&row) { 1e-4 } else { 1e-7 };
        writeln!(out, "{:.3},{:e},2.5", f64::from(row) / 1000.0, height * noise()).unwrap();
    }
    drop(out);
    let model = loaded(&path);
    assert_eq!(model.health().stray_states, 0, "{}", sentence(&model));
    let scenes: Vec<Span> =
        model.events().doings.within(Span::new(0.0, 14.0)).map(|stretch| stretch.span).collect();
    assert!(scenes[0].from_s < 0.1 && scenes[scenes.len() - 1].to_s > 13.9, "{scenes:?}");
    let is_slip = |mark: &&EventMark| matches!(mark.kind, EventKind::Incipient | EventKind::Gross);
    let slips: Vec<f64> =
        model.events().marks.iter().filter(is_slip).map(|mark| mark.t_s).collect();
    assert!(!slips.is_empty() && slips.iter().all(|t_s| (8.0..8.3).contains(t_s)), "{slips:?}");
}

#[test]
fn a_study_has_its_curves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.json");
    let text = r#"{"type":"study","title":"four nets","summary":["It works."],"results":[
        {"title":"v and F","nets":[
            {"net":"M1","trainer":"GD","curve":{"epoch":[0,1,4],"train":[0.5,0.25,0.125],"test":[0.6,0.5,0.4]}},
            {"net":"LBFGS","trainer":"L-BFGS","curve":{"epoch":[0],"train":[0.5],"test":[0.6]}},
            {"net":"M4","trainer":"SCG"}]}]}"#;
    fs::write(&path, text).unwrap();
    let watch = study(&path);
    let study = watch.model.study().unwrap();
    assert_eq!((study.title.as_str(), study.results.len()), ("four nets", 1));
    let result = &study.results[0];
    let names: Vec<String> = result.nets.iter().map(StudyNet::name).collect();
    assert_eq!(result.title, "v and F");
    assert_eq!(names, ["M1 GD", "L-BFGS", "M4 SCG"]);
    let curve = result.nets[0].curve.as_ref().unwrap();
    assert_eq!((&curve.epoch[..], curve.test[1]), (&[0.0, 1.0, 4.0][..], Some(0.5)));
    assert_eq!(study.summary, ["It works."]);
}

/// Times that are rounded hide the rate at the start of a table: it is that of the whole table here too, or slips would stand elsewhere
/// than `gripctl replay` finds them.
#[test]
fn a_table_with_rounded_times_has_the_slips_that_a_replay_finds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    let mut out = std::io::BufWriter::new(fs::File::create(&path).unwrap());
    writeln!(out, "Time (ms),ax").unwrap();
    let mut noise = noise();
    for row in 0..24_000_u32 {
        let slips = (12_000..13_500).contains(&row) || (18_000..19_500).contains(&row);
        let height = if slips { 0.08 } else { 0.02 };
        writeln!(out, "{:.4},{:.5}", f64::from(row) / 3.0, height * noise()).unwrap();
    }
    drop(out);
    let recording =
        grip_record::CsvSamples::open(&path, &Default::default()).unwrap().hold().unwrap();
    let config = grip_session::HostConfig::default();
    let config = grip_session::replay::pipeline_config(&recording, &config, true);
    let mut pipeline =
        slip_core::Pipeline::new(config, grip_session::model::default_estimator().ok()).unwrap();
    let starts = recording.samples.iter().filter_map(|sample| {
        let step = pipeline.handle(sample);
        let begins = step.event.filter(|event| event.phase != slip_core::Phase::Ended);
        begins.map(|event| event.t.as_seconds())
    });
    let expected: Vec<f64> = starts.collect();
    let is_slip = |mark: &&EventMark| matches!(mark.kind, EventKind::Incipient | EventKind::Gross);
    let model = loaded(&path);
    let found: Vec<f64> =
        model.events().marks.iter().filter(is_slip).map(|mark| mark.t_s).collect();
    assert!(expected.len() >= 2, "{expected:?}");
    assert_eq!(found, expected);
}
