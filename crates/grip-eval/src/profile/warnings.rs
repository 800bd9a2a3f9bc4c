//! Warnings about an evaluated profile: what speaks against the numbers, in words.

use super::{Evaluation, ProfileOptions, count};
use core::cmp::Ordering;
use grip_record::HeightProfile;

/// A cutoff with its lambda_s (ISO 3274) and the surfaces it is for (ISO 4288, ISO 21920-3).
#[derive(Clone, Copy)]
pub(super) struct Pair {
    cutoff_m: f64,
    pub(super) lambda_s_m: f64,
    most_ra_m: f64,
    most_rsm_m: f64,
}

const fn paired(cutoff_m: f64, lambda_s_m: f64, most_ra_m: f64, most_rsm_m: f64) -> Pair {
    Pair { cutoff_m, lambda_s_m, most_ra_m, most_rsm_m }
}

const PAIRS: [Pair; 5] = [
    paired(0.08e-3, 2.5e-6, 0.02e-6, 40e-6),
    paired(0.25e-3, 2.5e-6, 0.1e-6, 130e-6),
    paired(0.8e-3, 2.5e-6, 2e-6, 400e-6),
    paired(2.5e-3, 8e-6, 10e-6, 1.3e-3),
    paired(8e-3, 25e-6, f64::INFINITY, f64::INFINITY),
];
/// Sampling lengths that are asked for.
const SAMPLING_LENGTHS: u32 = 5;
/// Steps in lambda_s, at least.
const STEPS: f64 = 5.0;
/// Heights of a spike, at most.
const WIDEST_SPIKE: usize = 5;
/// How often a spike stands out of the step between heights that nine of ten do not exceed.
const SPIKE: f64 = 6.0;

/// The pair whose cutoff is nearest, by its ratio.
pub(super) fn pair(cutoff_m: f64) -> Pair {
    let apart = |pair: &Pair| (pair.cutoff_m / cutoff_m).ln().abs();
    PAIRS.into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(PAIRS[3])
}

pub(super) fn of(
    profile: &HeightProfile,
    options: &ProfileOptions,
    evaluation: &Evaluation,
) -> Vec<String> {
    let length_m = count(profile.heights_m.len()) * profile.step_m;
    [
        missing(profile),
        spiky(profile, &evaluation.roughness_m),
        cutoff(options, evaluation, length_m),
        step(options, profile.step_m),
        tilt(options, evaluation),
        (evaluation.irregularities.is_empty()).then(|| {
            let hysteresis_um = 1e6 * evaluation.hysteresis_m;
            format!(
                "no irregularity higher than the hysteresis of {hysteresis_um:.3} um; give a smaller --hysteresis-um"
            )
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn missing(profile: &HeightProfile) -> Option<String> {
    let widest = profile.filled.iter().max_by_key(|gap| gap.len())?;
    let all: usize = profile.filled.iter().map(ExactSizeIterator::len).sum();
    Some(format!(
        "heights that were not measured: {all}, gaps: {}, the widest {} um at {} mm; a line bridges each",
        profile.filled.len(),
        short(1e6 * count(widest.len()) * profile.step_m),
        short(1e3 * count(widest.start) * profile.step_m)
    ))
}

fn spiky(profile: &HeightProfile, roughness_m: &[f64]) -> Option<String> {
    let found = spikes(&profile.heights_m, roughness_m);
    let highest_m = found.iter().map(|spike| spike.height_m).fold(0.0, f64::max);
    let first: Vec<String> = found
        .iter()
        .take(3)
        .map(|spike| short(1e3 * count(spike.place) * profile.step_m))
        .collect();
    (!found.is_empty()).then(|| {
        format!(
            "spikes: {}, up to {} um high, at {} mm{}: hardly the surface, but in Ra, Rq, Rz and RSm; empty their cells, and a line bridges them",
            found.len(),
            short(1e6 * highest_m),
            first.join(", "),
            if found.len() > first.len() { " and on" } else { "" }
        )
    })
}

struct Spike {
    place: usize,
    height_m: f64,
}

/// Up to five heights that jump out and back by more than neighbours differ elsewhere and than the roughness spans.
fn spikes(heights: &[f64], roughness_m: &[f64]) -> Vec<Spike> {
    let steps: Vec<f64> = heights.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let moved = quantile(steps.iter().copied().filter(|step| *step > 0.0).collect(), 0.5);
    let [low, high] = [0.05, 0.95].map(|part| quantile(roughness_m.to_vec(), part));
    let least = (SPIKE * quantile(steps, 0.9).max(moved)).max(high - low);
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some([before, out]) = heights.get(at..at + 2) {
        let jump = out - before;
        let back = |z: &f64| (z - before) / jump < 0.5;
        let width = heights[at + 1..].iter().take(WIDEST_SPIKE + 1).position(back);
        match width.filter(|_| jump.abs() > least) {
            Some(width) => {
                found.push(Spike { place: at + 1, height_m: jump.abs() });
                at += width + 1;
            }
            None => at += 1,
        }
    }
    found
}

fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in it")]
    let place = (part * count(values.len())) as usize;
    if place >= values.len() {
        return 0.0;
    }
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// Too few sampling lengths, and the cutoff that Ra and RSm ask for.
fn cutoff(options: &ProfileOptions, evaluation: &Evaluation, length_m: f64) -> Option<String> {
    let parameters = &evaluation.parameters;
    let (ra_m, rsm_m) = (parameters.ra_m, parameters.rsm_m);
    let suits =
        |pair: &&Pair| ra_m <= pair.most_ra_m && rsm_m.is_none_or(|rsm| rsm <= pair.most_rsm_m);
    let wanted = PAIRS.iter().find(suits)?;
    let cutoff_mm = short(1e3 * options.cutoff_m);
    let whole = evaluation.evaluated.len() == evaluation.roughness_m.len();
    let few = match parameters.sections {
        _ if length_m < options.cutoff_m => Some(format!(
            "{} mm long, less than one cutoff of {cutoff_mm} mm: the mean line is not reliable",
            short(1e3 * length_m)
        )),
        n if n < SAMPLING_LENGTHS => Some(format!(
            "sampling lengths of {cutoff_mm} mm: {n} of the five that are asked for{}",
            if whole { ", the ends among them" } else { "" }
        )),
        _ => None,
    };
    let needs_m = f64::from(SAMPLING_LENGTHS + 1) * wanted.cutoff_m;
    let other = pair(options.cutoff_m).cutoff_m.total_cmp(&wanted.cutoff_m) != Ordering::Equal;
    let advice = other.then(|| {
        let with_rsm = rsm_m.map_or(" asks".to_owned(), |rsm_m| {
            format!(" and RSm of {} um ask", short(1e6 * rsm_m))
        });
        let (ra_um, cutoff_mm) = (short(1e6 * ra_m), short(1e3 * wanted.cutoff_m));
        let mut text = format!("Ra of {ra_um} um{with_rsm} for --cutoff-mm {cutoff_mm}");
        if length_m < needs_m {
            text += &format!(", which needs {} mm of profile", short(1e3 * needs_m));
        }
        text
    });
    match (few, advice) {
        (None, None) => None,
        (Some(few), None) => {
            let needs_m = f64::from(SAMPLING_LENGTHS + 1) * options.cutoff_m;
            Some(format!("{few}; trace {} mm", short(1e3 * needs_m)))
        }
        (few, advice) => Some([few, advice].into_iter().flatten().collect::<Vec<_>>().join("; ")),
    }
}

fn step(options: &ProfileOptions, step_m: f64) -> Option<String> {
    let lambda_s_m = options.short_cutoff_m;
    if lambda_s_m == 0.0 || step_m <= 1.05 * lambda_s_m / STEPS {
        return None;
    }
    let wanted_m = STEPS * step_m;
    let suits = |pair: &&Pair| pair.lambda_s_m > 0.95 * wanted_m;
    let with = PAIRS.iter().find(suits).map_or(String::new(), |pair| {
        format!("; steps this wide belong to --cutoff-mm {}", short(1e3 * pair.cutoff_m))
    });
    Some(format!(
        "steps of {} um are too wide for lambda_s of {} um, which takes {} um or less: the steps decide what is noise, as --lambda-s-um {} says{with}",
        short(1e6 * step_m),
        short(1e6 * lambda_s_m),
        short(1e6 * lambda_s_m / STEPS),
        short(1e6 * wanted_m),
    ))
}

/// The mean line of a tilted profile that is held at its ends is off by 0.075 tilt lambda_c there.
fn tilt(options: &ProfileOptions, evaluation: &Evaluation) -> Option<String> {
    let off_m = 0.075 * evaluation.tilt.abs() * options.cutoff_m;
    (!options.level && off_m > 0.5 * evaluation.parameters.ra_m).then(|| {
        format!(
            "tilted by {:.2} um/mm: the roughness profile is off by up to {:.1} um at its ends; --level takes the tilt away",
            1e3 * evaluation.tilt,
            1e6 * off_m
        )
    })
}

/// Four to five digits.
fn short(value: f64) -> String {
    let decimals = if value < 1.0 {
        4
    } else if value < 100.0 {
        3
    } else {
        1
    };
    let text = format!("{value:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
