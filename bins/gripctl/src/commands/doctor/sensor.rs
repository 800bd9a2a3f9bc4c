//! A recording of a sensor at rest in; what it can feel, and what keeps it from more, out.

use super::finding::Finding;
use grip_record::{Recording, StylusKind};
use grip_session::{HostConfig, replay};
use slip_core::{
    PipelineConfig, Sample,
    detector::{BANDS, BandThreshold, RestMeter},
    filter::MAX_CORNER,
};

/// Below this rate (Hz) no band lies above the motion of hands and robots.
const ABOVE_MOTION_HZ: f32 = 100.0;
/// Rest (s) that says something of a noise floor.
const REST_S: f32 = 2.0;
/// Bands that are lowered where the rate does not carry them.
const LOWERED_BANDS: usize = 2;
/// Stretches that are compared (s, and readings at least), and the ratio of energies from which one of them was no rest.
const STRETCH_S: f32 = 0.5;
const STRETCH: u64 = 400;
const STEADY: f32 = 4.0;
/// Share of readings equal to the one before from which the steps are coarser than the noise.
const COARSE: f32 = 0.5;
/// Share of readings that may be missing.
const MISSING: f32 = 0.01;

/// What the recording shows of its sensor.
pub(super) fn findings(recording: &Recording, config: &HostConfig) -> Vec<Finding> {
    let pipeline = replay::pipeline_config(recording, config, true);
    if recording.channels.stylus == StylusKind::Absent {
        let remedy =
            "record stylus (m) or vibration; an array of taxels is judged by gripctl calibrate";
        let text = format!("{}: no stylus and no vibration", recording.name);
        return vec![Finding::fault("sensor", text, remedy.to_owned())];
    }
    let readings = Readings::of(&recording.samples);
    let mut found = vec![rate(recording, &pipeline), complete(recording, &readings)];
    let Some(rest) = rest(recording, &pipeline) else {
        let text = "every reading is the same: a sensor at rest has noise".to_owned();
        let remedy = "check wiring and supply; tap the finger while you record";
        found.push(Finding::fault("sensor noise", text, remedy.to_owned()));
        return found;
    };
    found.extend([
        steps(&readings, &rest),
        steady(&rest, recording),
        floor(&rest, recording, &pipeline),
    ]);
    found
}

/// Counts of readings.
struct Readings {
    all: f32,
    missing: f32,
    repeated: f32,
}

impl Readings {
    #[expect(clippy::cast_precision_loss, reason = "shares")]
    fn of(samples: &[Sample]) -> Self {
        let all = samples.len().max(1) as f32;
        let missing = samples.iter().filter(|sample| !sample.stylus.is_finite()).count() as f32;
        let equal = samples
            .windows(2)
            .filter(|two| matches!(two, [a, b] if a.vibration() == b.vibration()))
            .count();
        Self { all, missing, repeated: equal as f32 }
    }
}

/// Noise of a recording: mean energies of all of it, least and largest energy of a band in a stretch, the smallest step.
struct Rest {
    energy: [f32; BANDS],
    unsteady: f32,
    step_rms: f32,
}

fn rest(recording: &Recording, pipeline: &PipelineConfig) -> Option<Rest> {
    let rate_hz = pipeline.sample_rate.0;
    let mut meter = RestMeter::new(&pipeline.detector, rate_hz).ok()?;
    let mut parts = RestMeter::new(&pipeline.detector, rate_hz).ok()?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "samples")]
    let stretch = (STRETCH_S * rate_hz) as u64;
    let stretch = stretch.max(STRETCH);
    let mut range = [(f32::INFINITY, 0.0_f32); BANDS];
    for sample in &recording.samples {
        meter.push_vector(sample.vibration());
        parts.push_vector(sample.vibration());
        if parts.samples() >= stretch
            && let Some(energy) = parts.take()
        {
            for ((least, most), energy) in range.iter_mut().zip(energy) {
                (*least, *most) = (least.min(energy), most.max(energy));
            }
        }
    }
    let energy = meter.floor(pipeline.floor)?;
    let known = range.iter().filter(|(least, most)| *least > 0.0 && most.is_finite());
    let unsteady = known.map(|(least, most)| most / least).fold(1.0, f32::max);
    Some(Rest { energy, unsteady, step_rms: meter.least_energy(pipeline.floor).sqrt() })
}

/// Corners (Hz) of each band as the rate has it: shear and vibration, the first two, are lowered, an octave that does not fit is none.
fn corners(pipeline: &PipelineConfig) -> [Option<(f32, f32)>; BANDS] {
    let limit_hz = MAX_CORNER * pipeline.sample_rate.0;
    let bands = pipeline.detector.bands();
    core::array::from_fn(|b| {
        let BandThreshold { low_hz, high_hz, .. } = *bands.get(b)?;
        if low_hz < 0.8 * limit_hz {
            Some((low_hz, high_hz.min(limit_hz)))
        } else {
            (b < LOWERED_BANDS).then_some((0.25 * limit_hz, limit_hz))
        }
    })
}

/// Which bands the rate carries.
fn rate(recording: &Recording, pipeline: &PipelineConfig) -> Finding {
    let rate_hz = pipeline.sample_rate.0;
    let corners = corners(pipeline);
    let carried: Vec<String> =
        corners.iter().flatten().map(|(low, high)| format!("{low:.0}-{high:.0} Hz")).collect();
    let text = format!("{rate_hz:.0} samples a second: bands {}", carried.join(", "));
    let given = recording.notes.given_rate_hz.is_some();
    let source = if given { " (as --rate says)" } else { "" };
    if carried.len() == BANDS {
        return Finding::ok("sensor rate", text + source);
    }
    let above = corners.iter().flatten().any(|(low_hz, _)| *low_hz >= ABOVE_MOTION_HZ);
    let remedy =
        "sample faster where the sensor can: all bands fit from 2.5 times their highest corner on";
    if above {
        return Finding::warning("sensor rate", text + source, remedy.to_owned());
    }
    let text = format!(
        "{rate_hz:.0} samples a second carry no band above the motion of hands and robots: only slips that stay three times as loud as all motion before are found"
    );
    Finding::warning("sensor rate", text, remedy.to_owned())
}

/// Whether readings or times are missing.
fn complete(recording: &Recording, readings: &Readings) -> Finding {
    let notes = &recording.notes;
    let missing = readings.missing / readings.all;
    #[expect(clippy::cast_precision_loss, reason = "a time to look at")]
    let longest_ms = notes.longest_step.0 as f32 / 1000.0;
    let text = format!(
        "{:.0} readings, {:.2} % of them no number; {} gaps, the longest step {longest_ms:.1} ms",
        readings.all,
        100.0 * missing,
        notes.gaps
    );
    let good = missing <= MISSING && notes.gaps == 0;
    let remedy = "raise the priority of the program that reads, or send batches; gaps delay alarms and hold the force";
    Finding::judge(good, "sensor data", text, remedy)
}

/// Whether the steps of the converter hide the noise.
fn steps(readings: &Readings, rest: &Rest) -> Finding {
    let share = readings.repeated / readings.all;
    let text = format!(
        "{:.0} % of the readings repeat the one before; rounding is worth {:.2e} (rms)",
        100.0 * share,
        rest.step_rms
    );
    let remedy = "amplify before the converter, or use more bits: what moves by less than a step is not felt. A sensor that is read less often than its samples are sent repeats readings, too: send each once";
    Finding::judge(share < COARSE, "sensor steps", text, remedy)
}

/// Whether it was at rest.
fn steady(rest: &Rest, recording: &Recording) -> Finding {
    #[expect(clippy::cast_precision_loss, reason = "seconds")]
    let seconds = recording.samples.len() as f32 / recording.rate_hz;
    let text = format!(
        "{seconds:.1} s; the loudest stretch has {:.1} times the energy of the quietest",
        rest.unsteady
    );
    let remedy = format!(
        "record {REST_S:.0} s and more with nothing moving; hum of the mains or of a fan shows as a steady line in gripmon"
    );
    Finding::judge(seconds >= REST_S && rest.unsteady <= STEADY, "sensor rest", text, &remedy)
}

/// The noise, and the smallest slip over it.
fn floor(rest: &Rest, recording: &Recording, pipeline: &PipelineConfig) -> Finding {
    let unit = if recording.channels.stylus == StylusKind::Vibration { "" } else { " m" };
    let bands = pipeline.detector.bands();
    let found =
        corners(pipeline).into_iter().zip(bands).zip(rest.energy).filter_map(
            |((corners, band), energy)| Some((corners?, (band.threshold * energy).sqrt())),
        );
    let smallest = found.min_by(|a, b| a.1.total_cmp(&b.1));
    let ((low_hz, high_hz), rms) = smallest.unwrap_or_default();
    let noise = rest.energy.iter().sum::<f32>().sqrt();
    Finding::ok(
        "sensor floor",
        format!(
            "noise {noise:.2e}{unit} (rms, all bands); a slip is found from {rms:.2e}{unit} in {low_hz:.0}-{high_hz:.0} Hz on, with the default thresholds"
        ),
    )
}
