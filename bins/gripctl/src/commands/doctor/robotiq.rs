//! Check of a gripper of Robotiq at a port and a unit: what it reports of itself. Its status is read; nothing is written to it.

use super::{super::clock::Clock, finding::Finding};
use grip_port::{READ_TIMEOUT, Source, UsbFilter};
use grip_robotiq::{
    BusCounters,
    gripper::{Gripper, GripperConfig, State},
};
use grip_session::exit::message;

/// Longest wait for an answer (us): some fifteen requests.
const PATIENCE_US: u64 = 2_000_000;

/// What the gripper `name` at `port` reports.
pub(crate) fn finding(name: &str, port: &str, baud: u32, config: GripperConfig) -> Finding {
    let place = format!("{} at {port}, unit {}, {baud} baud", config.model, config.unit);
    match ask(port, baud, config) {
        Ok((state, counters)) => judge(name, &place, state, counters),
        Err(error) => {
            let remedy = format!("stop what holds the port, then: gripctl doctor {name}");
            Finding::fault("gripper", format!("{place}: {}", message(error.as_ref())), remedy)
        }
    }
}

fn ask(port: &str, baud: u32, config: GripperConfig) -> anyhow::Result<(State, BusCounters)> {
    let mut line = Source::open(port, baud, UsbFilter::default())?.line()?;
    let clock = Clock::start();
    // Without an activation and without an order it only asks.
    let mut gripper = Gripper::new(GripperConfig { activate: false, ..config });
    let (mut input, mut out) = ([0; 256], Vec::new());
    gripper.opened(clock.now_us());
    while gripper.state() == State::Silent && clock.now_us() < PATIENCE_US {
        while gripper.poll_transmit(clock.now_us(), &mut out) {
            line.write_frame(&out)?;
        }
        let count = line.read(&mut input, READ_TIMEOUT)?;
        // Nothing is no late answer, after which the line would rest.
        if count > 0 {
            gripper.receive(clock.now_us(), input.get(..count).unwrap_or(&[]));
        }
    }
    Ok((gripper.state(), gripper.counters()))
}

fn judge(name: &str, place: &str, state: State, counters: BusCounters) -> Finding {
    let fault = |text: String, remedy: &str| {
        Finding::fault("gripper", format!("{place}: {text}"), remedy.to_owned())
    };
    let warning = |text: &str, remedy: String| {
        Finding::warning("gripper", format!("{place}: {text}"), remedy)
    };
    match state {
        State::Ready(ready) => {
            let holds =
                if ready.holds { "something is between the fingers" } else { "holds nothing" };
            let text = format!(
                "activated, {holds}, position {} of 255, motor current {} mA",
                ready.position, ready.current_ma
            );
            let note = counters.note().map_or_else(String::new, |note| format!("; {note}"));
            Finding::ok("gripper", format!("{place}: {text}{note}"))
        }
        State::Occupied => warning(
            "activated, and something is between the fingers with an unknown force",
            format!("gripd --gripper {name},holds=N to go on with N newtons, or let go by hand"),
        ),
        State::NotActivated | State::Activating => warning(
            "answers and is not activated",
            format!(
                "take out what it holds, then: gripd --gripper {name},activate (the fingers open and close)"
            ),
        ),
        State::Faulty(what) => fault(
            format!("answers and reports {what}"),
            "the gripper's manual; a grave fault needs a reset by hand",
        ),
        State::Silent => {
            let BusCounters { timeouts, broken, refused, echoes, .. } = counters;
            fault(
                format!(
                    "no status over Modbus RTU: {timeouts} requests without an answer, {broken} broken answers, {refused} refused, {echoes} \
                     own requests echoed"
                ),
                "its power, the wires A and B of RS-485, and unit= and baud= behind the port",
            )
        }
    }
}
