//! Simulation of roll-outs of models that ask for too little or too much: how many of each are rolled back, and after how many grasps.
//!
//! Each model grasps the same objects of the grasp simulator once, and estimates once beside the default model on them. A roll-out draws the grasps
//! of its grippers from these, with a seed: before it with the default model, then beside it, and then with the new one. Stages, numbers of grasps
//! and judge are those of `gripfleet deploy`; once without the shadow stage (`--shadow 0`), once with it.
//! `slow_lift.toml` is the scene of docs/results.md.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use anyhow::Context as _;
use clap::Parser;
use grip_fleet::{
    Member, Uid,
    rollout::{
        Difference, Draws, Grasp, JudgeConfig, Order, Progress, Report, Rollout, RolloutConfig,
        Stop,
    },
};
use grip_session::{
    HostEstimator,
    model::{default_estimator, parse_estimator},
};
use grip_sim::Scene;
use std::{collections::BTreeMap, fs, thread};

#[path = "../../tests/hand/mod.rs"]
mod hand;

/// Grippers of a roll-out, and grasps that each has made before.
const GRIPPERS: u8 = 20;
const BEFORE: usize = 300;
/// Forces of the models as shares of those of the default model, and what they are called.
const MODELS: [(f64, &str); 6] = [
    (1.0, "equal"),
    (0.95, "5 % too little"),
    (0.9, "10 % too little"),
    (0.75, "25 % too little"),
    (1.5, "1.5 x too much"),
    (5.0, "5 x too much"),
];

#[derive(Parser)]
struct Args {
    /// A scene file, or the name of a built-in one.
    #[arg(long, default_value = "default")]
    scene: String,
    /// Length of a grasp (s).
    #[arg(long, default_value_t = 3)]
    seconds: u64,
    /// Objects.
    #[arg(long, default_value_t = 200)]
    objects: u64,
    /// Seed of the first object; the others follow.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Roll-outs of each model.
    #[arg(long, default_value_t = 200)]
    rollouts: u64,
    /// What slips and force may grow by.
    #[arg(long, default_value_t = JudgeConfig::default().margin)]
    margin: f32,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let scene = match fs::read_to_string(&args.scene) {
        Ok(text) => Scene::from_toml(&text)?,
        Err(_) => grip_sim::scene::open(&args.scene)?,
    };
    println!(
        "model, grasps, lost, slips a grasp, slip p50 / p90, force over slip p50 / p90, over-force"
    );
    let mut pools = Vec::new();
    for (share, name) in MODELS {
        let model = parse_estimator("model.json", &hand::scaled(share)?)?;
        let pool = play_all(&args, &scene, &model, None)?;
        describe(name, &pool);
        let beside = play_all(&args, &scene, &default_estimator()?, Some(&model))?;
        let beside: Vec<Grasp> =
            beside.into_iter().filter(|grasp| grasp.compared.is_some()).collect();
        pools.push((name, Pools { pool, beside }));
    }
    let before = pools.first().map(|(_, pools)| pools.pool.clone()).context("no model")?;
    let judge = JudgeConfig { margin: args.margin, ..JudgeConfig::default() };
    let difference = Difference::default();
    let grasps =
        judge.needed(&before, BEFORE, &difference).context("no number of grasps will do")?;
    let config = RolloutConfig {
        judge,
        grasps: Some(grasps),
        replay: false,
        shadow: Some(0),
        idle_us: u64::MAX,
        ..RolloutConfig::default()
    };
    println!("a stage takes {grasps} grasps: {difference:?}, {BEFORE} grasps before");
    println!(
        "model, shadow stage, stopped as a shadow, grasps compared until then p50 / p90, rolled back, in stage 1, grasps with it until then p50 / p90"
    );
    for (shadow, with) in [(Some(0), "no"), (None, "yes")] {
        let config = RolloutConfig { shadow, ..config };
        for (name, pools) in &pools {
            let all = roll_outs(&args, config, &before, pools);
            let shadows: Vec<_> = all.iter().filter(|ended| ended.shadow).collect();
            let back: Vec<_> = all.iter().filter(|ended| ended.rolled_back).collect();
            let first = back.iter().filter(|ended| ended.stage == 1).count();
            let compared = quantiles(shadows.iter().map(|ended| ended.compared));
            let grasps = quantiles(back.iter().map(|ended| ended.grasps));
            let (shadows, back, all) = (shadows.len(), back.len(), all.len());
            println!(
                "{name}, {with}, {shadows} of {all}, {compared}, {back} of {all}, {first}, {grasps}"
            );
        }
    }
    Ok(())
}

/// What became of each object with a model, and of those with an estimate of it beside the default model.
struct Pools {
    pool: Vec<Grasp>,
    beside: Vec<Grasp>,
}

fn roll_outs(args: &Args, config: RolloutConfig, before: &[Grasp], pools: &Pools) -> Vec<Ended> {
    let one = |number| {
        let draws = Draws(args.seed.wrapping_mul(1_000_003).wrapping_add(number));
        roll_out(draws, config, before, pools)
    };
    (0..args.rollouts).map(one).collect()
}

/// Median and what nine of ten stay below.
fn quantiles(values: impl Iterator<Item = usize>) -> String {
    let mut values: Vec<usize> = values.collect();
    values.sort_unstable();
    let at = |tenths: usize| {
        let value = values.get(values.len() * tenths / 10).or(values.last());
        value.map_or("-".to_owned(), ToString::to_string)
    };
    format!("{} / {}", at(5), at(9))
}

/// What became of each object with the first model, and what the second one asked for beside it.
fn play_all(
    args: &Args,
    scene: &Scene,
    estimator: &HostEstimator,
    shadow: Option<&HostEstimator>,
) -> anyhow::Result<Vec<Grasp>> {
    let cores = thread::available_parallelism().map_or(1, |cores| cores.get() as u64);
    let some = |first: u64| {
        let seeds = (args.seed + first..args.seed + args.objects).step_by(usize::try_from(cores)?);
        let all = seeds
            .map(|seed| Ok((seed, hand::grasp(scene, seed, estimator, shadow, args.seconds)?)));
        all.collect::<anyhow::Result<Vec<_>>>()
    };
    let mut all = thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|first| scope.spawn(move || some(first))).collect();
        let ended = threads
            .into_iter()
            .map(|thread| thread.join().map_err(|_| anyhow::anyhow!("a panic"))?);
        ended.collect::<anyhow::Result<Vec<_>>>()
    })?
    .concat();
    all.sort_by_key(|(seed, _)| *seed);
    Ok(all.into_iter().filter_map(|(_, grasp)| grasp).collect())
}

fn describe(name: &str, pool: &[Grasp]) {
    let share = |is: &dyn Fn(&Grasp) -> bool| {
        100.0 * pool.iter().filter(|grasp| is(grasp)).count() as f64 / pool.len().max(1) as f64
    };
    let quantiles = |mut values: Vec<f32>| {
        values.sort_by(f32::total_cmp);
        let at =
            |tenths: usize| values.get(values.len() * tenths / 10).copied().unwrap_or(f32::NAN);
        format!("{:.2} / {:.2}", at(5), at(9))
    };
    let slips: u32 = pool.iter().map(|grasp| grasp.regrasps).sum();
    println!(
        "{name}, {}, {:.1} %, {:.2}, {} mm, {}, {:.1} %",
        pool.len(),
        share(&|grasp| grasp.lost),
        f64::from(slips) / pool.len().max(1) as f64,
        quantiles(pool.iter().map(|grasp| grasp.slip_mm).collect()),
        quantiles(pool.iter().filter_map(|grasp| grasp.force_ratio).collect()),
        share(&Grasp::over_force)
    );
}

/// How a roll-out ended.
struct Ended {
    /// It was stopped as a shadow.
    shadow: bool,
    rolled_back: bool,
    stage: usize,
    /// Grasps that were compared in the shadow stage, and grasps with the model.
    compared: usize,
    grasps: usize,
}

/// All grippers grasp in turn, what is drawn.
fn roll_out(mut draws: Draws, config: RolloutConfig, before: &[Grasp], pools: &Pools) -> Ended {
    let member =
        |n| Member { site: "hall".parse().unwrap_or_else(|_| unreachable!()), uid: Uid([n; 16]) };
    let mut rollout = Rollout::new(config, (0..GRIPPERS).map(member));
    let mut trying: BTreeMap<Member, usize> = BTreeMap::new();
    let (mut beside, mut history) = (Vec::new(), BTreeMap::new());
    loop {
        for (member, order) in rollout.step() {
            let report = match order {
                Order::Check => {
                    let grasps: Vec<Grasp> = (0..BEFORE).map(|_| draws.of(before)).collect();
                    history.insert(member.clone(), grasps.clone());
                    Report::Fit(grasps)
                }
                Order::Replay => Report::Replaying,
                Order::Shadow => {
                    beside.push((member.clone(), 0));
                    Report::Beside
                }
                Order::Take => {
                    trying.insert(member.clone(), 0);
                    Report::Taken(history.get(&member).cloned().unwrap_or_default())
                }
                Order::Accept => Report::Kept,
                Order::GiveBack => Report::Back,
            };
            rollout.receive(&member, report, 0);
        }
        match rollout.progress() {
            Progress::Done | Progress::Stopped(0) => break,
            Progress::Shadow => {
                for (member, from) in &mut beside {
                    let grasps = vec![draws.of(&pools.beside)];
                    rollout.receive(member, Report::Compared { from: *from, grasps }, 0);
                    *from += 1;
                    let (wanted, tally) = rollout.shadow();
                    if rollout.stopped().is_some() || tally.grasps >= wanted {
                        break;
                    }
                }
                continue;
            }
            Progress::Stage(_) if rollout.stopped().is_none() => {}
            _ => continue,
        }
        for (member, from) in &mut trying {
            let grasps = vec![draws.of(&pools.pool)];
            rollout.receive(member, Report::Grasps { from: *from, grasps }, 0);
            *from += 1;
            if rollout.stopped().is_some() {
                break;
            }
        }
    }
    let rolled_back = matches!(rollout.stopped(), Some(Stop::Worse { .. }));
    let shadow = matches!(rollout.stopped(), Some(Stop::Wrong { .. }));
    if let Some(stop) = rollout.stopped().filter(|_| !rolled_back && !shadow) {
        eprintln!("{stop}");
    }
    let grasps = trying.values().sum();
    let (stage, compared) = (rollout.stage(), rollout.shadow().1.grasps);
    Ended { shadow, rolled_back, stage, compared, grasps }
}
