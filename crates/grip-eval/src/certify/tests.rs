use super::{Certified, NotCertified, Stretch, certify};
use slip_core::detector::{BANDS, Certificate, Evidence};

const BASE_S: f64 = 5e-3;
const ALL: [bool; BANDS] = [true; BANDS];

/// Scores of noise, band by band independent.
struct Scores {
    state: u64,
    law: Law,
    loud: bool,
    before: [f64; BANDS],
}

#[derive(Clone, Copy, Debug)]
enum Law {
    /// Energy of two readings: exponential.
    Exponential,
    /// P(x > t) = t^-1.5: the mean exists, the variance does not.
    Pareto,
    /// Readings of few steps: most scores are equal.
    Steps,
    /// 2 % of the blocks have 20 times the energy.
    Bursts,
    /// Ten times the energy for 2 s in 8 s, in all bands.
    Hum,
    /// Each block keeps two thirds of the one before.
    Follows,
}

impl Scores {
    fn new(law: Law, seed: u64) -> Self {
        let state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        Self { state, law, loud: false, before: [1.0; BANDS] }
    }

    fn uniform(&mut self) -> f64 {
        self.state = self
            .state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.state >> 33) as f64 + 0.5) / f64::from(1_u32 << 31)
    }

    fn next(&mut self) -> [f32; BANDS] {
        let mean_s = if self.loud { 2.0 } else { 6.0 };
        if self.uniform() < BASE_S / mean_s {
            self.loud = !self.loud;
        }
        core::array::from_fn(|b| {
            let energy = -self.uniform().ln();
            let burst = self.uniform() < 0.02;
            let score = match self.law {
                Law::Exponential => energy,
                Law::Pareto => (energy / 1.5).exp(),
                Law::Steps => (energy * 2.0).floor(),
                Law::Bursts if burst => 20.0 * energy,
                Law::Bursts => energy,
                Law::Hum if self.loud => 10.0 * energy,
                Law::Hum => energy,
                Law::Follows => (2.0 * self.before[b] + energy) / 3.0,
            };
            self.before[b] = score;
            #[expect(clippy::cast_possible_truncation, reason = "test data")]
            let score = score as f32;
            score
        })
    }

    fn stretch(&mut self, count: usize, moving: bool) -> Stretch {
        Stretch { moving, scores: (0..count).map(|_| self.next()).collect() }
    }
}

fn alarms(certificate: &Certificate, scores: &mut Scores, count: u32) -> u32 {
    let mut evidence = Evidence::new(certificate, 5e-3);
    (0..count).map(|_| u32::from(evidence.bet(&scores.next(), false))).sum()
}

/// The promise itself: calibrations of two minutes, each judged on five hours of blocks.
#[test]
fn the_interval_holds_for_every_law_in_95_of_100_calibrations() {
    let laws = [Law::Exponential, Law::Pareto, Law::Steps, Law::Bursts, Law::Hum, Law::Follows];
    let (blocks, interval_s) = (360_000, 60.0);
    let wanted = f64::from(blocks) * BASE_S / interval_s;
    let (mut broken, mut made) = (0, 0);
    for law in laws {
        for seed in 1..=5 {
            let recorded = Scores::new(law, seed).stretch(24_000, false);
            let Ok((certificate, _)) = certify(&[recorded], BASE_S, ALL, interval_s) else {
                continue;
            };
            made += 1;
            let alarms = alarms(&certificate, &mut Scores::new(law, 1000 + seed), blocks);
            // Three deviations of the count beside the interval.
            broken += u32::from(f64::from(alarms) > wanted + 3.0 * wanted.sqrt());
        }
    }
    assert!(made >= 27, "{made} of 30 certify");
    assert!(broken <= 2, "{broken} of {made}");
}

fn certified(law: Law, seconds: usize, interval_s: f64) -> (Certificate, Certified) {
    let stretch = Scores::new(law, 3).stretch(200 * seconds, false);
    certify(&[stretch], BASE_S, ALL, interval_s).unwrap()
}

#[test]
fn what_follows_itself_gets_longer_blocks_and_what_comes_and_goes_is_reported() {
    let (certificate, independent) = certified(Law::Exponential, 300, 600.0);
    let rest = independent.rest.unwrap();
    assert_eq!(certificate.rest.unwrap().blocks, [1; BANDS]);
    assert!(
        rest.clusters < 2.5 && rest.blocks_ms == [5.0; 2] && rest.soonest_ms <= 30.0,
        "{rest:?}"
    );
    assert!(independent.motion.is_none() && certificate.motion.is_none());
    let (certificate, _) = certified(Law::Follows, 300, 600.0);
    assert!(certificate.rest.unwrap().blocks.iter().all(|n| *n >= 2), "{certificate:?}");
    // High for a quarter of the time.
    let clusters = certified(Law::Hum, 300, 600.0).1.rest.unwrap().clusters;
    assert!((3.0..8.0).contains(&clusters), "{clusters}");
}

#[test]
fn rest_and_motion_have_laws_of_their_own() {
    let mut scores = Scores::new(Law::Exponential, 9);
    let mut louder = scores.stretch(20_000, true);
    louder.scores.iter_mut().flatten().for_each(|score| *score *= 5.0);
    let (certificate, _) =
        certify(&[scores.stretch(20_000, false), louder], BASE_S, ALL, 60.0).unwrap();
    let [rest, motion] = [certificate.rest, certificate.motion].map(|law| law.unwrap().limits[0]);
    for (quiet, loud) in rest.into_iter().zip(motion) {
        assert!((3.0..8.0).contains(&(loud / quiet)), "{quiet} {loud}");
    }
    assert!(rest.is_sorted());
}

#[test]
fn bands_that_do_not_exist_have_no_part() {
    let stretch = Scores::new(Law::Exponential, 3).stretch(20_000, false);
    let bands = core::array::from_fn(|b| b < 4);
    let (certificate, _) = certify(&[stretch], BASE_S, bands, 60.0).unwrap();
    assert_eq!(certificate.rest.unwrap().blocks[4..], [0; 2]);
}

#[test]
fn too_little_and_too_seldom_are_refused() {
    let mut scores = Scores::new(Law::Exponential, 4);
    let few = scores.stretch(100, false);
    assert_eq!(
        certify(&[few], BASE_S, ALL, 60.0).unwrap_err(),
        NotCertified::Short { seconds: 0.5 }
    );
    // Loud every two seconds of the second half only.
    let mut changed = scores.stretch(24_000, false);
    for block in 0..30 {
        for score in &mut changed.scores[12_000 + 400 * block..12_020 + 400 * block] {
            *score = [1000.0; BANDS];
        }
    }
    let refused = certify(&[changed], BASE_S, ALL, 60.0).unwrap_err();
    assert!(matches!(refused, NotCertified::Unsteady { .. }), "{refused}");
}
