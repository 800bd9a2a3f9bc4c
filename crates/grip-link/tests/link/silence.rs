//! An end that falls silent or starts anew: closing, hold, loss action and reboot.

use crate::line::{Line, Reported};
use grip_link::device::Drive;
use grip_link::host::{CloseReason, LinkState};
use grip_link::message::DeviceState;

#[test]
fn silence_closes_the_link() {
    let mut line = Line::streaming();
    line.run_through(1_100_000, |_, to_host| to_host.clear());
    assert!(
        matches!(line.closed(), Some(CloseReason::Lost { silent_us }) if silent_us > 1_000_000)
    );
    assert_eq!(line.states().last(), Some(&LinkState::Closed));
    assert_eq!(line.host.reopen_after_us(), 50_000);
    line.reported.clear();
    line.open();
    line.run(200_000);
    assert_eq!(line.host.state(), LinkState::Stream, "opens again, with the same nonce too");
}

#[test]
fn stalled_host_holds_then_takes_the_loss_action() {
    let mut line = Line::streaming();
    line.grip_n = Some(9.5);
    line.run(100_000);
    assert_eq!((line.device.state(), line.force_now()), (DeviceState::Active, 9500));
    line.host_runs = false;
    let begin = line.tick();
    line.run(45_000);
    assert_eq!(line.device.state(), DeviceState::Active);
    line.run(60_000);
    assert_eq!(line.device.state(), DeviceState::Hold);
    assert_eq!(line.force_now(), 8000, "falls to the hold cap");
    assert!(line.most_since(begin) <= 9500);
    line.run(1_000_000);
    assert_eq!(line.device.state(), DeviceState::LossAction);
    assert_eq!(
        line.drives.last().unwrap().1,
        Drive::Force(8000),
        "the configured action is to keep holding"
    );
}

#[test]
fn stalled_host_comes_back_within_the_hold() {
    let mut line = Line::streaming();
    line.grip_n = Some(5.0);
    line.run(100_000);
    line.host_runs = false;
    line.run(200_000);
    assert_eq!(line.device.state(), DeviceState::Hold);
    line.host_runs = true;
    line.run(20_000);
    assert_eq!((line.device.state(), line.force_now()), (DeviceState::Active, 5000));
}

#[test]
fn reboot_mid_grip_arms_again_and_drops_the_force() {
    let mut line = Line::streaming();
    line.grip_n = Some(4.0);
    line.run(100_000);
    line.reported.clear();
    line.reboot(2);
    line.run(100);
    assert_eq!(line.drives.last().unwrap().1, Drive::Passive, "passive at start");
    line.run(400_000);
    assert!(line.reported.contains(&Reported::Rebooted(1, 2)));
    assert!(line.reported.contains(&Reported::Identified(true)));
    assert_eq!(line.host.state(), LinkState::Stream);
    assert_ne!(line.host.session(), 0xBEEF);
    assert_eq!(line.host.clock().unwrap().boot_id(), 2);
    assert_eq!((line.device.state(), line.force_now()), (DeviceState::Active, 4000));
}
