//! Check of the bytes of a model file against what they are said to be: a model that may be tried on a gripper, or a sentence against it.
//!
//! The self-test asks the model about 256 slips of objects of which the right answer is known exactly: `objects.csv`, as `gripctl generate
//! --source trial --rows 256 --seed 4711` writes it (constant friction, no noise, a seed that no built-in model was trained on), so that
//! a daemon needs no simulator for it. Its bounds keep out what is broken, was made for
//! something else or knows too little to move fingers. They are wide: a model that is off by less is judged by the slips of the
//! gripper, which know its objects.

use super::{ModelId, Refused, refused};
use core::fmt::Write as _;
use grip_session::{HostEstimator, model, signature::Provenance};
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
/// The error that half, and 19 of 20, of the answers may have (% of the right force).
const MEDIAN: f64 = 25.0;
const TAIL: f64 = 50.0;
/// Objects that the model must be sure enough of to move the fingers.
const TRUSTED: usize = 230;

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
/// [`Refused`].
pub fn examine(name: &str, ordered: &str, bytes: &[u8]) -> Result<Examined, Refused> {
    let wrong = |what: String| Err(Refused(what));
    if bytes.is_empty() {
        return wrong("no model came with the order".to_owned());
    }
    let count = bytes.len();
    if count > MOST_BYTES {
        return wrong(format!(
            "the model file has {count} bytes; more than {MOST_BYTES} are not taken"
        ));
    }
    let sha256 = digest(bytes);
    if !sha256.eq_ignore_ascii_case(ordered) {
        let ordered: String = ordered.chars().take(LONGEST_NAME).collect();
        return wrong(format!(
            "what came is not what was ordered: its SHA-256 is {sha256}, the order says {ordered}"
        ));
    }
    let name = plain(name);
    let Ok(text) = core::str::from_utf8(bytes) else {
        return wrong(format!("{name}: this is no model file but bytes that are no text"));
    };
    let estimator = model::parse_estimator(&name, text).map_err(|error| refused(&error))?;
    self_test(&estimator).map_err(|what| Refused(format!("{name} fails the self-test: {what}")))?;
    Ok(Examined { id: ModelId { name, sha256 }, text: text.to_owned(), estimator, signed: None })
}

fn self_test(estimator: &HostEstimator) -> Result<(), String> {
    let rows = OBJECTS.lines().skip(1).count();
    let mut trusted = 0;
    let mut errors = Vec::new();
    for (slip, adequate_n) in OBJECTS.lines().skip(1).filter_map(object) {
        let Ok(estimate) = estimator.estimate(&slip) else { continue };
        trusted += usize::from(estimate.is_trusted());
        errors.push((f64::from(estimate.force_n) / adequate_n - 1.0).abs());
    }
    if errors.len() < rows {
        return Err(format!("of {rows} known objects it answers {}", errors.len()));
    }
    // No number is as far off as can be.
    errors.sort_by(f64::total_cmp);
    let worst = |part: usize| 100.0 * errors.get(part).copied().unwrap_or(f64::NAN);
    let [median, tail] = [worst(rows / 2), worst(rows * 19 / 20)];
    if !(median <= MEDIAN && tail <= TAIL) {
        return Err(format!(
            "half of its answers are off by {median:.0} % or more, one of 20 by {tail:.0} % or more; {MEDIAN} % and {TAIL} % are the most"
        ));
    }
    if trusted < TRUSTED {
        return Err(format!("of {rows} known objects it is sure enough of {trusted}"));
    }
    Ok(())
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
