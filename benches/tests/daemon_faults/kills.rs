//! kill -9 at random moments: the gripper holds by itself, the recording lacks its last moment only, the next daemon takes over.

use super::{
    recordings,
    rig::{Object, Rig, SLACK_MS},
    spread, times,
};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use slip_benches::time;
use stories::Program;

/// What a kill may cost at the end of a recording (ms of samples): one flush interval of 250 ms, 50 ms until the recorder's thread looks
/// into its ring again, and what was on its way: the line, the ring, a chunk that was being written. Where the machine let the gripper's
/// thread wait, as long may the recorder's have waited.
pub(crate) const LOST_MS: u64 = 250 + 50 + 75;
/// Longest life of a daemon before it is killed (ms).
const LONGEST_LIFE_MS: u64 = 1_500;
/// After this time without commands nothing may rise any more (ms): the life of a command and some.
const RUN_OUT_MS: u64 = 120;

#[test]
fn the_gripper_holds_and_the_next_daemon_takes_over() {
    let rig = Rig::new(Object::Lifted);
    // The object is in the air before the first kill.
    rig.gripping(&["--record", "first.mcap"]).kill();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let (mut lost, mut stalls) = (Vec::new(), Vec::new());
    for index in 0..times(4) {
        let life_ms = 20 + random.next_u64() % LONGEST_LIFE_MS;
        let name = format!("kill-{index}.mcap");
        let configs = rig.gripper.bench().judge.configs;
        rig.gripper.bench().take_stall_us();
        let daemon = rig.daemon(&["--record", &name]);
        time::wait_ms(life_ms);
        let sent = kill(&rig, daemon, configs);
        rests(&rig);
        let found = recordings::read(&rig.folder.path().join(&name));
        let Some(sent) = sent else { continue };
        let (lost_ms, most_ms) = (sent.lost_ms(found.last_row), LOST_MS + SLACK_MS + sent.stall_ms);
        assert!(
            lost_ms <= most_ms,
            "kill {index} after {life_ms} ms cost {lost_ms} of {most_ms} ms: {found:?}, {sent:?}"
        );
        lost.push(lost_ms);
        stalls.push(sent.stall_ms);
    }
    spread("lost at the end of the recording", lost);
    spread("the machine stalled", stalls);
    let last = rig.daemon(&["--record", "last.mcap"]);
    rig.must(rig.gripper.until_gripped(), "the last daemon does not take over", &last);
    rig.finish(last);
}

/// Rows that the gripper had sent to a daemon.
#[derive(Debug)]
struct Sent {
    first: u32,
    next: u32,
    rate_hz: u32,
    stall_ms: u64,
}

impl Sent {
    /// What of it comes after the last row that was recorded (ms).
    fn lost_ms(&self, last: Option<u32>) -> u64 {
        let had = last.map_or(self.first, |last| last.wrapping_add(1));
        u64::from(self.next.saturating_sub(had)) * 1000 / u64::from(self.rate_hz.max(1))
    }
}

/// Kills while the gripper's time stands still: what it had sent to this daemon, if anything.
fn kill(rig: &Rig, mut daemon: Program, configs: u64) -> Option<Sent> {
    let mut bench = rig.gripper.bench();
    let stated = daemon.reported();
    assert!(daemon.is_running() && !stated.contains("panicked"), "{stated}");
    daemon.kill();
    let stall_ms = bench.take_stall_us() / 1000;
    let (next, first) = bench.rows_sent();
    let rate_hz = bench.mcu.link().in_force().map_or(0, |config| config.sample_rate_hz);
    (bench.judge.configs > configs).then_some(Sent { first, next, rate_hz, stall_ms })
}

/// Without a daemon the force stays: it does not fall (the gripper is watched all the time), and after the life of a command it does not rise.
fn rests(rig: &Rig) {
    let from_us = rig.gripper.bench().now_us();
    let after = |ms: u64| time::until(20, || rig.gripper.bench().now_us() > from_us + 1000 * ms);
    let run_out = after(RUN_OUT_MS);
    let settled_n = rig.gripper.bench().mcu.commanded_n();
    let later = after(RUN_OUT_MS + 40);
    let bench = rig.gripper.bench();
    let force_n = bench.mcu.commanded_n();
    assert!(run_out && later && force_n <= settled_n, "from {settled_n} to {force_n} N");
    assert!(!bench.is_active(), "commands without a daemon");
}
