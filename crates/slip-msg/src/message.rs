//! Messages as tables: one row gives a field its offset, name, type, unit and meaning; its bytes and its documentation follow from it.

use crate::{
    DeviceState, EXTRAPOLATED, FaultCode, GripState, INFORMATIVE, Method, Phase, Reading, Scene,
    SensorHealth, SpeedSource,
    units::Micros,
    wire::{PayloadError, Reader, Writer},
};

/// A type that a field of a message has.
pub trait Wire<'a>: Copy {
    /// Bytes; where the number differs from value to value, those that are always there.
    const SIZE: usize;
    /// Its name in the tables of protocol/MESSAGES.md, of an array that of an element; several for several numbers. Empty for a message.
    const TYPE: &'static str;
    /// Of a message its fields.
    const FIELDS: &'static [Field] = &[];
    /// The next field.
    ///
    /// # Errors
    /// [`PayloadError`] where the payload ends, or holds what the type cannot.
    fn read(reader: &mut Reader<'a>) -> Result<Self, PayloadError>;
    /// Appends the field.
    fn append(self, writer: Writer<'_>) -> Writer<'_>;
}

/// A row of a table of fields, as protocol/MESSAGES.md prints it and the vectors of `protocol/vectors` name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Offset in the payload.
    pub at: usize,
    /// Bytes; of text its count alone.
    pub size: usize,
    /// [`Wire::TYPE`].
    pub kind: &'static str,
    /// Its name; where it is several numbers, theirs.
    pub name: &'static str,
    /// Unit, range and meaning; of several numbers theirs, between bars.
    pub text: &'static str,
    /// Reserved bytes behind it.
    pub reserved: usize,
    /// Whether older programs do not send it.
    pub appended: bool,
    /// The fields of a message within the message.
    pub fields: &'static [Self],
}

impl Field {
    /// Every number, text and reserved gap of `fields`, one after the other, those of messages within included. What is written about a message
    /// within is about its first field.
    pub fn each(fields: &[Self], see: &mut dyn FnMut(Self)) {
        for field in fields {
            let appended = field.appended || field.size == 0;
            let mut about = field.text;
            Self::each(field.fields, &mut |inner| {
                let text = if about.is_empty() { inner.text } else { about };
                about = "";
                let (at, appended) = (field.at + inner.at, appended || inner.appended);
                see(Self { at, text, appended, ..inner });
            });
            let (mut at, mut kind, mut text) = (field.at, "", "");
            let (mut kinds, mut texts) = (field.kind.split(' '), field.text.split(" | "));
            let names = field.name.split(' ').filter(|_| field.fields.is_empty());
            let one = Self { appended, reserved: 0, ..*field };
            let count = names.clone().count();
            for name in names {
                (kind, text) = (kinds.next().unwrap_or(kind), texts.next().unwrap_or(text));
                let size = if count == 1 { field.size } else { Self::bytes(kind) };
                see(Self { at, size, kind, name, text, ..one });
                at += size;
            }
            if field.reserved > 0 {
                let (at, size) = (field.at + field.size, field.reserved);
                see(Self { at, size, kind: "", name: "reserved", text: "0", ..one });
            }
        }
    }

    /// Bytes of a number of that type.
    #[must_use]
    pub fn bytes(kind: &str) -> usize {
        kind.get(1..).and_then(|bits| bits.parse().ok()).map_or(1, |bits: usize| bits / 8)
    }
}

/// A type with a value for what is not known, and for a field that an older program does not send.
pub trait Absent: PartialEq + Sized {
    /// That value.
    const MISSING: Self;
}

macro_rules! wires {
    ($($type:ty, $size:literal $kind:literal, |$r:ident| $read:expr, |$value:ident, $w:ident| $write:expr;)+) => { $(
        impl<'a> Wire<'a> for $type {
            const SIZE: usize = $size;
            const TYPE: &'static str = $kind;
            fn read($r: &mut Reader<'a>) -> Result<Self, PayloadError> {
                $read
            }
            fn append(self, $w: Writer<'_>) -> Writer<'_> {
                let $value = self;
                $write
            }
        }
    )+ };
}

wires! {
    u8, 1 "u8", |r| r.u8(), |value, w| w.u8(value);
    u16, 2 "u16", |r| r.u16(), |value, w| w.u16(value);
    u32, 4 "u32", |r| r.u32(), |value, w| w.u32(value);
    u64, 8 "u64", |r| r.u64(), |value, w| w.u64(value);
    i32, 4 "i32", |r| r.i32(), |value, w| w.i32(value);
    i64, 8 "i64", |r| r.i64(), |value, w| w.i64(value);
    f32, 4 "f32", |r| r.f32(), |value, w| w.f32(value);
    Micros, 8 "u64", |r| r.u64().map(Self), |value, w| w.u64(value.0);
    FaultCode, 2 "u16", |r| r.u16().map(Self), |value, w| w.u16(value.0);
    // NaN stands for what is not known.
    Option<f32>, 4 "f32", |r| r.maybe(), |value, w| w.maybe(value);
    // Known with more digits than travel.
    Option<f64>, 4 "f32", |r| Ok(r.maybe()?.map(f64::from)), |value, w| w.maybe(value.map(single));
    // 4294967295 stands for what is not known.
    Option<u32>, 4 "u32", |r| Ok(Some(r.u32()?).filter(|n| *n != u32::MAX)), |value, w| w.u32(value.unwrap_or(u32::MAX));
    // A count of bytes before it.
    &'a [u8], 1 "text", |r| r.text(), |value, w| w.text(value);
}

impl<'a, T: Wire<'a> + Default, const N: usize> Wire<'a> for [T; N] {
    const SIZE: usize = N * T::SIZE;
    const TYPE: &'static str = T::TYPE;
    fn read(reader: &mut Reader<'a>) -> Result<Self, PayloadError> {
        let mut all = [T::default(); N];
        for slot in &mut all {
            *slot = T::read(reader)?;
        }
        Ok(all)
    }
    fn append(self, writer: Writer<'_>) -> Writer<'_> {
        self.into_iter().fold(writer, |writer, one| one.append(writer))
    }
}

macro_rules! absent {
    ($($type:ty => $missing:expr,)+) => { $(
        impl Absent for $type {
            const MISSING: Self = $missing;
        }
    )+ };
}

absent! {
    u8 => 0,
    bool => false,
    u32 => 0,
    u64 => 0,
    Micros => Self(0),
    FaultCode => Self::NONE,
    Option<f32> => None,
    Option<f64> => None,
    Option<u32> => None,
    Scene => Self::Idle,
    GripState => Self::Observing,
    DeviceState => Self::Boot,
    Phase => Self::Ended,
    Method => Self::None,
    SpeedSource => Self::None,
    Reading => Self::None,
    [SensorHealth; 4] => [SensorHealth::Good; 4],
}

#[expect(clippy::cast_possible_truncation, reason = "seven digits travel")]
const fn single(value: f64) -> f32 {
    value as f32
}

/// A message, or a part of one: its fields in the order of the payload, from what offset on, `as` what name on the wire where that is another,
/// unit and range (what protocol/MESSAGES.md prints), meaning, the range that others are refused outside of, and reserved bytes behind one of them. Fields after `appended` are missing in payloads of older programs, and left out behind
/// the last one that is not `Absent::MISSING`. `local` ones stay in the program.
///
/// ```
/// slip_msg::message! {
///     /// Where a finger stands.
///     Finger {
///         0 number: u8, "1..", "Which finger.", in 1.., reserved 3;
///         4 travel_um: i32, "um", "From the open end.";
///     }
/// }
/// let mut bytes = [0; Finger::SIZE];
/// let finger = Finger { number: 2, travel_um: -1 };
/// assert_eq!(finger.write(&mut bytes), Ok(8));
/// assert_eq!(Finger::parse(&bytes), Ok(finger));
/// assert!(Finger::parse(&[0; 8]).is_err());
/// ```
#[macro_export]
macro_rules! message {
    (@read $r:ident $type:ty) => { <$type as $crate::Wire<'_>>::read($r)? };
    (@read $r:ident $type:ty, $range:expr) => { $r.within::<$type>($range)? };
    (@field $at:literal $type:ty, $names:expr, $text:literal, $reserved:expr, $appended:literal) => {
        $crate::Field {
            at: $at,
            size: <$type as $crate::Wire<'_>>::SIZE,
            kind: <$type as $crate::Wire<'_>>::TYPE,
            name: $names[$names.len() - 1],
            text: $text,
            reserved: $reserved,
            appended: $appended,
            fields: <$type as $crate::Wire<'_>>::FIELDS,
        }
    };
    (
        @made $wire:lifetime [$($life:lifetime)?]
        $(#[$about:meta])* $name:ident {
            $($at:literal $field:ident $(as $wire_name:literal)?: $type:ty, $unit:literal, $doc:literal $(, in $range:expr)? $(, reserved $reserved:literal)?;)+
        }
        $(appended { $($more_at:literal $more:ident $(as $more_name:literal)?: $more_type:ty, $more_unit:literal, $more_doc:literal;)+ })?
        $(local { $($own:ident: $own_type:ty, $own_unit:literal, $own_doc:literal;)+ })?
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name $(<$life>)? {
            $(#[doc = concat!($doc, " Unit or range: ", $unit, ". Offset ", stringify!($at), ".")] pub $field: $type,)+
            $($(#[doc = concat!($more_doc, " Unit or range: ", $more_unit, ". Offset ", stringify!($more_at), ".")] pub $more: $more_type,)+)?
            $($(#[doc = concat!($own_doc, " Unit or range: ", $own_unit, ". It does not travel.")] pub $own: $own_type,)+)?
        }

        impl<$wire> $crate::Wire<$wire> for $name $(<$life>)? {
            const SIZE: usize = {
                let mut end = 0;
                $(assert!(end == $at); end += <$type as $crate::Wire<'_>>::SIZE $(+ $reserved)?;)+
                end
            };
            const TYPE: &'static str = "";
            const FIELDS: &'static [$crate::Field] = &[
                $($crate::message!(@field $at $type, [stringify!($field) $(, $wire_name)?], $unit, 0 $(+ $reserved)?, false),)+
                $($($crate::message!(@field $more_at $more_type, [stringify!($more) $(, $more_name)?], $more_unit, 0, true),)+)?
            ];

            fn read(r: &mut $crate::wire::Reader<$wire>) -> Result<Self, $crate::PayloadError> {
                $(let $field = $crate::message!(@read r $type $(, $range)?); $(r.slice($reserved)?;)?)+
                $($(let $more = if r.rest() < <$more_type as $crate::Wire<'_>>::SIZE {
                    <$more_type as $crate::Absent>::MISSING
                } else {
                    <$more_type as $crate::Wire<'_>>::read(r)?
                };)+)?
                Ok(Self { $($field,)+ $($($more,)+)? $($($own: <$own_type as $crate::Absent>::MISSING,)+)? })
            }

            fn append(self, w: $crate::wire::Writer<'_>) -> $crate::wire::Writer<'_> {
                $(let w = $crate::Wire::append(self.$field, w)$(.put(&[0; $reserved]))?;)+
                $(
                    let mut known_to = 0;
                    $(if self.$more != <$more_type as $crate::Absent>::MISSING { known_to = $more_at; })+
                    $(let w = if $more_at > known_to { w } else { $crate::Wire::append(self.$more, w) };)+
                )?
                w
            }
        }

        impl $(<$life>)? $name $(<$life>)? {
            /// Bytes of the payload; of one with text or with what was appended, those before.
            pub const SIZE: usize = <Self as $crate::Wire<'_>>::SIZE;

            /// Reads a payload.
            ///
            /// # Errors
            /// `PayloadError`: too short, an infinite number, or a value outside its range.
            pub fn parse(payload: & $($life)? [u8]) -> Result<Self, $crate::PayloadError> {
                <Self as $crate::Wire<'_>>::read(&mut $crate::wire::Reader::new(payload))
            }

            /// Writes the payload; its length.
            ///
            /// # Errors
            /// `PayloadError::Full`.
            pub fn write(&self, out: &mut [u8]) -> Result<usize, $crate::PayloadError> {
                $crate::Wire::append(*self, $crate::wire::Writer::new(out)).finish()
            }
        }

        const _: usize = $name::SIZE;
    };
    (
        $(#[$about:meta])* $name:ident {
            $($at:literal $field:ident $(as $wire_name:literal)?: $type:ty, $unit:literal, $doc:literal;)+
        }
        appended { $($more_at:literal $more:ident $(as $more_name:literal)?: $more_type:ty, $more_unit:literal, $more_doc:literal;)+ }
        $(local { $($own:ident: $own_type:ty, $own_unit:literal, $own_doc:literal;)+ })?
    ) => {
        $crate::message! {
            @made 'w [] $(#[$about])* $name { $($at $field $(as $wire_name)?: $type, $unit, $doc;)+ }
            appended { $($more_at $more $(as $more_name)?: $more_type, $more_unit, $more_doc;)+ }
            $(local { $($own: $own_type, $own_unit, $own_doc;)+ })?
        }

        impl $name {
            /// Bytes of the whole payload.
            pub const WHOLE: usize = {
                let mut end = Self::SIZE;
                $(assert!(end == $more_at); end += <$more_type as $crate::Wire<'_>>::SIZE;)+
                end
            };
            /// Nothing is known.
            pub const UNKNOWN: Self = Self {
                $($field: <$type as $crate::Absent>::MISSING,)+
                $($more: <$more_type as $crate::Absent>::MISSING,)+
                $($($own: <$own_type as $crate::Absent>::MISSING,)+)?
            };
        }

        const _: usize = $name::WHOLE;
    };
    ($(#[$about:meta])* $name:ident<$life:lifetime> { $($rows:tt)+ }) => {
        $crate::message! { @made $life [$life] $(#[$about])* $name { $($rows)+ } }
    };
    ($(#[$about:meta])* $name:ident { $($rows:tt)+ }) => {
        $crate::message! { @made 'w [] $(#[$about])* $name { $($rows)+ } }
    };
}

// What is known of a slip when it is noticed, becomes gross, is certified, or ends.

message! {
    /// What is known of a slip; SLIP (A1), daemon to client.
    SlipReport {
        0 number: u32, "+1 for every SLIP since the daemon's start, from 1", "+1 for every report since the daemon's start; 0 before the daemon has numbered it.";
        4 t as "device_us": Micros, "us, device time", "Device time.";
        12 host as "host_us": Micros, "us since the daemon's start", "Host time since the daemon's start.";
        20 phase: Phase, "slip phase", "How far it has come.";
        21 method: Method, "slip method", "Which method noticed it.";
        22 speed_source: SpeedSource, "speed source", "Where the speed comes from.";
        23 esc_kind: Reading, "which E_sc `esc_chosen` is", "Which reading `esc` is.";
        24 statistic: Option<f32>, "over the interval", "Evidence of a slip over the wanted interval.";
        28 confidence: Option<f32>, "0..1", "Probability that noise alone would not reach the statistic within the stated false-alarm interval.";
        32 speed_m_s as "speed": Option<f32>, "m/s", "Slip speed.";
        36 speed_sigma_m_s as "sigma": Option<f32>, "m/s, standard deviation of it", "Its standard deviation.";
        40 moved_m as "moved": Option<f32>, "m", "Distance moved since the slip was noticed.";
        44 irregularities: Option<u32>, "passed so far; 4294967295 = not known", "Irregularities the stylus passed.";
        48 esc_w as "esc": Option<f64>, "W, E_sc as printed", "E_sc as printed.";
        52 esc as "esc_chosen": Option<f64>, "W or J, the reading that was asked for", "The reading of E_sc that was asked for.";
        56 esc_flags: u8, "b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate", "What is wrong with E_sc as printed: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.";
        57 notes: u8, "b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used", "b0 E_sc depends on the surface, b1 the estimate is extrapolated and not used.";
        58 ruled_out: u8, "[causes](CLIENTS.md#causes-of-an-alarm) other than a slip that were ruled out, a bit for each", "Causes other than a slip that were ruled out: b0 knock, b1 motion, b2 grip change, b3 closing, b4 arm stop.";
        59 possible: u8, "causes that were not ruled out; one in neither could not be judged", "Causes that were not ruled out; one in neither could not be judged.";
        60 estimate_n as "estimate": Option<f32>, "N, estimate of the adequate force", "Estimate of the adequate force.";
        64 command_n as "command": Option<f32>, "N, commanded force", "Commanded force.";
        68 duration_s as "duration": Option<f64>, "s, of a slip that has ended", "From the first notice to the end.";
    }
    appended {
        72 certified_s as "certified": Option<f32>, "s, interval that the slip is certified with: such false alarms are at least so far apart on average; left out where it is not", "The interval that the slip is certified with: false alarms of that kind are at least so far apart on average.";
    }
    local {
        estimate_sigma_n: Option<f32>, "N", "Standard deviation of the estimate in the physics that the model was trained on.";
        estimate_lo_n: Option<f32>, "N", "Lower limit of the interval that the model states.";
        estimate_hi_n: Option<f32>, "N", "Its upper limit.";
        mean_slope: Option<f32>, "", "Mean height over distance of the irregularities the stylus passed.";
        first: bool, "", "Whether this is the first notice of the slip: not its turn to gross, its certificate or its end.";
    }
}

impl SlipReport {
    /// Whether E_sc as printed depends on the surface at the assumed noise.
    #[must_use]
    pub const fn is_informative(&self) -> bool {
        self.notes & INFORMATIVE != 0
    }

    /// Whether the estimate lies outside what the network was trained on.
    #[must_use]
    pub const fn is_extrapolated(&self) -> bool {
        self.notes & EXTRAPOLATED != 0
    }
}
