//! What the gripper's microcontroller measured at one instant.

use crate::units::Micros;

/// What the stylus channel holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
pub enum Signal {
    /// Displacement (m): heights, spacings and E_sc have a meaning.
    #[default]
    Displacement,
    /// Vibration in units of the sensor, signed or rectified: slips are found, heights are not known.
    ///
    /// The bands act on a rectified signal as it is: rectification moves its vibration towards lower and doubled
    /// frequencies, but the noise floor is measured on the same rectified signal, so the thresholds keep
    /// their meaning.
    Vibration,
}

/// Axes that a vector has beside its first one.
pub const FURTHER_AXES: usize = 2;

/// Every component of a vibration or of a motion reference.
pub type Vector = [f32; 1 + FURTHER_AXES];

/// When the computer took a reading in, by its own clock. Part of the input, so that a replay gives the same steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arrival {
    /// Host time of arrival (monotonic).
    pub at: Micros,
    /// Age of the reading on arrival: host time minus the device time mapped to the host's clock; 0 where the clocks are not related yet.
    pub age: Micros,
}

/// One row of sensor readings. Only the stylus is required; a channel the gripper does not have is `None`.
///
/// Values may be anything a broken sensor sends, NaN and infinities included: the pipeline counts such
/// readings and never lets them into its state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Device time of the reading.
    pub t: Micros,
    /// Stylus displacement along its axis (m); for an uncalibrated vibration sensor its own units (counts).
    pub stylus: f32,
    /// Normal force of one finger on the object (N).
    pub normal_force_n: Option<f32>,
    /// Tangential (load) force on one finger (N).
    pub tangential_n: Option<f32>,
    /// Moved distance of the object against the finger (m), from a roller, an encoder or an optical sensor.
    pub travel_m: Option<f32>,
    /// Slip speed measured directly (m/s).
    pub velocity_m_s: Option<f32>,
    /// Second and third component of a vibration sensor that measures along several axes, the first being `stylus` (same units);
    /// 0 where there is none.
    pub stylus_axes: [f32; FURTHER_AXES],
    /// Second stylus (m), a known distance behind the first along the slip direction.
    pub second_stylus: Option<f32>,
    /// Motion reference: an accelerometer or a stylus that does not touch the object (own units).
    pub reference: Option<f32>,
    /// Second and third component of a motion reference with several axes, the first being `reference`; 0 where there is none.
    pub reference_axes: [f32; FURTHER_AXES],
    /// Static pressure of the fingertip (own units).
    pub pressure: Option<f32>,
    /// Commanded motion of arm or fingers: 0 while they are told to stand still, anything else while they are told to move.
    pub motion: Option<f32>,
    /// When the computer took the row in; `None` where that is not known, as in a table of readings: then device time stands for host time.
    pub arrival: Option<Arrival>,
}

impl Sample {
    /// A sample of the stylus alone.
    #[must_use]
    pub fn stylus(t: Micros, stylus: f32) -> Self {
        Self { t, stylus, ..Self::default() }
    }

    /// Every component of the stylus or vibration sensor (its unit).
    #[must_use]
    pub const fn vibration(&self) -> Vector {
        let [y, z] = self.stylus_axes;
        [self.stylus, y, z]
    }

    /// Every component of the motion reference (its unit), where it has a reading.
    #[must_use]
    pub const fn reference_vector(&self) -> Option<Vector> {
        let [y, z] = self.reference_axes;
        match self.reference {
            Some(x) => Some([x, y, z]),
            None => None,
        }
    }

    /// The readings of one value each in the order of the fields above, without the time.
    #[must_use]
    pub const fn readings(&self) -> [Option<f32>; 9] {
        [
            Some(self.stylus),
            self.normal_force_n,
            self.tangential_n,
            self.travel_m,
            self.velocity_m_s,
            self.second_stylus,
            self.reference,
            self.pressure,
            self.motion,
        ]
    }
}
