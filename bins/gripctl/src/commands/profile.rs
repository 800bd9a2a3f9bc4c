//! `gripctl profile`: a height profile measured.

use super::{checked, esc, profile_plot};
use crate::{
    cli::{Filter, ProfileArgs},
    output, table,
};
use anyhow::Context as _;
use grip_eval::{
    profile::{Agreement, Evaluation, ProfileLine, ProfileOptions, evaluate},
    roughness::FilterKind,
};
use grip_record::{
    HeightProfile,
    outputs::{OutputKind, OutputPath},
};
use grip_session::exit::{Exit, WrongArgument, escape};
use serde_json::json;
use std::{io::Write as _, path::Path};

/// Columns of the parts: no other command writes them.
const PARTS_HEADER: &str = "x_mm,height_um,form_um,waviness_um,roughness_um";
const PARTS: OutputKind =
    OutputKind { is_ours: |head| head.starts_with(PARTS_HEADER.as_bytes()), ..output::TABLE };

pub(crate) fn run(args: &ProfileArgs) -> anyhow::Result<Exit> {
    let trial = esc::trial(args.force, args.speed, args.noise)?;
    let options = options(args)?;
    let step_m = args.step_um.map(|um| checked("--step-um", um, false)).transpose()?;
    let step_m = step_m.map(|um| um * 1e-6);
    let inputs = || [Some(args.file.as_path()), args.reference.as_deref()].into_iter().flatten();
    let out = |file: &Path, kind| OutputPath::new(file, kind, inputs(), None);
    let plot = args.plot.as_deref().map(|file| out(file, output::PICTURE)).transpose()?;
    let parts = args.parts.as_deref().map(|file| out(file, PARTS)).transpose()?;
    let profile = HeightProfile::read(&args.file, step_m)?;
    let evaluation =
        evaluate(&profile, &options).with_context(|| args.file.display().to_string())?;
    let mut line = ProfileLine::new(&evaluation, &options, &trial);
    if let Some(reference) = &args.reference {
        line.reference = Some(compare(&evaluation, reference)?);
    }
    if let Some(plot) = &plot {
        let name = args.file.file_stem().unwrap_or_default().to_string_lossy();
        output::draw(&profile_plot::chart(&name, &profile, &evaluation, args.level), plot)?;
    }
    if let Some(parts) = &parts {
        write_parts(parts, &profile, &evaluation)?;
    }
    let left_out = profile.left_out.iter().map(ToString::to_string);
    for warning in line.warnings.iter().cloned().chain(left_out) {
        output::note(&format!("{}: {}", args.file.display(), escape(&warning)));
    }
    if args.json {
        output::json(&line)?;
    } else {
        print(&line, args.level)?;
    }
    let is_lost = profile.left_out.iter().any(|loss| loss.is_data());
    Ok(if is_lost { Exit::DataLost } else { Exit::Done })
}

fn options(args: &ProfileArgs) -> Result<ProfileOptions, WrongArgument> {
    let usual = ProfileOptions::new(1e-3 * checked("--cutoff-mm", args.cutoff_mm, false)?);
    let metres = |flag, um: Option<f64>, usual_m| {
        um.map_or(Ok(usual_m), |um| Ok(1e-6 * checked(flag, um, true)?))
    };
    let long_cutoff = args.lambda_f_mm.map(|mm| checked("--lambda-f-mm", mm, false)).transpose()?;
    let hysteresis =
        args.hysteresis_um.map(|um| checked("--hysteresis-um", um, true)).transpose()?;
    Ok(ProfileOptions {
        short_cutoff_m: metres("--lambda-s-um", args.lambda_s_um, usual.short_cutoff_m)?,
        low_pass_m: metres("--low-pass-um", args.low_pass_um, usual.low_pass_m)?,
        filter: match args.filter {
            Filter::MovingAverage => FilterKind::MovingAverage,
            Filter::Gaussian => FilterKind::Gaussian,
        },
        long_cutoff_m: long_cutoff.map(|mm| mm * 1e-3),
        form_degree: args.form_degree,
        level: args.level,
        hysteresis_m: hysteresis.map(|um| um * 1e-6),
        ..usual
    })
}

/// One row for each height; waviness and form are counted from their own mean lines.
fn write_parts(
    out: &OutputPath,
    profile: &HeightProfile,
    evaluation: &Evaluation,
) -> anyhow::Result<()> {
    let mut out = out.create()?;
    writeln!(out, "{PARTS_HEADER}")?;
    let Evaluation { form_m, waviness_m, roughness_m, .. } = evaluation;
    let parts = form_m.iter().zip(waviness_m).zip(roughness_m);
    for (i, (height, ((form, waviness), roughness))) in
        profile.heights_m.iter().zip(parts).enumerate()
    {
        let x_mm = 1e3 * profile.step_m * i as f64;
        let [height, form, waviness, roughness] =
            [height, form, waviness, roughness].map(|z| 1e6 * z);
        writeln!(out, "{x_mm:.6},{height:.4},{form:.4},{waviness:.4},{roughness:.4}")?;
    }
    Ok(out.finish()?)
}

fn compare(evaluation: &Evaluation, file: &Path) -> anyhow::Result<Agreement> {
    let theirs = HeightProfile::read(file, Some(evaluation.step_m))?;
    let (ours, heights) = (&evaluation.roughness_m, &theirs.heights_m);
    Agreement::of(ours, heights).with_context(|| {
        format!(
            "{}: {} heights, but the profile has {}; both must be of the same trace",
            file.display(),
            heights.len(),
            ours.len()
        )
    })
}

fn print(line: &ProfileLine, level: bool) -> anyhow::Result<()> {
    output::line(&format!(
        "profile        {:.3} mm, {:.4} um a step, noise {:.4} um (rms)",
        line.length_mm, line.step_um, line.noise_um
    ))?;
    output::line(&format!(
        "filters        {}, lambda_c {} mm, lambda_s {} um, {} sections, {} mm left out at either end",
        line.filter.replace('_', " "),
        line.cutoff_mm,
        short(line.lambda_s_um),
        line.sections,
        short(line.ends_mm)
    ))?;
    output::line(&format!(
        "roughness      Ra {:.4}  Rq {:.4}  Rz {:.3}  RSm {}  strongest wave {} um",
        line.ra_um,
        line.rq_um,
        line.rz_um,
        output::or_dash(line.rsm_um, 1),
        output::or_dash(line.period_um, 1)
    ))?;
    output::line(&waviness(line))?;
    if let Some(reference) = &line.reference {
        output::line(&format!(
            "reference      correlation {:.6}, Ra {:+.2} %, difference {:.4} um (rms)",
            reference.correlation,
            100.0 * (reference.ra_ratio - 1.0),
            reference.rms_um
        ))?;
    }
    output::line(&format!(
        "irregularities {}, hysteresis {:.3} um, after a low-pass of {} um",
        line.n,
        line.hysteresis_um,
        short(line.low_pass_um)
    ))?;
    output::line("")?;
    let spread = |name, spread| json!({"um": name, "of": spread});
    let rows = [spread("height delta", line.delta_um), spread("spacing s", line.s_um)];
    let least = ["um", "mean=of.mean", "sd=of.sd", "min=of.min", "10 %=of.p10"];
    let most = ["median=of.p50", "90 %=of.p90", "max=of.max"];
    table::print(&rows, &[&least[..], &most].concat())?;
    output::line("")?;
    output::line(&format!(
        "E_sc at {} N and {} m/s, {:.4} s to pass the profile",
        line.force_n, line.speed_m_s, line.contact_time_s
    ))?;
    esc::table(&line.esc)?;
    output::line("")?;
    output::line(&format!(
        "the same with waviness{}, of {} irregularities (primary profile)",
        if level { "" } else { " and form" },
        line.primary.n
    ))?;
    esc::table(&line.primary.esc)
}

/// Wa and Wz, or what the profile is too short for.
fn waviness(line: &ProfileLine) -> String {
    let form = match line.form_degree {
        1 => "line".to_owned(),
        degree => format!("polynomial of degree {degree}"),
    };
    let above = format!("above a {form}, {:.3} um high", line.form_um);
    match (line.wa_um, line.wz_um, line.waviness_sections) {
        (Some(wa), Some(wz), Some(sections)) => format!(
            "waviness       Wa {wa:.4}  Wz {wz:.3}  {}, {sections} sections, {above}",
            line.lambda_f_mm.map_or("no lambda_f".to_owned(), |mm| format!("lambda_f {mm} mm")),
        ),
        _ => format!(
            "waviness       not measured: it needs {} mm of profile; {above}",
            short(line.waviness_needs_mm)
        ),
    }
}

/// A length of an option without the digits of a division.
fn short(um: f64) -> String {
    let text = format!("{um:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
