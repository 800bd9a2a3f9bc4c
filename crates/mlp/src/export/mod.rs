//! Exports of a model file: the same model as C99 source, as an ONNX graph, and its model card.
//!
//! Texts and bytes are returned, nothing is written. All three hold the scaling of features and targets, so that raw values
//! go in and come out, and the limits of the training rows.

pub mod agreement;
pub mod c;
mod c_text;
pub mod card;
pub mod onnx;
mod proto;
#[cfg(test)]
mod test_models;

use crate::train::FileError;

/// Why a model can not be exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// The contents are no valid model.
    #[error(transparent)]
    File(#[from] FileError),
    /// A prefix that is no start of a C identifier.
    #[error(
        "\"{prefix}\" can not begin a C name: letters, digits and underscores, no digit first, at most {MAX_PREFIX} of them"
    )]
    Prefix {
        /// The prefix.
        prefix: String,
    },
}

/// Longest prefix of C names; C99 promises 31 significant characters for external names.
pub const MAX_PREFIX: usize = 18;
