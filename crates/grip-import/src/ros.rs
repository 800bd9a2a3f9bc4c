//! Decoder of the numbers of ROS 2 messages, by the definition of the message (`ros2msg` text).
//!
//! Layout of the bytes: [`CdrReader`]. Every number of a message is a leaf with a path (`linear_acceleration.x`, `data[3]`); texts are
//! passed over, and so are arrays of more than [`MOST_ITEMS`] numbers, which are pictures.

use grip_record::mcap::{CdrError, CdrReader};
use std::collections::BTreeMap;

/// Most items of an array that are signals.
const MOST_ITEMS: usize = 256;
/// Messages within messages; a definition may contain itself.
const DEEPEST: usize = 16;
/// Most numbers of one message.
const MOST_LEAVES: usize = 4096;

/// Definitions that bags made before they carried them refer to (fields only).
const KNOWN: [(&str, &str); 24] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Int16", "int16 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/UInt16", "uint16 data"),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride"),
    ("std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset"),
    ("std_msgs/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data"),
    ("std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data"),
    ("std_msgs/Int16MultiArray", "MultiArrayLayout layout\nint16[] data"),
    ("std_msgs/Int32MultiArray", "MultiArrayLayout layout\nint32[] data"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header\nVector3 vector"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque"),
    ("geometry_msgs/WrenchStamped", "std_msgs/Header header\nWrench wrench"),
    ("geometry_msgs/Accel", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/AccelStamped", "std_msgs/Header header\nAccel accel"),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance",
    ),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Kind {
    Number(Number),
    Text,
    Message(String),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Count {
    One,
    Fixed(usize),
    Sequence,
}

#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: Kind,
    count: Count,
}

/// Decodes the messages of one type.
#[derive(Clone, Debug)]
pub(crate) struct Decoder {
    types: BTreeMap<String, Vec<Field>>,
    root: String,
}

/// The numbers of one message.
#[derive(Clone, Debug, Default)]
pub(crate) struct Leaves {
    pub(crate) values: Vec<f64>,
    /// Lengths of its sequences: messages with the same ones have the same paths.
    pub(crate) shape: Vec<usize>,
    /// Paths of the values, where they are wanted.
    paths: Option<Vec<String>>,
    path: String,
}

impl Decoder {
    /// A decoder of the type `name`, defined by `definition`, or by what is known where that is empty.
    ///
    /// # Errors
    /// What is not known, as the end of a sentence about the topic.
    pub(crate) fn new(name: &str, definition: &str) -> Result<Self, String> {
        let root = plain(name);
        let mut types = BTreeMap::new();
        for (known, text) in KNOWN {
            types.insert(known.to_owned(), fields(known, text)?);
        }
        if definition.trim().is_empty() {
            if !types.contains_key(&root) {
                return Err(format!(
                    "has the type {name}, whose definition the file does not hold"
                ));
            }
            return Ok(Self { types, root });
        }
        let mut parts = definition.split("\nMSG: ");
        let trimmed = |part: &str| part.trim_end().trim_end_matches('=').to_owned();
        if let Some(main) = parts.next() {
            types.insert(root.clone(), fields(&root, &trimmed(main))?);
        }
        for part in parts {
            let (name, text) = part.split_once('\n').unwrap_or((part, ""));
            let name = plain(name.trim());
            let parsed = fields(&name, &trimmed(text))?;
            types.insert(name, parsed);
        }
        Ok(Self { types, root })
    }

    /// Every number of a message.
    ///
    /// # Errors
    /// What is wrong with it, as a sentence.
    pub(crate) fn decode(&self, bytes: &[u8], leaves: &mut Leaves) -> Result<(), String> {
        leaves.values.clear();
        leaves.shape.clear();
        leaves.paths = None;
        self.run(bytes, leaves)
    }

    /// The paths of the numbers of such a message.
    ///
    /// # Errors
    /// As [`Decoder::decode`].
    pub(crate) fn paths(&self, bytes: &[u8]) -> Result<Vec<String>, String> {
        let mut leaves = Leaves { paths: Some(Vec::new()), ..Leaves::default() };
        self.run(bytes, &mut leaves)?;
        Ok(leaves.paths.unwrap_or_default())
    }

    fn run(&self, bytes: &[u8], leaves: &mut Leaves) -> Result<(), String> {
        let mut reader = CdrReader::new(bytes).map_err(|error| error.to_string())?;
        self.message(&self.root, &mut reader, leaves, 0)
    }

    fn message(
        &self,
        name: &str,
        reader: &mut CdrReader<'_>,
        leaves: &mut Leaves,
        depth: usize,
    ) -> Result<(), String> {
        let fields = self.types.get(name).filter(|_| depth < DEEPEST);
        let fields = fields.ok_or_else(|| format!("the type {name} is not defined"))?;
        for field in fields {
            let before = leaves.path.len();
            if leaves.paths.is_some() {
                if before > 0 {
                    leaves.path.push('.');
                }
                leaves.path.push_str(&field.name);
            }
            self.field(field, reader, leaves, depth)?;
            leaves.path.truncate(before);
        }
        Ok(())
    }

    fn field(
        &self,
        field: &Field,
        reader: &mut CdrReader<'_>,
        leaves: &mut Leaves,
        depth: usize,
    ) -> Result<(), String> {
        let count = match field.count {
            Count::One => return self.item(&field.kind, reader, leaves, true, depth),
            Count::Fixed(count) => count,
            Count::Sequence => {
                let count = reader.u32().map_err(|error| error.to_string())? as usize;
                leaves.shape.push(count);
                count
            }
        };
        let kept = count <= MOST_ITEMS;
        let before = leaves.path.len();
        for k in 0..count {
            if leaves.paths.is_some() {
                leaves.path.push_str(&format!("[{k}]"));
            }
            self.item(&field.kind, reader, leaves, kept, depth)?;
            leaves.path.truncate(before);
        }
        Ok(())
    }

    fn item(
        &self,
        kind: &Kind,
        reader: &mut CdrReader<'_>,
        leaves: &mut Leaves,
        kept: bool,
        depth: usize,
    ) -> Result<(), String> {
        match kind {
            Kind::Message(name) => self.message(name, reader, leaves, depth + 1),
            Kind::Text => reader.text().map(drop).map_err(|error| error.to_string()),
            Kind::Number(number) => {
                let value = read(*number, reader).map_err(|error| error.to_string())?;
                if kept {
                    if leaves.values.len() >= MOST_LEAVES {
                        return Err(format!("it has more than {MOST_LEAVES} numbers"));
                    }
                    leaves.values.push(value);
                    if let Some(paths) = &mut leaves.paths {
                        paths.push(leaves.path.clone());
                    }
                    if leaves.paths.is_some() && leaves.values.len() > MOST_LEAVES {
                        return Err("it has too many numbers".to_owned());
                    }
                }
                Ok(())
            }
        }
    }
}

#[expect(
    clippy::cast_possible_wrap,
    reason = "a reading has 24 bits; the sign of an integer is in its bits"
)]
fn read(number: Number, reader: &mut CdrReader<'_>) -> Result<f64, CdrError> {
    Ok(match number {
        Number::U8 => reader.u8()?.into(),
        Number::I8 => (reader.u8()? as i8).into(),
        Number::U16 => reader.u16()?.into(),
        Number::I16 => (reader.u16()? as i16).into(),
        Number::U32 => reader.u32()?.into(),
        Number::I32 => reader.i32()?.into(),
        Number::U64 => reader.u64()? as f64,
        Number::I64 => reader.u64()? as i64 as f64,
        Number::F32 => reader.f32()?.into(),
        Number::F64 => reader.f64()?,
    })
}

/// `package/msg/Type` as `package/Type`.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

fn fields(owner: &str, text: &str) -> Result<Vec<Field>, String> {
    let package = owner.split('/').next().unwrap_or_default();
    let mut fields = Vec::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else { continue };
        let constant = name.contains('=') || words.next().is_some_and(|word| word.starts_with('='));
        if kind.starts_with('=') || constant {
            continue;
        }
        let (kind, count) = counted(kind)?;
        let kind = match kind {
            "bool" | "uint8" | "byte" | "char" => Kind::Number(Number::U8),
            "int8" => Kind::Number(Number::I8),
            "uint16" => Kind::Number(Number::U16),
            "int16" => Kind::Number(Number::I16),
            "uint32" => Kind::Number(Number::U32),
            "int32" => Kind::Number(Number::I32),
            "uint64" => Kind::Number(Number::U64),
            "int64" => Kind::Number(Number::I64),
            "float32" => Kind::Number(Number::F32),
            "float64" => Kind::Number(Number::F64),
            text if text == "string" || text.starts_with("string<=") => Kind::Text,
            wide if wide.starts_with("wstring") => {
                return Err(format!("has wide texts ({owner}.{name}), which are not read"));
            }
            "Header" => Kind::Message("std_msgs/Header".to_owned()),
            own if !own.contains('/') => Kind::Message(format!("{package}/{own}")),
            other => Kind::Message(plain(other)),
        };
        fields.push(Field { name: name.to_owned(), kind, count });
    }
    Ok(fields)
}

/// The type of an item, and how many there are.
fn counted(kind: &str) -> Result<(&str, Count), String> {
    let Some((item, size)) = kind.strip_suffix(']').and_then(|kind| kind.rsplit_once('[')) else {
        return Ok((kind, Count::One));
    };
    if size.is_empty() || size.starts_with("<=") {
        return Ok((item, Count::Sequence));
    }
    let size = size.parse().map_err(|_| format!("has an array of {size:?} items"))?;
    Ok((item, Count::Fixed(size)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use grip_record::mcap::CdrWriter;

    const TEXT: &str = "# a comment\nstd_msgs/Header header\nuint8 KIND=3\nint16 level -2\nstring<=9 name\nfloat32[] data # c\n\
        Point[2] points\n\n====\nMSG: our/Point\nfloat64 x\nbool good\n";

    fn message(count: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut out = CdrWriter::new(&mut bytes);
        out.i32(7).u32(500).text("frame").u16(u16::MAX).text("n").u32(count);
        for k in 0..count {
            out.f32(k as f32);
        }
        out.f64(1.5).bool(true).f64(2.5).bool(false);
        bytes
    }

    #[test]
    fn every_number_has_its_path() {
        let decoder = Decoder::new("our/msg/Thing", TEXT).unwrap();
        let paths = decoder.paths(&message(2)).unwrap();
        let expected = [
            "header.stamp.sec",
            "header.stamp.nanosec",
            "level",
            "data[0]",
            "data[1]",
            "points[0].x",
            "points[0].good",
            "points[1].x",
            "points[1].good",
        ];
        assert_eq!(paths, expected);
        let mut leaves = Leaves::default();
        decoder.decode(&message(2), &mut leaves).unwrap();
        assert_eq!(leaves.values, [7.0, 500.0, -1.0, 0.0, 1.0, 1.5, 1.0, 2.5, 0.0]);
        assert_eq!(leaves.shape, [2]);
        decoder.decode(&message(300), &mut leaves).unwrap();
        assert_eq!(leaves.values, [7.0, 500.0, -1.0, 1.5, 1.0, 2.5, 0.0], "a picture is left out");
        for cut in 0..message(2).len() {
            assert!(decoder.decode(&message(2)[..cut], &mut leaves).is_err(), "{cut}");
        }
    }

    #[test]
    fn what_is_not_known_is_refused() {
        assert!(Decoder::new("our/msg/Thing", "").unwrap_err().contains("our/msg/Thing"));
        assert!(Decoder::new("a/B", "wstring x").unwrap_err().contains("wide"));
        let endless = Decoder::new("a/B", "B b").unwrap();
        assert!(endless.paths(&[0, 1, 0, 0]).unwrap_err().contains("a/B"));
        let unknown = Decoder::new("a/B", "c/D d").unwrap();
        assert!(unknown.paths(&[0, 1, 0, 0]).unwrap_err().contains("c/D"));
        Decoder::new("sensor_msgs/msg/Imu", "").unwrap();
    }
}
