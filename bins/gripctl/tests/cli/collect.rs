//! `gripctl collect` on grasps of the simulator, whose truth is known; and `train` and `eval` on what it writes.

use crate::run::{gripctl, number, put, read};
use grip_eval::trial;
use grip_record::{
    ChannelSet, CsvWriter, StylusKind,
    mcap::{Attached, McapWriter, Record, SampleRecord},
};
use grip_session::{
    HostConfig, Update, model,
    recording::{ABOUT, CONFIG_NAME, OBJECT, pipeline_record},
};
use grip_sim::{Scene, scene};
use slip_core::{Sample, estimate::KAPPA, units::Micros};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, File},
    path::Path,
};

/// What a recording of one grasp shows of itself.
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
        let mut report = |updates: Update<'_>| match updates {
            Update::Began(beginning) => {
                let record = pipeline_record(beginning, &mut json).unwrap();
                writer.write(0, &Record::Pipeline(record)).unwrap();
            }
            Update::Step { index, sample, taxels, .. } => {
                samples.push(*sample);
                let record = SampleRecord { index, sample: *sample, taxels };
                writer.write(sample.t.0, &Record::Sample(record)).unwrap();
            }
            Update::Gripper { .. } | Update::Link(_) | Update::Event(_) => {}
        };
        let estimator = model::default_estimator().unwrap();
        let duration = Micros(4_000_000);
        let outcome = trial::grasp(&scene, &config, estimator, duration, &mut report).unwrap();
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

const TRAIN: &str = "train train.csv --inputs slip_acceleration_m_s2,trial_force_n --target adequate_force_n:ln --test train-test.csv -o m.json";

#[test]
fn recordings_of_many_grippers_become_rows_whose_target_is_near_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let truth = fleet(here, 24);
    let collect = "collect . -o train.csv --test-share 0.25 --json";
    let reported = gripctl(here, collect).last();
    assert_eq!(
        (&reported["recordings"], &reported["lossy"]),
        (&96.into(), &0.into()),
        "{reported}"
    );
    let (train, test) =
        (Rows::read(&here.join("train.csv")), Rows::read(&here.join("train-test.csv")));
    let (rows, tested) = (train.0.len(), test.0.len());
    assert_eq!(reported["kept"], rows + tested, "{reported}");
    let left_out = reported["left_out"].as_object().unwrap().values();
    let left_out: u64 = left_out.map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(reported["slips"].as_u64().unwrap(), left_out + reported["kept"].as_u64().unwrap());
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
        "{} rows: target over truth: median {:.3}, error median {:.1} %, worst {:.1} %, bounds hold for {within}; {reported}",
        label.len(),
        median(label.iter().copied()),
        100.0 * error,
        100.0 * worst
    );

    assert_eq!(within, label.len(), "bounds: {low:?} {high:?}");
    assert!(label.len() >= 20 && error < 0.1 && worst < 0.25, "{label:?}");

    gripctl(here, format!("{TRAIN} --hidden 2 --repeats 4")).done();
    test.with_truth(&here.join("truth.csv"), &truth);
    let eval = |model: &str| gripctl(here, format!("eval {model} truth.csv --json")).last();
    let (trained, built_in) = (eval("m.json"), eval("default"));
    eprintln!("trained: {trained}; built in: {built_in}");
    assert!(number(&trained, "within_10pct") >= 0.5, "{trained}");
}

#[test]
fn csv_recordings_and_folders_of_objects_do_as_well_and_the_same_rows_come_again() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let grasp = Grasp { scene: "heavy_smooth", seed: 0, gripper: 9 };
    let uid = grasp.uid();
    let jar = here.join(format!("yard/{uid}/object=jar"));
    fs::create_dir_all(&jar).unwrap();
    let (samples, needed_n) = grasp.record(&here.join("run.mcap"));
    let out = File::create(jar.join("run.csv")).unwrap();
    let mut writer = CsvWriter::new(out, &ChannelSet::all(StylusKind::Displacement)).unwrap();
    samples.iter().for_each(|sample| writer.write(sample).unwrap());
    writer.finish().unwrap();
    put(here, "gripd.toml", "[link]\nsample_rate_hz = 2000\n");
    let run = |output: &str| {
        let args = &format!("collect . -o {output} --config gripd.toml");
        let ran = gripctl(here, args).done();
        assert!(ran.out.contains("slips in 2 recordings"), "{}", ran.out);
        read(here, output)
    };
    let first = run("train.csv");
    // Its own file is no recording.
    assert_eq!(run("train.csv"), first);
    let rows = Rows::read(&here.join("train.csv"));
    assert_eq!(rows.names("object"), BTreeSet::from(["heavy_smooth-0", "jar"]));
    assert_eq!(rows.names("site"), BTreeSet::from(["hall", "yard"]));
    assert_eq!(rows.names("gripper"), BTreeSet::from([uid.as_str()]));
    let force = |row: &BTreeMap<String, String>| row["adequate_force_n"].clone();
    assert_eq!(force(&rows.0[0]), force(&rows.0[1]), "the same samples, the same target");
    let ratio = force(&rows.0[0]).parse::<f64>().unwrap() / f64::from(KAPPA) / needed_n;
    assert!((0.85..1.2).contains(&ratio), "{ratio}");

    let one = "collect run.mcap -o one.csv --test-share 0.5";
    gripctl(here, one).refused(2, &["--split object: objects: 1 groups of rows"]);
    let named = "collect run.mcap -o one.csv --object brick";
    gripctl(here, named).done();
    assert_eq!(Rows::read(&here.join("one.csv")).names("object"), BTreeSet::from(["brick"]));
    fs::copy(jar.join("run.csv"), here.join("loose.csv")).unwrap();
    let loose = "run.mcap loose.csv -o two.csv --config gripd.toml";
    let ran = gripctl(here, format!("collect --test-share 0.5 {loose}")).done();
    assert!(ran.err.contains("rows whose object is not known stand on one side"), "{ran:?}");
    let wide = "collect run.mcap -o none.csv --widest 1.01";
    gripctl(here, wide)
        .refused(1, &["nothing to train on: 3 slips in 1 recordings", "too far apart"]);
    assert!(!here.join("none.csv").exists());
    let cut = fs::read(here.join("run.mcap")).unwrap();
    put(here, "cut.mcap", &cut[..cut.len() - 40_000]);
    put(here, "bad.mcap", "no recording");
    let ran = gripctl(here, "collect . -o train.csv --config gripd.toml");
    assert_eq!(ran.code, 3, "{ran:?}");
    assert!(
        ran.err.contains("cut.mcap: ends at byte") && ran.err.contains("bad.mcap: is no MCAP file"),
        "{ran:?}"
    );
}
