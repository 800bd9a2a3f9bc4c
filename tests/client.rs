//! A client. Two people beside gripd want to know how it does: one watches its figures, one is informed of each slip.
//!
//! gripd waits for its gripper, and both clients are there already. The gripper is plugged in, grips and lifts; the object slips. One client is informed of the
//! gripper and of every slip that gripd prints, once and in order; the other one sees the figures grow. Neither disturbs the grasp.
#![expect(clippy::unwrap_used, reason = "test code")]

use serde_json::Value;
use stories::{Program, folder, in_one_of_some_runs, until};

/// Where gripd listens.
const ADDRESS: &str = "unix:gripd.sock";

/// Waits until the figures are like that.
#[track_caller]
fn until_seen(figures: &Program, is: impl Fn(&Value) -> bool) {
    let seen = until(|| figures.lines().last().is_some_and(&is));
    assert!(seen, "{}{}", figures.printed(), figures.reported());
}

/// Times of the slips in lines of gripd or gripctl.
fn slips(lines: &[Value]) -> Vec<f64> {
    let slips = lines.iter().filter(|line| line["type"].as_str().unwrap().starts_with("slip"));
    slips.map(|line| line["t_s"].as_f64().unwrap()).collect()
}

/// A grasp before two clients; an error where the object fell.
fn watched() -> Result<(), String> {
    let folder = folder();
    let args = ["--port", "./gripper", "--wait", "--json", "--listen", ADDRESS];
    let gripd = Program::gripd(folder.path(), &args);
    gripd.until_reported("waiting for it");
    let gripctl = |how: &str| Program::gripctl(folder.path(), &["status", ADDRESS, how, "--json"]);
    let (figures, updates) = (gripctl("--watch"), gripctl("--events"));
    until_seen(&figures, |now| now["health"]["clients"] == 2);

    let gripper = Program::gripctl(folder.path(), &["sim", "--pty", "gripper"]);
    let fallen = || gripd.reported().contains("the object is gone");
    let reported = until(|| updates.printed().contains("\"phase\":\"ended\"") || fallen());
    assert!(reported, "{}{}", updates.printed(), gripd.reported());
    until_seen(&figures, |now| now["health"]["slips"].as_u64() >= Some(1) || fallen());
    let now = figures.lines().pop().unwrap();
    let ended = gripd.interrupted().done();
    let received = updates.ended();
    drop(gripper);
    if ended.err.contains("the object is gone") {
        return Err(ended.err);
    }

    assert!(now["gripper"]["link"] == "stream" && now["state"]["device"] == "active", "{now}");
    assert!(now["events"].as_array().unwrap().iter().any(|event| event["type"] == "slip"), "{now}");
    let lines = received.lines();
    assert!(lines.iter().any(|line| line["type"] == "gripper" && line["uid"].is_string()));
    let printed = slips(&ended.lines());
    assert_eq!(slips(&lines), printed, "{received:?}");
    assert!(printed.is_sorted() && printed.len() >= 2, "{printed:?}");
    Ok(())
}

#[test]
fn a_client_receives_of_every_slip_once_and_another_sees_the_figures() {
    in_one_of_some_runs(watched);
}

/// Whoever stands at the console. Without leave gripd refuses; with it the fingers open, close and stop, and each refusal names what to type.
/// An error where the object fell: its loss is a fault that refuses the next grasp.
fn commanded() -> Result<(), String> {
    let folder = folder();
    let command = |what: &[&str]| {
        let args = [&["command"], what, &["--address", ADDRESS]].concat();
        Program::gripctl(folder.path(), &args).ended()
    };
    let gripd = |settings: &str| {
        std::fs::write(folder.path().join("gripd.toml"), settings).unwrap();
        let gripd = Program::gripd(folder.path(), &["--port", "sim", "--listen", ADDRESS]);
        gripd.until_printed("slip ended");
        gripd
    };
    let alone = gripd("");
    let refused = command(&["release"]);
    assert!(refused.code == 1 && refused.err.contains("allow_commands = true"), "{refused:?}");
    let _ended = alone.interrupted();

    let open = gripd("allow_commands = true\n");
    for what in ["grasp", "stop"] {
        let ran = command(&[what]);
        if ran.code != 0 && open.reported().contains("the object is gone") {
            return Err(open.interrupted().err);
        }
        assert!(ran.code == 0 && ran.out.contains(what), "{what}: {ran:?}");
    }
    let latched = || {
        let ran = command(&["grasp"]);
        ran.code == 1 && ran.err.contains("clear-fault")
    };
    assert!(until(latched));
    // Another code clears nothing.
    assert!(command(&["clear-fault", "0303"]).code == 0 && latched());
    assert_eq!(command(&["clear-fault", "0001"]).code, 0);
    if !until(|| command(&["grasp"]).code == 0) {
        return Err(open.interrupted().err);
    }
    assert!(until(|| command(&["release"]).code == 0));
    let wrong = command(&["at-least", "-3"]);
    assert!(wrong.code == 2 && wrong.err.contains("no force"), "{wrong:?}");
    let _ended = open.interrupted();
    Ok(())
}

#[test]
fn a_command_at_the_console_is_carried_out_or_refused_with_the_next_step() {
    in_one_of_some_runs(commanded);
}
