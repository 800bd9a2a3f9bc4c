//! The table of sensor faults and that of stalls: what is drawn, when faults begin, and what stands beside gripd.

use grip_eval::grasp::{
    Friction, Incident, IncidentKind, Line, Own, Setup,
    faults::{FAULT_SENSORS, FaultBench, FaultKind, FaultPhase, FaultPlan, FaultTrial, fault_cell},
    play,
    stalls::{SLIPS, STALLS_MS, stall_cell, stall_trials},
};
use grip_session::{config::HostConfig, model};
use grip_sim::{
    mcu::{Sensor, SensorFault},
    scene,
};
use slip_core::units::Micros;

fn trials(plan: &FaultPlan, friction: &str, seed: u64) -> Vec<FaultTrial> {
    let (config, estimator) = (HostConfig::default(), model::default_estimator().unwrap());
    let bench = FaultBench { config: &config, estimator: &estimator };
    bench.trials(plan, Friction::named(friction).unwrap(), seed).unwrap()
}

fn plan(sensor: Sensor, fault: &str, phases: &[FaultPhase]) -> FaultPlan {
    let faults = vec![FaultKind::named(fault).unwrap()];
    FaultPlan { sensors: vec![sensor], faults, phases: phases.to_vec() }
}

#[test]
fn names_of_the_table_are_known() {
    for kind in FaultKind::ALL {
        assert_eq!(FaultKind::named(kind.name), Some(kind));
    }
    for phase in FaultPhase::ALL {
        assert_eq!(FaultPhase::named(phase.name()), Some(phase));
    }
    for friction in Friction::ALL {
        assert_eq!(Friction::named(friction.name), Some(friction));
    }
    let plan = FaultPlan::default();
    let cells = plan.sensors.len() * plan.faults.len() * plan.phases.len() * Friction::ALL.len();
    assert_eq!((cells, FAULT_SENSORS.len()), (810, 3));
}

#[test]
fn phases_come_in_their_order_and_a_cell_is_the_same_every_time() {
    let all = plan(Sensor::Stylus, "gain+30", &FaultPhase::ALL);
    let first = trials(&all, "coulomb", 3);
    assert_eq!(first, trials(&all, "coulomb", 3));
    let begins: Vec<f64> = first.iter().map(|trial| trial.begins_s.unwrap()).collect();
    assert!(begins.windows(2).all(|pair| pair[0] < pair[1]), "{begins:?}");
    assert!(begins[2] - begins[1] <= 0.014 && begins[3] - begins[1] <= 0.029, "{begins:?}");
    // A part of the table is the same as in the whole of it.
    let only = trials(&plan(Sensor::Stylus, "gain+30", &[FaultPhase::End]), "coulomb", 3);
    assert_eq!(only, first[3..4]);
}

#[test]
fn what_stands_beside_a_fault_does_not_depend_on_it() {
    let phases = [FaultPhase::First, FaultPhase::Holding];
    let some = FaultPlan { phases: phases.to_vec(), ..FaultPlan::default() };
    let all = trials(&some, "stribeck", 1);
    assert_eq!(all.len(), 3 * 9 * 2);
    for phase in phases {
        for (name, _) in FAULT_SENSORS {
            let cell = || all.iter().filter(|t| t.sensor == name && t.phase == phase.name());
            let one = cell().next().unwrap();
            let same = |t: &FaultTrial| {
                (t.absent, t.sound, t.oracle) == (one.absent, one.sound, one.oracle)
            };
            assert!(cell().all(same), "{name}");
            assert!(one.oracle.holds && one.oracle.usual.whole() && one.sound.whole(), "{one:?}");
        }
    }
    let of = |fault: &str| all.iter().find(|t| t.sensor == "force" && t.fault == fault).unwrap();
    assert_ne!(of("gain+30").faulty, of("gain+30").sound, "a fault changes something");
    // Whatever is done to the load is done to all of them: 1.3 times what 1.4 times the weight needs.
    let holding = all.iter().find(|t| t.phase == "holding").unwrap();
    assert!((holding.oracle.usual.peak_ratio - 1.3).abs() < 0.01, "{holding:?}");
    assert!((holding.oracle.usual.final_ratio - 1.3).abs() < 0.01, "{holding:?}");
}

#[test]
fn cells_count_what_was_reached() {
    let plan = plan(Sensor::Travel, "nan", &[FaultPhase::First]);
    let mut all: Vec<FaultTrial> = (0..2).flat_map(|seed| trials(&plan, "coulomb", seed)).collect();
    all[0].faulty.dropped = true;
    all[0].oracle.holds = false;
    all[1].faulty.dropped = true;
    all[1].oracle.holds = true;
    let mut unreached = all[1].clone();
    unreached.begins_s = None;
    all.push(unreached);
    let all: Vec<&FaultTrial> = all.iter().collect();
    let cell = fault_cell("fault", ["travel", "nan", "first", "coulomb"], &all);
    assert_eq!((cell.trials, cell.unreached), (2, 1));
    assert_eq!((cell.dropped, cell.dropped_holdable, cell.oracle_lost), (2, 1, 1));
    assert_eq!((cell.dropped_seeds, cell.peak_ratio.max), (vec![0, 1], None));
}

/// Rows that gripd handled and lost in 1.5 s, with such an incident at 1 s.
fn rows(kind: Option<IncidentKind>) -> (u64, u64) {
    let (config, scene) = (HostConfig::default(), scene::load("default").unwrap());
    let setup = Setup {
        scene: &scene,
        config: &config,
        duration: Micros(1_500_000),
        line: Line::default(),
        incident: kind.map(|kind| Incident { at: Micros(1_000_000), kind }),
    };
    let mut silent = |_: grip_session::Update<'_>| ();
    let estimator = model::default_estimator().unwrap();
    let outcome = play(&setup, &mut Own::new(&config, estimator, &mut silent).unwrap()).unwrap();
    (outcome.samples, outcome.lost)
}

#[test]
fn a_line_loses_nothing_in_a_stall_and_a_daemon_what_exceeds_its_buffer() {
    let calm = rows(None);
    assert!(calm.0 > 14_000 && calm.1 == 0, "{calm:?}");
    let length = Micros(400_000);
    assert_eq!(rows(Some(IncidentKind::LineStall(length))), calm);
    assert_eq!(rows(Some(IncidentKind::HostStall(Micros(100_000)))), calm);
    let (samples, lost) = rows(Some(IncidentKind::HostStall(length)));
    assert!(lost > 0 || samples == calm.0, "{samples} {lost}");
    // What never comes is no stall: a line that stands still to the end.
    let (samples, _) = rows(Some(IncidentKind::LineStall(Micros(10_000_000))));
    assert!(samples < 10_100, "{samples}");
    let dead = rows(Some(IncidentKind::Sensor(Sensor::Travel, SensorFault::Dead)));
    assert_eq!(dead, calm, "a dead sensor still has its rows");
}

#[test]
fn stalls_begin_in_a_slip_and_the_oracle_holds_on() {
    let (config, estimator) = (HostConfig::default(), model::default_estimator().unwrap());
    let all = stall_trials(&config, &estimator, SLIPS[0].0, SLIPS[0].1, 0.4, 1).unwrap();
    assert_eq!(all.len(), 2 * STALLS_MS.len());
    assert!(all.iter().all(|trial| trial.begins_s == all[0].begins_s), "one time for all");
    assert!(all[0].begins_s.is_some_and(|at| at > 0.6), "{:?}", all[0]);
    assert!(all.iter().all(|trial| trial.oracle.usual.whole() && trial.sound.whole()));
    assert!(all.iter().any(|trial| trial.stalled != trial.sound));
    let cell = stall_cell("stall", ["all"; 4].map(str::to_owned), &all.iter().collect::<Vec<_>>());
    assert_eq!((cell.trials, cell.unreached, cell.oracle_dropped), (10, 0, 0));
}
