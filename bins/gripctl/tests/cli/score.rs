//! `gripctl score`: labelled recordings, made here and real.

use crate::run::{gripctl, noise, number, put, read, real_data};
use core::fmt::Write as _;
use serde_json::Value;
use std::{fs, path::Path};

/// 0.6 s at 2.2 kHz in counts: seeded noise of 10 counts, and a tone from `slip_from_s` on.
fn recording(slip_from_s: f64, tone_counts: f64, seed: u32) -> String {
    let mut noise = noise(seed);
    let mut text = String::from("t_s,vibration\n");
    for i in 0..1320_u32 {
        let t = f64::from(i) / 2200.0;
        let tone = if t >= slip_from_s { tone_counts * (942.0 * t).sin() } else { 0.0 };
        writeln!(text, "{t:.6},{}", (10.0 * noise() + tone).round()).unwrap();
    }
    text
}

pub(crate) fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| put(&folder, name, text);
    put(
        "labels.csv",
        "recording,kind,material,onset_s\nfound,onset,cork,0.3\nearly,onset,cork,0.37\nquiet,onset,felt,0.3\nall,steady,felt,\nrest,rest,,\n",
    );
    put("found.csv", &recording(0.3, 200.0, 1));
    put("early.csv", &recording(0.3, 60.0, 2));
    put("quiet.csv", &recording(9.0, 200.0, 3));
    put("all.csv", &recording(0.0, 200.0, 4));
    put("rest.csv", &recording(9.0, 200.0, 5));
    put("found_pose.csv", "t_s,travel_mm\n0,0\n0.3,0\n0.6,30\n");
    folder
}

#[test]
fn each_recording_is_judged_by_its_label() {
    let folder = folder();
    let ran = gripctl(&folder, "score . --json").done();
    assert!(
        ran.err.contains("noise floor measured on") && ran.err.contains("that of the others"),
        "{}",
        ran.err
    );
    let lines = ran.json();
    let [found, early, quiet, all, rest, still, total] = lines.as_slice() else {
        panic!("{}", ran.out)
    };
    assert_eq!((&still["type"], &still["cause"]), (&"cause".into(), &"motion not known".into()));
    assert_eq!(number(still, "alarms"), 1.0, "the early one: {still}");
    let alarm = &early["alarms_at"][0];
    assert!(alarm["is_false"] == true && alarm["t_s"] == early["alarm_s"], "{early}");
    assert!(number(&total["onsets_chance"], "found") < 3.0, "{total}");
    assert_eq!(
        (&found["recording"], &found["kind"], &found["material"]),
        (&"found".into(), &"onset".into(), &"cork".into())
    );
    assert_eq!(
        (&found["missed"], &found["early"], number(found, "onset_s")),
        (&false.into(), &false.into(), 0.3)
    );
    let latency = number(found, "latency_ms");
    assert!((0.0..10.0).contains(&latency), "{found}");
    assert!((number(found, "alarm_s") - 0.3 - 1e-3 * latency).abs() < 1e-9, "{found}");
    assert!((number(found, "travel_mm") - 0.1 * latency).abs() < 1e-6, "100 mm/s: {found}");
    assert_eq!(
        (&early["missed"], &early["early"], &early["latency_ms"]),
        (&false.into(), &true.into(), &().into())
    );
    assert_eq!(
        (&quiet["missed"], &quiet["early"], &quiet["alarm_s"]),
        (&true.into(), &false.into(), &().into())
    );
    assert!(
        all["missed"] == false && number(all, "latency_ms") < 20.0 && all["onset_s"].is_null(),
        "{all}"
    );
    assert!(rest["alarm_s"].is_null() && rest["missed"] == false, "{rest}");
    assert_eq!(total["type"], "total");
    let counts = ["onsets", "missed", "early", "steady", "steady_missed", "rest_alarms"];
    assert_eq!(counts.map(|name| number(total, name)), [3.0, 1.0, 1.0, 1.0, 0.0, 0.0], "{total}");
    assert!((number(total, "rest_s") - 0.6).abs() < 1e-3, "{total}");
    assert!((number(&total["latency_ms"], "p50") - latency).abs() < 1e-9, "{total}");
    assert_eq!(total["latency_ms"]["p50"], total["latency_ms"]["p95"]);
    // A longer guard makes the early alarm incipient slip.
    let ran = gripctl(&folder, "score . --json --guard-ms 72").done();
    let lines = ran.json();
    assert!(lines[1]["early"] == false && number(&lines[1], "latency_ms") < -40.0, "{}", lines[1]);
    let text = gripctl(&folder, "score .").done().out;
    assert!(
        text.contains("MISSED") && text.contains("EARLY") && text.contains("false alarms"),
        "{text}"
    );
}

#[test]
fn detectors_stand_side_by_side_with_materials_intervals_and_curves() {
    let folder = folder();
    let taxels: String = (0..60_u32).fold(String::from("t_s,a,b,c,d\n"), |mut text, i| {
        // A pattern that turns from 0.3 s on, with a count of noise.
        let (t, turn) = (f64::from(i) * 0.01, if i >= 30 { f64::from(i - 29) } else { 0.0 });
        let noise = f64::from(i * 7 % 3) - 1.0;
        writeln!(text, "{t},{},{},{},{}", 50.0 + turn + noise, 20.0 - noise, 30.0, 40.0 - turn)
            .unwrap();
        text
    });
    for name in ["found", "early"] {
        put(&folder, format!("{name}_taxels.csv"), &taxels);
    }
    let pose: String = (0..60_u32).fold(String::from("t_s,travel_mm\n"), |mut text, i| {
        let t = f64::from(i) * 0.01;
        writeln!(text, "{t},{}", (100.0 * (t - 0.3)).max(0.0)).unwrap();
        text
    });
    put(&folder, "found_pose.csv", pose);
    let args = "score . --json --materials --detectors stylus,travel,pressure,fused";
    let files = "--curve c.json --curve c.svg";
    let ran = gripctl(&folder, format!("{args} {files}")).done();
    assert!(ran.err.contains("taxel noise of the labelled rest"), "{}", ran.err);
    let lines = ran.json();
    let of = |detector: &str, kind: &str| {
        lines
            .iter()
            .filter(|l| l["detector"] == detector && l["type"] == kind)
            .cloned()
            .collect::<Vec<_>>()
    };
    let total = |detector: &str| of(detector, "total").pop().unwrap();
    let counts = ["stylus", "travel", "pressure", "fused"].map(|d| number(&total(d), "missed"));
    // Travel is known beside one recording, taxels beside two of three.
    assert_eq!(counts, [1.0, 2.0, 1.0, 1.0]);
    assert_eq!(of("fused", "material").len(), 3, "cork, felt and the nameless rest");
    let ci = &total("stylus")["missed_ci"];
    assert!(ci[0].as_f64().unwrap() < 0.34 && ci[1].as_f64().unwrap() > 0.9, "1 of 3: {ci}");
    let found =
        lines.iter().find(|l| l["detector"] == "travel" && l["recording"] == "found").unwrap();
    // 0.1 mm at 100 mm/s from 0.3 s on, reported by the next pose.
    assert!((number(found, "latency_ms") - 10.0).abs() < 1.0, "{found}");
    let curve: Value = serde_json::from_str(&read(&folder, "c.json")).unwrap();
    let points = curve["detectors"][0]["points"].as_array().unwrap();
    assert!(curve["detectors"].as_array().unwrap().len() == 4 && points.len() == 33);
    let rates: Vec<f64> = points.iter().map(|p| number(p, "false_alarms")).collect();
    // Far below its threshold an alarm hardly ever ends, so that few are counted.
    let most = rates.iter().copied().fold(0.0, f64::max);
    let falling = rates.iter().skip_while(|rate| **rate < most);
    assert!(falling.clone().count() > 30 && falling.is_sorted_by(|a, b| a >= b), "{rates:?}");
    let drawn = read(&folder, "c.svg");
    assert!(drawn.contains("(ROC)") && drawn.contains("marks: as configured"), "{drawn}");
    let text = gripctl(&folder, "score . --detectors stylus,travel").done().out;
    let row = |name: &str| text.lines().find(|line| line.starts_with(&format!("{name} "))).unwrap();
    let onsets_missed = ["stylus", "travel"]
        .map(|name| row(name).split_whitespace().skip(1).take(2).collect::<Vec<_>>().join(" "));
    assert_eq!(onsets_missed, ["3 1", "3 2"], "{text}");
}

#[test]
fn a_detector_that_cannot_run_has_a_row_with_the_reason_and_the_others_come() {
    let folder = folder();
    let score = |detectors: &str, more: &str| {
        gripctl(&folder, format!("score . --detectors {detectors} {more}"))
    };
    let ran = score("pressure,stylus,travel", "--json").done();
    let lines = ran.json();
    let [refused] = lines.iter().filter(|l| l["type"] == "refused").collect::<Vec<_>>()[..] else {
        panic!("{}", ran.out)
    };
    let why = refused["why"].as_str().unwrap();
    assert!(refused["detector"] == "pressure" && why.contains("NAME_taxels.csv"), "{refused}");
    let totals = lines.iter().filter(|l| l["type"] == "total").map(|l| l["detector"].clone());
    assert_eq!(totals.collect::<Vec<_>>(), ["stylus", "travel"], "travel needs no floor");
    let text = score("pressure,stylus,travel", "").done().out;
    assert!(text.contains("detector: pressure\nnot scored: needs taxels"), "{text}");
    score("pressure", "").refused(2, &["pressure", "NAME_taxels.csv"]);
    fs::remove_file(folder.path().join("found_pose.csv")).unwrap();
    score("travel", "").refused(2, &["travel", "NAME_pose.csv"]);
}

#[test]
fn every_slip_of_a_recording_is_scored_and_its_alarms_count_once() {
    let folder = folder();
    let put = |name: &str, text: &str| put(&folder, name, text);
    // 1.8 s, loud from 0.3 s to 0.6 s and from 1.5 s on; nothing is there at 1.0 s.
    let quiet = recording(9.0, 0.0, 7);
    let loud = recording(0.3, 200.0, 1);
    let rows = |text: &str, add_s: f64| -> String {
        let later = text.lines().skip(1).map(|line| {
            let (t_s, x) = line.split_once(',').unwrap();
            format!("{:.6},{x}\n", t_s.parse::<f64>().unwrap() + add_s)
        });
        later.collect()
    };
    let text = [rows(&loud, 0.0), rows(&quiet, 0.6), rows(&loud, 1.2)].concat();
    put("three.csv", &format!("t_s,vibration\n{text}"));
    let header = "recording,kind,material,onset_s\n";
    let onsets = "three,onset,cork,0.3\nthree,onset,cork,1.0\nrest,rest,,\nthree,onset,cork,1.5\n";
    put("labels.csv", &format!("{header}{onsets}"));
    let lines = gripctl(&folder, "score . --json").done().json();
    let slips: Vec<_> = lines.iter().filter(|line| line["recording"] == "three").collect();
    let shown =
        slips.iter().map(|s| (number(s, "slip"), number(s, "onset_s"), s["missed"] == true));
    assert_eq!(
        shown.collect::<Vec<_>>(),
        [(1.0, 0.3, false), (2.0, 1.0, true), (3.0, 1.5, false)],
        "{slips:?}"
    );
    for found in [slips[0], slips[2]] {
        assert!((0.0..10.0).contains(&number(found, "latency_ms")), "{found}");
    }
    let total = lines.last().unwrap();
    let counts = ["onsets", "missed", "early"].map(|name| number(total, name));
    assert_eq!(counts, [3.0, 1.0, 0.0], "{total}");
    let alarms: f64 = slips.iter().map(|slip| number(slip, "alarms")).sum();
    let length_s: f64 = slips.iter().map(|slip| number(slip, "length_s")).sum();
    assert!(alarms == 2.0 && (length_s - 1.8).abs() < 1e-3, "{slips:?}");
    let text = gripctl(&folder, "score .").done().out;
    let mut rows = text.lines().map(|line| line.split_whitespace().take(2));
    assert!(rows.any(|row| row.eq(["three", "2"])), "{text}");
    assert!(text.contains("onsets: 3, 1 missed"), "{text}");
    for rows in ["three,onset,x,1.5\nthree,onset,x,1.0\n", "three,rest,x,\nthree,onset,x,1\n"] {
        put("labels.csv", &format!("{header}{rows}"));
        gripctl(&folder, "score .").refused(2, &["three", "rising order"]);
    }
}

#[test]
fn the_alarms_of_a_detector_of_ones_own_are_judged_as_those_of_ours() {
    let folder = folder();
    let score =
        |detectors: &str| gripctl(&folder, format!("score . --json --detectors {detectors}"));
    score("own").refused(2, &["alarms.csv", "recording,begin_s,end_s"]);
    let alarms = "recording,begin_s,end_s\nearly,0.05,0.06\nfound,0.31,0.5\nall,0.05,\nrest,0.4,\n";
    put(&folder, "alarms.csv", alarms.to_owned() + "fuond,1,2\n");
    score("own").refused(2, &["alarms.csv", "no recording \"fuond\""]);
    put(&folder, "alarms.csv", alarms);
    let lines = score("default,own").done().json();
    let of = |name: &str| {
        let own = lines.iter().filter(|line| line["detector"] == "own");
        own.clone().find(|line| line["recording"] == name || line["type"] == name).unwrap()
    };
    let near = |line: &Value, name: &str, wanted: f64| (number(line, name) - wanted).abs() < 1.0;
    assert!(near(of("found"), "latency_ms", 10.0), "{}", of("found"));
    assert!(of("early")["early"] == true && of("early")["missed"] == true, "{}", of("early"));
    assert!(of("quiet")["missed"] == true && near(of("all"), "latency_ms", 50.0));
    let counts = ["onsets", "missed", "early", "steady_missed", "rest_alarms"];
    let found = counts.map(|name| number(of("total"), name));
    assert_eq!(found, [3.0, 2.0, 1.0, 0.0, 1.0], "{}", of("total"));
    put(&folder, "alarms.csv", "recording,begin_s,end_s\nall,2,1\n");
    score("own").refused(2, &["alarms.csv", "line 2", "after begin_s"]);
    // Nobody asked for it.
    score("default").done();
}

#[test]
fn recordings_too_short_for_a_floor_are_named_and_the_floors_to_cite() {
    let folder = folder();
    let rows: Vec<String> =
        recording(0.05, 200.0, 6).lines().take(250).map(|line| format!("{line}\n")).collect();
    put(&folder, "short.csv", rows.concat());
    let labels = "recording,kind,material,onset_s\nfound,onset,cork,0.3\nrest,rest,,\nshort,onset,cork,0.05\n";
    put(&folder, "labels.csv", labels);
    for (floor, named) in [("live", true), ("folds", false)] {
        let ran = gripctl(&folder, format!("score . --json --floor {floor}")).done();
        let why = "the noise floor is never learned, so that the signal shows no slip, in short;";
        assert_eq!(ran.err.contains(why), named, "{}", ran.err);
        assert_eq!(ran.err.contains("in a paper cite --floor live"), !named, "{}", ran.err);
        let learning = |line: &Value| (line["recording"].clone(), line["learning"] == true);
        let learning: Vec<_> = ran.json().iter().take(3).map(learning).collect();
        assert_eq!(
            learning,
            [("found".into(), false), ("rest".into(), false), ("short".into(), named)]
        );
    }
}

/// 6 s of noise with a tone of 0.2 s from each onset on, and a detector whose alarms last for most of it.
#[test]
fn a_detector_that_never_stops_alarming_finds_nothing() {
    let folder = folder();
    let put = |name: &str, text: &str| put(&folder, name, text);
    let mut noise = (1..11).flat_map(|seed| {
        let rows = recording(9.0, 0.0, seed);
        let values = rows.lines().skip(1).map(|line| line.split_once(',').unwrap().1.to_owned());
        values.collect::<Vec<_>>()
    });
    let mut text = String::from("t_s,vibration\n");
    for i in 0..13_200_u32 {
        let (t, x) = (f64::from(i) / 2200.0, noise.next().unwrap().parse::<f64>().unwrap());
        let slips = [1.0, 2.0, 3.0, 4.0].iter().any(|onset| (*onset..onset + 0.2).contains(&t));
        let tone = if slips { 200.0 * (942.0 * t).sin() } else { 0.0 };
        writeln!(text, "{t:.6},{}", (x + tone).round()).unwrap();
    }
    put("a.csv", &text);
    let labels = "recording,kind,material,onset_s\na,onset,x,1\na,onset,x,2\na,onset,x,3\na,onset,x,4\nrest,rest,,\n";
    put("labels.csv", labels);
    let total = |alarms: &str| {
        put("alarms.csv", &format!("recording,begin_s,end_s\n{alarms}"));
        let args = "score . --json --materials --detectors own";
        let lines = gripctl(&folder, args).done().json();
        let text = gripctl(&folder, "score . --detectors own").done().out;
        (lines, text)
    };
    let counts = |line: &Value| ["onsets", "missed", "inside"].map(|name| number(line, name));
    // From before the first onset to the end, with and without a break; from the first slip on.
    for alarms in ["a,0.1,5.9\nrest,0,0.6\n", "a,0.1,0.3\na,0.5,6\nrest,0,1\n", "a,1.01,6\n"] {
        let (lines, text) = total(alarms);
        let [total, material] = ["total", "material"]
            .map(|kind| lines.iter().find(|l| l["type"] == kind && l["material"] != "").unwrap());
        let found = f64::from(u8::from(alarms.contains("1.01")));
        assert_eq!(counts(total), [4.0, 0.0, 4.0 - found], "{total}");
        assert_eq!(counts(material), counts(total), "{material}");
        assert!(
            total["onsets_chance"].is_null()
                && total["latency_ms"]["p50"].is_null() == (found == 0.0)
        );
        assert!(
            number(total, "in_alarm_s") > 4.9 && number(total, "in_alarm_share") > 0.7,
            "{total}"
        );
        assert!(!text.contains("at random") && !text.contains("(p "), "{text}");
        assert!(text.contains("inside a running alarm") && text.contains("in alarm: "), "{text}");
        assert!(
            text.contains("INSIDE") && total["missed_ci"].is_null() == (found == 0.0),
            "{text}"
        );
    }
    // One that reports each slip, and ends each alarm.
    let (lines, text) = total("a,1.01,1.2\na,2.01,2.2\na,3.01,3.2\na,4.01,4.2\n");
    let of_all = lines.last().unwrap();
    assert_eq!(counts(of_all), [4.0, 0.0, 0.0]);
    assert!(
        number(&of_all["onsets_chance"], "found") < 2.0 && text.contains("at random"),
        "{text}"
    );
    // Of ours the curve says the same.
    put("labels.csv", labels);
    gripctl(&folder, "score . --curve c.json").done();
    let curve: Value = serde_json::from_str(&read(&folder, "c.json")).unwrap();
    for point in curve["detectors"][0]["points"].as_array().unwrap() {
        let [onsets, missed, inside] = counts(point);
        assert!(missed + inside <= onsets, "{point}");
        let at = number(point, "threshold");
        assert!(at != 1.0 || missed + inside == 0.0, "{point}");
    }
}

/// Fingertip recordings of 14 materials.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn slips_of_a_real_fingertip_are_found_in_time() {
    let folder = real_data("biotac_slide");
    let ran = gripctl(Path::new("."), format!("score {} --json", folder.display())).done();
    let total = ran.json().pop().unwrap();
    println!("{total}");
    assert!(number(&total, "onsets") >= 50.0 && total["missed"] == 0, "{total}");
    assert!(number(&total, "missed") <= 1.0 && number(&total, "early") <= 1.0, "{total}");
    assert!(number(&total["latency_ms"], "p50") <= 0.0, "{total}");
    assert!(number(&total["latency_ms"], "p95") <= 30.0, "{total}");
    assert_eq!(total["steady_missed"], 0, "{total}");
}

#[test]
fn recordings_of_several_rates_and_units_have_floors_of_their_own() {
    let folder = folder();
    let put = |name: &str, text: &str| put(&folder, name, text);
    let halved = |text: &str| -> String {
        let rows = text.lines().enumerate().filter(|(nth, _)| *nth == 0 || nth % 2 == 1);
        rows.map(|(_, line)| format!("{line}\n")).collect()
    };
    put("slow.csv", &halved(&recording(0.3, 200.0, 6)));
    put("slow_rest.csv", &halved(&recording(9.0, 200.0, 7)));
    // A displacement: of another unit than the vibrations, at the same rate.
    let rest = recording(9.0, 200.0, 8).replacen("vibration", "stylus", 1);
    put("um.csv", &rest);
    let labels =
        "recording,kind,material,onset_s\nfound,onset,cork,0.3\nrest,rest,,\nslow,onset,cork,0.3\n";
    put("labels.csv", &format!("{labels}slow_rest,rest,,\num,rest,pad,\n"));
    let lines = gripctl(&folder, "score . --json").done().json();
    let total = lines.last().unwrap();
    let counts = ["onsets", "missed", "rest_alarms", "own_floors"].map(|name| number(total, name));
    assert_eq!(counts, [2.0, 0.0, 0.0, 1.0], "{total}");
    let rates = total["rates_hz"].as_array().unwrap().iter().map(|rate| rate.as_f64().unwrap());
    assert_eq!(rates.map(f64::round).collect::<Vec<_>>(), [2200.0, 1100.0, 2200.0]);
    let own = lines.iter().filter(|line| line["floor_from"] == "own");
    assert_eq!(own.map(|line| line["recording"].clone()).collect::<Vec<_>>(), ["um"]);
    // The others are judged as if those of other rates were not there.
    put("labels.csv", "recording,kind,material,onset_s\nslow,onset,cork,0.3\nslow_rest,rest,,\n");
    let alone = gripctl(&folder, "score . --json").done().json();
    assert_eq!((&alone[0], &alone[1]), (&lines[2], &lines[3]));
    put("labels.csv", &format!("{labels}slow_rest,rest,,\num,rest,pad,\n"));
    let text = gripctl(&folder, "score .").done().out;
    let said = "3 rates or units (2200, 1100, 2200 Hz), each with floors of its own; 1 recording";
    assert!(text.contains(said), "{text}");
    // Of one material: nothing to measure a floor on but the recording itself.
    put("labels.csv", "recording,kind,material,onset_s\nfound,onset,cork,0.3\n");
    let ran = gripctl(&folder, "score .").done();
    assert!(
        ran.err.contains("1 of 1 recordings learn their noise floor from their own"),
        "{}",
        ran.err
    );
    assert!(!ran.err.contains("noise floor measured on"), "{}", ran.err);
    assert!(ran.out.contains("motion not known: the arm may have moved"), "{}", ran.out);
}

/// `NAME.npz` where there is no `NAME.csv`, with the companions beside it.
#[test]
fn recordings_of_numpy_are_judged_like_those_in_csv() {
    let folder = folder();
    let score = || gripctl(&folder, "score . --json").done().out;
    let reported = score();
    for name in ["found", "quiet", "rest"] {
        let csv = folder.path().join(format!("{name}.csv"));
        let recording = grip_record::read_csv(&csv, &grip_record::CsvOptions::default()).unwrap();
        let npz = fs::File::create(csv.with_extension("npz")).unwrap();
        recording.write_npz(npz).unwrap();
        fs::remove_file(csv).unwrap();
    }
    assert_eq!(score(), reported);
}
