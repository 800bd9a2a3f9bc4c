//! Which of the three classic ways to notice a slip are used.

pub use slip_msg::Method;

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
        Self(bit(method))
    }

    /// The same set and `method`.
    #[must_use]
    pub const fn with(self, method: Method) -> Self {
        Self(self.0 | bit(method))
    }

    /// The same set without `method`.
    #[must_use]
    pub const fn without(self, method: Method) -> Self {
        Self(self.0 & !bit(method))
    }

    /// Whether `method` may speak.
    #[must_use]
    #[inline]
    pub const fn has(self, method: Method) -> bool {
        self.0 & bit(method) != 0
    }

    /// Number of methods in the set.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }
}

const fn bit(method: Method) -> u8 {
    match method {
        Method::Stylus => 1,
        Method::Travel => 2,
        Method::Pressure => 4,
        Method::None | Method::Other(_) => 0,
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
