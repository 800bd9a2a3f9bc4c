//! Check of the bytes of a model file against what they are said to be: a model that may be tried on a gripper, or a sentence against it.
//!
//! The self-test asks the model about 256 slips of objects of which the right answer is known exactly: `objects.csv`, as `gripctl generate
//! --source trial --rows 256 --seed 4711` writes it (constant friction, no noise, a seed that no built-in model was trained on), so that
//! a daemon needs no simulator for it. Its bounds keep out what is broken, was made for
//! something else or knows too little to move fingers. They are wide: a model that is off by less is judged by the slips of the
//! gripper, which know its objects.

use super::ModelId;
use core::fmt::Write as _;
use grip_session::{
    HostEstimator, ModelError, model,
    signature::{Provenance, SignatureError},
};
use slip_core::{
    esc::{Esc, Flags, Reading},
    estimate::Features,
};

/// The longest model file (bytes).
pub const MOST_BYTES: usize = 1 << 20;
/// Most characters of a name.
const LONGEST_NAME: usize = 64;
/// Objects of the self-test.
const OBJECTS: &str = include_str!("objects.csv");
/// The error that half, and 19 of 20, of the answers may have: share of the right force.
const MEDIAN: f64 = 0.25;
const TAIL: f64 = 0.5;
/// Objects that the model must be sure enough of to move the fingers.
const TRUSTED: usize = 230;

/// Why a model is refused.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// Nothing came.
    #[error("no model came with the order")]
    Empty,
    /// It is too long.
    #[error("the model file has {bytes} bytes; more than {MOST_BYTES} are not taken")]
    TooLong {
        /// How long it is.
        bytes: usize,
    },
    /// Something else was sent than was meant.
    #[error("what came is not what was ordered: its SHA-256 is {is}, the order says {ordered}")]
    Hash {
        /// SHA-256 of what came.
        is: String,
        /// SHA-256 of the order.
        ordered: String,
    },
    /// It is no text.
    #[error("{name}: this is no model file but bytes that are no text")]
    NoText {
        /// The file.
        name: String,
    },
    /// It is no model of this version, or for something else.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// It is not signed as this gripper asks for.
    #[error("{name}: {source}; {}", source.remedy(name))]
    Signature {
        /// The model.
        name: String,
        /// What is wrong.
        source: SignatureError,
    },
    /// It is too far off on objects that are known.
    #[error(
        "{name} fails the self-test: half of its answers are off by {median:.0} % or more, one of 20 by {tail:.0} % or more; {} % and {} % are the most",
        100.0 * MEDIAN,
        100.0 * TAIL
    )]
    Wrong {
        /// The model.
        name: String,
        /// Error that half of the answers exceed (%).
        median: f64,
        /// Error that one of 20 exceeds (%).
        tail: f64,
    },
    /// It does not answer, or is too unsure to move the fingers.
    #[error("{name} fails the self-test: of {rows} known objects it {what} {count}")]
    Unsure {
        /// The model.
        name: String,
        /// Objects.
        rows: usize,
        /// `answers` or `is sure enough of`.
        what: &'static str,
        /// How many.
        count: usize,
    },
}

/// A model that may be tried.
#[derive(Clone, Debug)]
pub struct Examined {
    /// What it is.
    pub id: ModelId,
    /// Its file.
    pub text: String,
    /// What it runs as.
    pub estimator: HostEstimator,
    /// Who has signed it, where that was asked and somebody has.
    pub signed: Option<Provenance>,
}

/// SHA-256 of bytes, 64 hexadecimal digits.
#[must_use]
pub fn digest(bytes: &[u8]) -> String {
    hex(&model::digest(bytes))
}

/// Bytes as hexadecimal digits.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _written = write!(text, "{byte:02x}");
        text
    })
}

/// Examines a model file of that name (of which what is no letter, digit, dash, dot or underscore is left out) that should have this SHA-256.
///
/// # Errors
/// [`Fault`], a sentence for whoever sent it.
pub fn examine(name: &str, ordered: &str, bytes: &[u8]) -> Result<Examined, Fault> {
    if bytes.is_empty() {
        return Err(Fault::Empty);
    }
    if bytes.len() > MOST_BYTES {
        return Err(Fault::TooLong { bytes: bytes.len() });
    }
    let sha256 = digest(bytes);
    if !sha256.eq_ignore_ascii_case(ordered) {
        let ordered: String = ordered.chars().take(LONGEST_NAME).collect();
        return Err(Fault::Hash { is: sha256, ordered });
    }
    let name = plain(name);
    let Ok(text) = core::str::from_utf8(bytes) else { return Err(Fault::NoText { name }) };
    let estimator = model::parse_estimator(&name, text)?;
    self_test(&name, &estimator)?;
    Ok(Examined { id: ModelId { name, sha256 }, text: text.to_owned(), estimator, signed: None })
}

fn self_test(name: &str, estimator: &HostEstimator) -> Result<(), Fault> {
    let rows = OBJECTS.lines().skip(1).count();
    let unsure = |what, count| Err(Fault::Unsure { name: name.to_owned(), rows, what, count });
    let mut trusted = 0;
    let mut errors = Vec::new();
    for (slip, adequate_n) in OBJECTS.lines().skip(1).filter_map(object) {
        let Ok(estimate) = estimator.estimate(&slip) else { continue };
        trusted += usize::from(estimate.is_trusted());
        errors.push((f64::from(estimate.force_n) / adequate_n - 1.0).abs());
    }
    if errors.len() < rows {
        return unsure("answers", errors.len());
    }
    // No number is as far off as can be.
    errors.sort_by(f64::total_cmp);
    let worst = |part: usize| errors.get(part).copied().unwrap_or(f64::NAN);
    let [median, tail] = [worst(rows / 2), worst(rows * 19 / 20)];
    if !(median <= MEDIAN && tail <= TAIL) {
        let (median, tail) = (100.0 * median, 100.0 * tail);
        return Err(Fault::Wrong { name: name.to_owned(), median, tail });
    }
    if trusted < TRUSTED { unsure("is sure enough of", trusted) } else { Ok(()) }
}

/// A slip and its adequate force (N), from a line of the objects.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "features are f32, a count is whole"
)]
fn object(line: &str) -> Option<(Features, f64)> {
    let mut values = line.split(',').map(str::parse::<f64>).map_while(Result::ok);
    let mut next = || values.next();
    let (_object, _mass, _friction) = (next()?, next()?, next()?);
    let (trial_n, moved_m, speed_m_s, time_s) = (next()?, next()?, next()?, next()?);
    let (acceleration_m_s2, n, mean_slope, esc_w) = (next()?, next()? as u32, next()?, next()?);
    let (_needed_n, adequate_n) = (next()?, next()?);
    // Without irregularities there is no E_sc.
    let esc = (n > 0).then_some(Esc {
        reading: Reading::Literal,
        value: esc_w,
        lo: esc_w,
        hi: esc_w,
        n,
        degenerate: 0,
        sum: f64::NAN,
        condition: f64::NAN,
        sigma_s: f64::NAN,
        flags: Flags::default(),
    });
    let slip = Features {
        slip_speed_m_s: speed_m_s as f32,
        contact_time_s: time_s as f32,
        slip_acceleration_m_s2: acceleration_m_s2 as f32,
        slip_acceleration_sigma_m_s2: None,
        micro_displacement_m: moved_m as f32,
        trial_force_n: trial_n as f32,
        irregularities: n,
        mean_slope: (n > 0).then_some(mean_slope as f32),
        esc,
        esc_chosen: esc,
    };
    Some((slip, adequate_n))
}

fn plain(name: &str) -> String {
    let good = |letter: &char| letter.is_ascii_alphanumeric() || "-._".contains(*letter);
    let name: String = name.chars().filter(good).take(LONGEST_NAME).collect();
    if name.is_empty() { "model.json".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::OBJECTS;
    use grip_sim::generator::{CSV_HEADER, GeneratorConfig, rows};

    #[test]
    fn the_objects_are_those_of_the_generator() {
        let known = rows(GeneratorConfig::default(), 4711, 256).unwrap().map(|row| row.csv());
        let wanted: Vec<String> = core::iter::once(CSV_HEADER.to_owned()).chain(known).collect();
        assert_eq!(OBJECTS.lines().collect::<Vec<_>>(), wanted);
    }
}
