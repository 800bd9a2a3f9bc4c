//! Forces of made-up slips in, what the friction meter makes of them.

extern crate std;
use super::{FrictionMeter, KAPPA};
use crate::estimate::ForceEstimate;
use std::vec::Vec;

/// A slip of 0.1 s at 10 kHz under a force that grows by e each 20 ms from 2 N to 8 N.
#[derive(Clone, Copy)]
struct Slip {
    /// Friction of sliding and its excess at break-away, which fades in 2 ms.
    mu: f32,
    excess: f32,
    /// Half of the load (N); the object slides until the force is 1.2 times what that needs.
    load_n: f32,
    scale: f32,
    felt: bool,
}

impl Slip {
    const HELD: Self = Self { mu: 0.3, excess: 0.2, load_n: 1.5, scale: 1.0, felt: true };

    fn needed_n(self) -> f32 {
        self.load_n / self.mu
    }

    /// The estimates of each millisecond, with the force there is and whether the object slides.
    fn run(self) -> Vec<(Option<ForceEstimate>, f32, bool)> {
        let mut meter = FrictionMeter::new(10_000.0);
        meter.begin();
        let mut noise = 1_u32;
        let mut draw = || {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.017 * (f32::from(u16::try_from(noise >> 16).unwrap()) / 65_536.0 - 0.5)
        };
        let mut out = Vec::new();
        for i in 0..1000_u16 {
            let t_s = 1e-4 * f32::from(i);
            let normal_n = (2.0 * libm::expf(t_s / 0.02)).min(8.0);
            let slides = normal_n < 1.2 * self.needed_n();
            let mu = self.mu * (1.0 + self.excess * libm::expf(-t_s / 2e-3));
            let shown_n = if slides { mu * normal_n } else { self.load_n };
            let felt = self.felt && slides;
            meter.push(normal_n + draw(), self.scale * (shown_n + draw()), felt);
            if i % 10 == 9 {
                out.push((meter.estimate(), normal_n, slides));
            }
        }
        out
    }
}

#[test]
fn the_adequate_force_follows_from_the_load_at_rest_whatever_the_scale() {
    for scale in [1.0, 0.8, -1.2] {
        let slip = Slip { scale, ..Slip::HELD };
        let estimate = slip.run().last().unwrap().0.unwrap();
        let ratio = estimate.force_n / (KAPPA * slip.needed_n());
        assert!((0.9..1.05).contains(&ratio), "{ratio} at scale {scale}");
        assert!(estimate.is_trusted() && !estimate.extrapolated, "{estimate:?}");
    }
}

/// So the force goes on growing until the object stands.
#[test]
fn an_object_that_slides_needs_more_than_the_force_there_is() {
    let steps = Slip::HELD.run();
    let mean_n = |last: &[(Option<ForceEstimate>, f32, bool)]| {
        last.iter().map(|step| step.1).sum::<f32>() / 4.0
    };
    let ratio = |last: &[(Option<ForceEstimate>, f32, bool)]| {
        last[3].2.then(|| last[3].0.unwrap().force_n / mean_n(last))
    };
    let ratios: Vec<f32> = steps.windows(4).filter_map(ratio).collect();
    assert!(ratios.len() > 15, "{ratios:?}");
    assert!(ratios.iter().all(|ratio| (1.0..1.25).contains(ratio)), "{ratios:?}");
    assert!(ratios.last().is_some_and(|ratio| *ratio > 1.15), "{ratios:?}");
}

/// Much less friction than at break-away, as on a wet contact: the ratio of before fades.
#[test]
fn friction_that_has_fallen_is_believed_after_a_while() {
    let wet = Slip { excess: 0.8, load_n: 1e3, ..Slip::HELD };
    let (estimate, normal_n, _) = *wet.run().last().unwrap();
    assert!(estimate.unwrap().force_n > 1.1 * normal_n, "{estimate:?} at {normal_n} N");
    let unfelt = Slip { felt: false, ..wet };
    let (estimate, normal_n, _) = *unfelt.run().last().unwrap();
    assert!(estimate.unwrap().force_n < 0.9 * normal_n, "nothing slips: {estimate:?}");
}

#[test]
fn forces_that_say_nothing_give_no_estimate() {
    for slip in [Slip { scale: 0.0, ..Slip::HELD }, Slip { scale: 0.01, ..Slip::HELD }] {
        assert!(slip.run().iter().all(|(estimate, ..)| estimate.is_none()));
    }
    let after = |samples: u16, stuck: bool| {
        let mut meter = FrictionMeter::new(10_000.0);
        for i in 0..samples {
            let noise_n = if stuck { 0.0 } else { 1e-3 * f32::from(i % 7) };
            meter.push(2.0 + 0.1 * f32::from(i), 0.6 + noise_n, true);
        }
        (meter.estimate(), meter.friction())
    };
    assert_eq!(after(39, false), (None, None), "four blocks are needed");
    assert!(after(40, false).0.is_some());
    assert_eq!(after(400, true), (None, None), "a sensor that is stuck");
}
