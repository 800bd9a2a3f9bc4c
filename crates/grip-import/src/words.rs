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
    WORDS.contains(&plain(name).as_str())
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

/// What the unit at the end of a name multiplies a number by to make it one of the base unit (m, N, m/s).
pub(crate) fn scale(name: &str) -> Option<(f64, &'static str)> {
    let bare = name.trim_end_matches([')', ']', '}', ' ']);
    let unit = bare.rsplit(['(', '[', '{', '_', ' ']).next().unwrap_or_default();
    Some(match unit {
        "m" => (1.0, "m"),
        "mm" => (1e-3, "mm"),
        "um" | "\u{b5}m" | "\u{3bc}m" => (1e-6, "um"),
        "nm" => (1e-9, "nm"),
        "N" | "n" => (1.0, "N"),
        "mN" | "mn" => (1e-3, "mN"),
        "kN" | "kn" => (1e3, "kN"),
        "m/s" => (1.0, "m/s"),
        "mm/s" => (1e-3, "mm/s"),
        _ => return None,
    })
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
        assert!(is_vibration("Vib [V]") && is_vibration("/x.audio") && !is_vibration("vibes"));
        assert!(is_force("Force [mN]") && is_force("normal_force_n") && !is_force("/w.force.x"));
        assert_eq!(scale("Force [mN]"), Some((1e-3, "mN")));
        assert_eq!((scale("force"), scale("travel_um").map(|s| s.0)), (None, Some(1e-6)));
    }
}
