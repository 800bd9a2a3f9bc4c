//! Conversion between the force register of a model and newtons.

use core::{fmt, str::FromStr};

/// A gripper of which the range of force is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// 2F-85: 20 to 235 N.
    F85,
    /// 2F-140: 10 to 125 N.
    F140,
    /// Hand-E: 20 to 185 N.
    HandE,
}

/// A name that is no model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no Robotiq gripper: expected 2f-85, 2f-140 or hand-e")]
pub struct ModelError(String);

impl Model {
    /// Every model.
    pub const ALL: [Self; 3] = [Self::F85, Self::F140, Self::HandE];

    /// How it is written in commands.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::F85 => "2f-85",
            Self::F140 => "2f-140",
            Self::HandE => "hand-e",
        }
    }

    /// Force (N) of the register at 0, by the data sheet; no less can be asked for.
    #[must_use]
    pub const fn force_min_n(self) -> f32 {
        match self {
            Self::F85 | Self::HandE => 20.0,
            Self::F140 => 10.0,
        }
    }

    /// Force (N) of the register at 255, by the data sheet.
    #[must_use]
    pub const fn force_max_n(self) -> f32 {
        match self {
            Self::F85 => 235.0,
            Self::F140 => 125.0,
            Self::HandE => 185.0,
        }
    }

    /// Force (N) of one step of the register. The scale is taken for linear; the maker calls it approximate.
    #[must_use]
    pub const fn step_n(self) -> f32 {
        (self.force_max_n() - self.force_min_n()) / 255.0
    }

    /// The register for the nearest force to `force_n` (N) that there is.
    #[must_use]
    pub fn register(self, force_n: f32) -> u8 {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
        let step = ((force_n - self.force_min_n()) / self.step_n()).round().clamp(0.0, 255.0) as u8;
        step
    }

    /// Force (N) that a value of the register asks for.
    #[must_use]
    pub fn force_n(self, register: u8) -> f32 {
        self.force_min_n() + f32::from(register) * self.step_n()
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F85 => "2F-85",
            Self::F140 => "2F-140",
            Self::HandE => "Hand-E",
        })
    }
}

impl FromStr for Model {
    type Err = ModelError;

    fn from_str(name: &str) -> Result<Self, ModelError> {
        let found = Self::ALL.into_iter().find(|model| model.name().eq_ignore_ascii_case(name));
        found.ok_or_else(|| ModelError(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::Model;

    #[test]
    fn the_ends_of_the_register_are_those_of_the_data_sheet_and_each_step_comes_back() {
        let ends = [(20.0, 235.0), (10.0, 125.0), (20.0, 185.0)];
        for (model, (least_n, most_n)) in Model::ALL.into_iter().zip(ends) {
            assert!((model.force_n(0) - least_n).abs() < 1e-6);
            assert!((model.force_n(255) - most_n).abs() < 1e-3);
            for register in 0..=255 {
                assert_eq!(model.register(model.force_n(register)), register);
            }
            assert_eq!((model.register(0.0), model.register(1e9)), (0, 255));
            assert_eq!(model.name().parse(), Ok(model));
        }
        assert_eq!(Model::F85.register(f32::NAN), 0);
        assert!("3f".parse::<Model>().is_err());
    }
}
