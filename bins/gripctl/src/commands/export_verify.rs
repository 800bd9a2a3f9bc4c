//! Comparison of a model with its C source, how far they agree: compiles the source with a driver and feeds both the same
//! features.

use anyhow::{Context as _, bail};
use mlp::export::agreement;
use mlp::export::c::CSource;
use mlp::export::card::CardVerified;
use mlp::train::{Interval, LargeModel, ModelFile, file::rounded, metrics::softmax};
use mlp::{Coverage, PredictError};
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

/// Options for every compiler: strict C99, every usual warning an error, no fused multiply-add in place of what is written.
const OPTIONS: [&str; 7] =
    ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2", "-ffp-contract=off"];

/// Random feature vectors within the training range, and beyond it.
const WITHIN: usize = 20_000;
const BEYOND: usize = 5_000;

/// Compiles and compares.
///
/// # Errors
/// When there is no compiler, when it refuses the source, and when an answer differs by more than rounding explains.
pub(super) fn compare(
    file: &ModelFile,
    text: &CSource,
    prefix: &str,
    header_name: &str,
) -> anyhow::Result<CardVerified> {
    let folder = tempfile::tempdir().context("cannot make a folder for the C compiler")?;
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))
    };
    let model = &file.large_model()?;
    let inputs = features(model);
    let bytes: Vec<u8> = inputs.iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
    write(header_name, text.header.as_bytes())?;
    write("export-model.c", text.source.as_bytes())?;
    write("export-driver.c", driver(prefix, header_name, file.interval.is_some()).as_bytes())?;
    write("features", &bytes)?;
    compile(folder.path())?;
    let features = File::open(folder.path().join("features"))?;
    let run = Command::new(folder.path().join("driver"))
        .stdin(features)
        .output()
        .context("cannot run the compiled C code")?;
    if !run.status.success() {
        bail!("the compiled C code failed: {}", run.status);
    }
    check(file, model, &inputs, &run.stdout)
}

fn compile(folder: &Path) -> anyhow::Result<()> {
    let command = std::env::var("CC").ok().filter(|name| !name.trim().is_empty());
    let command = command.unwrap_or_else(|| "cc".to_owned());
    let mut words = command.split_whitespace();
    let mut compiler = Command::new(words.next().unwrap_or("cc"));
    compiler.args(words).args(OPTIONS).args([
        "export-model.c",
        "export-driver.c",
        "-o",
        "driver",
        "-lm",
    ]);
    let done = compiler.current_dir(folder).stdin(Stdio::null()).output().with_context(|| {
        format!("--verify needs a C compiler, and `{command}` cannot be run; install one or name it in CC")
    })?;
    if !done.status.success() {
        bail!("`{command}` refused the C code: {}", String::from_utf8_lossy(&done.stderr).trim());
    }
    Ok(())
}

/// Reads feature vectors, writes status, range flags, targets and their limits of each.
fn driver(prefix: &str, header_name: &str, interval: bool) -> String {
    let upper = prefix.to_uppercase();
    let limits = if interval {
        format!(
            "        {{\n            float low[{upper}_OUTPUTS];\n            float high[{upper}_OUTPUTS];\n            \
             {prefix}_interval(out, low, high);\n            \
             fwrite(low, sizeof low, 1, stdout);\n            fwrite(high, sizeof high, 1, stdout);\n        }}\n"
        )
    } else {
        String::new()
    };
    format!(
        "#include \"{header_name}\"\n#include <stdio.h>\nint main(void)\n{{\n    float in[{upper}_INPUTS];\n    \
         while (fread(in, sizeof in, 1, stdin) == 1) {{\n        float out[{upper}_OUTPUTS] = {{ 0.0f }};\n        \
         const int status = (int){prefix}_predict(in, out);\n        const unsigned flags = {prefix}_out_of_range(in);\n        \
         fwrite(&status, sizeof status, 1, stdout);\n        fwrite(&flags, sizeof flags, 1, stdout);\n        \
         fwrite(out, sizeof out, 1, stdout);\n{limits}    }}\n    return ferror(stdin) || fflush(stdout) != 0;\n}}\n"
    )
}

/// Corners and middle of the training range, extremes in each place, random vectors within and beyond the range.
fn features(model: &LargeModel) -> Vec<Vec<f32>> {
    let columns: Vec<(f32, f32)> =
        model.inputs().columns().map(|c| (rounded(c.min), rounded(c.max))).collect();
    let at =
        |share: f32| columns.iter().map(|(low, high)| low * (1.0 - share) + high * share).collect();
    let mut all: Vec<Vec<f32>> = [0.0, 0.5, 1.0].map(at).to_vec();
    let extremes = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        1e30,
        -1e30,
        0.0,
        -0.0,
        -1.0,
        f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
    ];
    for place in 0..columns.len() {
        let bounds = columns.get(place).map_or([0.0; 2], |&(low, high)| [low, high]);
        for value in extremes.into_iter().chain(bounds) {
            let mut one: Vec<f32> = at(0.4);
            one[place] = value;
            all.push(one);
        }
    }
    all.extend(extremes.map(|value| vec![value; columns.len()]));
    let mut random = Random(1);
    for count in 0..WITHIN + BEYOND {
        let spread = if count < WITHIN { 1.0 } else { 4.0 };
        let draw = |&(low, high): &(f32, f32)| {
            let share = 0.5 + spread * (random.unit() - 0.5);
            low * (1.0 - share) + high * share
        };
        all.push(columns.iter().map(draw).collect());
    }
    all
}

/// Numbers that look random and are the same every time (`SplitMix64`).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        f32::from(u16::try_from(bits >> 48).unwrap_or(0)) / 65_536.0
    }
}

/// Status of the C function for the Rust answer.
fn status(answer: Result<Coverage, PredictError>) -> u32 {
    match answer {
        Ok(Coverage::Inside) => 0,
        Ok(Coverage::Outside { .. }) => 1,
        Err(PredictError::OutOfDomain { .. }) => 3,
        Err(PredictError::Overflow { .. }) => 4,
        Err(PredictError::NotFinite { .. } | PredictError::Shape(_)) => 2,
    }
}

fn check(
    file: &ModelFile,
    model: &LargeModel,
    inputs: &[Vec<f32>],
    bytes: &[u8],
) -> anyhow::Result<CardVerified> {
    let targets = model.targets().axes().len();
    let (words, rest) = bytes.as_chunks::<4>();
    let record_size = 2 + targets * if file.interval.is_some() { 3 } else { 1 };
    if !rest.is_empty() || words.len() != inputs.len() * record_size {
        bail!("the compiled C code wrote {} bytes for {} inputs", bytes.len(), inputs.len());
    }
    let mut verified = CardVerified { inputs: inputs.len(), largest_difference: 0.0, bound: 0.0 };
    let mut out = vec![0.0; targets];
    for (raw, record) in inputs.iter().zip(words.chunks_exact(record_size)) {
        let answer = status(model.predict(raw, &mut out));
        let flags = (0..raw.len()).filter(|&at| !model.inputs().axes()[at].covers(raw[at]));
        let flags = flags.fold(0_u32, |flags, at| flags | 1 << at.min(31));
        let reported = [answer, flags];
        let theirs = [record[0], record[1]].map(u32::from_ne_bytes);
        if reported != theirs {
            bail!(
                "the C code differs at {raw:?}: status and range flags {theirs:?}, expected {reported:?}"
            );
        }
        if answer > 1 {
            continue;
        }
        let mut bounds = agreement::bounds(model, raw);
        if let Some(interval) = &file.interval {
            check_limits(interval, model, &record[2..])
                .with_context(|| format!("the C code differs at {raw:?}"))?;
        }
        if file.classes.is_some() {
            let bound = agreement::probability_bound(&bounds);
            bounds.fill(bound);
            let mut scores: Vec<f64> = out.iter().copied().map(f64::from).collect();
            softmax(&mut scores);
            out.iter_mut().zip(scores).for_each(|(out, p)| *out = rounded(p));
        }
        for (target, (word, bound)) in record[2..2 + targets].iter().zip(bounds).enumerate() {
            let theirs = f32::from_ne_bytes(*word);
            let found = agreement::difference(model, target, out[target], theirs);
            if found.is_nan() || found > bound {
                bail!(
                    "the C code differs at {raw:?}: target {target} is {theirs}, expected {} (difference {found:.1e} of the scaled range, bound {bound:.1e})",
                    out[target]
                );
            }
            // Equal everywhere: report the bound of the first input.
            if found > verified.largest_difference || verified.bound == 0.0 {
                (verified.largest_difference, verified.bound) = (found, bound);
            }
        }
    }
    Ok(verified)
}

/// The limits of C around its own answers are ours around them, bit for bit. `words` holds answers, lower limits and upper limits.
fn check_limits(interval: &Interval, model: &LargeModel, words: &[[u8; 4]]) -> anyhow::Result<()> {
    let targets = model.targets().axes().len();
    let float = |at: usize| words.get(at).map_or(f32::NAN, |word| f32::from_ne_bytes(*word));
    let widths = model.targets().columns().zip(&interval.widths);
    for (target, (column, &width)) in widths.enumerate() {
        let ours = Interval::around(column.transform, width, f64::from(float(target))).map(rounded);
        let theirs = [1, 2].map(|at| float(target + at * targets));
        if ours.map(f32::to_bits) != theirs.map(f32::to_bits) {
            bail!("limits of target {target} are {theirs:?}, expected {ours:?}");
        }
    }
    Ok(())
}
