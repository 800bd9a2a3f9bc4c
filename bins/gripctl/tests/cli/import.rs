//! Files of other programs through `gripctl import`, `replay` and `label`, to a figure of `score`.

use crate::run::{self, gripctl, noise, number, put, read};
use core::f64::consts::TAU;
use std::{fs, path::Path};

/// A WAV of 16 bits at 8 kHz: quiet noise, from 1.5 s on a loud one.
fn wav(file: &Path, seed: u32) {
    wav_at(file, seed, 8000);
}

/// The same 16,000 samples under another rate.
fn wav_at(file: &Path, seed: u32, rate_hz: u32) {
    let mut noise = noise(seed);
    let samples = (0..16_000_u32).map(|i| {
        let loud = if i >= 12_000 { 4000.0 * (TAU * 0.03 * f64::from(i)).sin() } else { 0.0 };
        80.0 * noise() + loud
    });
    fs::write(file, run::wav(rate_hz, samples)).unwrap();
}

#[test]
fn a_wav_is_imported_labelled_and_scored() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    wav(&folder.join("a.wav"), 1);
    wav(&folder.join("b.wav"), 2);
    let direct = gripctl(folder, "replay a.wav --json").done();
    assert!(direct.err.contains("channel_1 -> vibration (share of full scale)"), "{}", direct.err);
    for output in ["a.csv", "a.npz", "b.csv"] {
        let from = format!("{}.wav", &output[..1]);
        let ran = gripctl(folder, format!("import {from} -o {output}")).done();
        let words =
            ["WAV, times from the header: 8000 Hz, integers of 16 bits", "channel_1 -> vibration"];
        assert!(words.iter().all(|word| ran.out.contains(word)), "{}", ran.out);
        assert!(
            ran.out.contains(&format!("16000 samples in 2.000 s at 8000.0 Hz -> {output}")),
            "{}",
            ran.out
        );
    }
    let replayed = gripctl(folder, "replay a.npz --json").done();
    let played = replayed.out.replace("a.npz", "a.wav");
    assert_eq!(played, direct.out, "imported or not, the events are the same");
    let lines = gripctl(folder, "import a.wav --json").done().json();
    assert_eq!(
        (&lines[0]["column"], &lines[0]["signal"]),
        (&"vibration".into(), &"channel_1".into())
    );
    assert!(number(&lines[1], "samples") == 16_000.0 && lines[1]["output"].is_null(), "{lines:?}");

    fs::remove_file(folder.join("a.npz")).unwrap();
    let label = |name: &str, more: &str| gripctl(folder, format!("label {name} {more}"));
    let onset = "--onset 1.5 --material cork";
    assert!(label("a.csv", onset).done().out.contains("a onset at 1.500000 s"));
    label("b.csv", "--rest").done();
    label("b.csv", onset).refused(2, &["b has a label already (rest)", "--force"]);
    let replaced = label("b.csv", "--onset 1.5 --material steel --force").done();
    assert!(replaced.out.contains("was rest"), "{}", replaced.out);
    let scored = gripctl(folder, "score . --json").done().json();
    for line in &scored[..2] {
        assert!(line["material"] != "" && number(line, "latency_ms") < 10.0, "{line}");
    }
    label("b.csv", "--onset 1.6 --force").done();
    let labels = read(folder, "labels.csv");
    assert!(labels.contains("b,onset,steel,1.600000"), "the material stays: {labels}");
    label("b.csv", "--remove").done();
    label("b.csv", "--remove").refused(2, &["no label"]);
    label("a.csv", "--onset 2.5 --force").refused(2, &["goes from 0.000000 s to 1.999875 s"]);
    label("a.wav", "--rest").refused(2, &["gripctl import"]);
    let labels = read(folder, "labels.csv");
    assert_eq!(labels, "recording,kind,material,onset_s\na,onset,cork,1.500000\n");
}

/// As MCAP a recording gives the events and the score that it gives as CSV, taxels and channels included.
#[test]
fn an_mcap_gives_the_events_of_the_csv() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    wav(&folder.join("a.wav"), 1);
    let taxels: String = (0..300_u32)
        .map(|i| {
            let row: String = (0..9_u32)
                .map(|k| {
                    let moved = if i > 200 { f64::from(i - 200) * 0.05 } else { 0.0 };
                    let noise = f64::from((i * 7919 + k * 104_729) % 97) / 97.0;
                    format!(",{:.2}", 500.0 * (-(f64::from(k) - 4.0 - moved).powi(2)).exp() + noise)
                })
                .collect();
            format!("{:.2},5.0{row}\n", 0.01 * f64::from(i))
        })
        .collect();
    let head: String = (0..9).map(|k| format!(",pressure_{k}")).collect();
    put(folder, "taxels_in.csv", format!("t_s,force_n{head}\n{taxels}"));
    for (name, from) in [("a", "a.wav"), ("taxels", "taxels_in.csv")] {
        let events = |ending: &str| {
            let file = format!("{name}.{ending}");
            gripctl(folder, format!("import {from} -o {file}")).done();
            let mut lines = gripctl(folder, format!("replay {file} --json")).done().json();
            let summary = lines.pop().unwrap();
            (lines, summary["samples"].clone())
        };
        let csv = events("csv");
        assert!(csv.0.iter().any(|line| line["type"] == "slip"), "{csv:?}");
        assert_eq!(events("mcap"), csv);
        let mcap = format!("{name}.mcap");
        gripctl(folder, format!("replay {mcap} --check")).done();
        let kind = if name == "a" { "--onset 1.5" } else { "--onset 2" };
        let scored = |file: &str| {
            gripctl(folder, format!("label {file} {kind} --force")).done();
            gripctl(folder, "score . --floor live --json").done().json()
        };
        let as_csv = scored(&format!("{name}.csv"));
        fs::remove_file(folder.join(format!("{name}.csv"))).unwrap();
        assert_eq!(scored(&mcap), as_csv);
        fs::remove_file(folder.join("labels.csv")).unwrap();
    }
}

/// A file may clear the screen, or forge a line of it.
#[test]
fn names_of_a_file_change_no_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| put(&folder, "x.csv", text);
    let rows = "\n0,1,2,3\n0.001,2,3,4\n0.002,1,2,3\n";
    write(&format!("t_s,vibration,\x1b[31mred\x1b]0;title\x07,back{rows}"));
    gripctl(&folder, "import x.csv").refused(2, &["x.csv: is no text"]);
    write(&format!("t_s,vibration,\u{9b}31mred,\u{202e}back{rows}"));
    let ran = gripctl(&folder, "import x.csv").done();
    assert!(ran.out.contains("not used: \\u{9b}31mred, \\u{202e}back"), "{ran:?}");
    let hostile = |c: char| c.is_control() && c != '\n' || c == '\u{202e}';
    assert!(!ran.out.contains(hostile) && !ran.err.contains(hostile), "{ran:?}");

    let rows: String = (0..40).map(|k| format!("{k},1,{}\n", k * k % 7)).collect();
    let file = "\u{9b}2J\x1b[31m.csv";
    put(&folder, file, format!("a,\u{9b}31mred,b\n{rows}"));
    let columns = "--inputs a,\u{9b}31mred --target b --epochs 2 -o m.json";
    let ran = gripctl(&folder, format!("train {file} {columns}")).done();
    assert!(ran.err.contains("\\u{9b}2J\\u{1b}[31m.csv: "), "{ran:?}");
    assert!(!ran.out.contains(hostile) && !ran.err.contains(hostile), "{ran:?}");
}

#[test]
fn what_cannot_be_imported_ends_with_2_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let put = |name: &str, bytes: &[u8]| put(folder, name, bytes);
    put("x.wav", b"RIFF");
    put("x.npy", b"\x93NUMPY\x01\0");
    put("x.mcap", b"\x89MCAP0\r\n");
    put("x.db3", b"SQLite format 3\0 and nothing");
    put("x.csv", b"t_s,temperature\n0,1\n0.001,2\n");
    put("zeros.csv", &[0; 2 << 20]);
    let all =
        ["x.wav", "x.npy", "x.mcap", "x.db3", "x.csv", "zeros.csv", "none.csv", "/dev/zero", "."];
    for name in all {
        gripctl(folder, format!("import {name} -o out.csv")).refused(2, &[name]);
        assert!(!folder.join("out.csv").exists(), "{name}");
    }
    wav_at(&folder.join("fast.wav"), 1, 192_000);
    for args in ["import fast.wav -o out.csv", "replay fast.wav"] {
        gripctl(folder, args).refused(2, &["fast.wav", "192000", "50000", "sox", "48000"]);
    }
    put("ok.csv", b"time_ms;mic\n0;1\n1;2\n2;1\n");
    put("out.csv", b"of somebody");
    let import = "import ok.csv -o out.csv";
    gripctl(folder, import).refused(2, &["out.csv: is there already", "add --force to replace it"]);
    assert_eq!(fs::read(folder.join("out.csv")).unwrap(), b"of somebody");
    gripctl(folder, format!("{import} --force")).done();
    let text = read(folder, "out.csv");
    assert_eq!(text, "t_s,vibration\n0.000000,1.0\n0.001000,2.0\n0.002000,1.0\n");
}

/// A signal that slips from 2 s on, at 1600 Hz, with stamps in whole milliseconds.
fn coarse(file: &Path) {
    let mut noise = noise(5);
    let rows: String = (0..4800_u32)
        .map(|i| {
            let size = if i >= 3200 { 2.0 } else { 0.02 };
            format!("{};{:.5}\n", i * 1000 / 1600, size * noise())
        })
        .collect();
    fs::write(file, format!("board ready\nTime (ms);vib\n{rows}")).unwrap();
}

#[test]
fn a_file_with_coarse_stamps_replays_as_what_is_imported_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    coarse(&folder.join("x.csv"));
    let events = |file: &str| {
        let mut lines = gripctl(folder, format!("replay {file} --json")).done().json();
        let summary = lines.pop().unwrap();
        assert_eq!((number(&summary, "unusable"), number(&summary, "lost")), (0.0, 0.0), "{file}");
        (lines, summary["samples"].clone(), summary["slips"].clone())
    };
    let direct = events("x.csv");
    assert!(direct.0.iter().any(|line| line["type"] == "slip"), "{direct:?}");
    for output in ["y.csv", "y.npz", "y.mcap"] {
        let ran = gripctl(folder, format!("import x.csv -o {output}")).done();
        let words = ["vib -> vibration", "1800 of 4800 repeat", "placed evenly at 1600."];
        assert!(words.iter().all(|word| ran.out.contains(word)), "{}", ran.out);
        let (_, samples, slips) = events(output);
        assert_eq!((samples, slips), (direct.1.clone(), direct.2.clone()), "{output}");
    }
}

#[test]
fn a_table_that_was_cut_off_is_used_and_ends_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    coarse(&folder.join("x.csv"));
    gripctl(folder, "import x.csv -o y.csv").done();
    let bytes = fs::read(folder.join("y.csv")).unwrap();
    put(folder, "y.csv", &bytes[..bytes.len() - 4]);
    put(folder, "labels.csv", "recording,kind,material,onset_s\ny,onset,m,2.0\n");
    for args in ["replay y.csv", "import y.csv -o z.csv", "score . --floor live"] {
        let ran = gripctl(folder, args);
        let said = format!("{}{}", ran.out, ran.err);
        assert!(ran.code == 3 && said.contains("line 4801 was cut off"), "{args:?} {said}");
    }
}
