//! Constants in a source file of the crate: what no value can be asked for.

use std::path::Path;

fn read(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn number(text: &str) -> Option<u64> {
    let digits = text.replace('_', "");
    match digits.strip_prefix("0x") {
        Some(hex) => u64::from_str_radix(hex, 16).ok(),
        None => digits.parse().ok(),
    }
}

/// One numeric constant, public or not.
pub(crate) fn constant(file: &str, name: &str) -> u64 {
    let text = read(file);
    let found = text.lines().find_map(|line| {
        let (head, value) = line.trim().strip_suffix(';')?.split_once(" = ")?;
        let (before, _) = head.split_once(':')?;
        (before.split(' ').next_back()? == name).then(|| number(value))?
    });
    found.unwrap_or_else(|| panic!("no constant {name} in {file}"))
}
