//! `gripctl export`: C that compiles and agrees, ONNX, model cards, and what is refused.

use crate::run::{gripctl, number, put, read};
use std::{fs, path::Path, process::Command};

const MODEL: &str = include_str!("../../../../crates/grip-session/models/default.json");

/// Four inputs (a logarithm, a reciprocal, a constant), two hidden layers of all other functions, a target of each transform.
const OTHER: &str = r#"{
  "format": "mlp-model", "version": 1,
  "inputs": [
    { "name": "v*/ m", "unit": "m/s", "transform": "identity", "min": -0.5, "max": 2.0 },
    { "name": "f_n", "unit": "N", "transform": "ln", "min": 0.1, "max": 40.0 },
    { "name": "f_n", "unit": "µm", "transform": "identity", "min": 3.0, "max": 3.0 },
    { "name": "g", "unit": "", "transform": "reciprocal", "min": 0.2, "max": 30.0 }
  ],
  "targets": [
    { "name": "a", "unit": "N", "transform": "identity", "min": -3.0, "max": 9.0 },
    { "name": "b", "unit": "N", "transform": "ln", "min": 1.0, "max": 1e4 },
    { "name": "c", "unit": "N", "transform": "reciprocal", "min": 0.5, "max": 40.0, "noise": 0.1 }
  ],
  "layers": [
    { "activation": "relu", "weights": [[1.0, -0.5, 2.0, 0.2], [-1.25, 0.75, 0.1, -0.3], [0.3, 0.2, 0.4, 0.1]], "biases": [0.1, -0.2, 1e-45] },
    { "activation": "logistic", "weights": [[1.5, -0.5, -2.0], [-0.25, 3.75, -0.1]], "biases": [-0.0, 0.2] },
    { "activation": "tanh", "weights": [[1.0, -1.5], [0.5, 0.25], [0.9, 0.8]], "biases": [0.1, 0.0, 0.2] }
  ],
  "training": null
}"#;

/// A compiler without a C library: `bare/math.h` declares what a logarithmic model needs of one.
const BARE: [&str; 4] = ["-ffreestanding", "-Ibare", "-Wdouble-promotion", "-O2"];

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "force.json", MODEL);
    put(&folder, "2-other.json", OTHER);
    fs::create_dir(folder.path().join("bare")).unwrap();
    let math = "float logf(float x);\nfloat expf(float x);\n";
    put(&folder, "bare/math.h", math);
    folder
}

/// Compiles `file` with `compiler` in `folder`; false when there is no such compiler.
fn compiles(folder: &Path, compiler: &str, options: &[&str], file: &str) -> bool {
    if Command::new(compiler).arg("--version").output().is_err() {
        eprintln!("left out: no {compiler}");
        return false;
    }
    let strict =
        ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wshadow"];
    let args = [&strict[..], options, &["-c", file, "-o", "out.o"]].concat();
    let done = Command::new(compiler).current_dir(folder).args(args).output().unwrap();
    assert!(done.status.success(), "{compiler}: {}", String::from_utf8_lossy(&done.stderr));
    true
}

#[test]
fn c_code_agrees_with_the_model_and_compiles_everywhere() {
    let folder = folder();
    for (model, source) in [("force.json", "force.c"), ("2-other.json", "2-other.c")] {
        let args = &format!("export {model} --format c --verify --json");
        let result = gripctl(&folder, args).last();
        let verified = &result["verified"];
        assert!(number(verified, "inputs") > 25_000.0, "{result}");
        let (found, bound) = (number(verified, "largest_difference"), number(verified, "bound"));
        assert!(found <= bound && bound < 1e-2, "{result}");
        assert!(compiles(folder.path(), "cc", &["-Os"], source), "the tests need a C compiler");
        let m4 =
            [&["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"][..], &BARE];
        let m4 = m4.concat();
        compiles(folder.path(), "arm-none-eabi-gcc", &m4, source);
        let text = read(&folder, source);
        assert!(!text.contains("alloc"), "{text}");
    }
    let header = read(&folder, "force.h");
    for part in
        ["force_predict", "FORCE_INPUTS 2", "FORCE_IN_TRIAL_FORCE_N = 1", "m/s^2", "0.017626667"]
    {
        assert!(header.contains(part), "no {part} in {header}");
    }
    let header = read(&folder, "2-other.h");
    assert!(
        header.contains("M_2_OTHER_IN_F_N_2 = 2") && header.contains("m_2_other_predict"),
        "{header}"
    );
}

#[test]
fn a_card_goes_with_the_model_and_its_exports() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let card = |name: &str| -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(path(name)).unwrap()).unwrap()
    };
    for (name, seed) in [("rows.csv", "1"), ("test.csv", "2")] {
        gripctl(&folder, format!("generate -o {name} --rows 80 --seed {seed}")).done();
    }
    let columns = "--inputs slip_acceleration_m_s2,trial_force_n:ln --target adequate_force_n:ln";
    let args = "train rows.csv --test test.csv --epochs 20 --hidden 4 --seed 3 --json -o m.json";
    let result = gripctl(&folder, format!("{args} {columns}")).last();
    let trained = card("m.card.json");
    assert_eq!(trained["program"], concat!("gripctl ", env!("CARGO_PKG_VERSION")));
    assert_eq!(
        (&trained["data"]["train"]["rows"], &trained["data"]["test"]["rows"]),
        (&80.into(), &80.into())
    );
    assert_eq!(trained["training"]["seed"], 3, "{trained}");
    assert_eq!(trained["metrics"]["test"]["mse"], result["test_mse"]);
    assert_eq!(trained["metrics"]["train"]["within_10pct"], result["train_within_10pct"]);
    let model: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(path("m.json")).unwrap()).unwrap();
    assert_eq!(trained["data"]["train"]["sha256"], model["training"]["data_sha256"]);
    assert_eq!(trained["inputs"], model["inputs"]);

    gripctl(&folder, "export m.json --format onnx -o net.onnx").done();
    let args = "export m.json --format c --verify --prefix grip";
    let out = gripctl(&folder, args).done().out;
    assert!(
        out.contains("verified") && out.contains("m.c and m.h written, card in m.card.json"),
        "{out}"
    );
    let exported = card("m.card.json");
    assert_eq!((&exported["data"], &exported["metrics"]), (&trained["data"], &trained["metrics"]));
    assert_eq!(exported["exports"][0]["kind"], "c99");
    assert_eq!(card("net.card.json")["exports"][0]["files"][0]["file"], "net.onnx");
    // Of a model that came without its card, only what its file states.
    gripctl(&folder, "export force.json --format onnx --card c.json").done();
    let bare = card("c.json");
    assert!(bare["data"]["test"].is_null() && bare["training"]["precision"].is_null(), "{bare}");
    assert_eq!(bare["data"]["train"]["rows"], 4000);
}

#[test]
fn code_that_no_compiler_takes_is_not_verified() {
    let folder = folder();
    for (compiler, words) in
        [("no-such-cc", "`no-such-cc` cannot be run"), ("false", "refused the C code")]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gripctl"));
        let args = "export force.json --format c --verify";
        let run = command
            .current_dir(folder.path())
            .args(args.split(' '))
            .env("CC", compiler)
            .output()
            .unwrap();
        let stated = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.code() == Some(1) && stated.contains(words), "{stated}");
    }
    let files = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 3, "only the models and a folder are there");
    assert_eq!(read(&folder, "force.json"), MODEL);
}
