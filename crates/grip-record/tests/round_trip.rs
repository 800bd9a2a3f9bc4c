//! What is written reads back bit by bit.
#![expect(clippy::unwrap_used, reason = "helpers of the tests stand outside the test functions")]

use std::path::Path;

use grip_record::{Channel, ChannelSet, CsvOptions, CsvWriter, StylusKind, WriteError, parse_csv};
use proptest::option;
use proptest::prelude::*;
use slip_core::sample::Sample;
use slip_core::units::Micros;

/// Any reading; of the NaNs the two that words can distinguish.
fn reading() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(|bits| {
        let value = f32::from_bits(bits);
        if value.is_nan() {
            f32::NAN.copysign(if bits >> 31 == 1 { -1.0 } else { 1.0 })
        } else {
            value
        }
    })
}

fn sample(t: u64) -> impl Strategy<Value = Sample> {
    let force = (
        option::of(reading()),
        option::of(reading()),
        option::of(reading()),
        option::of(reading()),
    );
    let other = (
        option::of(reading()),
        option::of(reading()),
        option::of(reading()),
        option::of(reading()),
    );
    (reading(), force, other).prop_map(move |(stylus, force, other)| Sample {
        t: Micros(t),
        stylus,
        normal_force_n: force.0,
        tangential_n: force.1,
        travel_m: force.2,
        velocity_m_s: force.3,
        second_stylus: other.0,
        reference: other.1,
        pressure: other.2,
        motion: other.3,
        ..Sample::default()
    })
}

fn samples() -> impl Strategy<Value = Vec<Sample>> {
    // Times have 2^63 ns; what has uneven ones is placed by its rate.
    let times = (0_u64..9_000_000_000_000_000, 1_u64..1_000_000_000, 1_u64..40);
    times.prop_flat_map(|(start, step, rows)| {
        (0..rows).map(|row| sample(start + row * step)).collect::<Vec<_>>()
    })
}

fn bits(sample: &Sample) -> (Micros, u32, Vec<Option<u32>>) {
    let optional =
        Channel::ALL.into_iter().map(|channel| channel.reading(sample).map(f32::to_bits));
    (sample.t, sample.stylus.to_bits(), optional.collect())
}

fn written(channels: &ChannelSet, samples: &[Sample]) -> Vec<u8> {
    let mut writer = CsvWriter::new(Vec::new(), channels).unwrap();
    for sample in samples {
        writer.write(sample).unwrap();
    }
    writer.finish().unwrap()
}

proptest! {
    #[test]
    fn every_bit_survives(
        samples in samples(),
        kind in prop::sample::select(vec![StylusKind::Displacement, StylusKind::Vibration, StylusKind::Absent]),
    ) {
        let absent = kind == StylusKind::Absent;
        let samples: Vec<_> =
            samples.into_iter().map(|s| if absent { Sample { stylus: 0.0, ..s } } else { s }).collect();
        let channels = ChannelSet::all(kind);
        let bytes = written(&channels, &samples);
        let options = CsvOptions { rate_hz: Some(1000.0), ..CsvOptions::default() };
        let back = parse_csv(Path::new("rec.csv"), &bytes, &options).unwrap();
        prop_assert_eq!(&back.channels, &channels);
        prop_assert_eq!(back.samples.iter().map(bits).collect::<Vec<_>>(), samples.iter().map(bits).collect::<Vec<_>>());
        prop_assert_eq!(written(&back.channels, &back.samples), bytes);
    }
}

#[test]
fn the_columns_are_those_of_the_set() {
    let channels = ChannelSet::new(StylusKind::Displacement)
        .with(Channel::Pressure)
        .with(Channel::NormalForce);
    let first = Sample { pressure: Some(-0.0), ..Sample::stylus(Micros(455), 1e-7) };
    let second =
        Sample { normal_force_n: Some(0.1), ..Sample::stylus(Micros(61_000_000), f32::NAN) };
    let text = String::from_utf8(written(&channels, &[first, second])).unwrap();
    assert_eq!(text, "t_s,stylus,force_n,pressure\n0.000455,1e-7,,-0.0\n61.000000,NaN,0.1,\n");
}

#[test]
fn what_would_be_lost_or_unreadable_is_refused() {
    let mut writer =
        CsvWriter::new(Vec::new(), &ChannelSet::new(StylusKind::Displacement)).unwrap();
    writer.write(&Sample::stylus(Micros(5), 1.0)).unwrap();
    let error = writer
        .write(&Sample { reference: Some(1.0), ..Sample::stylus(Micros(6), 1.0) })
        .unwrap_err();
    assert!(matches!(error, WriteError::NoColumn { time: Micros(6), channel: Channel::Reference }));
    let error = writer.write(&Sample::stylus(Micros(4), 1.0)).unwrap_err();
    assert_eq!(error.to_string(), "time goes backwards from 0.000005 s to 0.000004 s");
    assert_eq!(writer.finish().unwrap(), b"t_s,stylus\n0.000005,1.0\n");
}

#[test]
fn axes_come_back() {
    let channels = ChannelSet::new(StylusKind::Vibration)
        .with(Channel::Reference)
        .with(Channel::Motion)
        .with_axes(&["vibration_x", "vibration_y", "vibration_z"], &["reference_1", "reference_2"]);
    let sample = |t: u64, reference: Option<f32>| Sample {
        stylus_axes: [0.1 * t as f32, -0.0],
        reference,
        reference_axes: reference.map_or([0.0; 2], |x| [x + 1.0, 0.0]),
        motion: Some(1.0),
        ..Sample::stylus(Micros(1000 * t), 0.3)
    };
    let samples: Vec<Sample> = (1..5).map(|t| sample(t, (t != 2).then_some(7.5))).collect();
    let mut writer = CsvWriter::new(Vec::new(), &channels).unwrap();
    samples.iter().for_each(|sample| writer.write(sample).unwrap());
    let bytes = writer.finish().unwrap();
    let head = "t_s,vibration_x,vibration_y,vibration_z,reference_1,reference_2,motion\n";
    assert!(bytes.starts_with(head.as_bytes()), "{}", String::from_utf8_lossy(&bytes));
    let back = parse_csv(Path::new("x.csv"), &bytes, &CsvOptions::default()).unwrap();
    assert_eq!(back.samples, samples);
    assert_eq!(
        (&back.channels.axes, &back.channels.reference_axes),
        (&channels.axes, &channels.reference_axes)
    );

    let mut narrow = CsvWriter::new(Vec::new(), &ChannelSet::new(StylusKind::Vibration)).unwrap();
    let lost = Sample { stylus_axes: [0.0, 1.0], ..Sample::default() };
    assert!(matches!(narrow.write(&lost), Err(WriteError::NoAxis { time: Micros(0) })));
}
