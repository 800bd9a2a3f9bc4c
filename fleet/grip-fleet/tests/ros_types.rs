//! The hashes of the types that a gripper's node names are those of their definitions, by the rule RIHS01 of REP-2011, which is tried on types of
//! ROS 2 whose hashes are known first.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

use core::fmt::Write as _;
use grip_fleet::ros::RosTopic;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;

/// The fields of types of ROS 2 (Jazzy, Kilted).
const COMMON: [(&str, &str); 5] = [
    ("builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec"),
    ("std_msgs/msg/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("std_msgs/msg/String", "string data"),
    (
        "sensor_msgs/msg/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
    (
        "rcl_interfaces/msg/Log",
        "builtin_interfaces/Time stamp\nuint8 DEBUG=10\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line",
    ),
];
const OWN: [(&str, &str); 2] = [
    ("grip_msgs/msg/GripState", include_str!("../../ros/grip_msgs/msg/GripState.msg")),
    ("grip_msgs/msg/SlipEvent", include_str!("../../ros/grip_msgs/msg/SlipEvent.msg")),
];

/// Numbers of the kinds of fields (`type_description_interfaces/msg/FieldType`); a sequence without bound has 144 more.
const KINDS: [(&str, u16); 9] = [
    ("int32", 6),
    ("uint8", 3),
    ("uint16", 5),
    ("uint32", 7),
    ("uint64", 9),
    ("float32", 10),
    ("float64", 11),
    ("bool", 15),
    ("string", 17),
];
const NESTED: u16 = 1;
const SEQUENCE: u16 = 144;

fn definition(name: &str) -> &'static str {
    let mut all = COMMON.iter().chain(&OWN);
    all.find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no definition of {name}")).1
}

/// One type as JSON; those in it are put beside it.
fn describe(name: &str, inside: &mut BTreeMap<String, String>) -> String {
    let bare = definition(name).lines().map(|line| line.split('#').next().unwrap_or_default());
    let fields = bare.filter(|line| !line.trim().is_empty() && !line.contains('='));
    let mut out = String::new();
    for line in fields {
        let [kind, field] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let (one, more) = match kind.strip_suffix("[]") {
            Some(one) => (one, SEQUENCE),
            None => (kind, 0),
        };
        let simple = KINDS.iter().find(|(known, _)| *known == one);
        let nested = one.replace('/', "/msg/");
        let (id, nested) = simple.map_or((NESTED, nested.as_str()), |(_, id)| (*id, ""));
        if !nested.is_empty() {
            let text = describe(nested, inside);
            inside.insert(nested.to_owned(), text);
        }
        let comma = if out.is_empty() { "" } else { ", " };
        write!(out, "{comma}{{\"name\": \"{field}\", \"type\": {{\"type_id\": {}, \"capacity\": 0, \"string_capacity\": 0, \"nested_type_name\": \"{nested}\"}}}}", id + more).unwrap();
    }
    format!("{{\"type_name\": \"{name}\", \"fields\": [{out}]}}")
}

/// RIHS01 of a type.
fn hash(name: &str) -> String {
    let mut inside = BTreeMap::new();
    let own = describe(name, &mut inside);
    let inside = inside.into_values().collect::<Vec<_>>().join(", ");
    let all =
        format!("{{\"type_description\": {own}, \"referenced_type_descriptions\": [{inside}]}}");
    let digest = Sha256::digest(all.as_bytes());
    digest.iter().fold("RIHS01_".to_owned(), |text, byte| format!("{text}{byte:02x}"))
}

/// `ros2 topic info --verbose` shows them: those of String (design document of rmw_zenoh), Header, JointState and Log are widely printed.
#[test]
fn known_types_have_their_known_hashes() {
    for (name, wanted) in [
        (
            "builtin_interfaces/msg/Time",
            "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
        ),
        ("std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"),
        ("std_msgs/msg/Header", "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"),
        (
            "rcl_interfaces/msg/Log",
            "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
        ),
        (
            "sensor_msgs/msg/JointState",
            "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
        ),
    ] {
        assert_eq!(hash(name), format!("RIHS01_{wanted}"), "{name}");
    }
}

#[test]
fn every_topic_names_the_hash_of_its_type() {
    for topic in RosTopic::ALL {
        assert_eq!(topic.hash(), hash(&topic.ros_type()), "{}", topic.ros_type());
    }
}
