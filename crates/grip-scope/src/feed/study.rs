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
    /// What x is.
    pub x_label: String,
    /// What y is.
    pub y_label: String,
    /// Whether y is to be drawn on a logarithmic axis.
    pub log_y: bool,
    /// Its curves.
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
