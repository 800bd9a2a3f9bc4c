//! Nine kinds of line faults on streams of frames: nothing corrupt is accepted, no untouched frame is lost, and none comes
//! late. `GRIP_LINK_FAULTS` sets the faults of each kind (20,000 by default).

use core::ops::Range;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Header, MAX_WIRE, encode};
use grip_link::message::Kind;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

const FRAMES: usize = 7;

struct Dice(ChaCha8Rng);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.0.next_u64() % u64::try_from(end).unwrap()).unwrap()
    }

    fn bytes(&mut self, len: usize) -> Vec<u8> {
        let mut bytes = vec![0; len];
        self.0.fill_bytes(&mut bytes);
        bytes
    }
}

struct Stream {
    bytes: Vec<u8>,
    /// Wire bytes of each frame, delimiters included.
    spans: Vec<Range<usize>>,
    payloads: Vec<Vec<u8>>,
}

fn stream(dice: &mut Dice) -> Stream {
    let mut made = Stream { bytes: Vec::new(), spans: Vec::new(), payloads: Vec::new() };
    for seq in 0..FRAMES {
        let longest = if dice.below(4) == 0 { 481 } else { 64 };
        let len = dice.below(longest);
        let mut payload = dice.bytes(len);
        if dice.below(2) == 0 {
            payload.iter_mut().for_each(|byte| *byte &= 3);
        }
        let header = Header::new(Direction::ToHost, Kind::SAMPLES, u16::try_from(seq).unwrap(), 1);
        let mut out = [0; MAX_WIRE];
        let len = encode(&header, &payload, &mut out).unwrap();
        let start = made.bytes.len();
        made.bytes.extend_from_slice(&out[..len]);
        made.spans.push(start..start + len);
        made.payloads.push(payload);
    }
    made
}

/// Changed bytes, what part of the old ones was touched (empty: a place between bytes), and, for each new byte
/// position behind the fault, how far it moved.
struct Faulty {
    bytes: Vec<u8>,
    touched: Range<usize>,
    moved: isize,
}

fn replaced(old: &[u8], touched: Range<usize>, with: &[u8]) -> Faulty {
    let bytes = [&old[..touched.start], with, &old[touched.end..]].concat();
    let moved = isize::try_from(bytes.len()).unwrap() - isize::try_from(old.len()).unwrap();
    Faulty { bytes, touched, moved }
}

fn inject(kind: &str, old: &[u8], dice: &mut Dice) -> Faulty {
    let at = dice.below(old.len());
    let up_to = |len: usize| at..(at + len).min(old.len());
    match kind {
        "flip" => replaced(old, at..at + 1, &[old[at] ^ (1 << dice.below(8))]),
        "delete" => replaced(old, at..at + 1, &[]),
        "insert" => replaced(old, at..at, &dice.bytes(1)),
        "burst" => {
            let range = up_to(2 + dice.below(30));
            let noise = dice.bytes(range.len());
            replaced(old, range, &noise)
        }
        "lost 64" => replaced(old, up_to(64), &[]),
        "duplicated" => {
            let range = up_to(1 + dice.below(600));
            replaced(old, range.end..range.end, &old[range])
        }
        "swapped" => {
            let len = 1 + dice.below(64);
            let (first, both) = (up_to(len), up_to(2 * len));
            let turned = [&old[first.end..both.end], &old[first]].concat();
            replaced(old, both, &turned)
        }
        "stall" => replaced(old, at..at, &[]),
        "garbage" => {
            let len = 1 + dice.below(300);
            replaced(old, at..at, &dice.bytes(len))
        }
        _ => unreachable!(),
    }
}

/// Whether the wire bytes of a frame came through whole and in place.
fn untouched(span: &Range<usize>, fault: &Faulty) -> bool {
    let Range { start, end } = fault.touched.clone();
    if start == end && fault.moved == 0 {
        return true;
    }
    span.end <= start || span.start >= end
}

/// Feeds the bytes in random pieces; accepted frames with the position of the byte that completed each.
fn receive(bytes: &[u8], dice: &mut Dice) -> Vec<(u16, Vec<u8>, usize)> {
    let mut decoder = Decoder::new(Role::Host);
    decoder.open_session(1, None);
    let mut found = Vec::new();
    let mut start = 0;
    while start < bytes.len() {
        let end = (start + 1 + dice.below(200)).min(bytes.len());
        let mut input = &bytes[start..end];
        while let Some(verdict) = decoder.next(&mut input) {
            if let Verdict::Frame(frame) = verdict {
                found.push((frame.header.seq, frame.payload.to_vec(), end - input.len()));
            }
        }
        start = end;
    }
    found
}

fn check(kind: &str, seed: u64, count: usize) {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(seed));
    let mut clean = 0;
    for trial in 0..count {
        let sent = stream(&mut dice);
        let fault = inject(kind, &sent.bytes, &mut dice);
        let got = receive(&fault.bytes, &mut dice);
        for (seq, payload, _) in &got {
            assert_eq!(
                payload,
                &sent.payloads[usize::from(*seq)],
                "{kind} {trial}: corrupt frame accepted"
            );
        }
        assert!(
            got.windows(2).all(|pair| pair[0].0 < pair[1].0),
            "{kind} {trial}: order or duplicate"
        );
        for (seq, span) in sent.spans.iter().enumerate() {
            if !untouched(span, &fault) {
                continue;
            }
            clean += 1;
            let behind = span.start >= fault.touched.end && span.start > 0;
            let shift = if behind || span.end > fault.touched.start { fault.moved } else { 0 };
            let completed =
                got.iter().find(|(found, ..)| usize::from(*found) == seq).map(|(.., at)| *at);
            let due = span.end.checked_add_signed(shift).unwrap();
            // A duplicated block can bring the frame earlier, in its first copy; never later.
            assert!(
                completed.is_some_and(|at| at <= due),
                "{kind} {trial}: clean frame {seq} lost or late"
            );
        }
    }
    assert!(clean >= count * (FRAMES - 6), "{kind}: {clean}");
}

fn count() -> usize {
    std::env::var("GRIP_LINK_FAULTS").map_or(20_000, |text| text.parse().unwrap())
}

macro_rules! fault_kinds {
    ($($name:ident $kind:literal $seed:literal;)*) => {
        $(#[test] fn $name() { check($kind, $seed, count()); })*
    };
}

fault_kinds! {
    one_bit_flipped "flip" 1;
    one_byte_deleted "delete" 2;
    one_byte_inserted "insert" 3;
    burst_overwritten "burst" 4;
    sixty_four_bytes_lost "lost 64" 5;
    block_duplicated "duplicated" 6;
    blocks_swapped "swapped" 7;
    stalled "stall" 8;
    garbage_inserted "garbage" 9;
}
