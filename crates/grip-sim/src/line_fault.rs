//! Wire bytes and a kind of fault in; the bytes as a bad line delivers them, and what part of them is still whole, out.
//!
//! What is whole follows from where the fault was put ([`Faulty::place_of`]), never from a decoder: this is the ground
//! truth that link tests compare decoders with.

use core::ops::Range;
use rand_core::Rng;

/// Longest block that is lost or doubled (bytes): one USB full-speed packet.
const PACKET: usize = 64;
/// Longest stretch of garbage (bytes).
const MOST_GARBAGE: usize = 300;

slip_msg::named! {
    /// What a line does to bytes.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum LineFault {
        fn name: "A few words for tables.";
    }
    BitFlip: "One bit of one byte is inverted.", "bit flipped";
    ByteReplaced: "One byte becomes another one.", "byte replaced";
    Deleted: "1 to 8 bytes in a row are missing.", "1-8 bytes deleted";
    Inserted: "1 to 8 random bytes appear.", "1-8 bytes inserted";
    Burst: "2 to 32 bytes in a row become random ones.", "burst of 2-32 bytes";
    PacketLost: "64 bytes in a row are missing.", "64 bytes lost";
    PacketDoubled: "64 bytes in a row come twice.", "64 bytes doubled";
    Swapped: "Two neighbouring blocks of 1 to 64 bytes change places.", "blocks swapped";
    StallAndGarbage: "The line stands still, then delivers 0 to 300 random bytes before it goes on.", "stall, garbage";
}

impl LineFault {
    /// Puts one fault of this kind at a random place of `old`. Nothing happens to no bytes.
    #[must_use]
    pub fn inject(self, old: &[u8], rng: &mut impl Rng) -> Faulty {
        let at = below(rng, old.len());
        let up_to = |len: usize| at..(at + len).min(old.len());
        match self {
            Self::BitFlip => {
                let bit = 1 << below(rng, 8);
                replaced(old, up_to(1), &mapped(old, up_to(1), |byte| byte ^ bit))
            }
            Self::ByteReplaced => {
                let change = u8::try_from(1 + below(rng, 255)).unwrap_or(1);
                replaced(old, up_to(1), &mapped(old, up_to(1), |byte| byte ^ change))
            }
            Self::Deleted => replaced(old, up_to(1 + below(rng, 8)), &[]),
            Self::Inserted => {
                let len = 1 + below(rng, 8);
                replaced(old, at..at, &noise(rng, len))
            }
            Self::Burst => {
                let hit = up_to(2 + below(rng, 31));
                let burst = noise(rng, hit.len());
                replaced(old, hit, &burst)
            }
            Self::PacketLost => replaced(old, up_to(PACKET), &[]),
            Self::PacketDoubled => {
                let packet = up_to(PACKET);
                let copy = mapped(old, packet.clone(), |byte| byte);
                replaced(old, packet.end..packet.end, &copy)
            }
            Self::Swapped => {
                let (first, second) = (1 + below(rng, PACKET), 1 + below(rng, PACKET));
                let (block, both) = (up_to(first), up_to(first + second));
                let mut turned = mapped(old, block.end..both.end, |byte| byte);
                turned.extend(mapped(old, block, |byte| byte));
                replaced(old, both, &turned)
            }
            Self::StallAndGarbage => {
                let len = below(rng, MOST_GARBAGE + 1);
                replaced(old, at..at, &noise(rng, len))
            }
        }
    }
}

/// What came out of the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faulty {
    /// The bytes delivered.
    pub bytes: Vec<u8>,
    /// The old bytes that the fault hit; empty where it only put bytes in between.
    pub touched: Range<usize>,
    /// Bytes put in the place of the touched ones.
    pub put: usize,
}

impl Faulty {
    /// Where an old stretch of bytes lies now; `None` where the fault hit it or fell into it.
    #[must_use]
    pub fn place_of(&self, old: &Range<usize>) -> Option<Range<usize>> {
        if old.end <= self.touched.start {
            return Some(old.clone());
        }
        if self.put == 0 && self.touched.is_empty() {
            return Some(old.clone());
        }
        (old.start >= self.touched.end).then(|| self.shifted(old.start)..self.shifted(old.end))
    }

    fn shifted(&self, position: usize) -> usize {
        position - self.touched.len() + self.put
    }
}

fn replaced(old: &[u8], touched: Range<usize>, with: &[u8]) -> Faulty {
    let (head, tail) = (old.get(..touched.start), old.get(touched.end..));
    let bytes = [head.unwrap_or(&[]), with, tail.unwrap_or(&[])].concat();
    Faulty { bytes, touched, put: with.len() }
}

fn mapped(old: &[u8], range: Range<usize>, change: impl Fn(u8) -> u8) -> Vec<u8> {
    old.get(range).unwrap_or(&[]).iter().map(|&byte| change(byte)).collect()
}

fn noise(rng: &mut impl Rng, len: usize) -> Vec<u8> {
    let mut bytes = vec![0; len];
    rng.fill_bytes(&mut bytes);
    bytes
}

/// Uniform in `0..end`, 0 where `end` is 0.
fn below(rng: &mut impl Rng, end: usize) -> usize {
    let end = u64::try_from(end).unwrap_or(u64::MAX).max(1);
    usize::try_from(rng.next_u64() % end).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::SeedableRng;

    /// Bytes that report their own place: what [`Faulty::place_of`] calls whole must read the same there.
    #[test]
    fn whole_stretches_are_where_they_are_stated_to_be() {
        let old: Vec<u8> = (0..=255).chain(0..=255).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for fault in LineFault::ALL {
            let (mut whole, mut hit) = (0, 0);
            for _ in 0..2000 {
                let faulty = fault.inject(&old, &mut rng);
                let start = below(&mut rng, old.len() - 40);
                let span = start..start + 40;
                match faulty.place_of(&span) {
                    Some(place) => {
                        assert_eq!(faulty.bytes[place], old[span], "{fault:?}");
                        whole += 1;
                    }
                    None => hit += 1,
                }
            }
            assert!(whole > 1000 && hit > 50, "{fault:?}: {whole} whole, {hit} hit");
        }
    }

    #[test]
    fn each_fault_does_what_its_name_states() {
        let old = [7_u8; 500];
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..500 {
            let mut change = |fault: LineFault| fault.inject(&old, &mut rng);
            let differing = |faulty: &Faulty| faulty.bytes.iter().filter(|&&b| b != 7).count();
            let flipped = change(LineFault::BitFlip);
            let bits: u32 = flipped.bytes.iter().map(|byte| (byte ^ 7).count_ones()).sum();
            assert_eq!((flipped.bytes.len(), bits), (500, 1));
            let other = change(LineFault::ByteReplaced);
            assert_eq!((other.bytes.len(), differing(&other)), (500, 1));
            assert!((492..500).contains(&change(LineFault::Deleted).bytes.len()));
            assert!((501..=508).contains(&change(LineFault::Inserted).bytes.len()));
            let burst = change(LineFault::Burst);
            assert!(burst.bytes.len() == 500 && differing(&burst) <= 32);
            assert!((436..500).contains(&change(LineFault::PacketLost).bytes.len()));
            assert!((501..=564).contains(&change(LineFault::PacketDoubled).bytes.len()));
            assert_eq!(change(LineFault::Swapped).bytes, old);
            assert!((500..=800).contains(&change(LineFault::StallAndGarbage).bytes.len()));
        }
    }

    #[test]
    fn nothing_comes_of_nothing_but_noise() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for fault in LineFault::ALL {
            let faulty = fault.inject(&[], &mut rng);
            let noisy = matches!(
                fault,
                LineFault::Inserted | LineFault::StallAndGarbage | LineFault::Burst
            );
            assert!(noisy || faulty.bytes.is_empty(), "{fault:?}");
        }
    }
}
