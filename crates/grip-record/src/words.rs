//! Names that people give to signals in, what they mean by them out.

/// The part of a name that states what it is: behind topic and fields, without its unit.
pub(crate) fn plain(name: &str) -> String {
    let last = name.rsplit(['.', '/']).next().unwrap_or(name).to_lowercase();
    last.split(['(', '[', '{']).next().unwrap_or_default().trim().replace([' ', '-'], "_")
}

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
    let is = ["acceleration", "accel", "acc", "accelerometer", "a"].contains(&word)
        || (word == "linear" && lower.contains("accel"));
    is.then(|| (stem.to_owned(), axis))
}

/// Whether a name without a number is that of a vibration signal.
pub(crate) fn is_vibration(name: &str) -> bool {
    const WORDS: [&str; 12] = [
        "vibration",
        "vib",
        "vibro",
        "piezo",
        "mic",
        "microphone",
        "audio",
        "sound",
        "accel",
        "acc",
        "acceleration",
        "accelerometer",
    ];
    let plain = plain(name);
    let stem = plain.strip_suffix("raw").unwrap_or(&plain).trim_end_matches(['_', ',']);
    WORDS.contains(&stem)
}

/// Whether it is that of the normal force of a finger.
pub(crate) fn is_force(name: &str) -> bool {
    let plain = plain(name);
    let stem = plain.strip_suffix("_n").or_else(|| plain.strip_suffix("_mn")).unwrap_or(&plain);
    ["force", "normal_force", "grip_force", "finger_force"].contains(&stem)
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

/// Whether it is that of an acceleration without a name for its axis.
pub(crate) fn is_acceleration(name: &str) -> bool {
    ["accel", "acc", "acceleration", "accelerometer"].contains(&plain(name).as_str())
}

/// Whether it is that of a sensor on the robot, which feels its motion and no slip.
pub(crate) fn is_robot(name: &str) -> bool {
    const WORDS: [&str; 9] =
        ["base", "wrist", "robot", "reference", "ref", "arm", "flange", "palm", "hand"];
    let lower = name.to_lowercase();
    lower.split(|c: char| !c.is_alphanumeric()).any(|word| WORDS.contains(&word))
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
        assert!(is_force("Force [mN]") && is_force("normal_force_n") && !is_force("/w.force.x"));
        assert!(is_robot("/wrist/imu.accel") && is_robot("base_a") && !is_robot("armature_a"));
    }
}
