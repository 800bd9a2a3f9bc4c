//! What a person may get wrong: each is refused with one message that states what, where and what to do.

use crate::running::gripd;
use std::{fs, path::Path};

const MODEL: &str = include_str!("../../../../crates/grip-session/models/default.json");

/// Each case: its text, and words of the message; the exit code is 2.
#[track_caller]
fn refuse(folder: &Path, args: &[&str], words: &[&str]) {
    let ran = gripd(folder, args).refused(2, words);
    for line in ran.err.lines().filter(|line| line.len() > 30) {
        assert_eq!(ran.err.matches(line).count(), 1, "told twice: {}", ran.err);
    }
}

#[test]
fn arguments() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |args: &[&str], words: &[&str]| refuse(folder.path(), args, words);
    refuse(&[], &["no port", "--port sim"]);
    refuse(&["--port", "sim:nope"], &["nope", "built in are default, heavy_smooth"]);
    refuse(&["--port", "sim:gone.toml"], &["gone.toml", "No such file"]);
    for duration in ["0", "-1", "nan", "inf", "x"] {
        let words = ["--duration", &format!("'{duration}'"), "more than 0"];
        refuse(&["--port", "sim", "--duration", duration], &words);
    }
    refuse(&["--port", "sim", "--baud", "0"], &["--baud", "1.."]);
    refuse(&["--port", "sim", "--seed", "-3"], &["-3"]);
    refuse(&["--port", "sim", "--record", "x.txt"], &["x.txt", ".mcap", ".csv"]);
    refuse(&["--prot", "sim"], &["--prot", "--port"]);
    refuse(&["--gripper", "robotiq:2f-85:/dev/ttyUSB0"], &["no sensor", "--sensor"]);
}

#[test]
fn configurations() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &[&str]); 14] = [
        ("f_max_n = 20.0\n", &[":1:1: unknown field `f_max_n`, which belongs under [grip]"]),
        ("[grip]\nsample_rate_hz = 1000\n", &[":2:1: ", "which belongs under [link]"]),
        ("ports = \"/dev/ttyACM0\"\n", &[":1:1: unknown field `ports`; is `port` meant?"]),
        ("[grip]\nf_max_n = 5.0\nforce = 3\n", &[":3:1: unknown field `force`", "expected one of"]),
        ("gripper = 1\n", &[":1:1: unknown field `gripper`", "`port`, `baud`"]),
        ("[grip]\nf_max_n = \"x\"\n", &[":2:11: ", "expected f32"]),
        ("[grip\n", &[":1:6: unclosed table"]),
        ("[link]\nbatch = 300\n", &[":2:9: ", "300"]),
        ("[grip]\nf_max_n = -3\n", &[":2:1: grip.f_max_n = -3 is outside 0.01 to 5000"]),
        ("[grip]\nf_max_n = nan\n", &[":2:1: grip.f_max_n = NaN is outside"]),
        ("[grip]\nf_max_n = 5.0\n  trial_force_n = 7.0\n", &[":3:3: grip.trial_force_n = 7"]),
        ("[health]\nmax_bad_run = 0\n", &[":2:1: health.max_bad_run = 0 is outside 1 to"]),
        ("baud = 0\n", &[":1:1: baud = 0 is outside 1 to"]),
        (
            "[detector]\nshear = { low_hz = 20.0, high_hz = 10.0 }\n",
            &[":2:11: detector.shear.low_hz = 20 is outside 0.001 to 10"],
        ),
    ];
    for (text, words) in cases {
        fs::write(folder.path().join("c.toml"), text).unwrap();
        refuse(folder.path(), &["--check-config", "--config", "c.toml"], words);
    }
    // The same file, found by its name, stops the daemon before it touches a port.
    fs::rename(folder.path().join("c.toml"), folder.path().join("gripd.toml")).unwrap();
    refuse(folder.path(), &["--port", "sim"], &["gripd.toml:2:11"]);
    let check = |file: &str, words: &[&str]| {
        refuse(folder.path(), &["--check-config", "--config", file], words);
    };
    check("gone.toml", &["gone.toml: the configuration cannot be read", "No such file"]);
    check(".", &["the configuration cannot be read", "directory"]);
    check("/dev/zero", &["the configuration cannot be read", "not a regular file"]);
    fs::File::create(folder.path().join("big.toml")).unwrap().set_len(1 << 40).unwrap();
    check("big.toml", &["1099511627776 bytes, more than the 1048576 that are read"]);
    fs::write(folder.path().join("b.toml"), [0xFF, 0x00, 0x9B, b'\n']).unwrap();
    check("b.toml", &["b.toml", "UTF-8"]);
    fs::write(folder.path().join("good.toml"), "[grip]\nf_max_n = 10.0\n").unwrap();
    let ran = gripd(folder.path(), &["--check-config", "--config", "good.toml"]);
    assert_eq!(
        (ran.code, ran.err.as_str()),
        (0, "good.toml: valid\nmodel: embedded model\n  grip.f_max_n = 10.0  good.toml:2:1\n")
    );
}

#[test]
fn layers_and_what_is_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let user = folder.path().join(".config/gripd");
    fs::create_dir_all(&user).unwrap();
    fs::write(user.join("gripd.toml"), "baud = 1\n[grip]\nf_max_n = 9.0\n[usb]\nvid = 1\n")
        .unwrap();
    fs::write(folder.path().join("gripd.toml"), "[grip]\ntrial_force_n = 1.0\nf_max_n = 8.0\n")
        .unwrap();
    let ran = gripd(folder.path(), &["--check-config", "--port", "sim", "--baud", "9600"]);
    let user_file = user.join("gripd.toml").display().to_string();
    let expected = format!(
        "gripd.toml: valid\n{user_file}: valid\nmodel: embedded model\n  baud = 9600               \
         --baud or GRIPD_BAUD, instead of {user_file}:1:1\n  grip.f_max_n = 8.0        gripd.toml:3:1, instead \
         of {user_file}:3:1\n  grip.trial_force_n = 1.0  gripd.toml:2:1\n  port = \"sim\"              \
         --port or GRIPD_PORT\n  usb.vid = 1               {user_file}:5:1\n\
         warning: [usb] chooses among ports only where port = \"auto\"\n"
    );
    assert_eq!((ran.code, ran.err.as_str()), (0, expected.as_str()));
    // --config takes the place of both.
    fs::write(folder.path().join("other.toml"), "").unwrap();
    let ran = gripd(folder.path(), &["--check-config", "--config", "other.toml"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, "other.toml: valid\nmodel: embedded model\n"));
    // A mistake is reported where it stands, also below the file in force.
    fs::write(user.join("gripd.toml"), "[grip]\nf_max_n = \"9\"\n").unwrap();
    refuse(folder.path(), &["--port", "sim"], &[".config/gripd/gripd.toml:2:11: invalid type"]);
    fs::write(user.join("gripd.toml"), "").unwrap();
    let flag = ["--port", "sim", "--listen", "tcp:0.0.0.0:1"];
    refuse(
        folder.path(),
        &flag,
        &["--listen or GRIPD_LISTEN: listen = tcp:0.0.0.0:1 is open", "allow_remote"],
    );
    refuse(
        folder.path(),
        &["--port", "sim", "--realtime", "hard"],
        &["--realtime or GRIPD_REALTIME: ", "`strict`"],
    );
    refuse(
        folder.path(),
        &["--port", "sim", "--log-level", "loud"],
        &["--log-level or GRIPD_LOG: ", "`debug`"],
    );
    refuse(
        folder.path(),
        &["--port", "sim", "--metrics", "9747"],
        &["--metrics or GRIPD_METRICS: ", "IP:PORT"],
    );
}

#[test]
fn models() {
    let folder = tempfile::tempdir().unwrap();
    let weight = "4.3647456";
    assert_eq!(
        MODEL.matches(weight).count(),
        1,
        "the model has been trained again: pick another weight"
    );
    let cases: [(String, &[&str]); 9] = [
        (
            MODEL.replace("\"version\": 1", "\"version\": 7"),
            &["version 7", "reads version 1", "gripctl train"],
        ),
        (MODEL.replace("mlp-model", "else"), &["no model file"]),
        (MODEL.replace(weight, "null"), &["line ", "column ", "null"]),
        (MODEL.replace(weight, "NaN"), &["line ", "column "]),
        (MODEL.replace(weight, "1e999"), &["line ", "column ", "number out of range"]),
        (MODEL.replace("trial_force_n", "temperature_k"), &["temperature_k", "slip_speed_m_s"]),
        (MODEL.replace("\"unit\": \"N\"", "\"unit\": \"kg\""), &["`kg`", "force in N"]),
        (MODEL.chars().take(700).collect(), &["line ", "column ", "EOF"]),
        (String::new(), &["EOF"]),
    ];
    for (text, words) in cases {
        fs::write(folder.path().join("m.json"), text).unwrap();
        let words: Vec<&str> = words.iter().copied().chain(["m.json"]).collect();
        refuse(folder.path(), &["--check-config", "--model", "m.json"], &words);
        refuse(folder.path(), &["--port", "sim", "--model", "m.json"], &words);
    }
    let check = ["--check-config", "--model", "gone.json"];
    refuse(folder.path(), &check, &["gone.json: the model cannot be read", "No such file"]);
}

#[test]
fn scenes() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &[&str]); 4] = [
        ("name = \"x\"\nmas_kg = 1.0\n", &["line 2, column 1", "`mas_kg`"]),
        ("mass_kg = 1.0\n", &["missing field `name`"]),
        ("name = \"x\"\nmass_kg = 0\n", &["s.toml:2:1: mass_kg = 0 is outside 0.005 to 20"]),
        ("name = \"x\"\n[noise]\nstylus_um = 1e9\n", &["s.toml:3:1: noise.stylus_um"]),
    ];
    for (text, words) in cases {
        fs::write(folder.path().join("s.toml"), text).unwrap();
        refuse(folder.path(), &["--port", "sim:s.toml"], words);
    }
}

#[test]
fn a_fleet_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let site = "[fleet]\nsite = \"hall\"\n";
    let cases: [(String, &[&str]); 2] = [
        (site.to_owned(), &[":2:1: fleet.site is set, but neither"]),
        ("[fleet]\nsite = \"a/b\"\n".to_owned(), &[":2:8: `a/b` is no name of a site"]),
    ];
    for (text, words) in cases {
        fs::write(folder.path().join("gripd.toml"), text).unwrap();
        refuse(folder.path(), &["--port", "sim", "--duration", "1"], words);
        refuse(folder.path(), &["--check-config"], words);
    }
}
