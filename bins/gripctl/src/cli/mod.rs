//! The command line of gripctl. The names are a contract.

pub(crate) mod command;
pub(crate) mod grasp;
pub(crate) mod import;
pub(crate) mod learn;

use clap::{ArgGroup, Args, Parser, Subcommand};
use grasp::GraspArgs;
use import::{ImportArgs, LabelArgs};
use learn::{
    CollectArgs, EstimateArgs, EvalArgs, ExportArgs, GenerateArgs, SearchArgs, StudyArgs, TrainArgs,
};
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
    /// Show one simulated grasp as curves in the terminal, and what to type next. Begin here.
    Demo(DemoArgs),
    /// List the serial ports of this computer.
    Ports(PortsArgs),
    /// Diagnose a gripper and this computer; suggest a command for each fault.
    ///
    /// Looks at the configuration, this computer, its disk and the port. Where nobody holds the port, it attaches to the gripper for some
    /// seconds without commanding any force, and measures. Exit codes: 0 no fault, 1 a fault, 2 wrong arguments.
    Doctor(DoctorArgs),
    /// Show the state of a running gripd: link, rate, losses, latency, grip, events.
    Status(StatusArgs),
    /// Command the gripper of a running gripd: release, grasp, at-least N, stop, clear-fault.
    ///
    /// gripd needs `allow_commands = true`. Exit code 0: gripd has taken the command; what it carries out within a second is printed. A stop is
    /// not a safety function.
    #[command(name = "command")]
    Control(CommandArgs),
    /// Name the object that is grasped next: gripd begins with what it has learned of that name.
    ///
    /// The name stands until another one is given. gripd needs `allow_commands = true`, and `file` in its table `memory`. Prints what is known of the
    /// object.
    Object(ObjectArgs),
    /// Show what gripd has learned of objects: needed force, friction, surface, with their uncertainty.
    Objects(ObjectsArgs),
    /// Run a virtual gripper on a pseudo-terminal.
    Sim(SimArgs),
    /// Run a recording through the pipeline: events and estimates.
    Replay(ReplayArgs),
    /// Make a recording of a file of another program: WAV, NPY, CSV, MCAP, rosbag2.
    ///
    /// Prints what was taken for what. `--map vibration=NAME` states what a signal is; NAME may be a group, whose axes or items are taken
    /// (`--map vibration=/imu.linear_acceleration`, `--map pressure=/skin.data`). Exit codes: 0 done, 2 nothing that can be used.
    Import(ImportArgs),
    /// Write into labels.csv what happens in a recording, for `gripctl score`.
    Label(LabelArgs),
    /// Make a whole recording of one that was cut off or damaged.
    Recover(RecoverArgs),
    /// Write the samples of a recording as CSV, bit by bit the same, or as .npz.
    Csv(CsvExportArgs),
    /// Measure noise floor, motion gate and slack on a recording without slip, or at a gripper.
    Calibrate(CalibrateArgs),
    /// Score a folder of labelled recordings: latency, misses, false alarms.
    Score(ScoreArgs),
    /// Measure a height profile: irregularities, roughness, every reading of E_sc.
    Profile(ProfileArgs),
    /// Compute every reading of E_sc for a list of irregularities.
    Esc(EscArgs),
    /// Let the controller hold many simulated objects: dropped, crushed, slipped.
    ///
    /// With --sensors, --baseline or --stress one row for each way of grasping, on the same objects; --compare puts gripd with each sensor set
    /// beside the older laws. The needed force is the largest one during the hold; slip, forces and times are those of objects
    /// that did not fall.
    Grasp(GraspArgs),
    /// Generate training data for the force estimate.
    Generate(GenerateArgs),
    /// Make training data of recordings: one row for each slip whose force is known from both sides.
    ///
    /// A recording does not know the adequate force. Of a slip it knows the force at which the object slipped, and the one at which it
    /// then stayed: 1.2 times these are the bounds adequate_low_n and adequate_high_n, their geometric mean is the target adequate_force_n. What states too
    /// little is left out and counted. `gripctl train OUTPUT --inputs slip_acceleration_m_s2,trial_force_n --target adequate_force_n`
    /// goes on from there. Exit codes: 0 done, 1 failed, 2 wrong arguments, 3 done, but recordings are damaged or have gaps.
    Collect(CollectArgs),
    /// Train a network, an ensemble or a support vector regression on rows of data.
    Train(Box<TrainArgs>),
    /// Search for the shape, activation and training of a network with a genetic algorithm.
    Search(SearchArgs),
    /// Judge models of the adequate force on generated objects that no training saw.
    ///
    /// Two rows for each model: `stretch`, what the pipeline sees of any slip, and `trial`, trial grasps of 2 mm. Each object has a
    /// mass, a friction, a surface and a force of its own. Columns: objects inside the range that the model knows; answers within 10 % of the adequate
    /// force, of all objects and of those in range; error; answers off by at most one and two of their stated deviations; answers
    /// that may move the fingers.
    Estimate(EstimateArgs),
    /// Evaluate a model file on rows of data.
    Eval(EvalArgs),
    /// Write a model file as C99 source or as an ONNX graph.
    Export(ExportArgs),
    /// Repeat the study of the four nets on simulated grasps: tables, curves, report.
    Study(StudyArgs),
}

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Name of a built-in scene, or a scene file.
    #[arg(default_value = "default")]
    pub(crate) scene: String,
    /// Seed of the object, instead of that of the scene; the same seed gives the same grasp.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Also write the recording (.csv), for `gripctl replay` and gripmon.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
}

#[derive(Debug, Args)]
pub(crate) struct PortsArgs {
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// The gripper: a serial device, `auto`, `sim` with an optional `:SCENE`, or `robotiq:MODEL:PORT` as for gripd --gripper, which is only
    /// asked for its status; that of the configuration otherwise, or the only USB serial port.
    pub(crate) port: Option<String>,
    /// Judge a sensor instead, by a recording of some seconds at rest (what `gripctl replay` reads): bands that its rate carries, noise, steps,
    /// gaps, and the smallest slip that is found.
    #[arg(long, value_name = "RECORDING", conflicts_with_all = ["port", "baud", "folder", "seconds"])]
    pub(crate) sensor: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
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
pub(crate) struct ObjectArgs {
    /// Its name, at most 64 bytes; an empty one is an object without a name.
    pub(crate) name: String,
    /// Where gripd listens: `tcp:ADDRESS:PORT` or `unix:PATH`.
    #[arg(default_value = grip_daemon::clients::Listen::DEFAULT)]
    pub(crate) address: grip_daemon::clients::Listen,
}

#[derive(Debug, Args)]
pub(crate) struct ObjectsArgs {
    /// The file of the memory: `file` of the table `memory` in gripd.toml.
    pub(crate) file: PathBuf,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CommandArgs {
    #[command(subcommand)]
    pub(crate) what: command::What,
    /// Where gripd listens: `tcp:ADDRESS:PORT` or `unix:PATH`.
    #[arg(long, default_value = grip_daemon::clients::Listen::DEFAULT, global = true)]
    pub(crate) address: grip_daemon::clients::Listen,
}

#[derive(Debug, Args)]
pub(crate) struct StatusArgs {
    /// Where gripd listens: `tcp:ADDRESS:PORT` or `unix:PATH`.
    #[arg(default_value = grip_daemon::clients::Listen::DEFAULT)]
    pub(crate) address: grip_daemon::clients::Listen,
    /// Ask again every second until it is stopped.
    #[arg(long, conflicts_with = "events")]
    pub(crate) watch: bool,
    /// Show slips and other events as they come, until it is stopped.
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

/// Whether files are replaced that the command did not make.
#[derive(Clone, Debug, Args)]
pub(crate) struct ForceArgs {
    /// Replace a file that is there already and that this command did not make. What the command reads is never replaced.
    #[arg(long)]
    pub(crate) force: bool,
}

/// How the columns of a CSV file are read.
#[derive(Debug, Args)]
pub(crate) struct CsvArgs {
    /// Samples per second, for a file without times, or with stamps coarser than its rows.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub(crate) rate: Option<f32>,
    /// Read the column NAME as another one, for example `stylus=height_m`; may be repeated.
    #[arg(long, value_name = "OURS=NAME")]
    pub(crate) map: Vec<String>,
    /// Unit of the times, where neither their name nor their rate shows it.
    #[arg(long, value_enum, value_name = "UNIT")]
    pub(crate) time_unit: Option<TimeUnit>,
}

/// Unit of times.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum TimeUnit {
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The recording: .mcap as gripd makes it, which has its settings and its model inside, or .csv with `t_s` and `stylus` (m),
    /// `vibration` (sensor units, signed or rectified) or neither but `travel_m` or taxels (`pressure_0` ...), or .npz
    /// with an array for each such column, or .wav, .npy or a rosbag2 as `gripctl import` reads them. Of a recording in
    /// several files all .mcap in their order; several of the others one after the other.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Compare the events with the recorded ones instead of printing them; exit 1 at the first difference. For .mcap.
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
    /// Calibration file: floor, gate and slack.
    #[arg(long, value_name = "FILE")]
    pub(crate) calibration: Option<PathBuf>,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// Built-in model (default, or paper: that of the source study) or model file, instead of the recorded one.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Show this reading of E_sc beside the literal one: literal, arc_cot, slope_power, lift_work or viscous_work.
    #[arg(long, value_name = "NAME", value_parser = grip_session::config::esc_reading)]
    pub(crate) esc: Option<slip_core::esc::Reading>,
    /// Do not run the force controller, even where the recording has a normal force.
    #[arg(long)]
    pub(crate) observe: bool,
    /// Write the evidence over the wanted interval, and where slips were found, as .svg or .png.
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
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
    /// Where to write what is saved. Otherwise it takes the place of a file of gripd that only lacks its end; of a file with damage in
    /// the middle, or of another program, it is written beside it, as NAME.recovered.mcap.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CsvExportArgs {
    /// The recording (.mcap); of one in several files all, in their order.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Where to write the samples: .csv, or .npz with an array for each column, where an empty cell is NaN.
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Which pipeline, counted from 1, where the recording has several: times start again with each.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) pipeline: Option<u64>,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("source").required(true).args(["file", "port"])))]
pub(crate) struct CalibrateArgs {
    /// A recording (.csv or .npz) of the gripper at rest or holding something that does not slip; with the robot moving for a part of it, where
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
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FloorOrigin {
    /// The labelled rest of the other materials; as live where they have none. For recordings too short to learn a floor.
    Folds,
    /// Its own earlier samples, as on a gripper: the one to cite in a paper.
    Live,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Folder with labels.csv (recording,kind,material,onset_s) and the recordings (.csv or .npz). A recording with several slips has a
    /// row for each onset. A phases.csv
    /// (recording,begin_s,end_s,cause) names what went on where nothing slipped: false alarms are counted for each cause.
    pub(crate) directory: PathBuf,
    #[command(flatten)]
    pub(crate) csv: CsvArgs,
    /// An alarm may come this much before the labelled onset; earlier is a false alarm (ms).
    #[arg(long, default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) guard_ms: f64,
    /// Calibration file, instead of the floor of the folder's labelled rest and the shipped slack.
    #[arg(long, value_name = "FILE")]
    pub(crate) calibration: Option<PathBuf>,
    /// Where the noise floors of a recording come from: the labelled rest of the other materials, or its own earlier samples as in
    /// a live run. Never its own label or later samples.
    #[arg(long, value_enum, default_value = "folds")]
    pub(crate) floor: FloorOrigin,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// Detectors to put side by side: default, stylus (alone), esc, esc_literal (the scattered energy of the last 10 ms, by the
    /// slopes and as printed), nn (a network that learns the labelled slips of the other materials), travel, pressure, fused, which
    /// also read what lies beside a recording: NAME_pose.csv as its travel, NAME_taxels.csv or NAME_electrodes.csv as its taxel
    /// array; own, a detector of your own, whose alarms stand in alarms.csv of the folder (recording,begin_s,end_s).
    #[arg(long, value_delimiter = ',', default_value = "default")]
    pub(crate) detectors: Vec<String>,
    /// A row for each material too.
    #[arg(long)]
    pub(crate) materials: bool,
    /// Measure the run time of each detector: `ns_per_sample` of the total.
    #[arg(long)]
    pub(crate) time: bool,
    /// Write misses, latency and false alarms over a range of thresholds to FILE, as .json; or found against false alarms
    /// (ROC) as a chart, .svg or .png; may be repeated.
    #[arg(long, value_name = "FILE")]
    pub(crate) curve: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ProfileArgs {
    /// The profile (.csv): `x_mm` at equal steps and `height_um`; absent heights are bridged up to a twentieth of lambda_c.
    pub(crate) file: PathBuf,
    /// Slip speed (m/s).
    #[arg(long, value_name = "M_S", allow_negative_numbers = true)]
    pub(crate) speed: f64,
    /// Trial force (N); E_sc is proportional to it, so 1 gives it per newton.
    #[arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) force: f64,
    /// Cutoff wavelength lambda_c (mm): longer waves are form or waviness, not roughness.
    #[arg(long, value_name = "MM", default_value_t = 2.5, allow_negative_numbers = true)]
    pub(crate) cutoff_mm: f64,
    /// Cutoff wavelength lambda_f (mm): longer waves are form, not waviness. Sampling length of Wz; none otherwise, and the whole profile is one.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub(crate) lambda_f_mm: Option<f64>,
    /// Degree of the least-squares polynomial that is the form: 1 for a line, 2 for an arc.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=9))]
    pub(crate) form_degree: u8,
    /// Cutoff wavelength lambda_s (um): shorter waves are noise; 0 for none. The pair of lambda_c in ISO 3274 otherwise: 2.5 up to 0.8 mm, 8 for 2.5 mm, 25 for 8 mm.
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
    /// Take the form away before the roughness too: for a tilted or bent profile, whose ends are wrong otherwise.
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
    /// Write the parts of the profile (.csv): `x_mm`, `height_um`, `form_um`, `waviness_um`, `roughness_um`.
    #[arg(long, value_name = "FILE")]
    pub(crate) parts: Option<PathBuf>,
    /// Draw the roughness profile with its peaks and valleys, and above it the profile with its form and waviness (.svg or .png).
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
