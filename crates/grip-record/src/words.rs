//! Meaning of the names that people give to signals.

/// The part of a name that states what it is: behind topic and fields, without its unit.
pub(crate) fn plain(name: &str) -> String {
    let last = name.rsplit(['.', '/']).next().unwrap_or(name).to_lowercase();
    last.split(['(', '[', '{']).next().unwrap_or_default().trim().replace([' ', '-'], "_")
}

/// An acceleration in English, and in the languages of [`is_time`](crate::time::is_time).
const ACCELERATION: [&str; 9] = [
    "acceleration",
    "accel",
    "acc",
    "accelerometer",
    "beschleunigung",
    "acc\u{e9}l\u{e9}ration",
    "aceleraci\u{f3}n",
    "accelerazione",
    "versnelling",
];

/// The group and the axis of an acceleration, such as `/imu.linear_acceleration` and `x`.
pub(crate) fn acceleration(name: &str) -> Option<(String, char)> {
    let bare = name.split(['(', '[', '{']).next().unwrap_or_default().trim();
    let axis = bare.chars().next_back()?.to_ascii_lowercase();
    if !matches!(axis, 'x' | 'y' | 'z') {
        return None;
    }
    let stem = bare.get(..bare.len() - 1)?.trim_end_matches(['.', '_', ' ', '-']);
    let lower = stem.to_lowercase();
    let word = lower.rsplit(['.', '_', '/', ' ']).next().unwrap_or_default();
    let is = word == "a"
        || ACCELERATION.contains(&word)
        || (word == "linear" && lower.contains("accel"));
    is.then(|| (stem.to_owned(), axis))
}

/// Whether a name without a number is that of a vibration signal.
pub(crate) fn is_vibration(name: &str) -> bool {
    const WORDS: [&str; 10] = [
        "vibration",
        "vibraci\u{f3}n",
        "vibrazione",
        "vib",
        "vibro",
        "piezo",
        "mic",
        "microphone",
        "audio",
        "sound",
    ];
    let plain = plain(name);
    let stem = plain.strip_suffix("raw").unwrap_or(&plain).trim_end_matches(['_', ',']);
    WORDS.contains(&stem) || ACCELERATION.contains(&stem)
}

/// Whether it is that of the normal force of a finger.
pub(crate) fn is_force(name: &str) -> bool {
    let plain = plain(name);
    let stem = plain.strip_suffix("_n").or_else(|| plain.strip_suffix("_mn")).unwrap_or(&plain);
    const WORDS: [&str; 6] =
        ["force", "normal_force", "grip_force", "finger_force", "normalkraft", "greifkraft"];
    WORDS.contains(&stem)
}

/// The group and the number of a taxel, such as `/tactile.data` and 3.
pub(crate) fn taxel(name: &str) -> Option<(String, usize)> {
    let bare = name.trim_end().strip_suffix(']').unwrap_or(name);
    let stem = bare.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = bare.get(stem.len()..)?.parse().ok()?;
    let lower = stem.to_lowercase();
    let words = ["taxel", "tactile", "pressure", "electrode"];
    words
        .into_iter()
        .any(|word| lower.contains(word))
        .then(|| (stem.trim_end_matches(['[', '_', '.']).to_owned(), number))
}

/// The group of what may be the motion of something: an acceleration, or an IMU that does not say what it gives.
pub(crate) fn motion(name: &str) -> Option<String> {
    if let Some((group, _)) = acceleration(name) {
        return Some(group);
    }
    let bare = name.split(['(', '[', '{']).next().unwrap_or_default().trim();
    let separators = ['.', '_', '/', ' ', '-'];
    let (start, axis) = bare.rsplit_once(separators).unwrap_or(("", bare));
    let is_axis = ["x", "y", "z"].contains(&axis.to_lowercase().as_str());
    let group = if is_axis { start } else { bare };
    let word = group.rsplit(separators).next().unwrap_or_default().to_lowercase();
    let word = without_number(&word);
    (word == "imu" || ACCELERATION.contains(&word)).then(|| group.to_owned())
}

/// Whether it is that of a sensor on the robot, which feels its motion and no slip: a word says so, and none names a finger.
pub(crate) fn is_robot(name: &str) -> bool {
    const ROBOT: [&str; 7] = ["base", "wrist", "robot", "reference", "ref", "arm", "flange"];
    const FINGER: [&str; 20] = [
        "left",
        "right",
        "l",
        "r",
        "f",
        "finger",
        "fingers",
        "fingertip",
        "tip",
        "thumb",
        "index",
        "middle",
        "ring",
        "little",
        "pinky",
        "pad",
        "hand",
        "palm",
        "gripper",
        "jaw",
    ];
    let lower = name.to_lowercase();
    let words = || lower.split(|c: char| !c.is_alphanumeric());
    words().any(|word| ROBOT.contains(&word))
        && !words().any(|word| FINGER.contains(&without_number(word)))
}

fn without_number(word: &str) -> &str {
    word.trim_end_matches(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_understood_or_left_alone() {
        let imu = "/arm/imu.linear_acceleration";
        assert_eq!(acceleration(&format!("{imu}.y")), Some((imu.to_owned(), 'y')));
        assert_eq!(acceleration("ax"), Some(("a".to_owned(), 'x')));
        assert_eq!(acceleration("acc_z [m/s2]"), Some(("acc".to_owned(), 'z')));
        assert_eq!(acceleration("/a.accel.linear.x"), Some(("/a.accel.linear".to_owned(), 'x')));
        let theirs = acceleration("Beschleunigung x (m/s\u{b2})");
        assert_eq!(theirs, Some(("Beschleunigung".to_owned(), 'x')));
        assert_eq!(acceleration("Acc\u{c9}l\u{e9}ration_Z").map(|(_, axis)| axis), Some('z'));
        for name in ["gyro_x", "max", "/imu.angular_velocity.x", "x", "force_x"] {
            assert_eq!(acceleration(name), None, "{name}");
        }
        assert_eq!(taxel("/tactile.data[12]"), Some(("/tactile.data".to_owned(), 12)));
        assert_eq!(taxel("electrode_3"), Some(("electrode".to_owned(), 3)));
        assert_eq!((taxel("pressure"), taxel("joint[3]")), (None, None));
        assert!(
            is_vibration("Vib [V]")
                && is_vibration("/x.audio")
                && is_vibration("vibration, raw")
                && !is_vibration("vibes")
        );
        assert!(is_vibration("Beschleunigung [g]") && is_force("Normalkraft (N)"));
        assert!(is_force("Force [mN]") && is_force("normal_force_n") && !is_force("/w.force.x"));
    }

    #[test]
    fn the_robot_is_named_and_no_finger() {
        for name in ["/wrist/imu.accel", "base_a", "arm acc", "Flange.acc"] {
            assert!(is_robot(name), "{name}");
        }
        for name in [
            "armature_a",
            "basement_acc",
            "palm_acc",
            "robot_hand_acc",
            "base/tip2.accel",
            "arm_right_a",
            "wrist_f2_acc",
            "imu2_acc",
            "a",
        ] {
            assert!(!is_robot(name), "{name}");
        }
        for (name, group) in [
            ("base_acc", Some("base_acc")),
            ("wrist_imu_x", Some("wrist_imu")),
            ("imu2_acc [g]", Some("imu2_acc")),
            ("/imu1.z", Some("/imu1")),
            ("ax", Some("a")),
            ("/imu.orientation.x", None),
            ("imu_temperature", None),
        ] {
            assert_eq!(motion(name).as_deref(), group, "{name}");
        }
    }
}
