//! Encoder and decoder of the bytes of a CDR message: numbers and strings.
//!
//! Plain CDR (XCDR1), little-endian: four bytes 00 01 00 00, then every number at a multiple of its own size, counted from
//! after these four. A string is its length with the closing zero, its bytes, a zero; a sequence its count and its elements.
//! Source: OMG DDSI-RTPS 2.5, chapter 10; ROS 2 writes messages so.

use slip_core::pressure::MAX_TAXELS;

/// Little-endian plain CDR.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// The message ends inside a field.
    #[error("the message ends at byte {at}, inside a field")]
    Short {
        /// Bytes there are.
        at: usize,
    },
    /// The first four bytes name another encoding.
    #[error("the message is not in little-endian CDR")]
    Encoding,
    /// A string is not UTF-8, or has no closing zero.
    #[error("the string at byte {at} is not UTF-8 with a closing zero")]
    Text {
        /// Where it begins.
        at: usize,
    },
    /// A code that stands for nothing.
    #[error("the code {code} before byte {at} stands for nothing")]
    Code {
        /// The code.
        code: u8,
        /// Where the reading stopped.
        at: usize,
    },
    /// An array with too many taxels.
    #[error("{count} taxels; an array has 1 to {MAX_TAXELS}")]
    Taxels {
        /// Its taxels.
        count: usize,
    },
}

/// Appends the fields of one message.
#[derive(Debug)]
pub struct CdrWriter<'a> {
    out: &'a mut Vec<u8>,
    start: usize,
}

macro_rules! numbers {
    ($($kind:ident),*) => {
        impl CdrWriter<'_> { $(
            #[doc = concat!("Appends a `", stringify!($kind), "`.")]
            #[inline]
            pub fn $kind(&mut self, value: $kind) -> &mut Self {
                self.align(size_of::<$kind>());
                self.out.extend_from_slice(&value.to_le_bytes());
                self
            }
        )* }
        impl CdrReader<'_> { $(
            #[doc = concat!("The next field, a `", stringify!($kind), "`.")]
            ///
            /// # Errors
            /// [`CdrError::Short`].
            #[inline]
            pub fn $kind(&mut self) -> Result<$kind, CdrError> {
                self.align(size_of::<$kind>());
                self.take().map($kind::from_le_bytes)
            }
        )* }
    };
}

numbers!(u8, u16, u32, u64, i32, f32, f64);

impl<'a> CdrWriter<'a> {
    /// Begins a message at the end of `out`.
    pub fn new(out: &'a mut Vec<u8>) -> Self {
        out.extend_from_slice(&HEADER);
        let start = out.len();
        Self { out, start }
    }

    #[inline]
    fn align(&mut self, size: usize) {
        let over = (self.out.len() - self.start) % size;
        if over > 0 {
            self.out.extend_from_slice(&[0; 8][..size - over]);
        }
    }

    /// Appends a `bool`.
    pub fn bool(&mut self, value: bool) -> &mut Self {
        self.u8(value.into())
    }

    /// Appends a string; one of 4 GiB and more, which no event has, is left empty.
    pub fn text(&mut self, text: &str) -> &mut Self {
        let (text, len) = match u32::try_from(text.len()).ok().and_then(|len| len.checked_add(1)) {
            Some(len) => (text, len),
            None => ("", 1),
        };
        self.u32(len);
        self.out.extend_from_slice(text.as_bytes());
        self.out.push(0);
        self
    }

    /// Appends a sequence of bytes; one of 4 GiB and more is left empty.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        let (bytes, len) = u32::try_from(bytes.len()).map_or((&[][..], 0), |len| (bytes, len));
        self.u32(len);
        self.out.extend_from_slice(bytes);
        self
    }

    /// Appends a sequence of `f32`; one of 2^32 and more is left empty.
    pub fn floats(&mut self, values: &[f32]) -> &mut Self {
        let (values, len) = u32::try_from(values.len()).map_or((&[][..], 0), |len| (values, len));
        self.u32(len);
        for value in values {
            self.out.extend_from_slice(&value.to_le_bytes());
        }
        self
    }

    /// Appends a `builtin_interfaces/Time`: nanoseconds since 1970. From 2038 on, which its seconds cannot state, the last there is.
    pub fn time(&mut self, ns: u64) -> &mut Self {
        let seconds = i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX);
        let nanos = (ns % 1_000_000_000) as u32;
        self.i32(seconds).u32(nanos)
    }
}

/// Reads the fields of one message in their order.
#[derive(Clone, Debug)]
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> CdrReader<'a> {
    /// Begins to read a message.
    ///
    /// # Errors
    /// [`CdrError::Short`] and [`CdrError::Encoding`].
    pub fn new(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let (head, bytes) = bytes.split_at_checked(4).ok_or(CdrError::Short { at: bytes.len() })?;
        if head != HEADER {
            return Err(CdrError::Encoding);
        }
        Ok(Self { bytes, at: 0 })
    }

    /// Bytes read so far, from after the first four.
    #[must_use]
    pub fn position(&self) -> usize {
        self.at
    }

    /// Whether every byte of the message has been read.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    #[inline]
    fn align(&mut self, size: usize) {
        self.at = self.at.next_multiple_of(size);
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        let short = CdrError::Short { at: self.bytes.len() };
        let rest = self.bytes.get(self.at..).ok_or(short)?;
        let taken = *rest.first_chunk().ok_or(short)?;
        self.at += N;
        Ok(taken)
    }

    /// The next fields, `N` of them `f32`.
    ///
    /// # Errors
    /// [`CdrError::Short`].
    #[inline]
    pub fn f32s<const N: usize>(&mut self) -> Result<[f32; N], CdrError> {
        self.align(size_of::<f32>());
        let mut values = [0.0; N];
        let (bytes, _) = self.slice(size_of::<[f32; N]>())?.as_chunks();
        for (value, bytes) in values.iter_mut().zip(bytes) {
            *value = f32::from_le_bytes(*bytes);
        }
        Ok(values)
    }

    #[inline]
    fn slice(&mut self, len: usize) -> Result<&'a [u8], CdrError> {
        let short = CdrError::Short { at: self.bytes.len() };
        let end = self.at.checked_add(len).ok_or(short)?;
        let taken = self.bytes.get(self.at..end).ok_or(short)?;
        self.at = end;
        Ok(taken)
    }

    /// The next field, a `bool`: anything but 0 is true.
    ///
    /// # Errors
    /// [`CdrError::Short`].
    pub fn bool(&mut self) -> Result<bool, CdrError> {
        Ok(self.u8()? != 0)
    }

    /// The next field, a string.
    ///
    /// # Errors
    /// [`CdrError::Short`] and [`CdrError::Text`].
    pub fn text(&mut self) -> Result<&'a str, CdrError> {
        let len = self.u32()? as usize;
        let at = self.at;
        let bytes = self.slice(len)?;
        let text = bytes.strip_suffix(&[0]).ok_or(CdrError::Text { at })?;
        core::str::from_utf8(text).map_err(|_| CdrError::Text { at })
    }

    /// The next field, a sequence of bytes.
    ///
    /// # Errors
    /// [`CdrError::Short`].
    pub fn bytes(&mut self) -> Result<&'a [u8], CdrError> {
        let len = self.u32()? as usize;
        self.slice(len)
    }

    /// The next field, a sequence of `f32`, appended to `out`.
    ///
    /// # Errors
    /// [`CdrError::Short`].
    pub fn floats(&mut self, out: &mut Vec<f32>) -> Result<(), CdrError> {
        let count = self.u32()? as usize;
        let len = count.checked_mul(4).ok_or(CdrError::Short { at: self.bytes.len() })?;
        let bytes = self.slice(len)?;
        out.extend(
            bytes.chunks_exact(4).filter_map(|c| c.first_chunk()).map(|c| f32::from_le_bytes(*c)),
        );
        Ok(())
    }

    /// The next field, a `builtin_interfaces/Time`, in nanoseconds since 1970; 0 before.
    ///
    /// # Errors
    /// [`CdrError::Short`].
    pub fn time(&mut self) -> Result<u64, CdrError> {
        let seconds = u64::try_from(self.i32()?).unwrap_or(0);
        Ok(seconds * 1_000_000_000 + u64::from(self.u32()?))
    }
}

#[cfg(test)]
mod tests {
    use super::{CdrError, CdrReader, CdrWriter};

    /// Written by hand from the standard: a byte, an aligned u16, u32, u64, a string of 2 and a double after it.
    const BY_HAND: [u8; 44] = [
        0, 1, 0, 0, // little-endian CDR
        7, 0, 2, 1, // u8 7, padding, u16 0x0102
        0x0d, 0x0c, 0x0b, 0x0a, // u32 0x0a0b0c0d
        1, 0, 0, 0, 0, 0, 0, 0x80, // u64 at 8: no padding
        3, 0, 0, 0, b'h', b'i', 0, // string of 2 at 16, ends at 23
        0, // padding to 24
        0, 0, 0, 0, 0, 0, 0xf8, 0x3f, // f64 1.5
        1, 0, 0, 0, 0, 0, 0x80, 0xbf, // one f32, -1
    ];

    #[test]
    fn the_bytes_are_those_of_the_standard() {
        let mut out = Vec::new();
        let mut w = CdrWriter::new(&mut out);
        w.u8(7).u16(0x0102).u32(0x0a0b_0c0d).u64(0x8000_0000_0000_0001);
        w.text("hi").f64(1.5).floats(&[-1.0]);
        assert_eq!(out, BY_HAND);
        let mut r = CdrReader::new(&BY_HAND).unwrap();
        assert_eq!((r.u8(), r.u16(), r.u32()), (Ok(7), Ok(0x0102), Ok(0x0a0b_0c0d)));
        assert_eq!((r.u64(), r.text(), r.f64()), (Ok(0x8000_0000_0000_0001), Ok("hi"), Ok(1.5)));
        let mut floats = Vec::new();
        assert_eq!((r.floats(&mut floats), floats), (Ok(()), vec![-1.0]));
        assert_eq!(r.u8(), Err(CdrError::Short { at: 40 }));
    }

    #[test]
    fn every_bit_of_a_float_survives() {
        let values =
            [f32::MIN_POSITIVE / 3.0, -0.0, f32::INFINITY, f32::from_bits(0x7fc0_0123), 1e-7];
        let mut out = Vec::new();
        CdrWriter::new(&mut out).floats(&values);
        let mut back = Vec::new();
        CdrReader::new(&out).unwrap().floats(&mut back).unwrap();
        assert!(back.iter().map(|v| v.to_bits()).eq(values.iter().map(|v| v.to_bits())));
    }

    #[test]
    fn what_is_no_message_is_reported() {
        assert_eq!(CdrReader::new(&[0, 1]).unwrap_err(), CdrError::Short { at: 2 });
        assert_eq!(CdrReader::new(&[0, 0, 0, 0]).unwrap_err(), CdrError::Encoding);
        let unclosed = [0, 1, 0, 0, 1, 0, 0, 0, b'x'];
        assert_eq!(CdrReader::new(&unclosed).unwrap().text(), Err(CdrError::Text { at: 4 }));
        let endless = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff];
        let mut r = CdrReader::new(&endless).unwrap();
        assert_eq!(r.clone().bytes(), Err(CdrError::Short { at: 4 }));
        assert_eq!(r.floats(&mut Vec::new()), Err(CdrError::Short { at: 4 }));
    }

    #[test]
    fn a_time_ends_where_its_seconds_end() {
        for (ns, back) in [
            (1_763_766_000_123_456_789, 1_763_766_000_123_456_789),
            (u64::MAX, 2_147_483_647_709_551_615),
        ] {
            let mut out = Vec::new();
            CdrWriter::new(&mut out).time(ns);
            assert_eq!(CdrReader::new(&out).unwrap().time(), Ok(back));
        }
    }
}
