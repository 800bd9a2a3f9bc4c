//! Time of one sample through the pipeline, scene by scene, with and without skipping.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use slip_benches::scenes::{SCENES, STRETCH, SceneRun};
use slip_core::filter::{Band, FilterBank};

fn handle(how: &str, scene: &str, run: anyhow::Result<SceneRun>) {
    let run = run.expect("the scene stands");
    let begin = || run.pipeline.clone();
    rounds::by_item(&format!("Pipeline::handle, {scene}, {how}"), STRETCH, begin, |pipeline| {
        for sample in &run.samples {
            black_box(&pipeline.handle(black_box(sample)));
        }
    });
}

/// Blocks of 5 samples through eight lanes of band-passes, by one bank and by several side by side: what the recursion of one bank leaves
/// idle, the others use (docs/results/run-time.md).
fn bank() {
    const BLOCK: usize = 5;
    let bands: [Band; 8] = core::array::from_fn(|i| {
        let low_hz = 8.0 * f32::from(1_u16 << i);
        Band { low_hz, high_hz: 2.0 * low_hz }
    });
    let bank = FilterBank::new(&bands, 10_000.0).expect("the bands fit");
    let blocks: Vec<[f32; BLOCK]> = (0..STRETCH / BLOCK)
        .map(|i| core::array::from_fn(|j| ((i * BLOCK + j) as f32 * 0.37).sin()))
        .collect();
    for banks in [1, 2, 4] {
        let what = format!("FilterBank::energy, a sample of a bank, {banks} banks");
        rounds::by_item(
            &what,
            STRETCH * banks,
            || vec![bank; banks],
            |side_by_side| {
                for block in &blocks {
                    for bank in side_by_side.iter_mut() {
                        black_box(bank.energy(black_box(block), 0.1, &[1.0; 8]));
                    }
                }
            },
        );
    }
}

fn main() {
    for scene in SCENES {
        handle("skip", scene.name(), SceneRun::new(scene, false));
        handle("no_skip", scene.name(), SceneRun::new(scene, true));
        handle("certifying", scene.name(), SceneRun::certifying(scene));
    }
    handle("stylus alone", "slipping", SceneRun::stylus_alone());
    bank();
}
