//! Chart of a measured profile with peaks and valleys.

use grip_eval::profile::Evaluation;
use grip_plot::{Axis, Chart, Layer, Mark};
use grip_record::HeightProfile;
use slip_core::irregularity::TurnKind;

/// Points of the line in the picture, at most; two for each column of it.
const POINTS: usize = 2400;

/// The roughness profile of `name` with the peaks and valleys that were counted; above it the profile with its form and
/// waviness, or the levelled profile with its waviness.
pub(super) fn chart(
    name: &str,
    profile: &HeightProfile,
    evaluation: &Evaluation,
    level: bool,
) -> Chart {
    let Evaluation { form_m, waviness_m, roughness_m, step_m, .. } = evaluation;
    let marked = |kind: TurnKind| {
        let turns = evaluation.turns.iter().filter(|turn| turn.kind == kind);
        turns.map(|turn| (1e3 * turn.position_m, 1e6 * f64::from(turn.height_m))).collect()
    };
    let waviness = evaluation.waviness.map(|w| format!(", Wa {:.3} um", 1e6 * w.wa_m));
    let title = format!(
        "{name}: Ra {:.3} um{}, {} irregularities higher than {:.2} um",
        1e6 * evaluation.parameters.ra_m,
        waviness.unwrap_or_default(),
        evaluation.irregularities.len(),
        1e6 * evaluation.hysteresis_m
    );
    let form = |z: &f64| if level { 0.0 } else { *z };
    let traced: Vec<f64> = if level {
        profile.heights_m.iter().zip(form_m).map(|(z, f)| z - f).collect()
    } else {
        profile.heights_m.clone()
    };
    let raised = raise(&traced, roughness_m);
    let above = |heights: Vec<f64>| {
        outline(&heights.into_iter().map(|z| z + raised).collect::<Vec<_>>(), *step_m)
    };
    let mean_line = form_m.iter().zip(waviness_m).map(|(f, w)| form(f) + w).collect();
    let (x, y) = (Axis::linear("distance (mm)"), Axis::linear("height (um)"));
    let names = if level { ["levelled", "waviness"] } else { ["profile", "form + waviness"] };
    Chart::new(title, x, y)
        .with(Layer::line("roughness", outline(roughness_m, *step_m)))
        .with(Layer::markers("peaks", marked(TurnKind::Peak)).drawn_as(Mark::Triangles))
        .with(Layer::markers("valleys", marked(TurnKind::Valley)).drawn_as(Mark::TrianglesDown))
        .with(Layer::line(names[0], above(traced)))
        .with(Layer::line(names[1], above(mean_line)))
        .with(
            Layer::line("form", above(form_m.iter().map(form).collect()))
                .drawn_as(Mark::DashedLine),
        )
}

/// By how much `upper` is drawn higher (m), so that it lies a quarter of its height above `lower`.
fn raise(upper: &[f64], lower: &[f64]) -> f64 {
    let ends = |z: &[f64]| z.iter().fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
    let ((low, high), (_, top)) = (ends(upper), ends(lower));
    top - low + 0.25 * (high - low)
}

/// The profile in mm and um, thinned to the lowest and highest point of equal stretches.
fn outline(heights_m: &[f64], step_m: f64) -> Vec<(f64, f64)> {
    let stretch = heights_m.len().div_ceil(POINTS / 2).max(1);
    let place = |(i, z): (usize, &f64)| (1e3 * step_m * i as f64, 1e6 * z);
    let points: Vec<(f64, f64)> = heights_m.iter().enumerate().map(place).collect();
    let mut thinned = Vec::new();
    for part in points.chunks(stretch) {
        let by_height = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let low = part.iter().min_by(by_height);
        let high = part.iter().max_by(by_height);
        let mut ends: Vec<(f64, f64)> = low.into_iter().chain(high).copied().collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.dedup();
        thinned.extend(ends);
    }
    thinned
}

#[cfg(test)]
mod tests {
    use super::outline;

    #[test]
    fn thinning_keeps_the_extremes() {
        let heights: Vec<f64> =
            (0..50_000_u32).map(|i| f64::from(i * 7919 % 1013) * 1e-6).collect();
        let thin = outline(&heights, 1e-6);
        assert!(thin.len() <= 2400 && thin.len() > 2000, "{}", thin.len());
        let highest = thin.iter().map(|p| p.1).fold(0.0, f64::max);
        assert!((highest - 1012.0).abs() < 1e-9);
        assert!(thin.windows(2).all(|p| p[0].0 < p[1].0));
        assert_eq!(outline(&heights[..3], 1e-6).len(), 3);
    }
}
