//! `gripctl score`: labelled recordings against the detector.

use super::{calibrated_config, csv_options};
use crate::{cli::ScoreArgs, output, output::or_dash};
use grip_host::{
    exit::{Exit, WrongArgument},
    score::{RecordingScore, Total, score},
};

/// Less rest than this makes a floor that the next recording may contradict (s).
const SHORT_REST_S: f64 = 0.05;

pub(crate) fn run(args: &ScoreArgs) -> anyhow::Result<Exit> {
    if !(args.guard_ms >= 0.0 && args.guard_ms.is_finite()) {
        let message = format!("--guard-ms {}: expected 0 or more", args.guard_ms);
        return Err(WrongArgument(message).into());
    }
    let config = calibrated_config(args.config.as_deref(), args.calibration.as_deref())?;
    let score = score(&args.directory, &csv_options(&args.csv)?, &config, args.guard_ms)?;
    let origin = match &args.calibration {
        Some(file) => format!("taken from {}, measured on", file.display()),
        None => "measured on".to_owned(),
    };
    let pooled =
        if args.calibration.is_some() { "rest" } else { "labelled rest, pooled over the folder" };
    eprintln!(
        "noise floor {origin} {:.3} s of {pooled}: shear {:.3}, vibration {:.3} (rms)",
        score.floor_s,
        score.floor[0].sqrt(),
        score.floor[1].sqrt()
    );
    if score.floor_s < SHORT_REST_S {
        eprintln!(
            "warning: that is less than {SHORT_REST_S} s of rest; the floor, and with it every figure below, may be far off"
        );
    }
    let total = score.total(args.guard_ms);
    if args.json {
        for recording in &score.recordings {
            output::json(recording)?;
        }
        output::json(&total)?;
    } else {
        table(&score.recordings)?;
        summary(&total)?;
    }
    Ok(Exit::Done)
}

fn table(recordings: &[RecordingScore]) -> anyhow::Result<()> {
    let width = recordings.iter().map(|r| r.recording.len()).max().unwrap_or(0).max(9);
    output::line(&format!(
        "{:width$}  kind    material  onset s  alarm s  latency ms  travel mm",
        "recording"
    ))?;
    for r in recordings {
        let note = match (r.missed, r.early) {
            (true, _) => "  MISSED",
            (_, true) => "  EARLY",
            _ => "",
        };
        output::line(&format!(
            "{:width$}  {:6}  {:8}  {:>7}  {:>7}  {:>10}  {:>9}{note}",
            r.recording,
            r.kind,
            r.material,
            or_dash(r.onset_s, 3),
            or_dash(r.alarm_s, 3),
            or_dash(r.latency_ms, 1),
            or_dash(r.travel_mm, 3),
        ))?;
    }
    Ok(())
}

fn summary(total: &Total) -> anyhow::Result<()> {
    output::line("")?;
    if total.onsets > 0 {
        output::line(&format!(
            "onsets: {} recordings, {} missed, {} early (before onset - {} ms); latency median {} ms, 95 % {} ms; travel at the alarm median {} mm, 95 % {} mm",
            total.onsets,
            total.missed,
            total.early,
            total.guard_ms,
            or_dash(total.latency_ms.p50, 1),
            or_dash(total.latency_ms.p95, 1),
            or_dash(total.travel_mm.p50, 3),
            or_dash(total.travel_mm.p95, 3),
        ))?;
    }
    if total.steady > 0 {
        output::line(&format!(
            "steady: {} recordings, {} without alarm; first alarm after median {} ms, 95 % {} ms",
            total.steady,
            total.steady_missed,
            or_dash(total.steady_ms.p50, 1),
            or_dash(total.steady_ms.p95, 1),
        ))?;
    }
    if total.rest_s > 0.0 {
        output::line(&format!("rest: {:.1} s, {} false alarms", total.rest_s, total.rest_alarms))?;
    }
    Ok(())
}
