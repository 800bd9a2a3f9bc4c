//! Recordings with several axes through `replay`, `score` and `calibrate`: the same figures however the sensor is mounted.

use crate::run::{gripctl, number};
use core::{f64::consts::FRAC_PI_4, fmt::Write as _};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Uniform noise of variance 1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f64 / f64::from(1_u32 << 23) - 1.0) * 1.732
    }
}

/// About z and then about x.
fn turned([x, y, z]: [f64; 3], by: f64) -> [f64; 3] {
    let (s, c) = by.sin_cos();
    let (x, y) = (c * x - s * y, s * x + c * y);
    [x, c * y - s * z, s * y + c * z]
}

/// 14 s at 2 kHz, the arm moving along y from 6 to 12 s, a slip along x from `onset` on; the sensors turned. Where it is labelled, the
/// arm stands, because `score` takes all rest for that of a standing arm.
fn recording(folder: &Path, name: &str, seed: u64, moves: bool, onset: f64, by: f64) {
    let mut noise = Noise(seed);
    let names = ["vibration", "reference"].map(|n| format!("{n}_x,{n}_y,{n}_z"));
    let mut text = format!("t_s,{}\n", names.join(","));
    for i in 0..28_000_u32 {
        let t_s = f64::from(i) / 2000.0;
        let arm = if moves && (6.0..12.0).contains(&t_s) { noise.next() } else { 0.0 };
        let slip = if t_s >= onset { 0.3 * noise.next() } else { 0.0 };
        let mut rest = || [(); 3].map(|()| 0.02 * noise.next());
        let ([a, b, c], [d, e, f]) = (rest(), rest());
        let [x, y, z] = turned([slip + a, 0.5 * arm + b, 9.8 + c], by);
        let [u, v, w] = turned([d, arm + e, 9.8 + f], -by);
        writeln!(text, "{t_s:.4},{x:.5},{y:.5},{z:.5},{u:.5},{v:.5},{w:.5}").unwrap();
    }
    fs::write(folder.join(name), text).unwrap();
}

fn folder(by: f64) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    recording(folder.path(), "moved.csv", 2, true, 12.5, by);
    recording(folder.path(), "one.csv", 3, false, 12.5, by);
    recording(folder.path(), "two.csv", 5, false, 13.0, by);
    recording(folder.path(), "rest.csv", 7, true, f64::INFINITY, by);
    let labels = "recording,kind,material,onset_s\none,onset,a,12.5\ntwo,onset,b,13\n";
    fs::write(folder.path().join("labels.csv"), labels).unwrap();
    let path = folder.path().to_owned();
    (folder, path)
}

#[test]
fn a_turned_sensor_gives_the_same_figures() {
    let [(_straight, straight), (_turned, turned)] = [0.0, FRAC_PI_4].map(folder);
    let both = |args: &[&str]| [&straight, &turned].map(|dir| gripctl(dir, args).done());

    let [one, other] = both(&["replay", "moved.csv", "--json"]).map(|ran| ran.json());
    assert_eq!(one.len(), other.len(), "{one:?} {other:?}");
    let first = |lines: &[serde_json::Value]| number(&lines[0], "t_s");
    assert!((12.5..12.51).contains(&first(&one)), "the motion is none: {one:?}");
    for (line, turned) in one.iter().zip(&other).filter(|(line, _)| line["type"] != "summary") {
        assert_eq!((&line["type"], &line["phase"]), (&turned["type"], &turned["phase"]));
        assert!((number(line, "t_s") - number(turned, "t_s")).abs() < 6e-4, "{line} {turned}");
    }

    let [one, other] = both(&["score", ".", "--json"]).map(|ran| ran.json());
    let latency = |lines: &[serde_json::Value], at: usize| number(&lines[at], "latency_ms");
    for at in [0, 1] {
        let (a, b) = (latency(&one, at), latency(&other, at));
        assert!(a < 10.0 && (a - b).abs() <= 0.5, "{a} ms, turned {b} ms");
    }

    let args = ["calibrate", "rest.csv", "-o", "c.toml", "--json"];
    let [one, other] = both(&args).map(|ran| ran.json().remove(0));
    let close = |name: &str| {
        let (a, b) = (one[name].as_array().unwrap(), other[name].as_array().unwrap());
        for (a, b) in a.iter().zip(b) {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a / b - 1.0).abs() < 0.02, "{name}: {one} {other}");
        }
    };
    for name in ["floor", "reference_floor", "gain", "slack_still"] {
        close(name);
    }
}

#[test]
fn one_of_more_axes_than_a_vector_has_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let text = "t_s,vibration_1,vibration_2,vibration_3,vibration_4\n0,1,2,3,4\n0.001,1,2,3,4\n";
    fs::write(folder.path().join("four.csv"), text).unwrap();
    let one = ["replay", "four.csv", "--map", "vibration=vibration_2"];
    let ran = gripctl(folder.path(), &one).done();
    assert!(ran.err.contains("vibration_3"), "what is not used is said: {}", ran.err);
}
