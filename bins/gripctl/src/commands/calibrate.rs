//! `gripctl calibrate`: floor, gate and thresholds from a recording without slip, or from a gripper.

use super::{
    host_config,
    measure::{Measured, measure},
};
use crate::{cli::CalibrateArgs, output};
use anyhow::Context as _;
use grip_eval::{
    calibrate::{Calibrated, calibrate, check_interval},
    certify::NotCertified,
};
use grip_record::outputs::OutputKind;
use grip_session::{
    calibration::{Calibration, LawEvidence, StylusCalibration, TaxelRest},
    exit::{Exit, WrongArgument},
};
use serde::Serialize;
use slip_core::pressure::PressureConfig;
use std::path::Path;

#[derive(Serialize)]
#[serde(tag = "type", rename = "calibration")]
struct Line<'a> {
    #[serde(flatten)]
    calibration: &'a Calibration,
}

const CALIBRATION: OutputKind = OutputKind {
    endings: &["toml"],
    strict: false,
    is_ours: |head| {
        head.starts_with(b"sample_rate_hz = ")
            && ["\n[evidence]", "\n[taxels]"].iter().any(|table| output::has(head, table))
    },
};

pub(crate) fn run(args: &CalibrateArgs) -> anyhow::Result<Exit> {
    let scene = args.port.as_deref().and_then(|port| port.strip_prefix("sim:")).map(Path::new);
    let inputs = [args.file.as_deref(), args.config.as_deref(), scene];
    let out = output::path(&args.output, CALIBRATION, &args.force, &inputs)?;
    let config = host_config(args.config.as_deref())?;
    check_interval(args.interval).map_err(|error| WrongArgument(error.to_string()))?;
    let (Measured { recording, lost }, place) = match (&args.port, &args.file) {
        (Some(port), _) => (measure(port, args, &config)?, port.clone()),
        (None, file) => {
            let file = file.as_deref().unwrap_or(Path::new(""));
            let recording = super::recording(file, &args.csv)?;
            (Measured { recording, lost: 0 }, file.display().to_string())
        }
    };
    let Calibrated { calibration, certified } =
        calibrate(&recording, &config, args.interval).context(place)?;
    out.write(toml::to_string(&calibration)?)?;
    if args.json {
        output::json(&Line { calibration: &calibration })?;
    } else {
        report(&calibration, &config.pressure)?;
    }
    if let Err(why) = certified {
        eprintln!("gripctl: no slip will be certified: {why}{}", next_step(&why, args));
    }
    if lost > 0 {
        eprintln!(
            "gripctl: {lost} samples were lost on the way; the gaps can only raise the thresholds: measure again on an idle computer"
        );
        return Ok(Exit::DataLost);
    }
    Ok(if recording.notes.cut { Exit::DataLost } else { Exit::Done })
}

/// What to type where a longer recording can carry the certificate.
fn next_step(why: &NotCertified, args: &CalibrateArgs) -> String {
    let longer_s = (2.0 * args.rest_s).max(60.0);
    let output = args.output.display();
    match (why, &args.port) {
        (NotCertified::Array, _) => String::new(),
        (_, Some(port)) => format!(
            "; measure longer: `gripctl calibrate --port {port} --rest-s {longer_s:.0} -o {output}`"
        ),
        (_, None) => format!(
            "; record {longer_s:.0} s or more without slip, then type `gripctl calibrate LONGER.csv -o {output}`"
        ),
    }
}

fn report(calibration: &Calibration, pressure: &PressureConfig) -> anyhow::Result<()> {
    let calibration = match calibration {
        Calibration::Stylus(calibration) => calibration,
        Calibration::Array(array) => return report_taxels(&array.taxels, pressure),
    };
    let StylusCalibration { thresholds, cusum_threshold, evidence, .. } = calibration;
    output::line(&format!(
        "floor from {:.1} s of rest, gate from {:.1} s of motion{}",
        evidence.rest_s,
        evidence.motion_s,
        if calibration.gain.is_some() {
            ""
        } else {
            " (too little: the default gate stays, and no threshold goes below its default)"
        }
    ))?;
    if evidence.unexplained_s > 0.0 {
        let [at_s, length_s] = evidence.unexplained_longest.unwrap_or_default();
        output::line(&format!(
            "left out as unexplained: {:.2} s of rest, loud without motion of the reference, the longest {length_s:.2} s at {at_s:.2} s; floor and thresholds know nothing of it. Look whether it is a slip: there it would be reported, as it should; a knock or other work would be a false alarm",
            evidence.unexplained_s
        ))?;
    }
    output::line(&format!(
        "thresholds: bands {thresholds:.1?}, cumulative sum {cusum_threshold:.1}"
    ))?;
    if let Some(rest) = evidence.smallest_rest {
        let unit = if calibration.vibration { "" } else { " m" };
        let motion = evidence
            .smallest_motion
            .map_or_else(String::new, |motion| format!(", in motion from {motion:.2e}{unit} on"));
        output::line(&format!(
            "the fast trigger finds a slip at rest from {rest:.2e}{unit} of vibration (rms, 100-400 Hz) on{motion}"
        ))?;
    }
    if let Some(taxels) = &calibration.taxels {
        report_taxels(taxels, pressure)?;
    }
    let high = evidence
        .interval_high_s
        .map_or_else(|| "without upper bound".to_owned(), |high| format!("up to {high:.0} s"));
    output::line(&format!(
        "fast trigger, wanted: one false alarm in {:.0} s; seen: {} in {:.0} s not used for the thresholds, so one in {:.0} s or more, {high} (95 %)",
        evidence.wanted_interval_s, evidence.alarms, evidence.judged_s, evidence.interval_low_s
    ))?;
    if evidence.extrapolation > 1.0 {
        output::line(&format!(
            "the thresholds are extrapolated: the tail of each test was continued {:.1} times beyond the recording; record {:.0} s to measure the wanted interval itself. Without extrapolation the fast trigger claims one in {:.0} s",
            evidence.extrapolation,
            10.0 * evidence.wanted_interval_s,
            evidence.claimed_s.unwrap_or(0.0)
        ))?;
    }
    certificate(calibration)
}

/// Noise and range, and the smallest change of the pattern that is a slip.
fn report_taxels(taxels: &TaxelRest, pressure: &PressureConfig) -> anyhow::Result<()> {
    let TaxelRest { rms, range } = *taxels;
    let range = range.map_or_else(
        || ", no range: no stretch of rest was 2 s long, so slow slips are judged by what the first grasps show".to_owned(),
        |range| format!(", range {range:.3e}; a slow slip is found from that range on"),
    );
    let smallest = rms * pressure.threshold.sqrt();
    Ok(output::line(&format!(
        "taxels at rest: noise {rms:.3e} (rms){range}. A slip is found from a change of the pattern by {smallest:.3e} (rms over the taxels) on"
    ))?)
}

fn certificate(calibration: &StylusCalibration) -> anyhow::Result<()> {
    let Some(certified) = &calibration.certified else { return Ok(()) };
    output::line(&format!(
        "certified alarm: one false alarm in {:.0} s or more, whatever the law of the noise (95 %); limits from halves gave {} in {:.0} s of the other, so one in {:.0} s or more",
        calibration.evidence.wanted_interval_s,
        certified.alarms,
        certified.judged_s,
        certified.interval_low_s
    ))?;
    for (place, law) in [("at rest", certified.rest), ("in motion", certified.motion)] {
        let Some(LawEvidence { seconds, blocks_ms: [short, long], clusters, soonest_ms }) = law
        else {
            output::line(&format!("  {place}: too little of it, nothing is certified"))?;
            continue;
        };
        output::line(&format!(
            "  {place}: {seconds:.0} s, blocks of {short:.0} to {long:.0} ms, high blocks follow each other up to {clusters:.1} times as often as independent ones; a clear slip is certified within {soonest_ms:.0} ms and one block"
        ))?;
    }
    Ok(())
}
