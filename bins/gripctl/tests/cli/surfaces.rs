//! Profiles and lists of irregularities through `gripctl profile` and `gripctl esc`.

use crate::run::{gripctl, number, put, read};
use serde_json::Value;
use std::{fs, path::Path};

/// A sine of 2 um and 250 um, 10 mm long.
fn write_sine(folder: &Path) {
    let row = |i: u32| {
        let x_mm = f64::from(i) * 1e-3;
        format!("{x_mm:.3},{:.4}\n", 2.0 * (core::f64::consts::TAU * x_mm / 0.25).sin())
    };
    let text: String = (0..10_000).map(row).collect();
    put(folder, "sine.csv", format!("x_mm,height_um\n{text}"));
}

#[test]
fn a_profile_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    write_sine(folder.path());
    let args = "profile sine.csv --speed 0.05 --force 2 --json";
    let line = gripctl(&folder, args).last();
    let close =
        |got: f64, want: f64| assert!((got / want - 1.0).abs() < 0.01, "{got} {want} {line}");
    close(number(&line, "ra_um"), 4.0 / core::f64::consts::PI);
    close(number(&line, "rq_um"), 2.0_f64.sqrt());
    close(number(&line, "rz_um"), 4.0);
    close(number(&line, "rsm_um"), 250.0);
    close(number(&line, "period_um"), 250.0);
    close(number(&line["s_um"], "mean"), 250.0);
    close(number(&line["delta_um"], "mean"), 4.0 * 0.927);
    assert_eq!((number(&line, "n"), number(&line, "sections")), (39.0, 3.0), "{line}");
    let names: Vec<&Value> =
        line["esc"].as_array().unwrap().iter().map(|e| &e["reading"]).collect();
    assert_eq!(names, ["literal", "arc_cot", "slope_power", "lift_work", "viscous_work"]);
    let lift = &line["esc"][3];
    close(number(lift, "value"), 2.0 * 39.0 * 4e-6 * 0.927);
    assert!(lift["unit"] == "J" && number(lift, "lo") <= number(lift, "hi"), "{lift}");
    let args = "profile sine.csv --speed 0.05 --filter gaussian --level";
    let text = gripctl(&folder, args).done().out;
    for word in [
        "10.000 mm",
        "gaussian",
        "RSm 250.0",
        "height delta",
        "spacing s",
        "literal",
        "F sum delta",
    ] {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}

#[test]
fn a_plot_shows_peaks_and_valleys() {
    let folder = tempfile::tempdir().unwrap();
    write_sine(folder.path());
    for (file, begin) in [("p.svg", &b"<svg"[..]), ("p.png", &b"\x89PNG"[..])] {
        gripctl(&folder, format!("profile sine.csv --speed 0.05 --plot {file}")).done();
        let bytes = fs::read(folder.path().join(file)).unwrap();
        assert!(bytes.starts_with(begin) && bytes.len() > 5000, "{file}: {} bytes", bytes.len());
    }
    let svg = read(&folder, "p.svg");
    assert!(svg.contains("peaks") && svg.contains("valleys") && svg.contains("distance (mm)"));
}

#[test]
fn a_user_is_reported_what_spoils_the_figures() {
    let folder = tempfile::tempdir().unwrap();
    write_sine(folder.path());
    let stated =
        |more: &str| gripctl(&folder, format!("profile sine.csv --speed 0.05 {more}")).done().err;
    assert_eq!(stated("--cutoff-mm 0.8 --lambda-s-um 5"), "");
    let other = stated("");
    for words in
        ["sampling lengths of 2.5 mm: 3 of the five", "RSm of 250 um ask for --cutoff-mm 0.8"]
    {
        assert!(other.contains(words), "{other}");
    }
    assert!(stated("--cutoff-mm 0.8").contains("steps of 1 um are too wide for lambda_s"));
    let mut rows: Vec<String> = read(&folder, "sine.csv").lines().map(Into::into).collect();
    rows[3001] = "3.000,500".to_owned();
    rows[4001] = "4.000,".to_owned();
    rows.drain(5001..5011);
    put(&folder, "holes.csv", rows.join("\n") + "\n");
    let args = "profile holes.csv --speed 0.05 --json";
    let line = gripctl(&folder, args).last();
    let warnings = line["warnings"].to_string();
    for words in [
        "spikes: 1, up to 500",
        "um high, at 3 mm:",
        "not measured: 11, gaps: 2, the widest 10 um at 5 mm",
    ] {
        assert!(warnings.contains(words), "{warnings}");
    }
    put(&folder, "cut.csv", rows.join("\n") + "\n9.1");
    let cut = gripctl(&folder, "profile cut.csv --speed 0.05");
    assert!(cut.code == 3 && cut.err.contains("was cut off and is left out"), "{}", cut.err);
    rows.drain(6001..6151);
    put(&folder, "holes.csv", rows.join("\n") + "\n");
    gripctl(&folder, args).refused(2, &["no heights from 6.0100 to 6.1600 mm", "split the file"]);
    assert!(stated("--cutoff-mm 20").contains("less than one cutoff"));
    assert!(stated("--hysteresis-um 50").contains("no irregularity higher than"));
    let tilted: String = (0..3000).map(|i| format!("{},{}\n", i, i * 5)).collect();
    put(&folder, "tilt.csv", format!("x_mm,height_um\n{tilted}"));
    let args = "profile tilt.csv --speed 0.05 --step-um 1";
    assert!(gripctl(&folder, args).done().err.contains("--level"));
}

#[test]
fn every_reading_of_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let list = "delta_m,s_m\n20e-6,100e-6\n30e-6,50e-6\n5e-6,80e-6\n0,1e-4\n";
    put(&folder, "i.csv", list);
    let esc = "esc i.csv --force 2 --speed 0.05";
    let args = &format!("{esc} --noise 0.01");
    let ran = gripctl(&folder, format!("{args} --json")).done();
    assert!(ran.err.contains("1 of 4 irregularities left out"), "{}", ran.err);
    let lines = ran.json();
    let r: [f64; 3] = [0.2, 0.6, 0.0625];
    let literal = 3.0 * 2.0 * 0.05 * r.iter().map(|r| 1.0 / r.tan()).sum::<f64>().tan();
    let sigma = 0.01 * r.iter().map(|r| (r / r.sin().powi(2)).powi(2)).sum::<f64>().sqrt();
    assert!((number(&lines[0], "value") / literal - 1.0).abs() < 1e-12, "{}", lines[0]);
    assert!((number(&lines[0], "sigma_s") / sigma - 1.0).abs() < 1e-6, "{sigma} {}", lines[0]);
    assert!(
        number(&lines[0], "lo") <= literal * (1.0 + 1e-12) && number(&lines[0], "condition") > 1.0
    );
    assert!(lines.iter().all(|l| l["flags"].as_array().unwrap().contains(&"degenerate".into())));
    assert_eq!((lines.len(), &lines[3]["unit"]), (5, &Value::from("J")));
    let noisy = format!("{esc} --noise 1 --json");
    let flags = gripctl(&folder, noisy).done().json()[0]["flags"].clone();
    assert!(flags.as_array().unwrap().contains(&"no_information".into()), "{flags}");
    let text = gripctl(&folder, args).done().out;
    assert!(text.contains("n F v tan(sum cot(delta/s))") && text.contains("degenerate"), "{text}");
    put(&folder, "um.csv", "delta_m,s_m\n20,100\n");
    let um = "esc um.csv --force 1 --speed 1";
    assert!(gripctl(&folder, um).done().err.contains("in metres (20 um is 2e-5)"));
    put(&folder, "bad.csv", "delta_m,s_m\n0,0\n");
    let lines = gripctl(&folder, "esc bad.csv --force 1 --speed 1 --json");
    assert!(
        lines.done().json().iter().all(|l| l["value"].is_null() && l["flags"][0] == "degenerate")
    );
}

/// A wave of 4 um and 2 mm under the sine, on an arc, 12 mm long.
fn write_wavy(folder: &Path) {
    let tau = core::f64::consts::TAU;
    let row = |i: u32| {
        let x = f64::from(i) * 2e-3;
        let height = 2.0 * (tau * x / 0.25).sin() + 4.0 * (tau * x / 2.0).sin() + x * (12.0 - x);
        format!("{x:.3},{height:.4}\n")
    };
    let text: String = (0..6000).map(row).collect();
    put(folder, "wavy.csv", format!("x_mm,height_um\n{text}"));
}

#[test]
fn waviness_is_reported_beside_roughness() {
    let folder = tempfile::tempdir().unwrap();
    write_wavy(folder.path());
    let args = "profile wavy.csv --speed 0.05 --cutoff-mm 0.8";
    let args = &format!("{args} --form-degree 2 --level");
    let with = |more: &str| gripctl(&folder, format!("{args} {more}"));
    let line = with("--json --parts parts.csv").done().json().remove(0);
    // Three moving averages keep 89.9 % of a wave of 2.5 cutoffs.
    let wa = 8.0 / core::f64::consts::PI * 0.8989;
    assert!((number(&line, "wa_um") / wa - 1.0).abs() < 0.03, "{wa} {line}");
    assert!((number(&line, "form_um") / 36.0 - 1.0).abs() < 0.1, "{line}");
    assert!(line["lambda_f_mm"].is_null() && line["waviness_sections"] == 1, "{line}");
    let (roughness, primary) = (&line["esc"][2], &line["primary"]["esc"][2]);
    let ratio = number(primary, "value") / number(roughness, "value");
    assert!((0.8..1.2).contains(&ratio) && number(&line["primary"], "n") > 30.0, "{line}");
    let parts = read(&folder, "parts.csv");
    let mut rows = parts.lines();
    assert_eq!(rows.next(), Some("x_mm,height_um,form_um,waviness_um,roughness_um"));
    let sums = rows.map(|row| {
        let v: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
        assert_eq!(v.len(), 5);
        (v[2] + v[3] + v[4] - v[1]).abs()
    });
    // lambda_s takes 1 % of the sine away.
    assert!(sums.fold(0.0, f64::max) < 0.05);
    let text = with("--lambda-f-mm 6").done().out;
    for words in ["Wa ", "lambda_f 6 mm, 2 sections", "polynomial of degree 2", "with waviness, of"]
    {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
}

#[test]
fn a_profile_too_short_for_waviness_says_so_and_bad_limits_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_wavy(folder.path());
    let args = "profile wavy.csv --speed 0.05";
    let with = |more: &str| gripctl(&folder, format!("{args} {more}"));
    let line = with("--json").done().json().remove(0);
    assert!(line["wa_um"].is_null() && line["wz_um"].is_null() && number(&line, "ra_um") > 0.0);
    assert!((number(&line, "waviness_needs_mm") - 12.5).abs() < 1e-9, "{line}");
    let text = with("").done().out;
    assert!(text.contains("not measured: it needs 12.5 mm of profile"), "{text}");
    with("--lambda-f-mm 1").refused(2, &["must be longer than lambda_c of 2.5 mm"]);
    with("--lambda-f-mm -1").refused(2, &["--lambda-f-mm -1: expected a number of more"]);
    with("--form-degree 0").refused(2, &["0 is not in 1..=9"]);
    with("--parts no/parts.csv").refused(1, &["cannot write no/parts.csv"]);
}
