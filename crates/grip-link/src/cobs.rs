//! Consistent overhead byte stuffing: the same bytes without zeros, and back.
//!
//! A code byte `c` stands before `c - 1` data bytes; a zero follows them unless `c = 255` or the data end
//! there (S. Cheshire, M. Baker, "Consistent Overhead Byte Stuffing", 1997). Implementations differ after a
//! final block of exactly 254 data bytes: this encoder ends there, the decoder also takes the trailing `01`
//! that others add.

/// Zeros in a row that are decoded in one step.
const RUN: usize = 8;

/// Longest encoding of `len` bytes.
#[must_use]
pub const fn max_encoded(len: usize) -> usize {
    if len == 0 { 1 } else { len + len.div_ceil(254) }
}

/// Encodes slices one after the other into `out`, without delimiters.
#[derive(Debug)]
pub struct Encoder<'a> {
    out: &'a mut [u8],
    code_at: usize,
    code: u8,
    fits: bool,
}

impl<'a> Encoder<'a> {
    /// An encoder that writes from `out[0]` on.
    #[must_use]
    pub fn new(out: &'a mut [u8]) -> Self {
        let fits = !out.is_empty();
        Self { out, code_at: 0, code: 1, fits }
    }

    fn end(&self) -> usize {
        self.code_at + usize::from(self.code)
    }

    fn close_block(&mut self) {
        if let Some(slot) = self.out.get_mut(self.code_at) {
            *slot = self.code;
        }
        self.code_at = self.end();
        self.code = 1;
        self.fits &= self.code_at < self.out.len();
    }

    /// Appends `bytes`.
    pub fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if self.code == u8::MAX {
                self.close_block();
            }
            if byte == 0 {
                self.close_block();
            } else {
                let end = self.end();
                match self.out.get_mut(end) {
                    Some(slot) => *slot = byte,
                    None => self.fits = false,
                }
                self.code += 1;
            }
        }
    }

    /// Ends the last block; the number of bytes written, or `None` when they did not fit.
    #[must_use]
    pub fn finish(mut self) -> Option<usize> {
        let len = self.end();
        let fits = self.fits && len <= self.out.len();
        self.close_block();
        fits.then_some(len)
    }
}

/// Encodes `data` into `out`; the encoded length, or `None` when `out` is too short.
///
/// [`max_encoded`]`(data.len())` bytes always suffice.
#[must_use]
pub fn encode(data: &[u8], out: &mut [u8]) -> Option<usize> {
    let mut encoder = Encoder::new(out);
    encoder.push(data);
    encoder.finish()
}

/// Decodes the zero-free `block` in place; the data are the returned part of it.
///
/// Decoded byte i stands at encoded byte i + 1, so only code bytes are overwritten; after a full block
/// the part before it moves up by one. `None` when a code is 0 or points past the end.
#[must_use]
pub fn decode_in_place(block: &mut [u8]) -> Option<&mut [u8]> {
    let mut start = 1;
    let mut at = 0;
    let mut code = *block.first()?;
    loop {
        if code == 0 {
            return None;
        }
        if code == 1
            && let Some(run) =
                block.get_mut(at + 1..).and_then(|rest| rest.first_chunk_mut::<RUN>())
            && *run == [1; RUN]
        {
            *run = [0; RUN];
            at += RUN;
            continue;
        }
        let next = at + usize::from(code);
        let Some(slot) = block.get_mut(next) else {
            at = next;
            break;
        };
        let following = *slot;
        if code == u8::MAX {
            let part @ [_, ..] = block.get_mut(start..=next)? else { return None };
            part.rotate_right(1);
            start += 1;
        } else {
            *slot = 0;
        }
        at = next;
        code = following;
    }
    if at == block.len() { block.get_mut(start..) } else { None }
}

/// Position of the first zero byte.
#[must_use]
pub fn find_zero(bytes: &[u8]) -> Option<usize> {
    const STEP: usize = 32;
    let (blocks, _) = bytes.as_chunks::<STEP>();
    let clean = blocks
        .iter()
        .take_while(|block| block.iter().fold(u8::MAX, |low, &b| low.min(b)) != 0)
        .count();
    let skipped = clean * STEP;
    bytes.get(skipped..)?.iter().position(|&byte| byte == 0).map(|i| skipped + i)
}

// Lengths and bytes of blocks: protocol/vectors, rows `cobs`.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_short_an_output_is_refused() {
        for len in 0..6 {
            let mut out = [0; 6];
            assert_eq!(encode(&[1, 2, 0, 3, 4], &mut out[..len]), None);
        }
        assert_eq!(encode(&[1, 2, 0, 3, 4], &mut [0; 6]), Some(6));
        assert_eq!(encode(&[1, 0], &mut [0; 2]), None);
    }

    #[test]
    fn zeros_are_found_at_every_place() {
        assert_eq!(find_zero(&[7; 100]), None);
        for at in 0..100 {
            let mut with = [7; 100];
            with[at] = 0;
            assert_eq!(find_zero(&with), Some(at));
        }
    }
}
