//! `gripctl export`: a model file as C source or as an ONNX graph, with its model card.

use super::{card, export_verify, model_file};
use crate::cli::learn::{ExportArgs, ExportFormat};
use crate::output;
use grip_record::outputs::OutputKind;
use grip_session::exit::{Exit, WrongArgument};
use mlp::export::card::{CardExport, CardFile, CardVerified};
use mlp::export::{c, onnx};
use mlp::train::ModelFile;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
#[serde(tag = "type", rename = "export")]
struct Result<'a> {
    format: &'a str,
    files: Vec<String>,
    card: String,
    verified: Option<CardVerified>,
}

/// C source and header, or a graph, of this command.
const EXPORT: OutputKind = OutputKind {
    endings: &["c", "h", "onnx"],
    strict: false,
    is_ours: |head| {
        output::has(head, ": a network of ")
            || output::has(head, "Made by gripctl export")
            || head.get(2..).is_some_and(|head| head.starts_with(b"\x12\x07gripctl"))
    },
};

/// A file to be written.
struct Output {
    path: PathBuf,
    bytes: Vec<u8>,
}

pub(crate) fn run(args: &ExportArgs) -> anyhow::Result<Exit> {
    let (file, text) = model_file(&args.model)?;
    let origin = file_name(&args.model);
    let (outputs, verified) = match args.format {
        ExportFormat::C => c_files(args, &file, &origin)?,
        ExportFormat::Onnx => (onnx_file(args, &file, &origin)?, None),
    };
    let beside = outputs.first().map_or(args.model.as_path(), |output| &output.path);
    let taken: Vec<&Path> = outputs.iter().map(|output| output.path.as_path()).collect();
    let inputs = [Some(args.model.as_path())];
    let card_out = card::output(args.card.as_deref(), beside, &args.force, &inputs, &taken)?;
    let made = |output: &Output| output::path(&output.path, EXPORT, &args.force, &inputs);
    let made = outputs.iter().map(made).collect::<core::result::Result<Vec<_>, _>>()?;
    made.iter().zip(&outputs).try_for_each(|(out, output)| out.write(&output.bytes))?;
    let kind = args.format.kind();
    let files = outputs.iter().map(|output| CardFile::new(&file_name(&output.path), &output.bytes));
    let export =
        CardExport { kind: kind.to_owned(), files: files.collect(), verified: verified.clone() };
    let known = card::known(&[card_out.file(), &card::path_beside(&args.model)], &text);
    let card = known.unwrap_or_else(|| mlp::export::card::Card::new(&file, &origin, &text));
    card_out.write(card.with_export(export).to_json()?)?;
    let files = outputs.iter().map(|output| output.path.display().to_string()).collect();
    report(
        args,
        &Result { format: kind, files, card: card_out.file().display().to_string(), verified },
    )
}

fn report(args: &ExportArgs, result: &Result<'_>) -> anyhow::Result<Exit> {
    if args.json {
        output::json(result)?;
        return Ok(Exit::Done);
    }
    if let Some(verified) = &result.verified {
        output::line(&format!(
            "verified with the C compiler: {} inputs, status and range flags equal, largest difference {:.1e} (bound there {:.1e}; the training range is 2)",
            verified.inputs, verified.largest_difference, verified.bound
        ))?;
    }
    output::line(&format!("{} written, card in {}", result.files.join(" and "), result.card))?;
    Ok(Exit::Done)
}

fn c_files(
    args: &ExportArgs,
    file: &ModelFile,
    origin: &str,
) -> anyhow::Result<(Vec<Output>, Option<CardVerified>)> {
    let stem = target(args)?;
    let source_path = stem.with_extension("c");
    let header_path = stem.with_extension("h");
    let name =
        source_path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into());
    let prefix = args.prefix.clone().unwrap_or_else(|| c::prefix_of(&name));
    let header_name = file_name(&header_path);
    if header_name.contains(['"', '\\', '\n']) {
        return Err(WrongArgument(format!("{header_name:?} can not stand in an #include")).into());
    }
    let text = c::source(file, &prefix, &header_name, origin)
        .map_err(|error| WrongArgument(format!("--prefix: {error}")))?;
    let verified = if args.verify {
        Some(export_verify::compare(file, &text, &prefix, &header_name)?)
    } else {
        None
    };
    let outputs = vec![
        Output { path: source_path, bytes: text.source.into_bytes() },
        Output { path: header_path, bytes: text.header.into_bytes() },
    ];
    Ok((outputs, verified))
}

fn onnx_file(args: &ExportArgs, file: &ModelFile, origin: &str) -> anyhow::Result<Vec<Output>> {
    for (given, flag) in [(args.verify, "--verify"), (args.prefix.is_some(), "--prefix")] {
        if given {
            let message = format!(
                "{flag} goes with --format c only; scripts/onnx-check.sh compares ONNX files with onnxruntime"
            );
            return Err(WrongArgument(message).into());
        }
    }
    let path = target(args)?;
    Ok(vec![Output { path, bytes: onnx::bytes(file, origin)? }])
}

/// Where to write: `--output`, in it where it is a folder, or beside the model; never over the model.
fn target(args: &ExportArgs) -> anyhow::Result<PathBuf> {
    let extension = args.format.extension();
    let beside = args.model.with_extension(extension);
    let path = match &args.output {
        None => beside,
        Some(folder) if folder.is_dir() => folder.join(beside.file_name().unwrap_or_default()),
        Some(path) if path.file_name().is_none() => {
            return Err(WrongArgument(format!("--output {}: no file name", path.display())).into());
        }
        Some(path) => path.clone(),
    };
    let extension = path.extension();
    if args.format == ExportFormat::C && extension.is_some_and(|known| known != "c" && known != "h")
    {
        let message = format!("--output {}: expected a name that ends in .c or .h", path.display());
        return Err(WrongArgument(message).into());
    }
    if path == args.model || path.extension().is_some_and(|extension| extension == "json") {
        let message = format!("--output {}: that is no name for an export", path.display());
        return Err(WrongArgument(message).into());
    }
    Ok(path)
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
