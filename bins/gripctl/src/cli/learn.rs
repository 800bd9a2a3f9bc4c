//! The part of the command line that is about networks and their data.

use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// Where to write the rows: .csv, or .npz with an array for each column.
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// Number of rows.
    #[arg(long, default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) rows: u32,
    /// Seed; the same seed gives the same rows.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Where the slips come from: `stretch`, what the pipeline sees of a slip, braking included; `trial`, one
    /// trial grasp each in closed form; `simulated`, the same played with the simulator.
    #[arg(long, default_value = "stretch")]
    pub(crate) source: String,
    /// Relative noise of speed and acceleration.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) speed_noise: f64,
    /// Relative noise of the force.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) force_noise: f64,
}

#[derive(Debug, Args)]
pub(crate) struct CollectArgs {
    /// Recordings (.mcap, or .csv and .npz as for replay) and folders of them; SITE/UID/NAME.mcap names the gripper, a folder object=NAME
    /// what was held.
    #[arg(required = true, value_name = "PLACE")]
    pub(crate) places: Vec<PathBuf>,
    /// Where to write the rows (.csv).
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// What was held in all of them, whatever they report.
    #[arg(long, value_name = "NAME")]
    pub(crate) object: Option<String>,
    /// An object must have stayed for this long after a slip (s), or its force is not known.
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) stay: f64,
    /// Leave out slips whose two forces are further apart than this ratio.
    #[arg(long, value_name = "RATIO", default_value_t = 2.0, allow_negative_numbers = true)]
    pub(crate) widest: f64,
    /// Leave out slips that did not show these features, for example mean_slope,esc_literal_w: their cells are empty otherwise.
    #[arg(long, value_delimiter = ',', value_name = "FEATURE")]
    pub(crate) require: Vec<String>,
    /// Write rows with about this share of the objects, or grippers, to OUTPUT-test.csv instead.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) test_share: Option<f64>,
    /// What stands in one of the two files only; with both, rows with one of them on the other side are left out.
    #[arg(long, value_enum, default_value = "object", requires = "test_share")]
    pub(crate) split: CollectSplit,
    /// Seed of the split.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) csv: super::CsvArgs,
    /// Configuration file for .csv recordings, as for gripd.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a split keeps apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum CollectSplit {
    /// Objects.
    Object,
    /// Grippers.
    Gripper,
    /// Objects and grippers.
    Both,
}

/// Which columns a learner sees.
#[derive(Clone, Debug, Args)]
pub(crate) struct ColumnArgs {
    /// Input columns; `name:ln` takes the logarithm, `name:reciprocal` the reciprocal.
    #[arg(long, value_delimiter = ',', required = true)]
    pub(crate) inputs: Vec<String>,
    /// Target columns; `name:ln` learns the logarithm, `name:reciprocal` the reciprocal.
    #[arg(long, value_delimiter = ',', required = true)]
    pub(crate) target: Vec<String>,
    /// The target is a class, the text in its one column: learn probabilities (softmax, cross-entropy) in place of a number.
    #[arg(long)]
    pub(crate) classify: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct TrainArgs {
    /// Training rows: .csv, or .npz with a 1-dimensional array for each column (`numpy.savez(FILE, a=..., f=...)`).
    pub(crate) data: PathBuf,
    #[command(flatten)]
    pub(crate) columns: ColumnArgs,
    /// What to train: mlp, one network; ensemble, several whose spread is an uncertainty; svr, a support vector regression; gp, a
    /// Gaussian process (up to 3000 rows); poly, a cubic, linear or mean. All but the first two leave the options of networks aside.
    #[arg(long, default_value = "mlp")]
    pub(crate) model: String,
    /// Choose by cross-validation on the training rows among mean, line, cubic, networks (br, scg, rprop) and a Gaussian process, of
    /// the target, its logarithm and its reciprocal, say why, and train that.
    #[arg(long, conflicts_with_all = ["model", "algorithm", "classify", "folds", "validation", "card"])]
    pub(crate) auto: bool,
    #[command(flatten)]
    pub(crate) beyond: BeyondArgs,
    /// Neurons of the hidden layers.
    #[arg(long, value_delimiter = ',', default_value = "10")]
    pub(crate) hidden: Vec<usize>,
    /// Function of the hidden neurons: tanh, logistic or relu.
    #[arg(long, default_value = "tanh")]
    pub(crate) activation: String,
    /// gd, gdm, gdx, rprop, scg, lbfgs, lm, or br: lm with the penalty on large weights that the rows themselves show (Bayesian
    /// regularisation), for few and noisy rows.
    #[arg(long, default_value = "rprop")]
    pub(crate) algorithm: String,
    #[command(flatten)]
    pub(crate) hyper: HyperArgs,
    /// Precision of the training: f32 or f64; the saved model is f32.
    #[arg(long, value_name = "PRECISION", default_value = "f64")]
    pub(crate) precision: String,
    /// What the training makes of the columns: min-max (-1 to 1) or z-score (mean 0, deviation 1), after any logarithm.
    #[arg(long, value_name = "SCALER", default_value = "min-max")]
    pub(crate) scaler: String,
    /// Penalty on large weights, in scaled units: decay / 2 times the sum of their squares is added to the error.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) decay: f64,
    /// Stop after this time (s); the best weights so far are kept.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) time_limit: Option<f64>,
    /// Most epochs.
    #[arg(long, default_value_t = 1000)]
    pub(crate) epochs: usize,
    /// Mean squared error, in scaled units, that is good enough.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) goal: f64,
    /// Trainings from different starts, of which one is kept.
    #[arg(long, default_value_t = 1)]
    pub(crate) repeats: usize,
    /// Which one: best, or nearest-average (the training error nearest the average of all).
    #[arg(long, value_name = "WHICH", default_value = "best")]
    pub(crate) choice: String,
    /// Seed of the first start.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Rows for the test error.
    #[arg(long, value_name = "FILE")]
    pub(crate) test: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) split: SplitArgs,
    /// State limits around each answer that hold this share of the truths, 0.9 for 90 %: each tenth of the rows is held out once and shows how far
    /// a model of the others misses it. With --split-by whole groups are held out, and it holds in the worst of a few.
    #[arg(
        long,
        value_name = "SHARE",
        allow_negative_numbers = true,
        conflicts_with = "time_limit"
    )]
    pub(crate) interval: Option<f64>,
    /// Where to write the model.
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// Where to write the model card: MODEL.card.json beside the model otherwise.
    #[arg(long, value_name = "FILE")]
    pub(crate) card: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Settings of training rules, the usual ones where none are given.
#[derive(Clone, Debug, Args)]
pub(crate) struct HyperArgs {
    /// Learning rate of gd, gdm and gdx, 0.01 otherwise.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) rate: Option<f64>,
    /// Momentum of gdm: averaged (as MATLAB's traingdm) or heavy-ball.
    #[arg(long, value_name = "FORM")]
    pub(crate) momentum: Option<String>,
    /// Share of the last step that gdm and gdx keep, 0.9 otherwise.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) momentum_share: Option<f64>,
    /// Variant of rprop: rprop-, rprop+, irprop- or irprop+.
    #[arg(long, value_name = "VARIANT", allow_hyphen_values = true)]
    pub(crate) rprop: Option<String>,
    /// First, growing, shrinking and longest step of rprop, 0.07,1.2,0.5,50 otherwise.
    #[arg(long, value_name = "FIRST,UP,DOWN,MOST", value_parser = four)]
    pub(crate) rprop_steps: Option<[f64; 4]>,
    /// Step of the probe for the curvature of scg, 5e-5 otherwise in f64.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) sigma: Option<f64>,
    /// First damping of scg, 5e-7 otherwise.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) lambda: Option<f64>,
    /// First damping of lm, 0.03 otherwise.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) mu: Option<f64>,
}

/// Four numbers with commas between.
fn four(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|cell| cell.trim().parse()).collect();
    let four = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    four.ok_or_else(|| "expected four numbers with commas between".to_owned())
}

/// Which rows are kept away from the training.
#[derive(Clone, Debug, Args)]
pub(crate) struct SplitArgs {
    /// Keep rows together that have the same text in this column (an object, a grasp, a session): with --holdout, --validation,
    /// --folds, --auto and --interval none of its groups stands on both sides.
    #[arg(long, value_name = "COLUMN")]
    pub(crate) split_by: Option<String>,
    /// Hold this share of the rows out and test on them.
    #[arg(long, value_name = "SHARE", conflicts_with = "test", allow_negative_numbers = true)]
    pub(crate) holdout: Option<f64>,
    /// Hold this share of the training rows out to stop by: the weights that are best on them are kept.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) validation: Option<f64>,
    /// Epochs without a better validation error before training stops.
    #[arg(long, value_name = "EPOCHS", default_value_t = 6, requires = "validation")]
    pub(crate) patience: usize,
    /// Cross-validate first: train K times on K-1 of K parts, test on the part left out. The model still comes from all training rows.
    #[arg(long, value_name = "K")]
    pub(crate) folds: Option<usize>,
    /// Seed of the splits.
    #[arg(long, default_value_t = 0)]
    pub(crate) split_seed: u64,
}

/// Options of ensembles and support vector regressions.
#[derive(Clone, Debug, Args)]
pub(crate) struct BeyondArgs {
    /// Networks of an ensemble.
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub(crate) members: usize,
    /// Each network of an ensemble sees as many rows drawn with replacement.
    #[arg(long)]
    pub(crate) bagging: bool,
    /// Price of errors of a support vector regression, in scaled units [default: the best of 1, 10 and 100 on a fifth of the rows].
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    pub(crate) svr_c: Option<f64>,
    /// Narrowness of its kernel [default: the best of 0.03, 0.1, 0.3, 1 and 3 on a fifth of the rows].
    #[arg(long, value_name = "GAMMA", allow_negative_numbers = true)]
    pub(crate) svr_gamma: Option<f64>,
    /// Error that costs it nothing, in scaled units.
    #[arg(long, value_name = "EPS", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(crate) svr_epsilon: f64,
}

#[derive(Debug, Args)]
pub(crate) struct SearchArgs {
    /// Rows to train and to validate on (.csv or .npz).
    pub(crate) data: PathBuf,
    #[command(flatten)]
    pub(crate) columns: ColumnArgs,
    /// Column of labels (an object, a grasp, a session); rows with the same one are never on both sides.
    #[arg(long, value_name = "COLUMN")]
    pub(crate) group: Option<String>,
    /// Share of the rows that judges the candidates.
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, allow_negative_numbers = true)]
    pub(crate) holdout: f64,
    /// Generations after the first population.
    #[arg(long, default_value_t = 12)]
    pub(crate) generations: usize,
    /// Networks in a population.
    #[arg(long, default_value_t = 24)]
    pub(crate) population: usize,
    /// Seed of the search, of the rows held out and of the first start.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Most epochs of a training.
    #[arg(long, default_value_t = 300)]
    pub(crate) epochs: usize,
    /// Starts of each candidate.
    #[arg(long, default_value_t = 3)]
    pub(crate) repeats: usize,
    /// Relative error that one more weight must earn.
    #[arg(long, value_name = "SHARE", default_value_t = 0.001, allow_negative_numbers = true)]
    pub(crate) size_cost: f64,
    /// Rows for the test error of the network found.
    #[arg(long, value_name = "FILE")]
    pub(crate) test: Option<PathBuf>,
    /// Train every other kind of learner on the same rows as well, and judge all on the test rows (needs --test).
    #[arg(long, requires = "test")]
    pub(crate) compare: bool,
    /// Where to write the model.
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct EstimateArgs {
    /// Built-in models and model files, two rows each.
    #[arg(default_values = ["default", "paper"])]
    pub(crate) model: Vec<PathBuf>,
    /// Objects of each row.
    #[arg(long, default_value_t = 5000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) rows: u32,
    /// Seed of the objects; not 1, with which the built-in models were trained.
    #[arg(long, default_value_t = 77)]
    pub(crate) seed: u64,
    /// Relative noise of speed and acceleration.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) speed_noise: f64,
    /// Relative noise of the force.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) force_noise: f64,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    /// A model file, or a built-in model: default or paper.
    pub(crate) model: PathBuf,
    /// The rows (.csv or .npz).
    pub(crate) data: PathBuf,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// A model file, or a built-in model: default or paper.
    pub(crate) model: PathBuf,
    /// What to write.
    #[arg(long, value_enum)]
    pub(crate) format: ExportFormat,
    /// Where to write, a file or a folder: beside the model otherwise. C gets a source and a header of this name.
    #[arg(short, long, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,
    /// How the names of the C code begin; made from the file name otherwise.
    #[arg(long)]
    pub(crate) prefix: Option<String>,
    /// Compile the C code with `cc` (or CC) and compare its answers with this program's before anything is written.
    #[arg(long)]
    pub(crate) verify: bool,
    /// Where to write the model card: PATH.card.json beside the export otherwise.
    #[arg(long, value_name = "FILE")]
    pub(crate) card: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a model is exported as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ExportFormat {
    /// C99 header and source in single precision, without heap.
    C,
    /// ONNX, operator set 17.
    Onnx,
}

impl ExportFormat {
    pub(crate) fn kind(self) -> &'static str {
        match self {
            Self::C => "c99",
            Self::Onnx => "onnx",
        }
    }

    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Onnx => "onnx",
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// Folder for report.html (one page), study.json (every number), figures/*.png (the paper's Fig. 7 is fig-7-paper.png)
    /// and rows/*.npz (what the figures were trained and tested on).
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// A look in seconds instead of the whole: seven conditions, three starts, one draw of rows, 300 epochs.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Hold each claim of the source study against 20 draws of rows instead, and print the table.
    #[arg(long, conflicts_with = "quick")]
    pub(crate) claims: bool,
    /// Independent draws of rows, 2 by default and 20 with --claims; more take longer and show how far means differ.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) draws: Option<u8>,
    /// Starts of each net, 20 by default; the run nearest the average is kept.
    #[arg(long, value_name = "N")]
    pub(crate) repeats: Option<usize>,
    /// Most epochs of a training, 1000 by default.
    #[arg(long, value_name = "N")]
    pub(crate) epochs: Option<usize>,
    /// Training error in scaled units at which a training stops, 0 by default: none does.
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) goal: Option<f64>,
    /// Hidden neurons, 10 by default.
    #[arg(long, value_name = "N")]
    pub(crate) hidden: Option<usize>,
    #[command(flatten)]
    pub(crate) hyper: HyperArgs,
    /// Seed of rows and starts; the same seed gives the same study on any number of threads.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}
