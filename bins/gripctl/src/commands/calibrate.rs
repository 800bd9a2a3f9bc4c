//! `gripctl calibrate`: floor, gate and slack from a recording without slip, or from a gripper.

use super::{
    host_config,
    measure::{Measured, measure},
};
use crate::{cli::CalibrateArgs, output};
use anyhow::Context as _;
use grip_eval::{
    calibrate::{Calibrated, MOTION_S, STEADY, calibrate, check_interval},
    certify::NotCertified,
};
use grip_record::outputs::OutputKind;
use grip_session::{
    calibration::{Calibration, Evidence, LawEvidence, StylusCalibration, TaxelRest},
    exit::{Exit, WrongArgument},
};
use serde::Serialize;
use slip_core::{detector::COMPONENTS, pressure::PressureConfig};
use std::path::Path;

#[derive(Serialize)]
#[serde(tag = "type", rename = "calibration")]
struct Line<'a> {
    #[serde(flatten)]
    calibration: &'a Calibration,
}

/// Slack that noise alone does not need.
const HIGH: f32 = 10.0;

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
            "gripctl: {lost} samples were lost on the way; the gaps can only raise the slack: measure again on an idle computer"
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
    let evidence = &calibration.evidence;
    output::line(&format!(
        "floor from {:.1} s of stillness, gate from {:.1} s of motion{}",
        evidence.rest_s,
        evidence.motion_s,
        missing_motion(calibration)
    ))?;
    let [still, moving] = [calibration.slack_still, calibration.slack_moving].map(shown);
    output::line(&format!("slack: still {still}, moving {moving}"))?;
    let unit = if calibration.vibration { "" } else { " m" };
    if let Some(rest) = evidence.smallest_rest {
        let motion = evidence
            .smallest_motion
            .map_or_else(String::new, |motion| format!(", in motion from {motion:.2e}{unit} on"));
        output::line(&format!(
            "the fast trigger finds a slip at rest from {rest:.2e}{unit} of vibration (rms, 100-400 Hz) on{motion}"
        ))?;
    }
    for warning in warnings(calibration, unit) {
        output::line(&warning)?;
    }
    if let Some(taxels) = &calibration.taxels {
        report_taxels(taxels, pressure)?;
    }
    output::line(&format!(
        "fast trigger, wanted: one false alarm in {:.0} s; seen: {} slips in a replay of this recording; {}",
        evidence.wanted_interval_s,
        evidence.seen,
        promise(evidence)
    ))?;
    certificate(calibration)
}

/// What to record where the motion was too short for a gate.
fn missing_motion(calibration: &StylusCalibration) -> String {
    if calibration.gain.is_some() {
        return String::new();
    }
    let missing_s = (MOTION_S - calibration.evidence.motion_s).max(0.1);
    let remedy = if calibration.reference_floor.is_some() {
        "record the robot moving as it does at work, nothing slipping"
    } else {
        "add a motion reference, or a column `motion` (0 or 1), and record the robot moving as it does at work"
    };
    format!(
        "; the default gate stays, and slack in motion is not below its default: {missing_s:.1} s of motion are missing: {remedy}"
    )
}

/// The slack of each component.
fn shown(slack: [f32; COMPONENTS]) -> String {
    slack
        .map(|slack| format!("{slack:.3}").trim_end_matches('0').trim_end_matches('.').to_owned())
        .join(" ")
}

/// What the calibration cannot promise.
fn warnings(calibration: &StylusCalibration, unit: &str) -> Vec<String> {
    let evidence = &calibration.evidence;
    let mut warnings = Vec::new();
    if evidence.unexplained_s > 0.0 {
        let [at_s, length_s] = evidence.unexplained_longest.unwrap_or_default();
        warnings.push(format!(
            "left out of the floor as unexplained: {:.2} s of stillness, loud without motion of the reference, the longest {length_s:.2} s at {at_s:.2} s. Look whether it is a slip: the slack takes it for work, so that slips like it are not reported",
            evidence.unexplained_s
        ));
    }
    let slack =
        calibration.slack_still.into_iter().chain(calibration.slack_moving).fold(0.0, f32::max);
    let changes = evidence.unsteady > STEADY;
    if changes || slack > HIGH {
        let what = if changes {
            format!("stillness is not steady: its energy changes by {:.0} times", evidence.unsteady)
        } else {
            "something is far louder than the noise now and then".to_owned()
        };
        let below = evidence.smallest_rest.unwrap_or(f32::INFINITY);
        warnings.push(format!(
            "{what} (hum, a machine, knocks, or slips?): slack up to {slack:.0}; vibration below {below:.2e}{unit} rms is no slip while this calibration is in force; where something slipped, record again"
        ));
    }
    if evidence.seen > 0 {
        warnings.push(format!(
            "{} slips remain in this recording: no slack takes them away, and they will be reported; look at them with `gripctl replay`, and record again without them",
            evidence.seen
        ));
    }
    warnings
}

/// What is promised, and under which condition.
fn promise(evidence: &Evidence) -> String {
    if evidence.judged_s == 0.0 {
        return "nothing is promised beyond it: no band of this rate lies above motion, so the level decides, and that knows no interval".to_owned();
    }
    let Evidence { alarms, judged_s, interval_low_s, wanted_interval_s, .. } = *evidence;
    let longer = if interval_low_s < wanted_interval_s {
        // Half of it judges, and three times the interval is needed without an alarm.
        format!("; to promise what is wanted, record {:.0} s", 6.0 * wanted_interval_s)
    } else {
        String::new()
    };
    format!(
        "{alarms} alarms in {judged_s:.0} s that the slack was not taken from, so one in {interval_low_s:.0} s or more (95 %), if what comes is like this recording{longer}"
    )
}

/// Noise and range, and the smallest change of the pattern that is a slip.
fn report_taxels(taxels: &TaxelRest, pressure: &PressureConfig) -> anyhow::Result<()> {
    let TaxelRest { rms, range } = *taxels;
    let range = range.map_or_else(
        || ", no range: no stretch of stillness was 2 s long, so slow slips are judged by what the first grasps show".to_owned(),
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
