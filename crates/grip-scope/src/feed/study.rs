//! The curves of a study.

/// Learning curves of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyCurves {
    /// What the study is called.
    pub title: String,
    /// Its plots.
    pub plots: Vec<StudyPlot>,
    /// Sentences beside them.
    pub notes: Vec<String>,
}

/// One plot of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyPlot {
    /// Title.
    pub title: String,
    /// Its curves: mean squared errors over epochs.
    pub curves: Vec<StudyCurve>,
}

/// One curve of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyCurve {
    /// What the legend states.
    pub name: String,
    /// Points.
    pub points: Vec<[f64; 2]>,
}
