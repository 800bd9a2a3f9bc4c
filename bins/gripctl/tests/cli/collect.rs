//! `gripctl collect` on grasps of the simulator, whose truth is known; and `train` and `eval` on what it writes.

use crate::run::{gripctl, number};
use grip_host::{
    HostConfig, News, model,
    recording::{ABOUT, CONFIG_NAME, OBJECT, pipeline_record},
    trial,
};
use grip_record::{
    ChannelSet, CsvWriter, StylusKind,
    mcap::{Attached, McapWriter, Record, SampleRecord},
};
use grip_sim::{Scene, scene};
use serde_json::Value;
use slip_core::{Sample, estimate::KAPPA, units::Micros};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, File},
    path::Path,
};

/// What a recording of one grasp says of itself.
struct Grasp<'a> {
    scene: &'a str,
    seed: u64,
    gripper: u8,
}

impl Grasp<'_> {
    fn object(&self) -> String {
        format!("{}-{}", self.scene, self.seed)
    }

    fn uid(&self) -> String {
        format!("{:02x}", self.gripper).repeat(16)
    }

    /// Grasps, records as the daemon does, and gives the samples and the force (N) that was needed at the end.
    fn record(&self, file: &Path) -> (Vec<Sample>, f64) {
        let mut config = scene::load(self.scene).unwrap().config().clone();
        config.seed = self.seed;
        let scene = Scene::new(config).unwrap();
        let mut config = HostConfig::default();
        config.link.sample_rate_hz = 2000;
        let mut writer = McapWriter::new(File::create(file).unwrap(), "test 1", 1 << 60).unwrap();
        let of = |pairs: &[(&str, String)]| -> BTreeMap<String, String> {
            pairs.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
        };
        writer.metadata(ABOUT, &of(&[(OBJECT, self.object())])).unwrap();
        writer.metadata("gripper", &of(&[("uid", self.uid())])).unwrap();
        let (name, data) = (CONFIG_NAME.to_owned(), b"[fleet]\nsite = \"hall\"\n".to_vec());
        let media_type = "application/toml".to_owned();
        writer.attach(0, &Attached { name, media_type, data }).unwrap();
        let (mut samples, mut json) = (Vec::new(), Vec::new());
        let mut tell = |news: News<'_>| match news {
            News::Began(beginning) => {
                let record = pipeline_record(beginning, &mut json).unwrap();
                writer.write(0, &Record::Pipeline(record)).unwrap();
            }
            News::Step { index, sample, taxels, .. } => {
                samples.push(*sample);
                let record = SampleRecord { index, sample: *sample, taxels };
                writer.write(sample.t.0, &Record::Sample(record)).unwrap();
            }
            News::Gripper { .. } | News::Link(_) | News::Event(_) => {}
        };
        let estimator = model::default_estimator().unwrap();
        let duration = Micros(4_000_000);
        let outcome = trial::grasp(&scene, &config, estimator, duration, &mut tell).unwrap();
        assert!(outcome.held(), "{} {outcome:?}", self.object());
        writer.finish().unwrap();
        (samples, outcome.truth.needed_now_n)
    }
}

/// Grasps of four scenes in three grippers; the adequate force (N) of each object.
fn fleet(folder: &Path, seeds: u64) -> BTreeMap<String, f64> {
    let mut truth = BTreeMap::new();
    for scene in ["default", "heavy_smooth", "light_rough", "glass_bottle_full"] {
        for seed in 0..seeds {
            let gripper = u8::try_from(1 + seed % 3).unwrap();
            let grasp = Grasp { scene, seed, gripper };
            let folder = folder.join(grasp.uid());
            fs::create_dir_all(&folder).unwrap();
            let (_, needed_n) = grasp.record(&folder.join(format!("{}.mcap", grasp.object())));
            truth.insert(grasp.object(), f64::from(KAPPA) * needed_n);
        }
    }
    truth
}

/// A file of rows: names and cells.
struct Rows(Vec<BTreeMap<String, String>>);

impl Rows {
    fn read(file: &Path) -> Self {
        let text = fs::read_to_string(file).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
        let names: Vec<String> = lines.next().unwrap().collect();
        Self(lines.map(|cells| names.iter().cloned().zip(cells).collect()).collect())
    }

    fn names(&self, column: &str) -> BTreeSet<&str> {
        self.0.iter().map(|row| row[column].as_str()).collect()
    }

    /// Of each row the cell over the truth.
    fn over(&self, column: &str, truth: &BTreeMap<String, f64>) -> Vec<f64> {
        let ratio = |row: &BTreeMap<String, String>| {
            row[column].parse::<f64>().unwrap() / truth[&row["object"]]
        };
        self.0.iter().map(ratio).collect()
    }

    /// The same rows with the truth as their target.
    fn with_truth(&self, file: &Path, truth: &BTreeMap<String, f64>) {
        let inputs = ["slip_acceleration_m_s2", "trial_force_n"];
        let mut text = format!("{},adequate_force_n\n", inputs.join(","));
        for row in &self.0 {
            let cells = inputs.map(|name| row[name].clone()).join(",");
            text += &format!("{cells},{}\n", truth[&row["object"]]);
        }
        fs::write(file, text).unwrap();
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

const TRAIN: [&str; 10] = [
    "train",
    "train.csv",
    "--inputs",
    "slip_acceleration_m_s2,trial_force_n",
    "--target",
    "adequate_force_n:ln",
    "--test",
    "train-test.csv",
    "-o",
    "m.json",
];

#[test]
fn recordings_of_many_grippers_become_rows_whose_target_is_near_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let truth = fleet(here, 12);
    let collect = ["collect", ".", "-o", "train.csv", "--test-share", "0.25", "--json"];
    let told = gripctl(here, &collect).done().json().pop().unwrap();
    assert_eq!((&told["recordings"], &told["lossy"]), (&48.into(), &0.into()), "{told}");
    let (train, test) =
        (Rows::read(&here.join("train.csv")), Rows::read(&here.join("train-test.csv")));
    let (rows, tested) = (train.0.len(), test.0.len());
    assert_eq!(told["kept"], rows + tested, "{told}");
    let left_out = told["left_out"].as_object().unwrap().values();
    let left_out: u64 = left_out.map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(told["slips"].as_u64().unwrap(), left_out + told["kept"].as_u64().unwrap());
    assert!(train.names("object").is_disjoint(&test.names("object")));
    assert_eq!(train.names("site"), BTreeSet::from(["hall"]));
    assert!(train.names("gripper").contains("02".repeat(16).as_str()));

    let all = Rows([train.0.clone(), test.0.clone()].concat());
    let label = all.over("adequate_force_n", &truth);
    let (low, high) = (all.over("adequate_low_n", &truth), all.over("adequate_high_n", &truth));
    let within = low.iter().zip(&high).filter(|(low, high)| **low <= 1.0 && **high >= 1.0).count();
    let error = median(label.iter().map(|ratio| (ratio - 1.0).abs()));
    let worst = label.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
    eprintln!(
        "{} rows: target over truth: median {:.3}, error median {:.1} %, worst {:.1} %, bounds hold for {within}; {told}",
        label.len(),
        median(label.iter().copied()),
        100.0 * error,
        100.0 * worst
    );

    gripctl(here, &[&TRAIN[..], &["--hidden", "2", "--repeats", "4"]].concat()).done();
    test.with_truth(&here.join("truth.csv"), &truth);
    let judged = gripctl(here, &["eval", "m.json", "truth.csv", "--json"]).done().json().pop();
    eprintln!("{}", judged.unwrap());
    let built_in = gripctl(here, &["eval", "default", "truth.csv", "--json"]).done().json().pop();
    eprintln!("{}", built_in.unwrap());
}
