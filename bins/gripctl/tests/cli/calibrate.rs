//! `gripctl calibrate`: what it measures, what it refuses, and that its file is taken.

use crate::run::{Ran, gripctl, noise, normal, number, put, read};
use core::fmt::Write as _;
use grip_sim::disturbance::Disturbance;

/// `seconds` at 2 kHz: noise of `rms_um`, a robot that moves now and then, and its reference.
fn recording(seconds: u32, rms_um: impl Fn(f64) -> f64, seed: u64) -> String {
    work(seconds, rms_um, |_| true, seed)
}

/// The same with a robot that stands where it does not `work`.
fn work(
    seconds: u32,
    rms_um: impl Fn(f64) -> f64,
    works: impl Fn(f64) -> bool,
    seed: u64,
) -> String {
    let mut still = Disturbance::new(0.0, 0.0, 2000.0, seed);
    let mut robot = Disturbance::new(1.0, 0.2, 2000.0, seed);
    let mut noise = normal(1);
    let mut text = String::from("t_s,stylus,reference\n");
    for i in 0..seconds * 2000 {
        let t = f64::from(i) / 2000.0;
        let (moving, standing) = (robot.next_sample(), still.next_sample());
        let motion = if works(t) { moving } else { standing };
        let stylus = motion.stylus_m + 1e-6 * rms_um(t) * noise();
        writeln!(text, "{t:.6},{stylus:e},{:e}", motion.reference_m).unwrap();
    }
    text
}

#[test]
fn a_calibration_holds_on_another_stretch_of_the_same_robot() {
    let folder = tempfile::tempdir().unwrap();
    let text = recording(240, |_| 0.1, 5);
    let (head, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let (first, second) = rows.split_at(rows.len() / 2);
    put(&folder, "a.csv", format!("{head}\n{}\n", first.join("\n")));
    put(&folder, "b.csv", format!("{head}\n{}\n", second.join("\n")));
    let args = "calibrate a.csv --interval 60 -o cal.toml --json";
    let line = gripctl(&folder, args).last();
    assert_eq!(line["type"], "calibration");
    let evidence = &line["evidence"];
    assert!(number(evidence, "rest_s") > 20.0 && number(evidence, "motion_s") > 20.0, "{line}");
    assert!(number(evidence, "interval_low_s") > 10.0, "{line}");
    // White noise of 0.1 um over 1 kHz has the energy of the shear band times 380 / 1000.
    let shear = line["floor"][0].as_f64().unwrap();
    assert!((shear / (1e-14 * 0.38) - 1.0).abs() < 0.15, "{shear:e}");
    let args = "replay b.csv --calibration cal.toml --json";
    let summary = gripctl(&folder, args).last();
    assert!(number(&summary, "slips") <= 6.0, "two minutes at one a minute: {summary}");
    let text = gripctl(&folder, "calibrate a.csv -o cal.toml").done().out;
    assert!(
        text.contains("fast trigger, wanted: one false alarm in 600 s; seen: 0 slips in a replay")
            && text.contains("to promise what is wanted, record 3600 s"),
        "{text}"
    );
}

/// What a calibration states the fast trigger still finds it finds, and what is far below it does not; the certified alarm does.
#[test]
fn the_smallest_slip_is_found() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "a.csv", recording(120, |_| 0.1, 5));
    let args = "calibrate a.csv --interval 60 -o cal.toml --json";
    let line = gripctl(&folder, args).last();
    let smallest_m = number(&line["evidence"], "smallest_rest");
    assert!((1e-7..5e-6).contains(&smallest_m), "{smallest_m}");
    assert!(number(&line["evidence"], "smallest_motion") > smallest_m, "{line}");
    let text = read(&folder, "cal.toml");
    put(&folder, "fast.toml", text.split("[certificate]").next().unwrap());
    let slips = |share: f64, calibration: &str| {
        let still = Disturbance::new(0.0, 0.0, 2000.0, 3);
        let mut robot = still.clone();
        let mut text = String::from("t_s,stylus,reference\n");
        for i in 0..6000_u32 {
            let t = f64::from(i) / 2000.0;
            let tone = (core::f64::consts::TAU * 250.0 * t).sin();
            let slip_m =
                if i > 4000 { share * smallest_m * core::f64::consts::SQRT_2 * tone } else { 0.0 };
            writeln!(text, "{t:.6},{slip_m:e},{:e}", robot.next_sample().reference_m).unwrap();
        }
        put(&folder, "slip.csv", &text);
        let args = &format!("replay slip.csv --calibration {calibration} --json");
        number(&gripctl(&folder, args).last(), "slips")
    };
    assert_eq!([slips(0.5, "fast.toml"), slips(1.3, "fast.toml")], [0.0, 1.0]);
    assert_eq!(slips(0.5, "cal.toml"), 1.0);
}

#[test]
fn floors_that_cannot_be_trusted_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "short.csv", recording(2, |_| 0.1, 1));
    let dead: String = recording(20, |_| 0.1, 1)
        .lines()
        .enumerate()
        .map(|(i, row)| match row.split(',').collect::<Vec<_>>()[..] {
            [t, _, r] if i > 12_000 => format!("{t},1e-6,{r}\n"),
            _ => format!("{row}\n"),
        })
        .collect();
    put(&folder, "dead.csv", &dead);
    let refuse = |file: &str, words: &[&str]| {
        gripctl(&folder, format!("calibrate {file} -o cal.toml")).refused(1, words);
        assert!(!folder.path().join("cal.toml").exists());
    };
    refuse("short.csv", &["short.csv", "too short"]);
    refuse("dead.csv", &["dead.csv", "not healthy", "frozen"]);
    let args = "calibrate short.csv -o cal.toml --interval 0";
    gripctl(&folder, args).refused(2, &["--interval 0"]);
    put(&folder, "bad.toml", "floor = 3\n");
    let args = "replay short.csv --calibration bad.toml";
    gripctl(&folder, args).refused(2, &["bad.toml:1:9", "invalid type"]);
}

/// What is loud at rest is left out of the floor and said, and replay reports it no more.
#[test]
fn a_rest_that_changes_is_taken_and_stated() {
    let folder = tempfile::tempdir().unwrap();
    let with = |loud_s: f64| {
        let rms = move |t: f64| if (50.0..50.0 + loud_s).contains(&t) { 2.0 } else { 0.1 };
        let text = work(120, rms, |t| !(48.0..70.0).contains(&t), 5);
        put(&folder, "work.csv", &text);
        let args = "calibrate work.csv --interval 60 -o cal.toml --json";
        let line = gripctl(&folder, args).last();
        let args = "replay work.csv --calibration cal.toml --json";
        let summary = gripctl(&folder, args).last();
        assert_eq!(number(&line["evidence"], "seen"), number(&summary, "slips"), "{line}");
        line
    };
    // Steady, a slip of 5 s at rest, and one that goes on in motion.
    let (clean, slipped, long) = (with(0.0), with(5.0), with(24.0));
    assert_eq!(clean["evidence"]["unexplained_s"], 0.0);
    let evidence = &slipped["evidence"];
    let [at_s, long_s] = [0, 1].map(|i| evidence["unexplained_longest"][i].as_f64().unwrap());
    assert!((4.8..5.5).contains(&number(evidence, "unexplained_s")), "{slipped}");
    assert!((49.8..55.0).contains(&at_s) && long_s < 5.3, "{slipped}");
    assert!(number(evidence, "unsteady") > 100.0, "{slipped}");
    let smallest = |line: &serde_json::Value| number(&line["evidence"], "smallest_rest");
    assert!(smallest(&slipped) > 5.0 * smallest(&clean), "{slipped}");
    let floor = |line: &serde_json::Value| line["floor"][1].as_f64().unwrap();
    for line in [&slipped, &long] {
        assert!((floor(line) / floor(&clean) - 1.0).abs() < 0.1, "{line}");
        assert!(number(&line["evidence"], "seen") <= 1.0, "{line}");
    }
    let text = gripctl(&folder, "calibrate work.csv -o cal.toml").done().out;
    for words in [
        "left out of the floor as unexplained",
        "its energy changes by",
        "is no slip while this calibration is in force; where something slipped, record again",
    ] {
        assert!(text.contains(words), "no {words}: {text}");
    }
}

/// An open hand has the noise of a closed one, though a gripper that holds nothing listens to no slip.
#[test]
fn a_force_of_zero_does_not_change_the_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let text = recording(60, |_| 0.1, 3);
    let open: String = text
        .lines()
        .map(|row| match row.starts_with('t') {
            true => format!("{row},force_n\n"),
            false => format!("{row},0.01\n"),
        })
        .collect();
    put(&folder, "bare.csv", &text);
    put(&folder, "open.csv", &open);
    let made = |file: &str| {
        let args = &format!("calibrate {file} -o cal.toml --interval 60 --json");
        gripctl(&folder, args).last()
    };
    let bare = made("bare.csv");
    assert_eq!(made("open.csv"), bare);
    assert!(bare["slack_still"][0].as_f64().unwrap() < 3.0, "{bare}");
}

/// Noise at rest of two minutes, and then a slip of four times its energy that lasts.
#[test]
fn a_slip_is_certified_by_a_calibration_that_carries_it_and_by_no_older_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = 1_u64;
    let mut noise = |size: f64| {
        let sum: f64 = (0..12)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
            })
            .sum();
        size * sum
    };
    let mut rows = |seconds: u32, slip_from: u32| {
        let mut text = String::from("t_s,vibration\n");
        for i in 0..seconds * 2000 {
            let size = if i >= slip_from * 2000 { 6.0 } else { 1.0 };
            writeln!(text, "{:.6},{:e}", f64::from(i) / 2000.0, noise(size)).unwrap();
        }
        text
    };
    put(&folder, "rest.csv", rows(180, 180));
    put(&folder, "slip.csv", rows(6, 5));
    let args = "calibrate rest.csv --interval 600 -o cal.toml";
    let text = gripctl(&folder, args).done().out;
    for words in [
        "certified alarm: one false alarm in 600 s or more",
        "at rest: 1",
        "in motion: too little",
        "of motion are missing: add a motion reference, or a column",
        "0 alarms in 90 s that the slack was not taken from, so one in 30 s or more",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let replay = |calibration: &str, json: bool| {
        let json = if json { "--json" } else { "" };
        gripctl(&folder, format!("replay slip.csv --calibration {calibration} {json}")).done()
    };
    let events = replay("cal.toml", true).json();
    let slips: Vec<_> = events.iter().filter(|event| event["type"] == "slip").collect();
    let certified = slips.iter().find(|slip| slip["certified"] == true).unwrap();
    assert!(
        number(certified, "t_s") < 5.1 && certified["certified_interval_s"] == 600.0,
        "{slips:?}"
    );
    // A file without a certificate, as older versions wrote it.
    let new = read(&folder, "cal.toml");
    put(&folder, "old.toml", new.split("[certificate]").next().unwrap());
    let ran = replay("old.toml", true);
    assert!(ran.err.contains("no certified false-alarm interval"), "{}", ran.err);
    assert!(ran.json().iter().filter(|e| e["type"] == "slip").all(|e| e["certified"] == false));
    assert!(!replay("old.toml", false).out.contains(", certified"));
}

#[test]
fn a_recording_too_short_for_a_certificate_states_so() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "short.csv", recording(25, |_| 0.1, 3));
    let ran = gripctl(&folder, "calibrate short.csv -o cal.toml").done();
    for words in ["no slip will be certified", "record 120 s or more", "gripctl calibrate LONGER"] {
        assert!(ran.err.contains(words), "no {words}: {}", ran.err);
    }
    let replayed = gripctl(&folder, "replay short.csv --calibration cal.toml").done();
    for words in ["it stands on ", "of motion: record 120 s or more", "gripctl calibrate LONGER"] {
        assert!(replayed.err.contains(words), "no {words}: {}", replayed.err);
    }
    assert!(!read(&folder, "cal.toml").contains("[certificate"));
}

/// A machine that stands still for a second ends the measurement of a live gripper, which is then done again.
fn not_interrupted(measure: impl Fn() -> Ran) -> Ran {
    (0..3).map(|_| measure()).find(|ran| !ran.err.contains("fell silent")).unwrap()
}

#[test]
fn a_gripper_is_calibrated_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let args = "calibrate --port sim --rest-s 9 --interval 20 -o cal.toml";
    let live = not_interrupted(|| gripctl(&folder, format!("{args} --json")));
    assert!([0, 3].contains(&live.code), "{live:?}");
    let line = live.json().pop().unwrap();
    assert!(
        number(&line["evidence"], "rest_s") > 5.0 && line["sample_rate_hz"] == 10_000.0,
        "{line}"
    );
    assert!(number(&line["evidence"], "interval_low_s") > 0.5, "{line}");
    assert!(live.err.contains("keep robot and gripper still"), "{}", live.err);
    // The same file is taken by a replay at the same rate.
    let mut rows = String::from("t_s,stylus,force_n\n");
    for i in 0..2000_u32 {
        writeln!(rows, "{:.4},{:e},0.0", f64::from(i) * 1e-4, 1e-8 * f64::from(i * 7 % 5)).unwrap();
    }
    put(&folder, "x.csv", &rows);
    gripctl(&folder, "replay x.csv --calibration cal.toml").done();
}

#[test]
fn a_measurement_that_cannot_be_trusted_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let args = "calibrate --port sim --rest-s 2 -o cal.toml";
    not_interrupted(|| gripctl(&folder, args)).refused(1, &["sim: ", "too short", "at least 5 s"]);
    assert!(!folder.path().join("cal.toml").exists());
}

/// Frames of four taxels, `hz` of them a second: open, then held from 1 s on; from `slips_s` on the pattern moves on.
fn array(seconds: u32, hz: u32, head: &str, slips_s: f64) -> String {
    let mut noise = noise(7);
    let mut text = format!("{head}pressure_0,pressure_1,pressure_2,pressure_3\n");
    for i in 0..seconds * hz {
        let t = f64::from(i) / f64::from(hz);
        write!(text, "{t:.6}").unwrap();
        let force = if t < 1.0 { 0.0 } else { 5.0 };
        if head.contains("force_n") {
            write!(text, ",{force}").unwrap();
        }
        for taxel in 0..4_u32 {
            let moved = (t - slips_s).max(0.0) * 40.0;
            let pattern = (f64::from(taxel) * 1.3 + moved).sin();
            write!(text, ",{}", 20.0 + force * (4.0 + pattern) + noise()).unwrap();
        }
        text.push('\n');
    }
    text
}

#[test]
fn an_array_alone_is_calibrated_on_an_object_that_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    put(path, "held.csv", array(12, 100, "t_s,force_n,", 1e9));
    put(path, "slips.csv", array(12, 100, "t_s,force_n,", 8.0));
    put(path, "bare.csv", array(12, 100, "t_s,", 1e9));
    put(path, "short.csv", array(4, 100, "t_s,force_n,", 1e9));
    let line = gripctl(path, "calibrate held.csv -o cal.toml --json").done().json();
    // Uniform noise of 1 has an rms of 0.289; the shape takes a part of it.
    let taxels = &line[0]["taxels"];
    assert!((0.2..0.5).contains(&number(taxels, "rms")), "{line:?}");
    assert!(number(taxels, "range") > 0.0, "{line:?}");
    let text = gripctl(path, "calibrate held.csv -o cal.toml").done().out;
    assert!(text.starts_with("taxels at rest: noise") && text.contains("A slip is found from"));
    for (file, slips) in [("held.csv", 0.0), ("slips.csv", 1.0)] {
        let args = &format!("replay {file} --calibration cal.toml --json");
        let summary = gripctl(path, args).last();
        assert_eq!(number(&summary, "slips"), slips, "{file}: {summary}");
    }
    gripctl(path, "calibrate bare.csv -o x.toml").refused(1, &["force_n"]);
    gripctl(path, "calibrate short.csv -o x.toml").refused(1, &["at least 5 s"]);
    put(path, "broken.toml", "sample_rate_hz = 100.0\n[taxels]\nrms = 1.0\nsize = 3\n");
    gripctl(path, "replay held.csv --calibration broken.toml").refused(2, &["size"]);
    assert!(!path.join("x.toml").exists());
}
