//! `include/slip.h` is what cbindgen makes of the crate, with the codes of slip-msg. `SLIP_HEADER=write` writes it.

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, Language, RenameRule};
use core::fmt::Write as _;
use slip_msg as msg;
use std::{env, fs, path::Path};

/// Names of the types in C.
const TYPES: [(&str, &str); 12] = [
    ("SlipPipeline", "slip_pipeline"),
    ("SlipOptions", "slip_options"),
    ("SlipBlock", "slip_block"),
    ("SlipEvent", "slip_event"),
    ("SlipEventKind", "slip_event_kind"),
    ("SlipObject", "slip_object"),
    ("SlipSignal", "slip_signal"),
    ("SlipState", "slip_state"),
    ("SlipNeed", "slip_need"),
    ("SlipResult", "slip_result"),
    ("SlipTrial", "slip_trial"),
    ("SlipEsc", "slip_esc_value"),
];

/// The codes that events, states and calls hold.
fn codes() -> String {
    let mut text = String::new();
    macro_rules! tables {
        ($($name:ident)+) => { $(
            write!(text, "\n// {}\nenum {{\n", stringify!($name)).unwrap();
            for row in msg::$name::TABLE {
                let constant: String = row.constant().collect();
                let prefix = constant_case(stringify!($name));
                writeln!(text, "  // {}\n  SLIP_{prefix}_{constant} = {},", row.about, row.code).unwrap();
            }
            text += "};\n";
        )+ };
    }
    tables!(Scene GripState Phase Method SpeedSource Reading Sensor SensorHealth Operation);
    text.trim().to_owned()
}

/// `GripState` as `GRIP_STATE`.
fn constant_case(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.push(letter.to_ascii_uppercase());
    }
    text
}

#[test]
fn the_header_is_that_of_the_crate() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = Config {
        language: Language::C,
        cpp_compat: true,
        include_guard: Some("SLIP_H".to_owned()),
        header: Some(
            "// Slip detection and grip force in your program; the guide is docs/c.md.\n// \
             Made by crates/slip-ffi/tests/header.rs: change it there."
                .to_owned(),
        ),
        // Within the include guard, where a trailer is not.
        after_includes: Some(format!("\n{}", codes())),
        documentation_style: DocumentationStyle::C99,
        usize_is_size_t: true,
        no_includes: true,
        sys_includes: vec!["stddef.h".to_owned(), "stdint.h".to_owned()],
        enumeration: EnumConfig {
            rename_variants: RenameRule::QualifiedScreamingSnakeCase,
            ..EnumConfig::default()
        },
        ..Config::default()
    };
    config.export.include.extend(["SlipEventKind", "SlipObject", "SlipSignal"].map(str::to_owned));
    config.export.rename.extend(TYPES.map(|(rust, c)| (rust.to_owned(), c.to_owned())));
    config.export.rename.insert("SlipStatus".to_owned(), "slip_status".to_owned());
    let mut made = Vec::new();
    let mut builder = Builder::new().with_config(config);
    for file in ["lib", "abi", "pipeline", "status"] {
        builder = builder.with_src(folder.join(format!("src/{file}.rs")));
    }
    builder.generate().unwrap().write(&mut made);
    // A line of documentation that is empty has no blank at its end; C has no section of Rust's safety.
    let made = String::from_utf8(made).unwrap();
    let made = made.replace("// \n", "//\n").replace("//\n// # Safety\n", "//\n");
    let file = folder.join("include/slip.h");
    if env::var("SLIP_HEADER").is_ok_and(|how| how == "write") {
        fs::write(&file, &made).unwrap();
    }
    let kept = fs::read_to_string(&file).unwrap_or_default();
    let line = made.lines().zip(kept.lines()).position(|(made, kept)| made != kept);
    assert!(
        made == kept,
        "{}: differs at line {line:?}; SLIP_HEADER=write writes it",
        file.display()
    );
}
