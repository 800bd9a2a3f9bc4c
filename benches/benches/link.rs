//! Time of one frame decoded or encoded, and of a checksum.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use criterion::{BenchmarkId, Criterion, Throughput};
use grip_link::{
    crc::crc32c,
    decoder::{Decoder, Role},
    frame::MAX_WIRE,
};
use slip_benches::frames::{self, ROWS, SESSION};

/// Frames of a round.
const FRAMES: u16 = 256;
const CRC_BYTES: usize = 4096;

fn decode(criterion: &mut Criterion) {
    let wire = frames::samples(FRAMES, ROWS).expect("the rows fit");
    let bytes = wire.iter().map(Vec::len).sum::<usize>() / wire.len();
    let mut group = criterion.benchmark_group("Decoder::next");
    group.throughput(Throughput::BytesDecimal(u64::try_from(bytes).expect("a few hundred")));
    group.bench_function(BenchmarkId::new("SAMPLES, bytes on the wire", bytes), |bencher| {
        rounds::by_item(
            bencher,
            wire.len(),
            || {
                let mut decoder = Decoder::new(Role::Host);
                decoder.open_session(SESSION, None);
                decoder
            },
            |decoder, count| {
                for frame in wire.iter().take(count) {
                    let mut input = black_box(frame.as_slice());
                    while let Some(verdict) = decoder.next(&mut input) {
                        black_box(verdict);
                    }
                }
            },
        );
    });
    group.finish();
}

fn encode(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("encode");
    group.throughput(Throughput::Elements(1));
    let mut out = [0; MAX_WIRE];
    group.bench_function("GRIP", |bencher| {
        bencher.iter(|| frames::grip(black_box(500), black_box(12_345), black_box(&mut out)));
    });
    group.finish();
}

fn checksum(criterion: &mut Criterion) {
    let bytes: Vec<u8> = (0..=u8::MAX).cycle().take(CRC_BYTES).collect();
    let mut group = criterion.benchmark_group("crc32c");
    for len in [32, 248, CRC_BYTES] {
        let covered = bytes.get(..len).expect("within the buffer");
        group.throughput(Throughput::BytesDecimal(u64::try_from(len).expect("a few thousand")));
        group.bench_function(BenchmarkId::new("bytes", len), |bencher| {
            bencher.iter(|| crc32c(black_box(covered)));
        });
    }
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    decode(&mut criterion);
    encode(&mut criterion);
    checksum(&mut criterion);
    criterion.final_summary();
}
