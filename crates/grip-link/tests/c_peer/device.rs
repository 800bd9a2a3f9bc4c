//! Random scripts: the C device says what the device of this crate says.

use crate::peer::{assert_same, run};
use crate::script;

#[test]
fn same_behaviour_on_random_scripts() {
    let mut seen = std::collections::HashSet::new();
    for seed in 0..40 {
        let (script, expected) = script::play(seed, 3000);
        for line in &expected {
            seen.insert(line.split(' ').next().unwrap().to_owned());
            if let Some((_, state)) = line.split_once("state ") {
                seen.insert(format!("state {}", state.split(' ').next().unwrap()));
            }
        }
        assert_same(&format!("seed {seed}"), &expected, &run("device", &script));
    }
    for event in [
        "linked",
        "configured",
        "started",
        "stopped",
        "command",
        "rejected",
        "heartbeat",
        "estop",
        "cleared",
        "log",
    ] {
        assert!(seen.contains(event), "no {event} in any script");
    }
    for state in 0..=8 {
        assert!(seen.contains(&format!("state {state}")), "state {state} was never reached");
    }
}
