//! An end that falls silent or starts anew: closing, hold, loss action and reboot.

use crate::line::Line;
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
