//! The arguments of `gripctl grasp`.

use clap::Args;
use grip_eval::grasp::{
    Friction, Law, SensorSet, Stress,
    faults::{FAULT_SENSORS, FaultKind, FaultPhase},
};
use grip_sim::mcu::Sensor;
#[cfg(feature = "ablation")]
use slip_core::ablation::Rule;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct GraspArgs {
    /// Scenes: built-in names or files; all files of --scenes otherwise, or the default scene.
    pub(crate) scene: Vec<String>,
    /// Folder of scene files.
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: Option<PathBuf>,
    /// All built-in scenes.
    #[arg(long, conflicts_with_all = ["scene", "scenes"])]
    pub(crate) all: bool,
    /// Grasps per scene, 100 by default, or per cell of --faults and --stalls, 8 by default; with seeds counting up.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(crate) trials: Option<u64>,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Length of a grasp (s).
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub(crate) duration: f64,
    /// Sensors of the gripper, a row each: scene (those of the scene), stylus, travel, two-styli, tangential; the last three beside a
    /// stylus. `all` is stylus to tangential.
    #[arg(long, value_name = "SET", value_delimiter = ',', value_parser = sensors, conflicts_with = "compare")]
    pub(crate) sensors: Vec<Chosen<SensorSet>>,
    /// Older laws of grip force instead of gripd, a row each: fixed (20 N), pr2 (each slip raises the force by 8 %), fft (each block that
    /// vibrates raises it by a step), oracle (knows mass, friction and every load to come: 1.3 times the
    /// largest needed force from the first sample of the slip on, a bound for every controller); gripd may stand among them. `all` is fixed to oracle.
    #[arg(long, value_name = "LAW", value_delimiter = ',', value_parser = laws, conflicts_with = "compare")]
    pub(crate) baseline: Vec<Chosen<Law>>,
    /// gripd with each sensor set, and every older law and the oracle with stylus and travel.
    #[arg(long)]
    pub(crate) compare: bool,
    /// What goes wrong, a row each: none, gain (+-20 %), noise (x 3), latency (0 to 20 ms either way), jitter (the same, of each frame), loss (5 % of the samples), dead-stylus,
    /// link (5 ms either way and noise x 3), everything. All of them where none is named: `--stress`, `--stress=noise,loss`.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = stresses, num_args = 0.., require_equals = true, default_missing_value = "all")]
    pub(crate) stress: Vec<Chosen<Stress>>,
    #[command(flatten)]
    pub(crate) equip: EquipArgs,
    #[command(flatten)]
    pub(crate) tables: TableArgs,
    /// Configuration file, as for gripd.
    #[arg(long)]
    pub(crate) config: Option<PathBuf>,
    /// Built-in model (default, or paper: that of the source study) or model file.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Print every grasp, not only the totals.
    #[arg(long)]
    pub(crate) each: bool,
    /// Draw the result (.svg or .png): every grasp of a single row, or the share of objects that were lost.
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: super::ForceArgs,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
    /// Rules of the force controller that are left out.
    #[cfg(feature = "ablation")]
    #[arg(long, value_name = "RULE", value_delimiter = ',', value_parser = rules, hide = true)]
    pub(crate) without: Vec<Chosen<Rule>>,
}

/// Files of keys that take the place of those of the scene.
#[derive(Debug, Args)]
pub(crate) struct EquipArgs {
    /// Gripper: direct, industrial (20 to 235 N in 255 steps, 150 commands a second), tendon (hysteresis and dead band), soft (rubber on
    /// air), franka (a grasp command each 33 ms), or a file. One after the other over the scene; in --matrix a column each.
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',', conflicts_with_all = ["faults", "stalls", "memory"])]
    pub(crate) gripper: Vec<String>,
    /// Its sensors: stylus_travel, stylus_alone, encoder_20um, optical_flow, ft_250hz, accelerometer, adc_12bit, usb_16ms, or a file.
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',', conflicts_with_all = ["faults", "stalls", "memory", "sensors", "compare"])]
    pub(crate) sensing: Vec<String>,
}

/// Tables of what goes wrong in the middle of a grasp.
#[derive(Debug, Args)]
pub(crate) struct TableArgs {
    /// Table of sensor faults: each sensor (stylus, force, travel) fails in each way in each phase of the grasp, with each kind of
    /// friction. Beside it: without that sensor from the start (absent), without a fault (sound), and the oracle; holdable counts what
    /// an oracle with 1.1 to 1.5 times the needed force holds.
    #[arg(long, conflicts_with_all = ["scene", "scenes", "all", "sensors", "baseline", "compare", "stress", "plot", "stalls", "duration"])]
    pub(crate) faults: bool,
    /// Table of stalls: in the middle of a slip the line or the daemon stops for 50 to 1000 ms.
    #[arg(long, conflicts_with_all = ["scene", "scenes", "all", "sensors", "baseline", "compare", "stress", "plot", "duration"])]
    pub(crate) stalls: bool,
    /// Memory of objects: each is grasped ten times under one name, then another one stands under it, with memory and without. --trials is
    /// the number of objects per scene, 20 by default.
    #[arg(long, conflicts_with_all = ["baseline", "compare", "stress", "plot", "faults", "stalls"])]
    pub(crate) memory: bool,
    /// Grippers by sensors by laws: each --gripper (all built-in ones) with each --sensing (all), by gripd, the older laws and the oracle.
    #[arg(long, conflicts_with_all = ["sensors", "baseline", "compare", "plot", "faults", "stalls", "memory"])]
    pub(crate) matrix: bool,
    /// Also write a row for each measurement in a slip, for `gripctl train` (.csv): scene, seed, the features, the estimate with its
    /// deviation, and the force that was needed at that moment; adequate_force_n is 1.2 times that.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["sensors", "baseline", "compare", "stress", "plot", "each", "faults", "stalls", "memory", "matrix"])]
    pub(crate) rows: Option<PathBuf>,
    /// Only these sensors in --faults: stylus, force, travel.
    #[arg(long, value_name = "SENSOR", value_delimiter = ',', value_parser = fault_sensors, requires = "faults")]
    pub(crate) fault_sensor: Vec<Chosen<Sensor>>,
    /// Only these faults: nan, inf, stuck, noise30 (30 times the noise), late5, late50, late300 (ms), gain+30, gain-30 (%).
    #[arg(long, value_name = "FAULT", value_delimiter = ',', value_parser = faults, requires = "faults")]
    pub(crate) fault: Vec<Chosen<FaultKind>>,
    /// Only faults that begin in these phases: before (the lift), first (2 ms into the slip), middle (of the slip), end (of the slip),
    /// holding (then the load grows by 40 %).
    #[arg(long, value_name = "PHASE", value_delimiter = ',', value_parser = phases, requires = "faults")]
    pub(crate) phase: Vec<Chosen<FaultPhase>>,
    /// Only these frictions in --faults: coulomb, stribeck, viscous10, viscous60, viscous150 (N s/m), static1.6 (static over kinetic).
    #[arg(long, value_name = "FRICTION", value_delimiter = ',', value_parser = frictions, requires = "faults")]
    pub(crate) friction: Vec<Chosen<Friction>>,
}

impl GraspArgs {
    /// The seeds of the grasps, `usual` of them where no number is asked for.
    pub(crate) fn seeds(&self, usual: u64) -> impl Iterator<Item = u64> + use<> {
        let first = self.seed;
        (0..self.trials.unwrap_or(usual)).map(move |trial| first.wrapping_add(trial))
    }
}

/// One name of a list; `all` stands for several.
#[derive(Clone, Debug)]
pub(crate) struct Chosen<T>(pub(crate) Vec<T>);

/// All that was chosen, in order.
pub(crate) fn flat<T: Copy>(chosen: &[Chosen<T>]) -> Vec<T> {
    chosen.iter().flat_map(|one| one.0.iter().copied()).collect()
}

fn sensors(name: &str) -> Result<Chosen<SensorSet>, String> {
    chosen(
        name,
        &SensorSet::ALL,
        SensorSet::named,
        "scene, stylus, travel, two-styli, tangential, all",
    )
}

fn laws(name: &str) -> Result<Chosen<Law>, String> {
    chosen(name, &Law::BASELINES, Law::named, "fixed, pr2, fft, oracle, gripd, all")
}

fn stresses(name: &str) -> Result<Chosen<Stress>, String> {
    let names: Vec<&str> = Stress::ALL.iter().map(|stress| stress.name).collect();
    chosen(name, &Stress::ALL, Stress::named, &format!("{}, all", names.join(", ")))
}

fn fault_sensors(name: &str) -> Result<Chosen<Sensor>, String> {
    let known = |name: &str| FAULT_SENSORS.iter().find(|one| one.0 == name).map(|one| one.1);
    chosen(name, &FAULT_SENSORS.map(|one| one.1), known, "stylus, force, travel, all")
}

fn faults(name: &str) -> Result<Chosen<FaultKind>, String> {
    let names = FaultKind::ALL.map(|kind| kind.name).join(", ");
    chosen(name, &FaultKind::ALL, FaultKind::named, &format!("{names}, all"))
}

fn phases(name: &str) -> Result<Chosen<FaultPhase>, String> {
    let names = FaultPhase::ALL.map(FaultPhase::name).join(", ");
    chosen(name, &FaultPhase::ALL, FaultPhase::named, &format!("{names}, all"))
}

fn frictions(name: &str) -> Result<Chosen<Friction>, String> {
    let names = Friction::ALL.map(|friction| friction.name).join(", ");
    chosen(name, &Friction::ALL, Friction::named, &format!("{names}, all"))
}

#[cfg(feature = "ablation")]
fn rules(name: &str) -> Result<Chosen<Rule>, String> {
    let names = Rule::ALL.map(Rule::name).join(", ");
    let known = |name: &str| Rule::ALL.into_iter().find(|rule| rule.name() == name);
    chosen(name, &Rule::ALL, known, &format!("{names}, all"))
}

fn chosen<T: Copy>(
    name: &str,
    all: &[T],
    named: fn(&str) -> Option<T>,
    names: &str,
) -> Result<Chosen<T>, String> {
    if name == "all" {
        return Ok(Chosen(all.to_vec()));
    }
    named(name).map(|one| Chosen(vec![one])).ok_or_else(|| format!("expected one of {names}"))
}
