//! `gripctl csv`: the samples of MCAP recordings as one CSV file or `.npz`.

use crate::{cli::CsvExportArgs, output};
use anyhow::Context as _;
use grip_record::{
    ChannelSet, CsvWriter, Notes, Recording, StylusKind, Taxels, is_npz,
    mcap::{Entry, McapError, McapReader, PipelineRecord, Record, SampleRecord},
    outputs::{OutputFile, OutputPath},
};
use grip_session::{
    exit::{Exit, WrongArgument},
    recording,
};
use slip_core::Signal;
use std::path::Path;

/// Where samples go.
enum Writer {
    Csv(CsvWriter<OutputFile>),
    /// Columns are written one after the other, so all samples are kept until then.
    Npz(Box<Recording>),
}

/// The pipeline that is wanted, on its way to the file.
struct Export<'a> {
    args: &'a CsvExportArgs,
    out: OutputPath,
    writer: Option<Writer>,
    /// Pipelines that began so far.
    pipelines: u64,
    rows: u64,
}

pub(crate) fn run(args: &CsvExportArgs) -> anyhow::Result<Exit> {
    let inputs: Vec<_> = args.files.iter().map(|file| Some(file.as_path())).collect();
    let out = output::path(&args.output, output::COLUMNS, &args.force, &inputs)?;
    let mut export = Export { args, out, writer: None, pipelines: 0, rows: 0 };
    let mut cut = false;
    for file in &args.files {
        match export.read(file) {
            Err(error) if is_cut(&error) && export.rows > 0 => {
                output::remark("gripctl", error);
                cut = true;
                break;
            }
            other => other?,
        }
    }
    let (pipelines, rows) = (export.pipelines, export.rows);
    let Some(writer) = export.writer else {
        let wanted = args.pipeline.unwrap_or(1);
        anyhow::bail!(
            "no samples: the recording has {pipelines} pipelines, and {wanted} was wanted"
        );
    };
    let name = || format!("cannot write {}", args.output.display());
    match writer {
        Writer::Csv(writer) => writer.finish().with_context(name)?.finish()?,
        Writer::Npz(recording) => {
            let mut out = export.out.create()?;
            recording.write_npz(&mut out).with_context(name)?;
            out.finish()?;
        }
    }
    output::line(&format!("{}: {rows} samples", args.output.display()))?;
    Ok(if cut { Exit::DataLost } else { Exit::Done })
}

/// Whether a file is only at fault at its end.
fn is_cut(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(McapError::Truncated { .. } | McapError::Damaged { .. }))
}

impl Export<'_> {
    fn read(&mut self, file: &Path) -> anyhow::Result<()> {
        let mut reader = McapReader::open(file)?.read_ahead()?;
        while let Some(entry) = reader.next_entry()? {
            match entry {
                Entry::Message { record: Record::Pipeline(begun), .. } => {
                    self.begin(file, &begun)?
                }
                Entry::Message { record: Record::Sample(sample), .. } => self.write(&sample)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// The columns of a recording that gripd makes itself: replaying it gives the same events.
    fn begin(&mut self, file: &Path, begun: &PipelineRecord<'_>) -> anyhow::Result<()> {
        if begun.continued && self.pipelines > 0 {
            return Ok(());
        }
        self.pipelines += 1;
        if self.args.pipeline.is_none() && self.pipelines > 1 && self.rows > 0 {
            return Err(WrongArgument(format!(
                "{}: has more than one pipeline, and times start again with each; choose one with --pipeline N",
                file.display()
            ))
            .into());
        }
        if !self.wanted() {
            return Ok(());
        }
        let beginning = recording::beginning(begun)
            .with_context(|| format!("{}: the settings of its pipeline", file.display()))?;
        let stylus = match beginning.config.signal {
            Signal::Displacement => StylusKind::Displacement,
            Signal::Vibration => StylusKind::Vibration,
        };
        let channels = ChannelSet::all(stylus).with_taxels(beginning.taxels).with_arrivals();
        let name = || format!("cannot write {}", self.args.output.display());
        self.writer = Some(if is_npz(&self.args.output) {
            let taxels = Some(Taxels::new(channels.taxels)).filter(|taxels| taxels.count() > 0);
            let (rate_hz, notes) = (beginning.config.sample_rate.0, Notes::default());
            let (name, samples) = (String::new(), Vec::new());
            Writer::Npz(Box::new(Recording { name, channels, samples, taxels, rate_hz, notes }))
        } else {
            Writer::Csv(CsvWriter::new(self.out.create()?, &channels).with_context(name)?)
        });
        Ok(())
    }

    fn write(&mut self, record: &SampleRecord<'_>) -> anyhow::Result<()> {
        if !self.wanted() {
            return Ok(());
        }
        match &mut self.writer {
            Some(Writer::Csv(writer)) => {
                let name = || format!("cannot write {}", self.args.output.display());
                writer.write_with(&record.sample, record.taxels).with_context(name)?;
            }
            Some(Writer::Npz(recording)) => {
                recording.samples.push(record.sample);
                if let Some(taxels) = &mut recording.taxels {
                    taxels.push(record.taxels);
                }
            }
            None => return Ok(()),
        }
        self.rows += 1;
        Ok(())
    }

    fn wanted(&self) -> bool {
        self.args.pipeline.is_none_or(|wanted| wanted == self.pipelines)
    }
}
