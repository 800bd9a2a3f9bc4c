//! What is clamped, and the verdicts of the clock.

use crate::page::{assert_states, row};
use core::fmt::Debug;
use grip_link::clock::PongVerdict;
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
    assert_eq!(Clamped::BITS.len(), 8);
    for (bit, name, about) in Clamped::BITS {
        let new = match about.split('`').nth(1).unwrap() {
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
        assert_eq!(Clamped::between(&old, &new), Clamped(1 << bit), "{name}");
    }
}

#[test]
fn verdicts_of_the_clock() {
    use PongVerdict as P;
    let verdicts = [P::Kept, P::Slow, P::Outlier, P::Impossible, P::Restarted];
    assert_states("HOST.md", &verdicts.map(|verdict| row(&[&upper(&verdict)])));
}
