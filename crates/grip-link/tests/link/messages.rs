//! What the bytes of messages mean; their layout, byte by byte, stands in the vectors.

use crate::targets::gripper::{ident, written};
use grip_link::frame::MAX_PAYLOAD;
use grip_link::message::{
    Channel, ChannelKind, Ident, Layout, Log, LogLevel, PayloadError, SampleFormat, Samples,
    SamplesHeader, Unit, Versions,
};

fn samples() -> Vec<u8> {
    let header = SamplesHeader {
        first_index: 1000,
        t0_tick: 5_000_000_000,
        dt_ticks: 200,
        rows: 3,
        format: SampleFormat::I16,
        dropped_total: 9,
    };
    let mut bytes = written(|p| header.write(p));
    for value in [100_i16, -200, 101, i16::MIN, 102, 0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

#[test]
fn samples_give_rows_in_units() {
    let layout = Layout::new(ident(1).channels(), 0b011);
    let bytes = [&samples()[..], &[1, 2, 3]].concat();
    let batch = Samples::parse(&bytes, &layout).unwrap();
    let force = layout.column(ChannelKind::NormalForce).unwrap();
    let rows: Vec<_> = batch
        .rows()
        .map(|row| (row.index, row.tick, row.raw(0), row.value(&force, 0).unwrap()))
        .collect();
    assert_eq!(rows[0], (1000, 5_000_000_000, Some(100), -0.2));
    assert_eq!((rows[1].0, rows[1].1, rows[1].2), (1001, 5_000_000_200, Some(101)));
    assert!(rows[1].3.is_nan(), "-32768 is no reading");
    assert_eq!(rows.len(), 3);
    let first = batch.rows().next().unwrap();
    assert_eq!(first.read(ChannelKind::Stylus), Some(100.0 * 1e-8));
    assert_eq!((first.read(ChannelKind::Velocity), first.value(&force, 1)), (None, None));
    assert!(Samples::parse(&bytes[..31], &layout).is_err());
    assert!(Samples::parse(&bytes, &Layout::EMPTY).is_err());
}

#[test]
fn array_and_float_rows() {
    let layout = Layout::new(ident(1).channels(), 0b101);
    assert_eq!((layout.elements(), layout.row_bytes(SampleFormat::F32)), (5, 20));
    let header = SamplesHeader {
        first_index: u32::MAX,
        t0_tick: 0,
        dt_ticks: 1000,
        rows: 2,
        format: SampleFormat::F32,
        dropped_total: 0,
    };
    let mut bytes = written(|p| header.write(p));
    for i in 0..10_u8 {
        bytes.extend(f32::from(i).to_le_bytes());
    }
    let batch = Samples::parse(&bytes, &layout).unwrap();
    let array = layout.column(ChannelKind::PressureArray).unwrap();
    let second = batch.rows().nth(1).unwrap();
    assert_eq!((second.index, second.raw(0)), (0, None));
    let values: Vec<f32> = (0..4).map(|k| second.value(&array, k).unwrap()).collect();
    assert_eq!(values, [6.0, 7.0, 8.0, 9.0]);
    assert_eq!(second.value(&array, 4), None);
}

#[test]
fn ident_tables_may_grow_and_must_make_sense() {
    let bytes = written(|p| ident(1).write(p));
    let mut grown = bytes[..68].to_vec();
    grown[65] = 10;
    grown[66] = 76;
    grown.extend([9; 8]);
    for entry in bytes[72..].chunks(8) {
        grown.extend(entry);
        grown.extend([7, 7]);
    }
    assert_eq!(Ident::parse(&grown).unwrap(), ident(1));
    let broken = |at: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = value;
        Ident::parse(&bytes)
    };
    assert_eq!(broken(64, 17), Err(PayloadError::Value { at: 64, value: 17 }));
    assert_eq!(broken(65, 7), Err(PayloadError::Value { at: 65, value: 7 }));
    assert_eq!(broken(75, 0), Err(PayloadError::Value { at: 75, value: 0 }));
    assert!(broken(79, 0xFF).is_err(), "a negative scale");
    assert!(broken(66, 90).is_err(), "a table past the end");
}

#[test]
fn a_single_channel_has_the_unit_of_its_kind() {
    assert_eq!(Channel::single(ChannelKind::Velocity, 1.0).unit, Unit::MetrePerSecond);
}

#[test]
fn versions_meet_at_the_highest() {
    let range = |min, max| Versions { min, max };
    assert_eq!(range(1, 3).common(range(2, 5)), Some(3));
    assert_eq!(range(1, 1).common(range(2, 5)), None);
    assert_eq!(range(4, 6).common(range(1, 3)), None);
}

#[test]
fn a_text_that_is_not_utf8_is_cut() {
    let log = Log { tick: 0, level: LogLevel::Info, text: b"ok \xFF no" };
    assert_eq!(log.as_str(), "ok ");
    // As every text of a message: 255 bytes at most.
    assert_eq!(Log { text: &[b'x'; 256], ..log }.write(&mut [0; MAX_PAYLOAD]), Ok(10 + 255));
}
