//! R2 and R3: what happens when nobody commands any more.

use crate::rig::{Rig, config, lifted, supported};
use grip_link::message::{Config, DeviceState, ForceClamp, LossAction};

/// Unplugged: no byte either way.
#[test]
fn r2_link_loss_holds_at_most_the_hold_cap() {
    let mut rig = Rig::gripping(&lifted(), config(), 9.5);
    rig.run(200);
    assert!(rig.mcu.truth().lifted());
    rig.run_through(60, |to_device, to_host| {
        to_device.clear();
        to_host.clear();
    });
    let from = rig.forces.len();
    rig.host_runs = false;
    rig.run(20_000);
    assert!((rig.force_n() - 8.0).abs() < 1e-9, "the hold cap: {} N", rig.force_n());
    assert!(rig.forces[from..].windows(2).all(|pair| pair[1] <= pair[0]));
    assert!(!rig.mcu.truth().dropped(), "{:?}", rig.mcu.truth());
    let status = rig.mcu.link().status(rig.now.0);
    assert!(status.clamp.has(ForceClamp::HOLD_CAP), "and told: {status:?}");
}

#[test]
fn r2_the_fingers_open_only_if_configured() {
    for (loss_action, dropped) in
        [(LossAction::Hold, false), (LossAction::Open, true), (LossAction::Passive, true)]
    {
        let mut rig = Rig::gripping(&lifted(), Config { loss_action, ..config() }, 7.5);
        rig.run(200);
        rig.host_runs = false;
        rig.run(1_000);
        assert!((rig.force_n() - 7.5).abs() < 1e-9, "the delay comes first: {loss_action:?}");
        rig.run(1_000);
        assert_eq!(rig.state(), DeviceState::LossAction, "{loss_action:?}");
        assert_eq!(rig.mcu.truth().dropped(), dropped, "{loss_action:?}");
        assert_eq!(rig.force_n() > 0.0, !dropped, "{loss_action:?}");
    }
}

/// Each life of a command against each silence: followed up to the end of its life, held from then on.
#[test]
fn r3_delay_sweep() {
    for ttl_ms in [20_u16, 35, 50, 100] {
        for silence_ms in (5..=150).step_by(5) {
            let mut rig = Rig::gripping(&supported(), Config { ttl_ms, ..config() }, 5.0);
            rig.host_runs = false;
            rig.run(silence_ms);
            let fresh = silence_ms <= u32::from(ttl_ms);
            let expected = if fresh { DeviceState::Active } else { DeviceState::Hold };
            assert_eq!(rig.state(), expected, "ttl {ttl_ms} ms, silent for {silence_ms} ms");
            rig.host_runs = true;
            rig.grip(6.0, 30);
            assert_eq!(rig.state(), DeviceState::Active, "the next command is followed");
            assert!((rig.force_n() - 6.0).abs() < 1e-9);
        }
    }
}

/// A life that the host may not ask for becomes the nearest one allowed.
#[test]
fn r3_no_command_lives_longer_than_100_ms() {
    for (asked_ms, given_ms) in [(0, 20), (1, 20), (101, 100), (u16::MAX, 100)] {
        let mut rig = Rig::gripping(&supported(), Config { ttl_ms: asked_ms, ..config() }, 5.0);
        assert_eq!(rig.host.in_force().unwrap().ttl_ms, given_ms);
        rig.host_runs = false;
        rig.run(u32::from(given_ms));
        assert_eq!(rig.state(), DeviceState::Active, "{asked_ms}");
        rig.run(1);
        assert_eq!(rig.state(), DeviceState::Hold, "{asked_ms}");
    }
}

/// The loss action comes after its delay, and only a new CONFIG arms again.
#[test]
fn r3_the_loss_action_waits_for_its_delay() {
    for loss_after_ms in [100_u16, 400, 1_000, 3_000] {
        let config = Config { loss_after_ms, loss_action: LossAction::Passive, ..config() };
        let mut rig = Rig::gripping(&supported(), config, 5.0);
        rig.host_runs = false;
        rig.run(50 + u32::from(loss_after_ms) - 1);
        assert_eq!(rig.state(), DeviceState::Hold, "{loss_after_ms}");
        assert!((rig.force_n() - 5.0).abs() < 1e-9);
        rig.run(3);
        assert_eq!(rig.state(), DeviceState::LossAction, "{loss_after_ms}");
        assert!(rig.force_n() <= 0.0);
    }
}
