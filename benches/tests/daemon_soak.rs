//! Some seconds of the soak that `daemon-soak` runs for half an hour: full rate, two clients that want everything, a recording.

use slip_benches::{
    daemon::soak::{Soak, run},
    time::clock,
};
use std::fs;
use stories::Build;

#[test]
fn every_sample_of_a_short_soak_is_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let soak = Soak {
        gripd: Build::beside_tests(&["daemon"]).programs().unwrap()["gripd"].clone(),
        folder: folder.path().into(),
        rate_hz: 20_000,
        seconds: 2.0,
        look_s: 1.0,
    };
    let mut looks = 0;
    let report = run(&soak, &clock(), &mut |_| looks += 1).unwrap();
    assert!(report.accounted(), "{report:?}");
    assert!(report.samples > 20_000 && report.unreported == 0, "{report:?}");
    // What a client is too slow for is dropped for it, never repeated.
    assert!(report.clients.iter().all(|rows| (1..=report.samples).contains(rows)), "{report:?}");
    assert!(looks >= 2 && report.looks.iter().all(|look| look.resident_kb > 1000), "{report:?}");
    let names: Vec<_> = report.threads_percent.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["gripd", "hot", "port", "recorder"]);
    assert!(report.recorded_bytes > 20 * report.samples, "{report:?}");
    let recorded = fs::metadata(folder.path().join("run.mcap")).unwrap();
    assert_eq!(recorded.len(), report.recorded_bytes);
}
