//! No room for a recording: it stops, is reported once and counted, and the grip goes on.

use super::rig::{Object, Rig, times_stated};
use rustix::process::{Pid, Resource, Rlimit, prlimit};
use slip_benches::time;
use stories::Signal;

/// Room for a recording (bytes): about a second of it.
const ROOM: u64 = 1 << 20;
/// What the daemon reports when a recording stops.
const REPORTED: &str = "the object is held without a recording";

#[test]
fn a_file_that_may_not_grow_any_more() {
    let rig = Rig::new(Object::Lifted);
    let daemon = rig.daemon(&["--record", "limited.mcap"]);
    let limit = Rlimit { current: Some(ROOM), maximum: Some(ROOM) };
    let id = Pid::from_raw(i32::try_from(daemon.id()).unwrap());
    prlimit(id, Resource::Fsize, limit).unwrap();
    rig.until_held(&daemon);
    let stopped = time::until(60, || times_stated(&daemon, REPORTED) > 0);
    rig.must(stopped, "the recording does not stop", &daemon);
    rig.commands_again(&daemon, 200);
    assert_eq!(times_stated(&daemon, REPORTED), 1, "{}", daemon.reported());
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.ended().code, 3, "lost samples are reported at the end");
    rig.gripper.bench().judge.must_be_kept();
    assert_eq!(rig.recordings().len(), 1);
}
