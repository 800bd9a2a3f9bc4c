//! C export: a model file as a C99 header and source.
//!
//! The source needs no heap, no tables beyond its weights and, without logarithms, nothing of the C library. tanh is the rational
//! function of [`tanh::rational`](crate::tanh::rational) rather than `tanhf`: 3.5 ulp in a fixed number of operations, no
//! library call, and the sums run in the order of [`Network`](crate::Network), so that compilers that do not contract
//! expressions give the bits of the Rust model. Only `logf` and `expf` of logarithmic columns and of a classifier's softmax come
//! from the C library.

use core::fmt::Write as _;

use super::c_text::{array, comment, constants, identifier, literal, operand};
use super::{ExportError, MAX_PREFIX};
use crate::activation::Activation;
use crate::model::{Axis, Scaler, Transform};
use crate::tanh::{DENOMINATOR, LIMIT, NUMERATOR};
use crate::train::ModelFile;
use crate::train::file::{FileColumn, rounded};

/// The two files of a model in C.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CSource {
    /// Contents of `PREFIX.h`.
    pub header: String,
    /// Contents of the source file.
    pub source: String,
}

/// A prefix for C names made from `name`, for example a file name.
#[must_use]
pub fn prefix_of(name: &str) -> String {
    let mut prefix = identifier(name).to_lowercase();
    if !prefix.starts_with(|c: char| c.is_ascii_alphabetic()) {
        prefix.insert_str(0, "m_");
    }
    prefix.truncate(MAX_PREFIX);
    prefix
}

/// Writes `file` as C. Every name begins with `prefix`; the source includes `header_name`; `origin` states in a comment where the
/// model comes from.
///
/// # Errors
/// [`ExportError::Prefix`]; [`ExportError::File`] when `file` holds no valid model.
pub fn source(
    file: &ModelFile,
    prefix: &str,
    header_name: &str,
    origin: &str,
) -> Result<CSource, ExportError> {
    let first = prefix.chars().next();
    if !first.is_some_and(|c| c.is_ascii_alphabetic())
        || identifier(prefix) != prefix
        || prefix.len() > MAX_PREFIX
    {
        return Err(ExportError::Prefix { prefix: prefix.to_owned() });
    }
    let model = file.large_model()?;
    let text = Text { file, prefix, upper: prefix.to_uppercase(), origin };
    let mut source = text.preamble(header_name);
    for (at, layer) in file.layers.iter().enumerate() {
        let flat: Vec<f32> = layer.weights.iter().flatten().copied().collect();
        let from = layer.weights.first().map_or(1, Vec::len);
        source += &array(&format!("weights_{}", at + 1), &flat, from);
        source += &array(&format!("biases_{}", at + 1), &layer.biases, 6);
    }
    source += &text.functions();
    source += &text.range_check();
    source += &text.predict(model.inputs(), model.targets());
    source += &text.interval();
    Ok(CSource { header: text.header(), source })
}

struct Text<'a> {
    file: &'a ModelFile,
    prefix: &'a str,
    upper: String,
    origin: &'a str,
}

impl Text<'_> {
    fn header(&self) -> String {
        let (prefix, upper) = (self.prefix, &self.upper);
        let (inputs, targets) = (&self.file.inputs, &self.file.targets);
        let mut text = format!(
            "/* {}: raw features in, raw targets out. Made by gripctl export; change the model, not this file. */\n\
             #ifndef {upper}_H\n#define {upper}_H\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n\
             #define {upper}_INPUTS {}\n#define {upper}_OUTPUTS {}\n\n",
            comment(self.origin),
            inputs.len(),
            targets.len()
        );
        text += &self.places(
            "IN",
            "Places of the features: name, unit, range of the training rows",
            inputs,
        );
        text += &self.places("OUT", &self.targets(), targets);
        let _infallible = write!(
            text,
            "typedef enum {{\n    {upper}_OK = 0,            /* all features within the training range */\n    \
             {upper}_EXTRAPOLATED = 1,  /* there is an answer, but a feature lies outside the training range */\n    \
             {upper}_NOT_FINITE = 2,    /* no answer: a feature is NaN or infinite */\n    \
             {upper}_OUT_OF_DOMAIN = 3, /* no answer: a logarithmic or reciprocal feature is zero or negative */\n    \
             {upper}_OVERFLOW = 4       /* no answer: it is too large for a float */\n}} {prefix}_status;\n\n\
             /* Estimates the targets. Without an answer (status 2 and above) out is left as it was. Takes a fixed number of\n   \
             operations, no heap and no static memory but constants. */\n\
             {prefix}_status {prefix}_predict(const float in[{upper}_INPUTS], float out[{upper}_OUTPUTS]);\n\n\
             /* Bit i is set where feature i lies outside the training range or is NaN; bit 31 stands for all from 31 on. */\n\
             unsigned {prefix}_out_of_range(const float in[{upper}_INPUTS]);\n\n"
        );
        if let Some(interval) = &self.file.interval {
            let about = format!("{} % of the truths ({})", 100.0 * interval.level, interval.from);
            let _infallible = write!(
                text,
                "/* Limits around the answers in out that hold {}. */\n\
                 void {prefix}_interval(const float out[{upper}_OUTPUTS], float low[{upper}_OUTPUTS], float high[{upper}_OUTPUTS]);\n\n",
                comment(&about)
            );
        }
        text + "#ifdef __cplusplus\n}\n#endif\n\n#endif\n"
    }

    /// As [`Interval::around`](crate::train::Interval::around), to the bit.
    fn interval(&self) -> String {
        let Some(interval) = &self.file.interval else { return String::new() };
        let (prefix, upper) = (self.prefix, &self.upper);
        let mut text = format!(
            "\nvoid {prefix}_interval(const float out[{upper}_OUTPUTS], float low[{upper}_OUTPUTS], float high[{upper}_OUTPUTS])\n{{\n"
        );
        for (at, (column, &width)) in self.file.targets.iter().zip(&interval.widths).enumerate() {
            let (down, up) = if column.transform.is_relative() { ('/', '*') } else { ('-', '+') };
            let width = operand(width);
            let _infallible = writeln!(
                text,
                "    low[{at}] = out[{at}] {down} {width};\n    high[{at}] = out[{at}] {up} {width};"
            );
        }
        text + "}\n"
    }

    /// What the targets are.
    fn targets(&self) -> String {
        match &self.file.classes {
            None => "Places of the targets: name, unit, range of the training rows".to_owned(),
            Some(column) => format!("Places of the probabilities of the classes of {column}"),
        }
    }

    fn places(&self, kind: &str, title: &str, columns: &[FileColumn]) -> String {
        let names = constants(columns.iter().map(|column| column.name.as_str()));
        let mut text = format!("/* {title}. */\nenum {{\n");
        for (at, (name, column)) in names.iter().zip(columns).enumerate() {
            let comma = if at + 1 == columns.len() { "" } else { "," };
            let what = comment(&format!(
                "{} [{}], {} to {}",
                column.name, column.unit, column.min, column.max
            ));
            let _infallible =
                writeln!(text, "    {}_{kind}_{name} = {at}{comma} /* {what} */", self.upper);
        }
        text + "};\n\n"
    }

    fn preamble(&self, header_name: &str) -> String {
        let sizes: Vec<String> = core::iter::once(self.file.inputs.len())
            .chain(self.file.layers.iter().map(|layer| layer.biases.len()))
            .map(|size| size.to_string())
            .collect();
        let mut text =
            format!("/* {}: a network of {} neurons.", comment(self.origin), sizes.join("-"));
        if let Some(note) = &self.file.training {
            let line = format!(
                "Trained with {}, seed {}, on {} rows of SHA-256 {}: mean squared error {:e} on them",
                note.algorithm, note.seed, note.rows, note.data_sha256, note.train_mse
            );
            let test =
                note.test_mse.map_or(String::new(), |mse| format!(", {mse:e} on the test rows"));
            let _infallible = write!(text, "\n   {}{}.", comment(&line), comment(&test));
        }
        text += " */\n";
        let _infallible = writeln!(text, "#include \"{header_name}\"\n\n#include <float.h>");
        let mut columns = self.file.inputs.iter().chain(&self.file.targets);
        let logarithmic = columns.any(|column| column.transform == Transform::Ln);
        if logarithmic || self.file.classes.is_some() {
            text += "#include <math.h>\n";
        }
        text.push('\n');
        text
    }

    /// The helper functions that this model uses; an unused one would be a warning.
    fn functions(&self) -> String {
        let uses = |wanted: &[Activation]| {
            self.file.layers.iter().any(|layer| wanted.contains(&layer.activation))
        };
        let mut text = String::from(IS_FINITE);
        if uses(&[Activation::Tanh, Activation::Logistic]) {
            text += &tanh();
        }
        text += LAYER;
        if self.file.classes.is_some() { text + SOFTMAX } else { text }
    }

    fn range_check(&self) -> String {
        let limits = |pick: fn(&FileColumn) -> f64| -> Vec<f32> {
            self.file.inputs.iter().map(pick).map(rounded).collect()
        };
        let (prefix, upper) = (self.prefix, &self.upper);
        // Beyond the first 32 inputs the last bit stands for all others.
        let flag = if self.file.inputs.len() > 32 { "1u << (i < 31 ? i : 31)" } else { "1u << i" };
        format!(
            "\n{}{}\nunsigned {prefix}_out_of_range(const float in[{upper}_INPUTS])\n{{\n    unsigned outside = 0;\n    \
             for (int i = 0; i < {upper}_INPUTS; i++) {{\n        \
             if (!(in[i] >= lowest[i] && in[i] <= highest[i])) {{\n            \
             outside |= {flag};\n        }}\n    }}\n    return outside;\n}}\n",
            array("lowest", &limits(|column| column.min), 6),
            array("highest", &limits(|column| column.max), 6),
        )
    }

    fn predict<const IO: usize>(&self, inputs: &Scaler<IO>, targets: &Scaler<IO>) -> String {
        let (prefix, upper) = (self.prefix, &self.upper);
        let widths = self.file.layers.iter().map(|layer| layer.biases.len());
        let widest = widths.chain([self.file.inputs.len()]).max().unwrap_or(1);
        let mut text = format!(
            "\n{prefix}_status {prefix}_predict(const float in[{upper}_INPUTS], float out[{upper}_OUTPUTS])\n{{\n    \
             float x[{widest}];\n    float y[{widest}];\n    float raw[{upper}_OUTPUTS];\n"
        );
        for (at, axis) in inputs.axes().iter().enumerate() {
            text += &scale(at, axis, upper);
        }
        let (mut from, mut to) = ("x", "y");
        for (at, layer) in self.file.layers.iter().enumerate() {
            let (width, count, number) =
                (layer.weights.first().map_or(1, Vec::len), layer.biases.len(), at + 1);
            let _infallible = writeln!(
                text,
                "    layer(weights_{number}, biases_{number}, {from}, {width}, {to}, {count});"
            );
            text += &activate(layer.activation, to, count);
            (from, to) = (to, from);
        }
        for (at, axis) in targets.axes().iter().enumerate() {
            text += &unscale(at, axis, from);
        }
        if self.file.classes.is_some() {
            let _infallible = writeln!(text, "    softmax(raw, {upper}_OUTPUTS);");
        }
        let _infallible = write!(
            text,
            "    for (int i = 0; i < {upper}_OUTPUTS; i++) {{\n        if (!is_finite(raw[i])) {{\n            \
             return {upper}_OVERFLOW;\n        }}\n    }}\n    \
             for (int i = 0; i < {upper}_OUTPUTS; i++) {{\n        out[i] = raw[i];\n    }}\n    \
             return {prefix}_out_of_range(in) ? {upper}_EXTRAPOLATED : {upper}_OK;\n}}\n"
        );
        text
    }
}

const IS_FINITE: &str =
    "\nstatic int is_finite(float x)\n{\n    return x >= -FLT_MAX && x <= FLT_MAX;\n}\n";

const LAYER: &str = "
/* Weighted sums in four lanes, as the model was tested: they do not wait for one another. */
static void layer(const float *weights, const float *biases, const float *from, int width, float *to, int count)
{
    for (int row = 0; row < count; row++) {
        float lanes[4] = { biases[row], -0.0f, -0.0f, -0.0f };
        for (int i = 0; i < width; i++) {
            lanes[i % 4] += weights[row * width + i] * from[i];
        }
        to[row] = (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
    }
}
";

const SOFTMAX: &str = "
/* Probabilities of scores. */
static void softmax(float *scores, int count)
{
    float largest = scores[0];
    float sum = 0.0f;
    for (int i = 1; i < count; i++) {
        largest = scores[i] > largest ? scores[i] : largest;
    }
    for (int i = 0; i < count; i++) {
        scores[i] = expf(scores[i] - largest);
        sum += scores[i];
    }
    for (int i = 0; i < count; i++) {
        scores[i] /= sum;
    }
}
";

fn tanh() -> String {
    let [p0, p1, p2] = NUMERATOR.map(literal);
    let [q0, q1, q2, q3] = DENOMINATOR.map(literal);
    let limit = literal(LIMIT);
    format!(
        "\n/* tanh x = 2nq / (n^2 + q^2), where n/q approximates tanh(x/2): within 3.5 units in the last place. */\n\
         static float rational_tanh(float x)\n{{\n    float size = x < 0.0f ? -x : x;\n    size = size > {limit} ? {limit} : size;\n    \
         const float square = size * size;\n    const float fourth = square * square;\n    \
         const float n = size * (({p2} * square + {p1}) * square + {p0});\n    \
         const float q = (({q3} * square + {q2}) * fourth + {q1} * square) + {q0};\n    \
         float y = (n * (q + q)) / (n * n + q * q);\n    y = y > 1.0f ? 1.0f : y;\n    return x < 0.0f ? -y : y;\n}}\n"
    )
}

fn scale(at: usize, axis: &Axis, upper: &str) -> String {
    let mut text =
        format!("    if (!is_finite(in[{at}])) {{\n        return {upper}_NOT_FINITE;\n    }}\n");
    if axis.column.transform != Transform::Identity {
        let _infallible = write!(
            text,
            "    if (!(in[{at}] > 0.0f)) {{\n        return {upper}_OUT_OF_DOMAIN;\n    }}\n"
        );
    }
    let value = match axis.column.transform {
        Transform::Identity => format!("in[{at}]"),
        Transform::Ln => format!("logf(in[{at}])"),
        Transform::Reciprocal => format!("-1.0f / in[{at}]"),
    };
    let _infallible = if axis.is_constant() {
        writeln!(text, "    x[{at}] = 0.0f; /* the same in all training rows */")
    } else {
        writeln!(
            text,
            "    x[{at}] = ({value} - {}) * {} - 1.0f;",
            operand(axis.low),
            operand(axis.gain)
        )
    };
    text
}

fn unscale(at: usize, axis: &Axis, from: &str) -> String {
    if axis.is_constant() {
        return format!("    raw[{at}] = {};\n", literal(axis.minimum()));
    }
    let (low, half_span) = (literal(axis.low), operand(axis.half_span));
    let linear = format!("{low} + ({from}[{at}] + 1.0f) * {half_span}");
    match axis.column.transform {
        Transform::Identity => format!("    raw[{at}] = {linear};\n"),
        Transform::Ln => format!("    raw[{at}] = expf({linear});\n"),
        Transform::Reciprocal => {
            let (noise, most) = (literal(axis.column.noise), operand(-axis.column.noise));
            format!(
                "    raw[{at}] = {linear};\n    raw[{at}] = raw[{at}] > {most} ? {most} : raw[{at}];\n    \
                 raw[{at}] = -1.0f / (raw[{at}] + {noise} * ({noise} / raw[{at}]));\n"
            )
        }
    }
}

fn activate(activation: Activation, values: &str, count: usize) -> String {
    let result = match activation {
        Activation::Linear => return String::new(),
        Activation::Tanh => format!("rational_tanh({values}[i])"),
        Activation::Logistic => format!("0.5f + 0.5f * rational_tanh(0.5f * {values}[i])"),
        Activation::Relu => format!("{values}[i] < 0.0f ? 0.0f : {values}[i]"),
    };
    format!("    for (int i = 0; i < {count}; i++) {{\n        {values}[i] = {result};\n    }}\n")
}

#[cfg(test)]
mod tests;
