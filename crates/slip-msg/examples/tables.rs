//! Prints every table of codes as constants of another language: `cargo run -p slip-msg --example tables -- python|msg`.

use slip_msg as msg;

fn main() {
    let language = std::env::args().nth(1).unwrap_or_default();
    for (name, table) in tables() {
        let mut rows = String::new();
        for row in table {
            let (constant, code) = (row.constant().collect::<String>(), row.code);
            rows += &match language.as_str() {
                "python" => format!("    {constant} = {code}\n"),
                _ => format!("uint8 {constant}={code}\n"),
            };
        }
        #[expect(clippy::print_stdout, reason = "what it is for")]
        match language.as_str() {
            "python" => println!("class {name}(OpenCode):\n{rows}"),
            _ => println!("# {name}\n{rows}"),
        }
    }
}

/// Every table by the name of its type.
pub(crate) fn tables() -> Vec<(&'static str, &'static [msg::Row])> {
    macro_rules! all {
        ($($name:ident)+) => { vec![$((stringify!($name), msg::$name::TABLE)),+] };
    }
    all! {
        Scene GripState Phase Method SpeedSource Reading Sensor SensorHealth LinkState Recording RealTime NoticeKind DroppedClass Goodbye
        DeviceState ResetReason ChannelKind Unit EventKind NackReason LogLevel Operation SampleFormat GripMode LossAction
    }
}
