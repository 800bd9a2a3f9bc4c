//! `gripctl import`: a recording of another program as one of this project.

use super::{
    csv_options,
    replay::is_mcap,
    source::{About, Source},
};
use crate::{cli::import::ImportArgs, output};
use anyhow::Context as _;
use grip_import::{ImportError, ImportOptions, Imported, Use};
use grip_record::{
    ChannelSet, CsvOptions, CsvWriter, Recording, is_npz,
    mcap::{McapWriter, Record, SampleRecord},
    outputs::{OutputFile, OutputKind, OutputPath},
};
use grip_session::{
    HostConfig,
    exit::{Exit, WrongArgument, escape},
    model,
    recording::{ABOUT, PART, RUN, event_record, pipeline_record},
    replay,
    report::EventLog,
    session::Beginning,
};
use serde::Serialize;
use slip_core::Pipeline;
use std::{collections::BTreeMap, path::Path};

/// Names that are shown of what is not used.
const MOST_UNUSED: usize = 20;

#[derive(Serialize)]
#[serde(tag = "type", rename = "channel")]
struct ChannelLine<'a> {
    column: &'a str,
    signal: &'a str,
    unit: &'a str,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "import")]
struct Summary<'a> {
    format: &'a str,
    times: &'a str,
    rate_hz: f32,
    samples: usize,
    duration_s: f64,
    gaps: usize,
    unused: &'a [String],
    notes: &'a [String],
    output: Option<String>,
}

pub(crate) fn run(args: &ImportArgs) -> anyhow::Result<Exit> {
    let out = args
        .output
        .as_ref()
        .map(|output| OutputPath::new(output, RECORDING, [args.file.as_path()], Some(args.force)));
    let out = out.transpose()?;
    let options = ImportOptions {
        topics: args.topic.clone(),
        finger: args.finger,
        ..import_options(&csv_options(&args.csv)?)
    };
    let wrong = |error: ImportError| WrongArgument(error.to_string());
    // The arrays of an .npz stand one behind the other, so its samples are held.
    let hold = args.output.as_deref().is_some_and(is_npz);
    let read = if hold { grip_import::import } else { grip_import::open };
    let imported = read(&args.file, &options).map_err(wrong)?;
    let (about, source) = Source::of(imported);
    if let Some(out) = &out {
        refuse_axes(&source.recording, out.file())?;
        let mut file = out.create()?;
        write(&source, out.file(), &mut file)
            .with_context(|| format!("cannot write {}", out.file().display()))?;
        file.finish()?;
    }
    show(&about, &source, args)?;
    Ok(if source.recording.notes.cut { Exit::DataLost } else { Exit::Done })
}

/// A recording of another program with its samples; what is taken for what, on standard error.
pub(super) fn shown(file: &Path, csv: &CsvOptions) -> anyhow::Result<Recording> {
    let imported = grip_import::import(file, &import_options(csv));
    Ok(said(file, imported)?.recording)
}

/// The same; its samples are held only where the file cannot be read a second time.
pub(super) fn opened(file: &Path, csv: &CsvOptions) -> Result<Imported, WrongArgument> {
    said(file, grip_import::open(file, &import_options(csv)))
}

/// A file that cannot be used is a wrong argument.
fn said(file: &Path, imported: Result<Imported, ImportError>) -> Result<Imported, WrongArgument> {
    let imported = imported.map_err(|error| WrongArgument(error.to_string()))?;
    show_uses(file, &imported.uses);
    for note in &imported.notes {
        output::remark(file.display(), note);
    }
    Ok(imported)
}

/// What is taken for what, on standard error; nothing where every name and unit is that of a recording.
pub(super) fn show_uses(file: &Path, uses: &[Use]) {
    #[expect(clippy::float_cmp, reason = "exactly 1 changes nothing")]
    let own = |used: &Use| used.ours == used.theirs && used.scale == 1.0;
    if uses.iter().all(own) {
        return;
    }
    for line in use_lines(uses) {
        output::remark(file.display(), line.trim_start());
    }
}

fn import_options(csv: &CsvOptions) -> ImportOptions {
    let CsvOptions { rate_hz, map, time_unit, finger } = csv.clone();
    ImportOptions { rate_hz, map, time_unit, finger, topics: Vec::new() }
}

/// A recording as it is written.
const RECORDING: OutputKind =
    OutputKind { endings: &["csv", "npz", "mcap"], strict: true, is_ours: |_| false };

/// Messages of a recording have one axis a sensor.
fn refuse_axes(recording: &Recording, output: &Path) -> Result<(), WrongArgument> {
    let ChannelSet { axes, reference_axes, .. } = &recording.channels;
    if !is_mcap(output) || (axes.is_empty() && reference_axes.is_empty()) {
        return Ok(());
    }
    Err(WrongArgument(format!(
        "-o {}: an .mcap has one axis a sensor; write .csv or .npz, or choose an axis with --map",
        output.display()
    )))
}

/// The recording as gripd would have made it, with the events of the shipped settings: what `replay` of the CSV shows.
fn write_mcap(source: &Source, out: &mut OutputFile) -> anyhow::Result<()> {
    let recording = &source.recording;
    let config = replay::pipeline_config(recording, &HostConfig::default(), false);
    let mut events = Pipeline::new(config, Some(model::default_estimator()?))?;
    let program = concat!("gripctl ", env!("CARGO_PKG_VERSION"));
    let mut writer = McapWriter::new(out, program, 0)?;
    let facts = [("program", program), (RUN, &recording.name), (PART, "0")];
    let facts = facts.map(|(name, value)| (name.to_owned(), value.to_owned()));
    writer.metadata(ABOUT, &BTreeMap::from(facts))?;
    let beginning = Beginning {
        config,
        carried_n: None,
        least_n: 0.0,
        released: false,
        taxels: recording.channels.taxels,
    };
    let (mut json, mut log) = (Vec::new(), EventLog::default());
    writer.write(0, &Record::Pipeline(pipeline_record(&beginning, &mut json)?))?;
    let bar = output::progress(source.count, "samples");
    let mut index = 0_u32;
    source.each(|sample, taxels| {
        let record = SampleRecord { index, sample: *sample, taxels };
        writer.write(sample.t.0, &Record::Sample(record))?;
        let step = events.handle_with(sample, taxels);
        for line in log.events(&step).into_iter().flatten() {
            writer.write(sample.t.0, &Record::Event(event_record(&line, &mut json)?))?;
        }
        index = index.wrapping_add(1);
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    writer.finish()?;
    Ok(())
}

fn write(source: &Source, file: &Path, out: &mut OutputFile) -> anyhow::Result<()> {
    if is_mcap(file) {
        return write_mcap(source, out);
    }
    if is_npz(file) {
        return Ok(source.recording.write_npz(out)?);
    }
    let mut writer = CsvWriter::new(out, &source.recording.channels)?;
    let bar = output::progress(source.count, "samples");
    source.each(|sample, frame| {
        bar.inc(1);
        Ok(writer.write_with(sample, frame)?)
    })?;
    bar.finish_and_clear();
    writer.finish()?;
    Ok(())
}

fn show(about: &About, source: &Source, args: &ImportArgs) -> anyhow::Result<()> {
    let About { format, clock, uses, unused, notes } = about;
    let (recording, samples, duration_s) = (&source.recording, source.count, source.duration_s()?);
    let times = if clock.is_empty() { "--rate" } else { clock };
    let mut notes = notes.clone();
    notes.extend(Some(recording.notes.to_string()).filter(|text| !text.is_empty()));
    let output = args.output.as_ref().map(|output| output.display().to_string());
    if args.json {
        for Use { ours, theirs, unit, .. } in uses {
            output::json(&ChannelLine { column: ours, signal: theirs, unit })?;
        }
        return output::json(&Summary {
            format,
            times,
            rate_hz: recording.rate_hz,
            samples,
            duration_s,
            gaps: recording.notes.gaps,
            unused,
            notes: &notes,
            output,
        });
    }
    output::line(&format!("{}: {format}, times from {times}", args.file.display()))?;
    for line in use_lines(uses) {
        output::line(&line)?;
    }
    if !unused.is_empty() {
        let shown: Vec<String> = unused.iter().take(MOST_UNUSED).map(|name| escape(name)).collect();
        let shown = shown.join(", ");
        let more = unused.len().saturating_sub(MOST_UNUSED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        output::line(&format!("  not used: {shown}{more}"))?;
    }
    for note in &notes {
        output::line(&format!("  {}", escape(note)))?;
    }
    output::line(&format!(
        "{samples} samples in {duration_s:.3} s at {:.1} Hz{}",
        recording.rate_hz,
        output.map_or_else(
            || "; nothing written without -o FILE.csv, FILE.npz or FILE.mcap".to_owned(),
            |output| format!(" -> {output}")
        )
    ))?;
    Ok(())
}

/// What was taken for what; the taxels of an array in one line.
fn use_lines(uses: &[Use]) -> Vec<String> {
    let is_taxel = |used: &&Use| {
        used.ours.strip_prefix("pressure_").is_some_and(|k| k.parse::<usize>().is_ok())
    };
    let mut lines: Vec<String> = uses
        .iter()
        .filter(|used| !is_taxel(used))
        .map(|Use { ours, theirs, unit, .. }| format!("  {} -> {ours} ({unit})", escape(theirs)))
        .collect();
    let taxels: Vec<&Use> = uses.iter().filter(is_taxel).collect();
    let place =
        |wanted: usize| taxels.iter().find(|used| used.ours == format!("pressure_{wanted}"));
    if let Some((first, last)) = place(0).zip(place(taxels.len().saturating_sub(1))) {
        lines.push(format!(
            "  {} .. {} -> pressure_0 .. pressure_{} ({})",
            escape(&first.theirs),
            escape(&last.theirs),
            taxels.len() - 1,
            first.unit
        ));
    }
    lines
}
