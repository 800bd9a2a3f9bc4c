//! What can go wrong between rows and report.

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The simulator refused the condition.
    #[error("rows of the simulator")]
    Rows(#[from] grip_sim::GeneratorError),
    /// The rows are no data set.
    #[error(transparent)]
    Data(#[from] mlp::train::DataSetError),
    /// A condition names its columns wrongly.
    #[error(transparent)]
    Column(#[from] mlp::train::ColumnSpecError),
    /// A condition asks for a column that a trial grasp has not.
    #[error("a trial grasp has no column \"{0}\"")]
    NoColumn(String),
    /// No training came to an end.
    #[error("condition {condition}, {learner}: {source}")]
    Fit {
        /// Name of the condition.
        condition: &'static str,
        /// Which learner.
        learner: &'static str,
        /// Why.
        source: mlp::train::FitError,
    },
    /// No Gaussian process, or no other learner.
    #[error("condition {condition}: {source}")]
    Learner {
        /// Name of the condition.
        condition: &'static str,
        /// Why.
        source: Box<crate::outlook::OutlookError>,
    },
    /// A learner beyond the nets of the study.
    #[error(transparent)]
    Outlook(#[from] crate::outlook::OutlookError),
    /// A setting of the study that can not work.
    #[error("{name} is {value}: it must be {range}")]
    Setting {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: usize,
        /// What is possible.
        range: &'static str,
    },
    /// A setting of a trainer that can not work.
    #[error(transparent)]
    Trainer(#[from] mlp::train::SettingError),
}
