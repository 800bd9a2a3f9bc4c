//! Check of a sensor by its recording at rest: what it can detect, and what keeps it from more.

use super::finding::Finding;
use grip_record::{Recording, StylusKind};
use grip_session::{HostConfig, calibration::Evidence, replay};
use slip_core::{
    ConfigError, PipelineConfig, Sample,
    detector::{AlarmSum, BANDS, RestMeter},
    filter::Band,
    isolated::{self, Guard},
};

/// Shortest rest (s) that shows a noise floor.
const REST_S: f32 = 2.0;
/// Stretches that are compared (s, and readings at least), and the ratio of energies from which one of them was no rest.
const STRETCH_S: f32 = 0.5;
const STRETCH: u64 = 400;
const STEADY: f32 = 4.0;
/// Share of readings equal to the one before from which the steps are coarser than the noise.
const COARSE: f32 = 0.5;
/// Share of readings from which isolated ones are reported: noise that is Gaussian has some in a million.
const OUTLIERS: f32 = 5e-5;
/// Share of readings that may be missing.
const MISSING: f32 = 0.01;

type Bands = [Option<Band>; BANDS];

/// What the recording shows of its sensor.
///
/// # Errors
/// Where the detector cannot work at its rate.
pub(super) fn findings(
    recording: &Recording,
    config: &HostConfig,
) -> Result<Vec<Finding>, ConfigError> {
    let pipeline = replay::pipeline_config(recording, config, true);
    if recording.channels.stylus == StylusKind::Absent {
        let remedy =
            "record stylus (m) or vibration; an array of taxels is judged by gripctl calibrate";
        let text = format!("{}: no stylus and no vibration", recording.name);
        return Ok(vec![Finding::fault("sensor", text, remedy.to_owned())]);
    }
    let readings = Readings::of(&recording.samples);
    let bands = pipeline.detector.bands_at(pipeline.sample_rate.0)?;
    let mut found = vec![rate(recording, &pipeline, &bands), complete(recording, &readings)];
    let Some(rest) = rest(recording, &pipeline)? else {
        let text =
            "no reading is a number, or all are the same: a sensor at rest has noise".to_owned();
        let remedy = "check wiring and supply; tap the finger while you record";
        found.push(Finding::fault("sensor noise", text, remedy.to_owned()));
        return Ok(found);
    };
    found.extend([
        outliers(&rest, &readings, pipeline.sample_rate.0),
        steps(&readings, &rest),
        steady(&rest, recording),
        floor(&rest, recording, &bands, &smallest(&pipeline)?),
    ]);
    Ok(found)
}

/// Counts of readings.
struct Readings {
    all: f32,
    missing: f32,
    repeated: f32,
}

impl Readings {
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

/// Noise of a recording, isolated readings left out: mean energies of all of it, least and largest energy of a band in a stretch, the
/// smallest step, and how many isolated readings there were.
struct Rest {
    isolated: u64,
    energy: [f32; BANDS],
    unsteady: f32,
    step_rms: f32,
}

fn rest(recording: &Recording, pipeline: &PipelineConfig) -> Result<Option<Rest>, ConfigError> {
    let rate_hz = pipeline.sample_rate.0;
    let mut meter = RestMeter::new(&pipeline.detector, rate_hz)?;
    let mut parts = meter;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "samples")]
    let stretch = (STRETCH_S * rate_hz) as u64;
    let stretch = stretch.max(STRETCH);
    let mut range = [(f32::INFINITY, 0.0_f32); BANDS];
    let mut guard = Guard::new(pipeline.sample_rate);
    for sample in &recording.samples {
        let reading = guard.step(sample.vibration()).unwrap_or(sample.vibration());
        meter.push_vector(reading);
        parts.push_vector(reading);
        if parts.samples() >= stretch
            && let Some(energy) = parts.take()
        {
            for ((least, most), energy) in range.iter_mut().zip(energy) {
                (*least, *most) = (least.min(energy), most.max(energy));
            }
        }
    }
    let Some(energy) = meter.floor(pipeline.floor) else { return Ok(None) };
    let known = range.iter().filter(|(least, most)| *least > 0.0 && most.is_finite());
    let unsteady = known.map(|(least, most)| most / least).fold(1.0, f32::max);
    let step_rms = meter.least_energy(pipeline.floor).sqrt();
    Ok(Some(Rest { isolated: guard.isolated(), energy, unsteady, step_rms }))
}

/// Which bands the rate carries.
fn rate(recording: &Recording, pipeline: &PipelineConfig, bands: &Bands) -> Finding {
    let rate_hz = pipeline.sample_rate.0;
    let carried: Vec<String> = bands
        .iter()
        .flatten()
        .map(|band| format!("{:.0}-{:.0} Hz", band.low_hz, band.high_hz))
        .collect();
    let source = if recording.notes.given_rate_hz.is_some() { " (by --rate)" } else { "" };
    let text = format!("{rate_hz:.0} samples a second{source}: bands {}", carried.join(", "));
    if carried.len() == BANDS {
        return Finding::ok("sensor rate", text);
    }
    let remedy =
        "sample faster where the sensor can: all bands fit from 2.5 times their highest corner on";
    let below = if pipeline.detector.reaches_above_motion(rate_hz) {
        ""
    } else {
        "; none lies above the motion of hands and robots, so only slips that stay three times as loud as all motion before are found"
    };
    Finding::warning("sensor rate", text + below, remedy.to_owned())
}

/// Whether readings or times are missing.
fn complete(recording: &Recording, readings: &Readings) -> Finding {
    let notes = &recording.notes;
    let missing = readings.missing / readings.all;
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

/// Whether single readings leap away and back.
fn outliers(rest: &Rest, readings: &Readings, rate_hz: f32) -> Finding {
    if rate_hz < isolated::SINGLE_HZ {
        let text =
            format!("isolated readings are not looked for below {:.0} Hz", isolated::SINGLE_HZ);
        return Finding::ok("sensor outliers", text);
    }
    let share = rest.isolated as f32 / readings.all;
    let text = format!(
        "{} isolated readings ({:.4} %): each leaps out of the noise and the next is back, which no surface does; they are replaced before anything is decided",
        rest.isolated,
        100.0 * share
    );
    let remedy = "look for a loose wire, a missing shield or ground, or values that are read while they change: longer runs of wrong readings would be slips";
    // Noise that grows leaps until that is the usual step: what was no rest shows nothing here.
    let good = share < OUTLIERS || rest.unsteady > STEADY;
    Finding::judge(good, "sensor outliers", text, remedy)
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

/// Energy of each band over its floor that is a slip within [`Evidence::WITHIN_S`].
fn smallest(pipeline: &PipelineConfig) -> Result<[f32; BANDS], ConfigError> {
    let (readings, block_s) = pipeline.detector.readings_at(pipeline.sample_rate.0)?;
    let sum = AlarmSum::new(&pipeline.detector, &readings, block_s);
    Ok(sum.smallest(false, Evidence::WITHIN_S))
}

/// The noise, and the smallest slip over it.
fn floor(rest: &Rest, recording: &Recording, bands: &Bands, smallest: &[f32; BANDS]) -> Finding {
    let unit = if recording.channels.stylus == StylusKind::Vibration { "" } else { " m" };
    let found = bands
        .iter()
        .zip(rest.energy.iter().zip(smallest))
        .filter_map(|(band, (energy, over))| band.map(|band| (band, (over * energy).sqrt())));
    let noise = rest.energy.iter().sum::<f32>().sqrt();
    let mut text = format!("noise {noise:.2e}{unit} (rms, all bands)");
    if let Some((band, rms)) = found.min_by(|a, b| a.1.total_cmp(&b.1)) {
        text += &format!(
            "; a slip is found from {rms:.2e}{unit} in {:.0}-{:.0} Hz on, with the slack in force",
            band.low_hz, band.high_hz
        );
    }
    Finding::ok("sensor floor", text)
}
