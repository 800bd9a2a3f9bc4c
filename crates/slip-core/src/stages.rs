//! How often each stage of the pipeline ran.

/// Counts since the pipeline was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCounters {
    /// Samples handled.
    pub samples: u64,
    /// Samples that went through the filter bank and the detector.
    pub bands: u64,
    /// Samples that also went through the bands of the motion reference and the gate.
    pub gate: u64,
    /// Travel readings and taxel frames that were looked at.
    pub methods: u64,
    /// Samples of slips, measured for speed, irregularities and E_sc.
    pub observation: u64,
    /// Answers asked of the network.
    pub inferences: u64,
    /// Answers the network could not give.
    pub refused_estimates: u64,
    /// Times a quieter second has lowered the noise floor.
    pub floor_lowered: u64,
}
