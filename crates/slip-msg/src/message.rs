//! Messages as tables: one row gives a field its offset, name, type, unit and meaning; bytes and tables of the specification follow from it.

use crate::wire::{PayloadError, Reader, Writer};
use crate::{
    DeviceState, FaultCode, GripState, LinkState, Method, Phase, Reading, Scene, SensorHealth,
    SpeedSource, units::Micros,
};

/// A field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Offset in the payload (bytes).
    pub at: usize,
    /// Bytes.
    pub size: usize,
    /// Type on the wire, as in the specification.
    pub wire: &'static str,
    /// Name.
    pub name: &'static str,
    /// Unit or range; empty where there is none.
    pub unit: &'static str,
    /// What it means.
    pub about: &'static str,
}

/// A type that a field of a message has.
pub trait Wire: Copy + PartialEq {
    /// Its name in the specification.
    const TYPE: &'static str;
    /// Bytes.
    const SIZE: usize;
    /// What a message has that ends before this field.
    const MISSING: Self;
    /// The next field.
    ///
    /// # Errors
    /// [`PayloadError`] where the payload ends, or holds what the type cannot.
    fn read(reader: &mut Reader<'_>) -> Result<Self, PayloadError>;
    /// Appends the field.
    fn write(self, writer: Writer<'_>) -> Writer<'_>;
}

macro_rules! wires {
    ($($type:ty, $name:literal, $size:literal, $missing:expr, |$r:ident| $read:expr, |$value:ident, $w:ident| $write:expr;)+) => { $(
        impl Wire for $type {
            const TYPE: &'static str = $name;
            const SIZE: usize = $size;
            const MISSING: Self = $missing;
            fn read($r: &mut Reader<'_>) -> Result<Self, PayloadError> {
                $read
            }
            fn write(self, $w: Writer<'_>) -> Writer<'_> {
                let $value = self;
                $write
            }
        }
    )+ };
}

wires! {
    u8, "u8", 1, 0, |r| r.u8(), |value, w| w.u8(value);
    bool, "u8", 1, false, |r| Ok(r.u8()? != 0), |value, w| w.u8(value.into());
    u16, "u16", 2, 0, |r| r.u16(), |value, w| w.u16(value);
    u32, "u32", 4, 0, |r| r.u32(), |value, w| w.u32(value);
    u64, "u64", 8, 0, |r| r.u64(), |value, w| w.u64(value);
    i32, "i32", 4, 0, |r| r.i32(), |value, w| w.i32(value);
    [u8; 16], "u8[16]", 16, [0; 16], |r| r.take(), |value, w| w.put(&value);
    Micros, "u64", 8, Self(0), |r| r.u64().map(Self), |value, w| w.u64(value.0);
    FaultCode, "u16", 2, Self::NONE, |r| r.u16().map(Self), |value, w| w.u16(value.0);
    // NaN stands for what is not known.
    Option<f32>, "f32", 4, None, |r| r.maybe(), |value, w| w.maybe(value);
    // Known with more digits than travel.
    Option<f64>, "f32", 4, None, |r| Ok(r.maybe()?.map(f64::from)), |value, w| w.maybe(value.map(single));
    // 4294967295 stands for what is not known.
    Option<u32>, "u32", 4, None, |r| Ok(Some(r.u32()?).filter(|n| *n != u32::MAX)), |value, w| w.u32(value.unwrap_or(u32::MAX));
    Scene, "u8", 1, Self::Idle, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    GripState, "u8", 1, Self::Observing, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    DeviceState, "u8", 1, Self::Boot, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    LinkState, "u8", 1, Self::Closed, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    Phase, "u8", 1, Self::Ended, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    Method, "u8", 1, Self::None, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    SpeedSource, "u8", 1, Self::None, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    Reading, "u8", 1, Self::None, |r| r.u8().map(Self::from_code), |value, w| w.u8(value.code());
    // Stylus, travel, pressure, reference.
    [SensorHealth; 4], "u8[4]", 4, [SensorHealth::Good; 4],
        |r| Ok(r.take::<4>()?.map(SensorHealth::from_code)), |value, w| w.put(&value.map(SensorHealth::code));
}

#[expect(clippy::cast_possible_truncation, reason = "seven digits travel")]
const fn single(value: f64) -> f32 {
    value as f32
}

/// A message: its fields in the order of the payload, from what offset on, reserved bytes behind one of them. Fields after `appended` are
/// missing in payloads of older programs, and left out at the end where they have nothing to say. `local` ones stay in the program.
macro_rules! message {
    (
        $(#[$about:meta])* $name:ident {
            $($at:literal $field:ident: $type:ty, $unit:literal, $doc:literal $(, reserved $reserved:literal)?;)+
        }
        $(appended { $($more_at:literal $more:ident: $more_type:ty, $more_unit:literal, $more_doc:literal;)+ })?
        $(local { $($own:ident: $own_type:ty, $own_unit:literal, $own_doc:literal;)+ })?
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name {
            $(#[doc = concat!($doc, " Unit or range: ", $unit, ". Offset ", stringify!($at), ".")] pub $field: $type,)+
            $($(#[doc = concat!($more_doc, " Unit or range: ", $more_unit, ". Offset ", stringify!($more_at), ".")] pub $more: $more_type,)+)?
            $($(#[doc = concat!($own_doc, " Unit or range: ", $own_unit, ". It does not travel.")] pub $own: $own_type,)+)?
        }

        impl $name {
            /// The fields in the order of the payload.
            pub const FIELDS: &[$crate::Field] = &[
                $($crate::Field { at: $at, size: <$type as $crate::Wire>::SIZE, wire: <$type as $crate::Wire>::TYPE, name: stringify!($field), unit: $unit, about: $doc },)+
                $($($crate::Field { at: $more_at, size: <$more_type as $crate::Wire>::SIZE, wire: <$more_type as $crate::Wire>::TYPE, name: stringify!($more), unit: $more_unit, about: $more_doc },)+)?
            ];
            /// Bytes of the payload without what was appended.
            pub const SIZE: usize = 0 $(+ <$type as $crate::Wire>::SIZE $(+ $reserved)?)+;
            /// Bytes of the whole payload.
            pub const WHOLE: usize = Self::SIZE $($(+ <$more_type as $crate::Wire>::SIZE)+)?;
            /// Nothing is known.
            pub const UNKNOWN: Self = Self {
                $($field: <$type as $crate::Wire>::MISSING,)+
                $($($more: <$more_type as $crate::Wire>::MISSING,)+)?
                $($($own: <$own_type as $crate::Wire>::MISSING,)+)?
            };

            /// Reads a payload.
            ///
            /// # Errors
            /// [`PayloadError`](crate::PayloadError): too short, or an infinite number.
            pub fn parse(payload: &[u8]) -> Result<Self, $crate::PayloadError> {
                let mut r = $crate::wire::Reader::new(payload);
                $(let $field = <$type as $crate::Wire>::read(&mut r)?; $(r.slice($reserved)?;)?)+
                $($(let $more = if r.rest() < <$more_type as $crate::Wire>::SIZE {
                    <$more_type as $crate::Wire>::MISSING
                } else {
                    <$more_type as $crate::Wire>::read(&mut r)?
                };)+)?
                Ok(Self { $($field,)+ $($($more,)+)? $($($own: <$own_type as $crate::Wire>::MISSING,)+)? })
            }

            /// Writes the payload; its length.
            ///
            /// # Errors
            /// [`PayloadError::Full`](crate::PayloadError).
            pub fn write(&self, out: &mut [u8]) -> Result<usize, $crate::PayloadError> {
                let w = $crate::wire::Writer::new(out);
                $(let w = <$type as $crate::Wire>::write(self.$field, w)$(.put(&[0; $reserved]))?;)+
                $(
                    let said = [$(self.$more != <$more_type as $crate::Wire>::MISSING),+];
                    let mut left = said.iter().rposition(|said| *said).map_or(0, |last| last + 1);
                    $(let w = if left == 0 { w } else {
                        left -= 1;
                        <$more_type as $crate::Wire>::write(self.$more, w)
                    };)+
                    let _none = left;
                )?
                w.finish()
            }
        }

        const _: () = {
            let mut end = 0;
            $(assert!(end == $at); end += <$type as $crate::Wire>::SIZE $(+ $reserved)?;)+
            $($(assert!(end == $more_at); end += <$more_type as $crate::Wire>::SIZE;)+)?
            assert!(end == $name::WHOLE);
        };
    };
}

pub(crate) use message;
