//! The two cursors that all messages use: fields in order, little-endian.

use crate::Wire;
use core::ops::RangeBounds;
use thiserror::Error;

/// Why a payload cannot be read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PayloadError {
    /// The payload ends before a field.
    #[error("payload of {have} bytes ends before byte {need}")]
    Short {
        /// Bytes needed up to the end of the field.
        need: usize,
        /// Bytes there.
        have: usize,
    },
    /// A field holds a value that has no meaning.
    #[error("byte {at} holds {value}, which is outside its range")]
    Value {
        /// Offset of the field.
        at: usize,
        /// What it holds.
        value: i64,
    },
    /// The message does not fit the output.
    #[error("message does not fit {have} bytes")]
    Full {
        /// Room given.
        have: usize,
    },
    /// No message of this type is read here.
    #[error("type {kind:02x} has no payload here")]
    Kind {
        /// Type byte.
        kind: u8,
    },
}

/// Reads fields one after the other.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// From the first byte.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// From byte `at`.
    #[must_use]
    pub const fn at_offset(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], PayloadError> {
        let need = self.at.saturating_add(N);
        let found = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        self.at = need;
        found.copied().ok_or(PayloadError::Short { need, have: self.bytes.len() })
    }

    /// The next `len` bytes.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn slice(&mut self, len: usize) -> Result<&'a [u8], PayloadError> {
        let need = self.at.saturating_add(len);
        let found = self.bytes.get(self.at..need);
        self.at = need;
        found.ok_or(PayloadError::Short { need, have: self.bytes.len() })
    }

    /// Reads a number where NaN stands for none; an infinite one is refused.
    ///
    /// # Errors
    /// [`PayloadError::Short`] or [`PayloadError::Value`].
    pub fn maybe(&mut self) -> Result<Option<f32>, PayloadError> {
        let at = self.at;
        let value = self.f32()?;
        if value.is_infinite() {
            return Err(PayloadError::Value { at, value: i64::from(value.to_bits()) });
        }
        Ok((!value.is_nan()).then_some(value))
    }

    /// Reads a count of bytes, then as many of text.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn text(&mut self) -> Result<&'a [u8], PayloadError> {
        let len = self.u8()?;
        self.slice(usize::from(len))
    }

    /// Bytes that are left.
    #[must_use]
    pub const fn rest(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// Reads a field that is refused outside `range`.
    ///
    /// # Errors
    /// [`PayloadError::Short`] or [`PayloadError::Value`].
    pub fn within<T: Wire<'a> + PartialOrd + Into<i64>>(
        &mut self,
        range: impl RangeBounds<T>,
    ) -> Result<T, PayloadError> {
        let at = self.at;
        let value = T::read(self)?;
        if range.contains(&value) {
            Ok(value)
        } else {
            Err(PayloadError::Value { at, value: value.into() })
        }
    }

    /// Reads a byte that `meaning` understands.
    ///
    /// # Errors
    /// [`PayloadError::Short`] or [`PayloadError::Value`].
    pub fn coded<T>(&mut self, meaning: impl Fn(u8) -> Option<T>) -> Result<T, PayloadError> {
        let at = self.at;
        let value = self.u8()?;
        meaning(value).ok_or(PayloadError::Value { at, value: i64::from(value) })
    }
}

macro_rules! numbers {
    ($($kind:ident)+) => {
        impl Reader<'_> { $(
            #[doc = concat!("The next field, a `", stringify!($kind), "`.")]
            ///
            /// # Errors
            /// [`PayloadError::Short`].
            pub fn $kind(&mut self) -> Result<$kind, PayloadError> {
                self.take().map($kind::from_le_bytes)
            }
        )+ }

        impl Writer<'_> { $(
            #[doc = concat!("Appends a `", stringify!($kind), "`.")]
            #[must_use]
            pub fn $kind(self, value: $kind) -> Self {
                self.put(&value.to_le_bytes())
            }
        )+ }
    };
}

numbers!(u8 u16 u32 u64 i32 i64 f32);

/// Writes fields one after the other.
#[derive(Debug)]
pub struct Writer<'a> {
    out: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    /// Writes from the first byte of `out`.
    #[must_use]
    pub const fn new(out: &'a mut [u8]) -> Self {
        Self { out, at: 0 }
    }

    /// Appends bytes.
    #[must_use]
    pub fn put(mut self, bytes: &[u8]) -> Self {
        let room = self.out.get_mut(self.at..).and_then(|free| free.get_mut(..bytes.len()));
        if let Some(room) = room {
            room.copy_from_slice(bytes);
        }
        self.at = self.at.saturating_add(bytes.len());
        self
    }

    /// A number, NaN where there is none or it is not finite.
    #[must_use]
    pub fn maybe(self, value: Option<f32>) -> Self {
        self.f32(value.filter(|value| value.is_finite()).unwrap_or(f32::NAN))
    }

    /// A count of bytes and the text: at most 255 bytes, cut where it is longer.
    #[must_use]
    pub fn text(self, text: &[u8]) -> Self {
        let text = text.get(..usize::from(u8::MAX)).unwrap_or(text);
        self.u8(u8::try_from(text.len()).unwrap_or(u8::MAX)).put(text)
    }

    /// How many bytes were written.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn finish(self) -> Result<usize, PayloadError> {
        if self.at <= self.out.len() {
            Ok(self.at)
        } else {
            Err(PayloadError::Full { have: self.out.len() })
        }
    }
}
