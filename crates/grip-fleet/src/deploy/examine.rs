//! The bytes of a model file, and what they are said to be, in; a model that may be tried on a gripper, or a sentence against it, out.
//!
//! The self-test asks the model about 256 slips of objects of which the right answer is known exactly ([`grip_sim`'s
//! generator](grip_host::accuracy), constant friction, no noise, a seed that no built-in model was trained on). Its bounds keep out what is broken, was made for
//! something else or knows too little to move fingers. They are wide: a model that is off by less is judged by the slips of the
//! gripper, which know its objects.

use super::ModelId;
use core::fmt::Write as _;
use grip_host::{
    HostEstimator, ModelError,
    accuracy::{Objects, accuracy},
    model,
};
use grip_sim::generator::{GeneratorError, Source};
use sha2::{Digest as _, Sha256};

/// The longest model file (bytes).
pub const MOST_BYTES: usize = 1 << 20;
/// Most characters of a name.
const LONGEST_NAME: usize = 64;
/// Objects of the self-test, and their seed.
const OBJECTS: Objects = Objects {
    source: Source::ClosedForm,
    count: 256,
    seed: 4711,
    speed_noise: 0.0,
    force_noise: 0.0,
};
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
    /// There are no known objects.
    #[error("the self-test cannot be made: {0}")]
    NoTest(#[from] GeneratorError),
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
}

/// SHA-256 of bytes, 64 hexadecimal digits.
#[must_use]
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
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
    Ok(Examined { id: ModelId { name, sha256 }, text: text.to_owned(), estimator })
}

fn self_test(name: &str, estimator: &HostEstimator) -> Result<(), Fault> {
    let seen = accuracy(name, estimator, &OBJECTS)?;
    let unsure = |what, count| {
        let (name, rows) = (name.to_owned(), seen.rows);
        Err(Fault::Unsure { name, rows, what, count })
    };
    if seen.answered < seen.rows {
        return unsure("answers", seen.answered);
    }
    // No number, or none at all, is as far off as can be.
    let [median, tail] = [seen.error.p50, seen.error.p95].map(|error| error.unwrap_or(f64::NAN));
    if !(median <= MEDIAN && tail <= TAIL) {
        let (median, tail) = (100.0 * median, 100.0 * tail);
        return Err(Fault::Wrong { name: name.to_owned(), median, tail });
    }
    if seen.trusted < TRUSTED { unsure("is sure enough of", seen.trusted) } else { Ok(()) }
}

fn plain(name: &str) -> String {
    let good = |letter: &char| letter.is_ascii_alphanumeric() || "-._".contains(*letter);
    let name: String = name.chars().filter(good).take(LONGEST_NAME).collect();
    if name.is_empty() { "model.json".to_owned() } else { name }
}
