//! `name=value` lists in, messages out, and back.

use crate::targets::words::{hex, unhex};
use grip_link::message::{
    Channel, ChannelKind, Clamped, DeviceState, EventKind, FaultCode, ForceClamp, Ident, Kind,
    LogLevel, LossAction, MAX_CHANNELS, NackReason, ResetReason, SampleFormat, StatusFlags, Unit,
};
use std::collections::HashMap;

/// What a list writes as a number.
pub(crate) trait Number {
    fn read(text: &str) -> Self;
}

macro_rules! numbers {
    ($($type:ty: |$number:ident| $value:expr;)+) => { $(
        impl Number for $type {
            fn read(text: &str) -> Self {
                let $number = text.parse().unwrap();
                $value
            }
        }
    )+ };
}

numbers! {
    u8: |n| n;
    u16: |n| n;
    u32: |n| n;
    u64: |n| n;
    i32: |n| n;
    Kind: |n| Self(n);
    FaultCode: |n| Self(n);
    Clamped: |n| Self(n);
    ForceClamp: |n| Self(n);
    StatusFlags: |n| Self(n);
    DeviceState: |n| Self::from_code(n);
    EventKind: |n| Self::from_code(n);
    LogLevel: |n| Self::from_code(n);
    NackReason: |n| Self::from_code(n);
    ResetReason: |n| Self::from_code(n);
    LossAction: |n| Self::from_code(n).unwrap();
    SampleFormat: |n| Self::from_code(n).unwrap();
}

/// A list being read; every name must be used exactly once.
pub(crate) struct Given(HashMap<String, String>);

impl Given {
    pub(crate) fn new(text: &str) -> Self {
        let pairs = text.split(' ').filter(|word| *word != "-");
        Self(
            pairs
                .map(|word| word.split_once('=').unwrap())
                .map(|(name, value)| (name.to_owned(), value.to_owned()))
                .collect(),
        )
    }

    pub(crate) fn text(&mut self, name: &str) -> String {
        self.0.remove(name).unwrap_or_else(|| panic!("no field {name}"))
    }

    /// A number, or what its number stands for.
    pub(crate) fn num<T: Number>(&mut self, name: &str) -> T {
        T::read(&self.text(name))
    }

    pub(crate) fn bytes(&mut self, name: &str) -> Vec<u8> {
        unhex(&self.text(name))
    }

    pub(crate) fn finish(&self) {
        assert!(self.0.is_empty(), "fields left: {:?}", self.0);
    }
}

pub(crate) fn f32_bits(text: &str) -> f32 {
    f32::from_bits(u32::from_str_radix(text, 16).unwrap())
}

pub(crate) fn channels(text: &str) -> ([Channel; MAX_CHANNELS], u8) {
    let mut table = [Ident::NO_CHANNEL; MAX_CHANNELS];
    let mut count = 0;
    for (slot, entry) in table.iter_mut().zip(text.split(',')) {
        let part: Vec<&str> = entry.split(':').collect();
        *slot = Channel {
            kind: ChannelKind::from_code(part[0].parse().unwrap()),
            unit: Unit::from_code(part[1].parse().unwrap()),
            formats: part[2].parse().unwrap(),
            count: part[3].parse().unwrap(),
            scale: f32_bits(part[4]),
        };
        count += 1;
    }
    (table, count)
}

/// Elements of all rows as they stand on the wire, and the elements of one row.
pub(crate) fn row_bytes(text: &str, format: u8) -> (Vec<u8>, usize) {
    let element = |text: &str| match format {
        0 => text.parse::<i16>().unwrap().to_le_bytes().to_vec(),
        _ => f32_bits(text).to_le_bytes().to_vec(),
    };
    let bytes = text.split([';', ',']).flat_map(element).collect();
    (bytes, text.split(';').next().unwrap().split(',').count())
}

/// Rows as they stand in the list, from their bytes.
pub(crate) fn row_text(bytes: &[u8], format: u8, elements: usize) -> String {
    let size = if format == 0 { 2 } else { 4 };
    let element = |bytes: &[u8]| match format {
        0 => i16::from_le_bytes(bytes.try_into().unwrap()).to_string(),
        _ => hex(&bytes.iter().rev().copied().collect::<Vec<_>>()),
    };
    let row = |row: &[u8]| row.chunks(size).map(element).collect::<Vec<_>>().join(",");
    bytes.chunks(size * elements).map(row).collect::<Vec<_>>().join(";")
}
