//! Check of a signed model file against the public keys of those who may sign one: who has signed it, or why it is refused.
//!
//! A signed model is one text: the model, and behind it the four lines of its [minisign](https://jedisct1.github.io/minisign/) signature over
//! every byte before them. So it travels, is kept and is recorded as one file with one SHA-256. On a disk the signature lies beside the
//! model (`force.json.minisig`); [`read_signed`](crate::model::read_signed) joins both.
//!
//! A signature shows who has signed a model and that it was not changed since. It does not show that the model is good, or the latest.

use core::fmt;
use minisign_verify::{Error, PublicKey, Signature};
use serde::{Deserialize, Serialize};

/// Most bytes of a signature; that of minisign has some 300, and its trusted comment may be longer.
pub const MOST_SIGNATURE: usize = 4096;
/// What a signature begins with.
const BEGIN: &str = "untrusted comment: ";
/// Its lines: comment, signature, trusted comment, signature of both.
const LINES: usize = 4;
/// Letters of a trusted comment that are shown.
const LONGEST_COMMENT: usize = 200;

/// Why a text is no public key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{key}` is no public key of minisign (the second line of minisign.pub: 56 letters from RW on)"
)]
pub struct KeyError {
    /// The text.
    pub key: String,
}

/// Why a model is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SignatureError {
    /// There is no signature.
    #[error("it is not signed, and model_keys takes signed models only")]
    Absent,
    /// It is none of minisign.
    #[error("its signature cannot be read, or is cut off")]
    Unreadable,
    /// It is too long.
    #[error("its signature has {bytes} bytes; more than {MOST_SIGNATURE} are not read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It is over the file and not over its hash, as those of minisign before 0.10.
    #[error("its signature is of the old form of minisign, which is not taken")]
    Legacy,
    /// It was made with another key.
    #[error("it is signed with key {id}, which is not in model_keys")]
    OtherKey {
        /// Number of that key, as minisign prints it.
        id: String,
    },
    /// The model, the signature or its comment is not what was signed.
    #[error("its signature is not of this model: one of the two was changed after it was signed")]
    Changed,
}

impl SignatureError {
    /// What to type next, where the model lies in `file`.
    #[must_use]
    pub fn remedy(&self, file: &str) -> String {
        match self {
            Self::OtherKey { .. } => {
                format!("add that key to model_keys, or sign it anew: `minisign -Sm {file}`")
            }
            _ => format!("sign it: `minisign -Sm {file}`"),
        }
    }
}

/// Who has signed a model.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Number of the key, as minisign prints it.
    pub key: String,
    /// What was signed beside the model: the trusted comment.
    pub comment: String,
}

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "signed with key {}: {}", self.key, self.comment)
    }
}

/// Whose models are taken.
#[derive(Clone, Debug, Default)]
pub struct ModelKeys {
    /// Without one, nothing is checked.
    keys: Vec<(String, PublicKey)>,
    allow_unsigned: bool,
}

impl ModelKeys {
    /// Keys as minisign prints them. `allow_unsigned` states whether a model without a signature is taken beside them; one with a wrong
    /// signature is refused all the same.
    ///
    /// # Errors
    /// [`KeyError`] of the first that is none.
    pub fn new(keys: &[String], allow_unsigned: bool) -> Result<Self, KeyError> {
        let read = |key: &String| {
            let error = || KeyError { key: key.clone() };
            let public = PublicKey::from_base64(key).map_err(|_| error())?;
            Ok((key_id(key).ok_or_else(error)?, public))
        };
        Ok(Self { keys: keys.iter().map(read).collect::<Result<_, _>>()?, allow_unsigned })
    }

    /// Who has signed the model; none where no key is set, or where it has no signature and needs none.
    ///
    /// # Errors
    /// [`SignatureError`].
    pub fn check(&self, text: &str) -> Result<Option<Provenance>, SignatureError> {
        if self.keys.is_empty() {
            return Ok(None);
        }
        let (model, signature) = split(text);
        let Some(signature) = signature else {
            return if self.allow_unsigned { Ok(None) } else { Err(SignatureError::Absent) };
        };
        check_form(signature)?;
        let id = signature.lines().nth(1).and_then(key_id).ok_or(SignatureError::Unreadable)?;
        let signature = Signature::decode(signature).map_err(|_| SignatureError::Unreadable)?;
        let mut fault = SignatureError::OtherKey { id };
        for (id, key) in &self.keys {
            match key.verify(model.as_bytes(), &signature, false) {
                Ok(()) => {
                    let comment = signature.trusted_comment().chars();
                    let shown = comment.filter(|letter| !letter.is_control());
                    let comment = shown.take(LONGEST_COMMENT).collect();
                    return Ok(Some(Provenance { key: id.clone(), comment }));
                }
                Err(Error::UnexpectedKeyId) => {}
                Err(Error::UnexpectedAlgorithm) => fault = SignatureError::Legacy,
                Err(_) => fault = SignatureError::Changed,
            }
        }
        Err(fault)
    }
}

/// A model, and its signature where it has one. The model is exactly what the signature is over.
#[must_use]
pub fn split(text: &str) -> (&str, Option<&str>) {
    let is_end = |at: usize| text.get(..at).is_some_and(|model| model.trim_end().ends_with('}'));
    let begin = text.match_indices(BEGIN).map(|(at, _)| at).find(|&at| is_end(at));
    begin.and_then(|at| text.split_at_checked(at)).map_or((text, None), |(a, b)| (a, Some(b)))
}

/// Whether a text may be the signature that lies beside a model.
///
/// # Errors
/// [`SignatureError::TooLong`], [`SignatureError::Unreadable`].
pub fn check_form(signature: &str) -> Result<(), SignatureError> {
    if signature.len() > MOST_SIGNATURE {
        return Err(SignatureError::TooLong { bytes: signature.len() });
    }
    if signature.starts_with(BEGIN) && signature.lines().count() == LINES {
        return Ok(());
    }
    Err(SignatureError::Unreadable)
}

/// The number of a key as minisign prints it, from the Base64 of a key or of a signature: two bytes show what it is, eight are the number.
fn key_id(base64: &str) -> Option<String> {
    let mut id = 0_u128;
    for letter in base64.bytes().take(16) {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        id = (id << 6) | u128::from(value);
    }
    let id = u64::try_from((id >> 16) & u128::from(u64::MAX)).ok()?;
    Some(format!("{:016X}", id.swap_bytes()))
}

#[cfg(test)]
mod tests {
    use super::{BEGIN, MOST_SIGNATURE, ModelKeys, Provenance, SignatureError, split};
    use crate::model::parse_estimator;
    use proptest::prelude::*;

    /// Keys that were made for these tests and thrown away: `minisign -GW`, `minisign -S -m model.json` (0.11), and `-l` for the old form.
    const KEY: &str = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ";
    const OTHER: &str = "RWR7zvcGElxkoXLz2FUABEEjtp0EqCSY1FsnREJ9vEt0EUwt90yfn1DG";
    const MODEL: &str = include_str!("../tests/signed/model.json");
    const SIGNATURE: &str = include_str!("../tests/signed/model.json.minisig");
    const LEGACY: &str = include_str!("../tests/signed/legacy.minisig");
    const BY_OTHER: &str = include_str!("../tests/signed/other-key.minisig");

    fn keys(keys: &[&str]) -> ModelKeys {
        ModelKeys::new(&keys.iter().map(|&key| key.to_owned()).collect::<Vec<_>>(), false).unwrap()
    }

    fn signed() -> String {
        MODEL.to_owned() + SIGNATURE
    }

    fn id(key: &str) -> String {
        key.to_owned()
    }

    #[test]
    fn a_model_that_one_of_the_keys_has_signed_passes_and_says_who() {
        let comment = "trained in hall-2, card sha256:0f1e".to_owned();
        let provenance = Some(Provenance { key: id("AF8131513DC1E017"), comment });
        assert_eq!(keys(&[KEY]).check(&signed()), Ok(provenance.clone()));
        assert_eq!(keys(&[OTHER, KEY]).check(&signed()), Ok(provenance));
        parse_estimator("signed.json", &signed()).unwrap();
        assert_eq!(split(&signed()), (MODEL, Some(SIGNATURE)));
        // Without a key nothing is checked.
        assert_eq!(keys(&[]).check(&(MODEL.to_owned() + BY_OTHER)), Ok(None));
        assert_eq!(keys(&[]).check(MODEL), Ok(None));
    }

    #[test]
    fn each_wrong_model_is_refused_with_its_reason() {
        let (first, rest) = SIGNATURE.split_at(SIGNATURE.find("\ntrusted").unwrap());
        let with = |signature: &str| MODEL.to_owned() + signature;
        let long = format!("{BEGIN}{}\n", "x".repeat(MOST_SIGNATURE));
        let bytes = long.len() + SIGNATURE.len();
        for (text, fault) in [
            (MODEL.to_owned(), SignatureError::Absent),
            (String::new(), SignatureError::Absent),
            (with(first), SignatureError::Unreadable),
            (with(&SIGNATURE[..SIGNATURE.len() - 10]), SignatureError::Unreadable),
            (with(&SIGNATURE.replace("RUQ", "XYZ")), SignatureError::Unreadable),
            (with(&(long + SIGNATURE)), SignatureError::TooLong { bytes }),
            (with(LEGACY), SignatureError::Legacy),
            // The letters that state that it is over the hash are changed.
            (with(&(first.replace("RUQ", "RWQ") + rest)), SignatureError::Legacy),
            (with(BY_OTHER), SignatureError::OtherKey { id: id("A1645C1206F7CE7B") }),
            (format!(" {}", signed()), SignatureError::Changed),
            (signed().replacen("4.36", "4.37", 1), SignatureError::Changed),
            (MODEL[1..].to_owned() + SIGNATURE, SignatureError::Changed),
            (MODEL.to_owned() + " " + SIGNATURE, SignatureError::Changed),
            (signed().replace("in hall-2", "in hall-3"), SignatureError::Changed),
            (signed().replacen("xgvF", "xgvG", 1), SignatureError::Changed),
            // Two signatures.
            (signed() + SIGNATURE, SignatureError::Unreadable),
            (MODEL.to_owned() + BY_OTHER + SIGNATURE, SignatureError::Unreadable),
        ] {
            assert_eq!(keys(&[KEY]).check(&text), Err(fault), "{}", text.len());
        }
        let id = id("AF8131513DC1E017");
        assert_eq!(keys(&[OTHER]).check(&signed()), Err(SignatureError::OtherKey { id }));
    }

    #[test]
    fn where_unsigned_models_are_allowed_a_wrong_signature_is_refused_all_the_same() {
        let keys = ModelKeys::new(&[KEY.to_owned()], true).unwrap();
        assert_eq!(keys.check(MODEL), Ok(None));
        assert!(keys.check(&signed()).unwrap().is_some());
        let changed = signed().replacen("4.36", "4.37", 1);
        assert_eq!(keys.check(&changed), Err(SignatureError::Changed));
    }

    #[test]
    fn what_is_no_key_is_named() {
        for key in ["", "RWRgV6Phf", "untrusted comment: minisign public key", "RW!"] {
            let error = ModelKeys::new(&[key.to_owned()], false).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{key}` is no public key")), "{error}");
        }
    }

    proptest! {
        #[test]
        fn no_cut_and_no_changed_letter_passes(at in 0_usize..3000, letter in "[ -~]") {
            let text = signed();
            // Without the end of the last line it is the same signature.
            let at = at % (text.len() - 1);
            prop_assert!(keys(&[KEY]).check(&text[..at]).is_err());
            let changed = text[..at].to_owned() + &letter + &text[at + 1..];
            // Only the first line of a signature may be anything.
            let free = MODEL.len()..MODEL.len() + SIGNATURE.find('\n').unwrap();
            let passes = keys(&[KEY]).check(&changed).is_ok();
            prop_assert!(!passes || changed == text || free.contains(&at));
        }
    }
}
