//! What is clamped, and the states and verdicts of a host.

use crate::markdown::table;
use core::fmt::Debug;
use grip_link::clock::PongVerdict;
use grip_link::host::LinkState;
use grip_link::message::{Clamped, Config};

/// `PowerOn` to `POWER_ON`.
pub(crate) fn upper(value: &impl Debug) -> String {
    let mut name = String::new();
    let mut after_small = false;
    for letter in format!("{value:?}").chars() {
        if letter.is_uppercase() && after_small {
            name.push('_');
        }
        after_small = !letter.is_uppercase();
        name.extend(letter.to_uppercase());
    }
    name
}

#[test]
fn clamped_fields() {
    let old = crate::targets::gripper::CONFIG;
    let rows = table("### Clamped fields");
    assert_eq!(rows.len(), 8);
    for row in rows {
        let new = match row[2].split(';').next().unwrap() {
            "sample_rate_hz" => Config { sample_rate_hz: 1, ..old },
            "batch" => Config { batch: 1, ..old },
            "channel_mask" => Config { channel_mask: 9, ..old },
            "force_max_mn" => Config { force_max_mn: 1, ..old },
            "slew_mn_s" => Config { slew_mn_s: 1, ..old },
            "ttl_ms" => Config { ttl_ms: 1, ..old },
            "hold_cap_mn" => Config { hold_cap_mn: 1, ..old },
            "loss_after_ms" => Config { loss_after_ms: 1, ..old },
            other => panic!("no field {other}"),
        };
        let bit: u32 = row[0].parse().unwrap();
        assert_eq!(Clamped::between(&old, &new), Clamped(1 << bit), "{}", row[1]);
    }
}

#[test]
fn states_and_verdicts_of_the_host() {
    use LinkState as S;
    use PongVerdict as P;
    let states = [S::Closed, S::Open, S::Hello, S::Config, S::Stream, S::Degraded];
    let names: Vec<String> = states.iter().map(upper).collect();
    assert_eq!(
        table("### Host states").iter().map(|row| row[0].clone()).collect::<Vec<_>>(),
        names
    );
    let verdicts = [P::Kept, P::Slow, P::Outlier, P::Impossible, P::Restarted];
    let names: Vec<String> = verdicts.iter().map(upper).collect();
    assert_eq!(
        table("### PONG verdicts").iter().map(|row| row[0].clone()).collect::<Vec<_>>(),
        names
    );
}
