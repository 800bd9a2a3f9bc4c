//! The three classic ways to notice a slip, and which of them may speak.

/// A way to notice a slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
pub enum Method {
    /// Vibration of the stylus.
    Stylus,
    /// Moved distance of the object, from a roller or an encoder.
    Travel,
    /// Change of the pressure distribution under the finger.
    Pressure,
}

impl Method {
    /// Every method, the fastest first.
    pub const ALL: [Self; 3] = [Self::Stylus, Self::Travel, Self::Pressure];

    /// The name used in configuration and output lines.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stylus => "stylus",
            Self::Travel => "travel",
            Self::Pressure => "pressure",
        }
    }

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// A set of methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Methods(u8);

impl Default for Methods {
    fn default() -> Self {
        Self::ALL
    }
}

impl Methods {
    /// No method: refused by a pipeline.
    pub const NONE: Self = Self(0);
    /// Whatever the gripper has.
    pub const ALL: Self =
        Self::NONE.with(Method::Stylus).with(Method::Travel).with(Method::Pressure);

    /// One method alone.
    #[must_use]
    pub const fn only(method: Method) -> Self {
        Self(method.bit())
    }

    /// The same set and `method`.
    #[must_use]
    pub const fn with(self, method: Method) -> Self {
        Self(self.0 | method.bit())
    }

    /// The same set without `method`.
    #[must_use]
    pub const fn without(self, method: Method) -> Self {
        Self(self.0 & !method.bit())
    }

    /// Whether `method` may speak.
    #[must_use]
    #[inline]
    pub const fn has(self, method: Method) -> bool {
        self.0 & method.bit() != 0
    }

    /// Number of methods in the set.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }
}

#[cfg(test)]
mod tests {
    use super::{Method, Methods};

    #[test]
    fn a_set_holds_what_was_put_in() {
        for method in Method::ALL {
            let one = Methods::only(method);
            assert_eq!(Method::ALL.map(|other| one.has(other)), Method::ALL.map(|o| o == method));
            assert!(Methods::ALL.has(method) && !Methods::NONE.has(method));
            assert_eq!(one.without(method), Methods::NONE);
        }
        assert_eq!((Methods::ALL.count(), Methods::NONE.count()), (3, 0));
    }
}
