//! The command line of gripctl. The names are a contract.

use clap::{ArgGroup, Args, Parser, Subcommand};
use std::path::PathBuf;

/// Simulate, replay, score and train.
///
/// Exit codes: 0 done, 1 failed, 2 wrong arguments or configuration, 3 done with loss of data.
#[derive(Debug, Parser)]
#[command(name = "gripctl", version, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the serial ports of this computer.
    Ports(PortsArgs),
    /// Say what keeps a gripper from working well, and the command that mends it.
    Doctor(DoctorArgs),
    /// Ask a running gripd how it does: link, rate, losses, latency, grip, events.
    Status(StatusArgs),
    /// Run a virtual gripper on a pseudo-terminal.
    Sim(SimArgs),
    /// Run a recording through the pipeline: events and estimates.
    Replay(ReplayArgs),
    /// Make a whole recording of one that was cut off or damaged.
    Recover(RecoverArgs),
    /// Write the samples of a recording as CSV, bit by bit the same.
    Csv(CsvExportArgs),
    /// Measure noise floor, motion gate and thresholds on a recording without slip, or at a gripper.
    Calibrate(CalibrateArgs),
    /// Score a folder of labelled recordings: latency, misses, false alarms.
    Score(ScoreArgs),
    /// Measure a height profile: irregularities, roughness, every reading of E_sc.
    Profile(ProfileArgs),
    /// Compute every reading of E_sc for a list of irregularities.
    Esc(EscArgs),
    /// Let the controller hold many simulated objects: dropped, crushed, slipped.
    Grasp(GraspArgs),
    /// Generate training data for the force estimate.
    Generate(GenerateArgs),
    /// Train a network, an ensemble or a support vector regression on a CSV file.
    Train(Box<TrainArgs>),
    /// Search for the shape, activation and training of a network with a genetic algorithm.
    Search(SearchArgs),
    /// Evaluate a model file on a CSV file.
    Eval(EvalArgs),
    /// Write a model file as C99 source or as an ONNX graph.
    Export(ExportArgs),
    /// Repeat the study of the four nets on simulated grasps and explain it: tables, curves, report.
    Study(StudyArgs),
}

#[derive(Debug, Args)]
pub(crate) struct PortsArgs {
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Looks at the configuration, this computer, its disk and the port; where nobody holds the port, attaches to the gripper for some
/// seconds without commanding any force, and measures. Exit codes: 0 no fault, 1 a fault, 2 wrong arguments.
#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// The gripper: a serial device, `auto`, or `sim` with an optional `:SCENE`; that of the configuration otherwise, or the only USB
    /// serial port.
    pub(crate) port: Option<String>,
    /// Bits per second of the serial line; USB devices ignore it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) baud: Option<u32>,
    /// Configuration file, instead of the one that gripd would find.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Folder of recordings, whose space and speed are measured: /var/lib/gripd if there is one, or the current one.
    #[arg(long, value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
    /// How long to listen to the gripper (s).
    #[arg(long, value_name = "S", default_value_t = 3.0, allow_negative_numbers = true)]
    pub(crate) seconds: f64,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct StatusArgs {
    /// Where gripd listens: `tcp:ADDRESS:PORT` or `unix:PATH`.
    #[arg(default_value = grip_daemon::clients::Listen::DEFAULT)]
    pub(crate) address: grip_daemon::clients::Listen,
    /// Ask again every second until it is stopped.
    #[arg(long, conflicts_with = "events")]
    pub(crate) watch: bool,
    /// Show slips and news as they come, until it is stopped.
    #[arg(long)]
    pub(crate) events: bool,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SimArgs {
    /// Name of a built-in scene, or a scene file.
    #[arg(long, default_value = "default")]
    pub(crate) scene: String,
    /// Path that will lead to the pseudo-terminal, as a symbolic link.
    #[arg(long)]
    pub(crate) pty: PathBuf,
    /// Seed of the scene, instead of its own.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Stop after this time (s).
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
}

/// How the columns of a CSV file are read.
#[derive(Debug, Args)]
pub(crate) struct CsvArgs {
    /// Samples per second, for a file without `t_s`.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub(crate) rate: Option<f32>,
    /// Read the column NAME as another one, for example `stylus=height_m`; may be repeated.
    #[arg(long, value_name = "OURS=NAME")]
    pub(crate) map: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The recording: .mcap as gripd makes it, which has its settings and its model inside, or .csv with `t_s` and `stylus` (m) or
    /// `vibration` (sensor units, signed or rectified). Of a recording in several files all .mcap in their order.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Compare the events with the recorded ones instead of printing them; exit 1 at the first difference. For .mcap.
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
    /// Calibration file: floor, gate and thresholds.
    #[arg(long, value_name = "FILE")]
    pub(crate) calibration: Option<PathBuf>,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// Model file instead of the embedded network.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Show this reading of E_sc beside the literal one: literal, arc_cot, slope_power, lift_work or viscous_work.
    #[arg(long, value_name = "NAME", value_parser = grip_host::config::esc_reading)]
    pub(crate) esc: Option<slip_core::esc::Reading>,
    /// Do not run the force controller, even where the recording has a normal force.
    #[arg(long)]
    pub(crate) observe: bool,
    /// Run every stage in every scene; the events are the same.
    #[arg(long)]
    pub(crate) no_skip: bool,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The recording (.mcap). A whole one is left as it is.
    pub(crate) file: PathBuf,
    /// Where to write what is saved. Otherwise it takes the place of a file that only lacks its end; of a file with damage in the
    /// middle it is written beside it, as NAME.recovered.mcap.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CsvExportArgs {
    /// The recording (.mcap); of one in several files all, in their order.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Where to write the samples (.csv).
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// Which pipeline, counted from 1, where the recording has several: times start again with each.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) pipeline: Option<u64>,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("source").required(true).args(["file", "port"])))]
pub(crate) struct CalibrateArgs {
    /// A recording (.csv) of the gripper at rest or holding something that does not slip; with the robot moving for a part of it, where
    /// there is a reference. `gripd --dry-run --record FILE` makes one.
    pub(crate) file: Option<PathBuf>,
    /// Measure at a gripper instead: a serial device, `auto`, or `sim` with an optional `:SCENE`. Nothing is commanded.
    #[arg(long, value_name = "PORT")]
    pub(crate) port: Option<String>,
    /// Bits per second of the serial line; USB devices ignore it.
    #[arg(long, value_name = "N", requires = "port", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) baud: Option<u32>,
    /// Seed of the simulated scene.
    #[arg(long, value_name = "N", requires = "port")]
    pub(crate) seed: Option<u64>,
    /// Rest to measure at the gripper (s); the longer, the surer.
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) rest_s: f64,
    /// Motion to measure after it (s): the robot moves as in work, without slip. On a terminal gripctl asks for it.
    #[arg(long, value_name = "S", requires = "port", allow_negative_numbers = true)]
    pub(crate) motion_s: Option<f64>,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
    /// Wanted mean time between false alarms (s).
    #[arg(long, default_value_t = 600.0, allow_negative_numbers = true)]
    pub(crate) interval: f64,
    /// Where to write the calibration (.toml).
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Folder with labels.csv (recording,kind,material,onset_s) and the recordings.
    pub(crate) directory: PathBuf,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
    /// An alarm may come this much before the labelled onset; earlier is a false alarm (ms).
    #[arg(long, default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) guard_ms: f64,
    /// Calibration file, instead of the floor of the folder's labelled rest and the shipped thresholds.
    #[arg(long, value_name = "FILE")]
    pub(crate) calibration: Option<PathBuf>,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// Detectors to put side by side: default, stylus (alone, with its tests fused), energy, cusum, glrt (one test alone),
    /// travel, pressure, fused. The last three also read what lies beside a recording: NAME_pose.csv as its travel,
    /// NAME_taxels.csv or NAME_electrodes.csv as its taxel array.
    #[arg(long, value_delimiter = ',', default_value = "default")]
    pub(crate) detectors: Vec<String>,
    /// A row for each material too.
    #[arg(long)]
    pub(crate) materials: bool,
    /// Write misses and latency against false alarms over a range of thresholds to FILE: .json, or a chart as .svg or .png;
    /// may be repeated.
    #[arg(long, value_name = "FILE")]
    pub(crate) curve: Vec<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ProfileArgs {
    /// The profile (.csv): `x_mm`, rising by equal steps, and `height_um`.
    pub(crate) file: PathBuf,
    /// Slip speed (m/s).
    #[arg(long, value_name = "M_S", allow_negative_numbers = true)]
    pub(crate) speed: f64,
    /// Trial force (N); E_sc is proportional to it, so 1 gives it per newton.
    #[arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) force: f64,
    /// Cutoff wavelength lambda_c (mm): longer waves are shape, not roughness.
    #[arg(long, value_name = "MM", default_value_t = 2.5, allow_negative_numbers = true)]
    pub(crate) cutoff_mm: f64,
    /// Cutoff wavelength lambda_s (um): shorter waves are noise; 0 for none. A hundredth of lambda_c otherwise.
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pub(crate) lambda_s_um: Option<f64>,
    /// Low-pass before peaks and valleys are looked for (um); 0 for none. A thirtieth of lambda_c otherwise.
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pub(crate) low_pass_um: Option<f64>,
    /// Peaks and valleys must differ by more than this (um). Otherwise 5 to 15 % of Rz, above the noise, where none is in doubt.
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pub(crate) hysteresis_um: Option<f64>,
    /// Weights of the filters: three moving averages, as many instruments have, or the Gaussian of ISO 16610-21.
    #[arg(long, value_enum, default_value = "moving-average")]
    pub(crate) filter: Filter,
    /// Take the least-squares line away first: for a tilted profile, whose ends are wrong otherwise.
    #[arg(long)]
    pub(crate) level: bool,
    /// Distance between two heights (um), where `x_mm` is absent or wrong.
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pub(crate) step_um: Option<f64>,
    /// Relative noise of each delta/s, for `sigma_s` and its flag.
    #[arg(long, value_name = "EPS", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(crate) noise: f64,
    /// Compare with the roughness profile of an instrument (.csv, `height_um`, as many rows).
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,
    /// Draw the roughness profile with its peaks and valleys (.svg or .png).
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Weights of the profile filters.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum Filter {
    /// Three moving averages in a row.
    MovingAverage,
    /// The Gaussian of ISO 16610-21.
    Gaussian,
}

#[derive(Debug, Args)]
pub(crate) struct EscArgs {
    /// The irregularities (.csv): `delta_m` (height) and `s_m` (spacing).
    pub(crate) file: PathBuf,
    /// Trial force (N).
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) force: f64,
    /// Slip speed (m/s).
    #[arg(long, value_name = "M_S", allow_negative_numbers = true)]
    pub(crate) speed: f64,
    /// Relative noise of each delta/s, for `sigma_s` and its flag.
    #[arg(long, value_name = "EPS", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(crate) noise: f64,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct GraspArgs {
    /// Scenes: built-in names or files; all files of --scenes otherwise, or the default scene.
    pub(crate) scene: Vec<String>,
    /// Folder of scene files.
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: Option<PathBuf>,
    /// Grasps per scene, with seeds counting up.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) trials: u64,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Length of a grasp (s).
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub(crate) duration: f64,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// Model file instead of the embedded network.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Print every grasp, not only the totals.
    #[arg(long)]
    pub(crate) each: bool,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// Where to write the rows (.csv).
    #[arg(short, long)]
    pub(crate) output: PathBuf,
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

/// Which columns a learner sees.
#[derive(Debug, Args)]
pub(crate) struct ColumnArgs {
    /// Input columns; `name:ln` takes the logarithm.
    #[arg(long, value_delimiter = ',', required = true)]
    pub(crate) inputs: Vec<String>,
    /// Target columns; `name:ln` takes the logarithm.
    #[arg(long, value_delimiter = ',', required = true)]
    pub(crate) target: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// Training rows.
    pub(crate) data: PathBuf,
    #[command(flatten)]
    pub(crate) columns: ColumnArgs,
    /// What to train: mlp, one network; ensemble, several whose spread is an uncertainty; svr, a support
    /// vector regression, which leaves the options of networks aside.
    #[arg(long, default_value = "mlp")]
    pub(crate) model: String,
    #[command(flatten)]
    pub(crate) beyond: BeyondArgs,
    /// Neurons of the hidden layers.
    #[arg(long, value_delimiter = ',', default_value = "10")]
    pub(crate) hidden: Vec<usize>,
    /// Function of the hidden neurons: tanh, logistic or relu.
    #[arg(long, default_value = "tanh")]
    pub(crate) activation: String,
    /// gd, gdm, gdx, rprop, scg, lbfgs or lm.
    #[arg(long, default_value = "rprop")]
    pub(crate) algorithm: String,
    /// Variant of rprop: rprop-, rprop+, irprop- or irprop+.
    #[arg(long, value_name = "VARIANT", allow_hyphen_values = true)]
    pub(crate) rprop: Option<String>,
    /// Momentum of gdm: averaged (as MATLAB's traingdm) or heavy-ball.
    #[arg(long, value_name = "FORM")]
    pub(crate) momentum: Option<String>,
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
    /// Trainings from different starts; the best one is kept.
    #[arg(long, default_value_t = 1)]
    pub(crate) repeats: usize,
    /// Seed of the first start.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Rows for the test error.
    #[arg(long, value_name = "FILE")]
    pub(crate) test: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) split: SplitArgs,
    /// Where to write the model.
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// Where to write the model card: MODEL.card.json beside the model otherwise.
    #[arg(long, value_name = "FILE")]
    pub(crate) card: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Which rows are kept away from the training.
#[derive(Debug, Args)]
pub(crate) struct SplitArgs {
    /// Keep rows together that have the same text in this column (an object, a grasp, a session): with --holdout, --validation
    /// and --folds none of its groups stands on both sides.
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
#[derive(Debug, Args)]
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
    /// Rows to train and to validate on.
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
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    /// The model file.
    pub(crate) model: PathBuf,
    /// The rows.
    pub(crate) data: PathBuf,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// The model file.
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
    /// Folder for report.html (everything on one page), study.json (every number) and figures/*.png.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// A look in seconds instead of the whole: seven conditions, three starts, one draw of rows, 300 epochs.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Seed of rows and starts; the same seed gives the same study on any number of threads.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}
