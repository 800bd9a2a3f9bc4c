//! Each kind of file that people have: what is read of it, or which words name the cause and the way out.
#![expect(
    clippy::unwrap_used,
    clippy::cognitive_complexity,
    clippy::too_many_lines,
    reason = "one list of cases a kind; helpers of the tests stand outside the test functions"
)]

use std::{io::Read, path::Path};

use grip_table::{Header, LossKind, Table, TableError};
use proptest::prelude::*;

/// All of a table: names, units, rows as text, losses.
#[derive(Debug, Default, PartialEq)]
struct Contents {
    names: Vec<String>,
    units: Vec<Option<String>>,
    text: Vec<String>,
    rows: Vec<Vec<Option<f64>>>,
    losses: Vec<(LossKind, u64)>,
    header: Option<Header>,
}

fn try_read(bytes: &[u8]) -> Result<Contents, TableError> {
    let mut table = Table::open(Path::new("x.csv"), bytes)?;
    let columns = table.columns().to_vec();
    let mut rows = Vec::new();
    while let Some(row) = table.next_row()? {
        let used = columns.iter().enumerate().filter(|(_, column)| !column.is_text);
        rows.push(used.map(|(at, _)| row.value(at)).collect::<Result<Vec<_>, _>>()?);
    }
    Ok(Contents {
        names: table.header().to_vec(),
        units: columns.iter().map(|column| column.unit.clone()).collect(),
        text: columns
            .iter()
            .filter(|column| column.is_text)
            .map(|column| column.name.clone())
            .collect(),
        rows,
        losses: table.losses().iter().map(|loss| (loss.kind, loss.line)).collect(),
        header: Some(table.header_line()),
    })
}

fn read(text: impl AsRef<[u8]>) -> Contents {
    try_read(text.as_ref()).unwrap()
}

fn refused(text: impl AsRef<[u8]>) -> String {
    try_read(text.as_ref()).unwrap_err().to_string()
}

/// Rows of two columns: `0.000,0.0`, `0.001,0.5`, ..
fn rows(count: u32) -> Vec<[f64; 2]> {
    (0..count).map(|k| [f64::from(k) / 1000.0, f64::from(k % 7) * 0.5]).collect()
}

/// The same as lines of text, with these signs.
fn body(count: u32, delimiter: &str, decimal: &str, end: &str) -> String {
    let line = |[t, x]: [f64; 2]| format!("{t:.3}{delimiter}{x:.1}{end}").replace('.', decimal);
    rows(count).into_iter().map(line).collect()
}

fn values(count: u32) -> Vec<Vec<Option<f64>>> {
    rows(count).iter().map(|row| row.iter().copied().map(Some).collect()).collect()
}

#[test]
fn every_encoding_and_line_end_reads_the_same() {
    let text = |end: &str| format!("t_s,x{end}{}", body(20, ",", ".", end));
    for end in ["\n", "\r\n", "\r"] {
        let found = read(text(end));
        assert_eq!(
            (found.names.join(","), found.rows),
            ("t_s,x".to_owned(), values(20)),
            "{end:?}"
        );
    }
    let plain = read(text("\n"));
    assert_eq!(read(format!("\u{feff}{}", text("\n"))), plain);
    for mark in [true, false] {
        for big in [true, false] {
            let order = |unit: u16| if big { unit.to_be_bytes() } else { unit.to_le_bytes() };
            let units = mark
                .then_some(0xfeff)
                .into_iter()
                .chain(text("\r\n").encode_utf16().collect::<Vec<_>>());
            let bytes: Vec<u8> = units.flat_map(order).collect();
            assert_eq!(read(&bytes), plain, "UTF-16, mark {mark}, big {big}");
            // Cut within a character.
            let cut = read(&bytes[..bytes.len() - 5]);
            assert_eq!((cut.rows.len(), cut.losses.len()), (19, 1), "UTF-16, cut");
        }
    }
    let latin = [b"t_s,h (\xb5m),a [\xb0]\n".as_slice(), b"0,1,2\n1,2,3\n"].concat();
    let latin = read(latin);
    assert_eq!(latin.names[1..], ["h (\u{b5}m)", "a [\u{b0}]"]);
    assert_eq!(latin.units[1].as_deref().and_then(grip_table::scale).unwrap().1, 1e-6);
}

#[test]
fn delimiter_and_decimal_sign_are_found() {
    for (delimiter, decimal) in [
        (",", "."),
        (";", "."),
        ("\t", "."),
        ("|", "."),
        (" ", "."),
        ("   ", "."),
        (";", ","),
        ("\t", ","),
        (" ", ","),
        ("; ", ","),
    ] {
        for head in
            [format!("t_s{delimiter}x\n"), String::new(), format!("sep=;\nt_s{delimiter}x\n")]
        {
            if head.starts_with("sep") && !delimiter.starts_with(';') {
                continue;
            }
            let text = format!("{head}{}", body(30, delimiter, decimal, "\n"));
            let found = read(&text);
            assert_eq!(found.rows, values(30), "{text}");
            let names = if head.is_empty() { ["column_0", "column_1"] } else { ["t_s", "x"] };
            assert_eq!(found.names, names, "{text}");
        }
    }
    // MATLAB's ascii, and an exponent with a comma.
    let matlab = "   0.0000000e+00   1.5000000e+00\n   1.0000000e-03  -2.5000000e+00\n";
    assert_eq!(read(matlab).rows[1], [Some(0.001), Some(-2.5)]);
    assert_eq!(read("t;x\n0;1,5E-03\n1;-2,5E+01\n").rows[1], [Some(1.0), Some(-25.0)]);
    // Whole numbers in the look-ahead, a comma behind it.
    let late = format!("t;x\n{}9;2,5\n", "1;2\n".repeat(300));
    assert_eq!(read(late).rows[300], [Some(9.0), Some(2.5)]);
    // One column below one name, and two columns of counts.
    assert_eq!(read("x\n0,5\n-1,25\n0,75\n").rows, [[Some(0.5)], [Some(-1.25)], [Some(0.75)]]);
    assert_eq!(read("0,512\n1,513\n2,514\n").rows[2], [Some(2.0), Some(514.0)]);
    assert_eq!(read("vibration\n0.5\n-1.5\n").rows, [[Some(0.5)], [Some(-1.5)]]);
}

#[test]
fn thousands_are_refused_and_never_misread() {
    for (text, words) in [
        ("t;x\n0;1,250\n1;2,375\n", ["1,250", "thousands"]),
        ("t;x\n0;1.250,5\n1;0,5\n2;0,5\n", ["1.250,5", "thousands"]),
        ("t;x\n0;1.250\n1;0,5\n2;0,5\n3;0,5\n", ["1.250", "thousands"]),
        ("t,x\n0,\"1,250\"\n1,2.5\n2,3.5\n", ["1,250", "thousands"]),
        ("t,x\n0,\"1,250.5\"\n1,2.5\n2,3.5\n", ["1,250.5", "thousands"]),
        ("t;x\n0;1 250,5\n1;2,5\n2;3,5\n", ["1 250,5", "thousands"]),
        ("t;x\n0;1'250.5\n1;2.5\n2;3.5\n", ["1'250.5", "thousands"]),
    ] {
        let message = refused(text);
        assert!(
            words.iter().all(|word| message.contains(word)) && message.contains("line 2, column x"),
            "{text:?}: {message}"
        );
    }
}

#[test]
fn points_and_commas_that_mean_two_things_are_refused() {
    let late = |first: &str, then: &str| format!("n;x\n{}{then}\n1;2\n", first.repeat(300));
    for (text, words) in [
        ("t;x\n0;1.184\n1;770\n2;1.038\n".to_owned(), "line 2, column x: \"1.184\""),
        ("t\tx\n0\t-770\n1\t-1.184\n".to_owned(), "line 3, column x: \"-1.184\""),
        (late("1;500\n", "1;1.184"), "line 302, column x: \"1.184\""),
        (late("1;1.500\n", "1;770"), "line 302, column x: \"770\""),
    ] {
        let message = refused(&text);
        assert!(message.contains(words) && message.contains("thousands"), "{message}");
    }
    assert_eq!(read("t;x\n0;0.123\n1;0.456\n2;700\n").rows[1][1], Some(0.456));
    assert_eq!(read("t;x\n0;1.123\n1;2.456\n2;3.200\n").rows[1][1], Some(2.456));
    assert_eq!(read("t;x\n0;1.184\n1;770\n2;1.5\n").rows[0][1], Some(1.184));
    assert_eq!(read("t,x\n0,1.184\n1,770\n").rows[0][1], Some(1.184));
    // Commas.
    for text in [
        "0,0204\n-0,0256\n0,0042\n",
        "512,3\n513,1\n511,9\n",
        "1,5\n-0,2\n0,25\n",
        "t_s,x\n0,000000,0,0204\n0,000625,0,0256\n",
        "t_s,x\n0,000000,0,0204\n0,000625,-0,0256\n",
    ] {
        let message = refused(text);
        assert!(message.contains("decimal comma") && message.contains("semicolons"), "{message}");
    }
    assert_eq!(read("1,5\n2,12\n2,-3\n").names.len(), 2);
    // Within quotes they are decimal.
    let quoted = "t,x\n\"0,000000\",\"0,0204\"\n\"0,000625\",\"-0,0256\"\n";
    assert_eq!(read(quoted).rows[1], [Some(0.000_625), Some(-0.0256)]);
}

#[test]
fn units_settings_and_logs_are_no_names() {
    let three = "0.0,1.5,2.0\n0.5,2.5,2.5\n1.0,3.5,1.5\n";
    for (units, found) in [
        ("s,m/s\u{b2},\u{b0}C", ["s", "m/s\u{b2}", "\u{b0}C"]),
        ("ms,-,N", ["ms", "", "N"]),
        ("ms,counts,furlong", ["ms", "counts", "furlong"]),
    ] {
        let read = read(format!("time,vibration,temp\n{units}\n{three}"));
        assert_eq!(read.names, ["time", "vibration", "temp"], "{units}");
        let own = read.units.iter().map(|unit| unit.as_deref().unwrap_or_default());
        assert_eq!(own.collect::<Vec<_>>(), found);
    }
    let pairs = body(12, ",", ".", "\n");
    for settings in ["Channels,2\nRate,1600\nGain,4\n", "Model,X1\nUnits,SI\n"] {
        let found = read(format!("{settings}Time,Vibration\ns,mV\n{pairs}"));
        assert_eq!(
            (found.names, found.rows),
            (vec!["Time".into(), "Vibration".into()], values(12))
        );
    }
    for text in [
        format!("Channels,2\nRate,1600\nDate,2026\n{pairs}"),
        format!("boot\n[I] sensor ok, 3 axes, 2.0 g\n{three}"),
        format!("I (31) boot: up, mode 3, done\n{three}"),
    ] {
        assert_eq!(read(&text).header, Some(Header::None), "{text}");
    }
    assert_eq!(read(format!("[s] t,[V] a,b\n{three}")).rows.len(), 3);
}

#[test]
fn the_header_is_the_last_text_above_the_rows() {
    type Case = (String, [&'static str; 2], [Option<&'static str>; 2]);
    let tab = body(12, "\t", ".", "\n");
    let comma = body(12, ",", ".", "\n");
    let lvm = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\nDate\t2026/01/31\n\
               ***End_of_Header***\t\n\t\nChannels\t1\t\nSamples\t1000\t\nY_Unit_Label\tVolts\t\nX0\t0.0E+0\t\nDelta_X\t1.0E-3\t\n\
               ***End_of_Header***\t\t\nX_Value\tUntitled\tComment\n";
    let tek = "Model,TBS1102\nFirmware Version,FV:1.2\nPoint Format,Y\nRecord Length,2000\nSample Interval,1e-3\n,\nLabel,\nTIME,CH1\n";
    let cases: [Case; 14] = [
        (format!("{tek}{comma}"), ["TIME", "CH1"], [None; 2]),
        (
            format!("Time,Channel A\n(ms),(mV)\n\n{comma}"),
            ["Time", "Channel A"],
            [Some("ms"), Some("mV")],
        ),
        (
            format!("x-axis,1\nsecond,Volt\n{comma}"),
            ["x-axis", "1"],
            [Some("second"), Some("Volt")],
        ),
        (
            format!(
                "Record Length,Analog:2000\nVertical Units,CH1:V\nModel,S\nSecond,Volt\n{comma}"
            ),
            ["Second", "Volt"],
            [None; 2],
        ),
        (
            format!("rst:0x1 (POWERON_RESET),boot:0x13\nets Jul 29\nmicros,x\n{comma}"),
            ["micros", "x"],
            [None; 2],
        ),
        (
            format!("\x1b[0;32mI (31) boot: 2nd stage\nload:0x3fff,len:1184\nmicros,x\n{comma}"),
            ["micros", "x"],
            [None; 2],
        ),
        (format!("# sampled at 1 kHz\n# t, x\n{comma}"), ["t", "x"], [None; 2]),
        (format!("% t, x\n{}", body(12, " ", ".", "\n")), ["t", "x"], [None; 2]),
        (format!("// t;x\n{}", body(12, ";", ",", "\n")), ["t", "x"], [None; 2]),
        (
            format!("# t x\n# a remark of more words\n{}", body(12, " ", ".", "\n")),
            ["t", "x"],
            [None; 2],
        ),
        (format!("time_s,\"vibration, raw\"\n{comma}"), ["time_s", "vibration, raw"], [None, None]),
        (format!("time_s,\"vibration\nraw\"\n{comma}"), ["time_s", "vibration raw"], [None, None]),
        (format!("\"a\" \"b c\"\n{}", body(12, " ", ".", "\n")), ["a", "b c"], [None; 2]),
        (
            format!("Rate,5000\n\nTime [ms]\tacc [g]\n{tab}"),
            ["Time [ms]", "acc [g]"],
            [Some("ms"), Some("g")],
        ),
    ];
    for (text, names, units) in cases {
        let found = read(&text);
        assert_eq!(found.names, names, "{text}");
        assert_eq!(found.rows, values(12), "{text}");
        if units != [None; 2] {
            assert_eq!(
                found.units.iter().map(Option::as_deref).collect::<Vec<_>>(),
                units,
                "{text}"
            );
        }
    }
    let found = read(format!("{lvm}{tab}"));
    assert_eq!(
        (found.names.join(","), found.rows.len()),
        ("X_Value,Untitled,Comment".to_owned(), 12)
    );
    assert_eq!(found.rows[3][..2], values(12)[3]);
    // Without a column of times LabVIEW leaves its cells blank.
    let empty: String = rows(12).iter().map(|[t, x]| format!("\t{t:.3}\t{x:.1}\n")).collect();
    let found = read(format!(
        "{}{empty}",
        lvm.replace("One", "No").replace("0.0E+0\t", "0.0\t0.0").replace("1.0E-3\t", "1.0\t1.0")
    ));
    assert_eq!((found.names[0].as_str(), found.rows.len()), ("X_Value", 12));
    // Rigol: numbers in other columns of the row of units.
    let rigol: String = rows(12).iter().map(|[t, x]| format!("{t:.3},{x:.1},,\n")).collect();
    let found = read(format!("X,CH1,Start,Increment\nSequence,Volt,-6.0e-03,1.0e-05\n{rigol}"));
    assert_eq!((found.names[1].as_str(), found.rows.len()), ("CH1", 12));
    // Old Tektronix: settings beside the first rows.
    let settings = ["Record Length,2500", "Source,CH1", ","];
    let old: String = (0..12).map(|k| format!("{},,{k}.5,0.{k},\n", settings[k.min(2)])).collect();
    let found = read(old);
    assert_eq!(found.rows.len(), 12);
    // R: names of rows without a name.
    let found = read("\"t\",\"x\"\n\"1\",0.5,1\n\"2\",0.6,2\n");
    assert_eq!((found.names.join(","), found.rows[1][1]), ("column_0,t,x".to_owned(), Some(0.6)));
}

#[test]
fn no_row_is_lost_at_the_start() {
    let blank: String = (0..300)
        .map(|k| format!("0.{k:03},1.5,{}\n", if k % 80 == 79 { "7" } else { "" }))
        .collect();
    let found = read(&blank);
    assert_eq!((found.rows.len(), found.header), (300, Some(Header::None)));
    let spelled = read("NaN,1.5,2\n0.1,NA,3\n0.2,2.5,-\n");
    assert_eq!((spelled.rows.len(), spelled.rows[0][1]), (3, Some(1.5)));
    // A fault in the first rows is one of a row, not of the header.
    for bad in ["0.0,x\n", "x,0.5\n", "0,1.2.3\n"] {
        let message = refused(format!("t_s,v\n{bad}{}", body(20, ",", ".", "\n")));
        assert!(message.contains("line 2, column"), "{bad}: {message}");
    }
    let message =
        refused(format!("t_s,v\n{}0.5,x\n{}", body(20, ",", ".", "\n"), body(20, ",", ".", "\n")));
    assert!(message.contains("line 22, column v"), "{message}");
}

#[test]
fn names_that_are_numbers_are_reported() {
    for text in [
        ",0,1\n0,0.0,0.5\n1,0.1,0.7\n2,0.2,0.5\n",
        "0,1\n0.0,0.5\n0.1,0.7\n0.2,0.9\n",
        "t,0,1\n0,1.5,2\n1,2.5,3\n2,2,2\n",
    ] {
        let found = read(text);
        assert_eq!((found.header, found.rows.len()), (Some(Header::Numbers(1)), 3), "{text}");
    }
    for text in ["0,1,2\n1,5,7\n2,5,9\n", "0,0.5\n1,0.7\n2,0.9\n", ",0.5\n1,0.7\n2,0.9\n"] {
        let found = read(text);
        assert_eq!((found.header, found.rows.len()), (Some(Header::None), 3), "{text}");
    }
    let found = read("a,,a,b\n0,1,2,3\n1,2,3,4\n");
    assert_eq!(found.names, ["a", "column_1", "column_2", "b"]);
}

#[test]
fn text_beside_numbers_is_not_looked_at() {
    let found = read(
        "time_s,phase,when,vibration\n0,hold,2026-01-31T10:00:00,1\n1,,2026-01-31T10:00:01,2\n2,7,x,3\n",
    );
    assert_eq!((found.text, found.rows.len()), (vec!["phase".to_owned(), "when".to_owned()], 3));
    let mut table =
        Table::open(Path::new("x.csv"), "t,x\n10:00:01,1\n10:00:02,2\n".as_bytes()).unwrap();
    let message = table.next_row().unwrap().unwrap().number(0).unwrap_err().to_string();
    assert!(message.contains("line 2, column t") && message.contains("--rate HZ"), "{message}");
}

#[test]
fn what_is_no_number_has_many_spellings() {
    let words = [
        "NaN",
        "nan",
        "NA",
        "N/A",
        "#N/A",
        "null",
        "NULL",
        "None",
        "-",
        "--",
        "#NUM!",
        "#DIV/0!",
        "-nan(ind)",
        "1.#QNAN",
        "-1.#IND",
        "?",
        "-nan",
        "<NA>",
        "#NV",
    ];
    for word in words {
        let found = read(format!("t,x\n0,1.5\n1,{word}\n{word},2\n3,2.5\n"));
        assert!(found.rows[1][1].unwrap().is_nan() && found.rows[2][0].unwrap().is_nan(), "{word}");
    }
    for (word, value) in [
        ("inf", f64::INFINITY),
        ("-Inf", f64::NEG_INFINITY),
        ("1.#INF", f64::INFINITY),
        ("-1.#INF", f64::NEG_INFINITY),
    ] {
        assert_eq!(read(format!("t,x\n0,1.5\n1,{word}\n")).rows[1][1], Some(value), "{word}");
    }
    assert_eq!(read("t,x\n0,1.5\n1,\n2,2\n").rows[1][1], None);
}

#[test]
fn a_cut_end_is_left_out_and_reported() {
    let whole = format!("t_s,x,y\n{}", body(40, ",", ".", ",5\n"));
    // Wherever it is cut: only rows that were there, and a word where one is missing.
    for cut in whole.len() - 40..whole.len() {
        let found = read(&whole[..cut]);
        let complete = whole[..cut].matches('\n').count() - 1;
        for (row, wanted) in found.rows.iter().zip(values(40)) {
            assert_eq!(row[..2], wanted, "cut at {cut}");
        }
        let ends_at_a_line = whole[..cut].ends_with('\n');
        let is_row = whole[..cut].ends_with(",5");
        assert_eq!(found.rows.len(), complete + usize::from(is_row), "cut at {cut}");
        let expected = if ends_at_a_line || is_row { 0 } else { 1 };
        assert_eq!(
            found.losses.iter().filter(|loss| loss.0 == LossKind::Cut).count(),
            expected,
            "cut at {cut}: {found:?}"
        );
    }
    // The last number shortened: fixed digits, and counts.
    let fixed = body(40, ",", ".", "\n");
    assert_eq!(read(fixed.trim_end()).losses, []);
    assert_eq!(read(&fixed[..fixed.len() - 2]).losses, [(LossKind::Cut, 40)]);
    let counts: String = (0..40).map(|k| format!("{k},{}\n", 100 + k)).collect();
    assert_eq!(read(counts.trim_end()).losses, []);
    assert_eq!(read(&counts[..counts.len() - 2]).losses, [(LossKind::Cut, 40)]);
    // A power cut.
    for nuls in [1, 512, 3 << 20] {
        let found = read([fixed.as_bytes(), &vec![0; nuls]].concat());
        assert_eq!(
            (found.rows.len(), found.losses),
            (40, vec![(LossKind::Bytes, 41)]),
            "{nuls} NULs"
        );
    }
    let found = read([fixed.as_bytes(), b"\0\0\0\0", fixed.as_bytes()].concat());
    assert_eq!((found.rows.len(), found.losses[0].0), (80, LossKind::Bytes));
    let found = read([fixed.as_bytes(), b"\x07\x80\x01\xff\x02\n\x03\x04"].concat());
    assert_eq!((found.rows.len(), found.losses[0]), (40, (LossKind::Bytes, 41)));
    // A remark behind the rows.
    for remark in [
        "Rate 5000, overflows 0\n",
        "Rate 5000, overflows 0",
        "\n# end\nstopped by user\n",
        "[END]\n",
    ] {
        let found = read(format!("{fixed}{remark}"));
        assert_eq!(found.rows.len(), 40, "{remark}");
        assert!(
            found.losses.iter().all(|loss| loss.0 == LossKind::Remark),
            "{remark}: {:?}",
            found.losses
        );
    }
    // In the middle it is a fault.
    let message = refused(format!("{fixed}stopped, started\n{fixed}"));
    assert!(message.contains("line 41"), "{message}");
    let message = refused(format!("t,x\n{fixed}t,x\n{fixed}"));
    assert!(message.contains("line 42 is the header again"), "{message}");
}

#[test]
fn other_kinds_of_files_are_named() {
    let kinds: [(&[u8], &str); 12] = [
        (b"\x1f\x8b\x08\0\0\0", "gzip -d"),
        (b"\x28\xb5\x2f\xfd\0", "zstd -d"),
        (b"MATLAB 5.0 MAT-file, Platform", "scipy.io.loadmat"),
        (b"\x89HDF\r\n\x1a\n\0", "HDF5"),
        (b"fLaC\0\0\0", "flac -d"),
        (b"TDSm\x0e\0", "TDMS"),
        (b"PAR1\x15", "Parquet"),
        (b"SQLite format 3\0", "SQLite"),
        (b"#ROSBAG V2.0\n", "ROS 1"),
        (b"\x93NUMPY\x01", "NumPy"),
        (b"PK\x03\x04\x14\0\0\0\0\0t_s.npy", ".npz"),
        (b"\x7fELF", "a program"),
    ];
    for (start, words) in kinds {
        let bytes = [start, b"\n1,2\n3,4\n5,6\n"].concat();
        let message = refused(bytes);
        assert!(message.contains("is no table but") && message.contains(words), "{message}");
    }
    assert!(refused("").contains("is empty"));
    assert!(refused("\n\n  \n").contains("is empty"));
    let noise: Vec<u8> =
        (0..4000_u32).map(|k| k.wrapping_mul(2_654_435_761).to_le_bytes()[2] & 0x1f).collect();
    assert!(refused(noise).contains("is no text"));
}

/// Bytes without end.
struct Endless(u64, &'static [u8]);

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        for byte in &mut *buffer {
            *byte = self.1[usize::try_from(self.0).unwrap() % self.1.len()];
            self.0 += 1;
        }
        Ok(buffer.len())
    }
}

#[test]
fn lines_and_quotes_without_end_are_refused_at_once() {
    let long = |start: &'static [u8], repeated: &'static [u8]| {
        let mut table = Table::open(Path::new("x.csv"), start.chain(Endless(0, repeated)))?;
        while table.next_row()?.is_some() {}
        Ok::<_, TableError>(table.losses().len())
    };
    assert!(long(b"", b"x").unwrap_err().to_string().contains("a line has more than"));
    assert!(
        long(b"t,x\n0,1\n1,2\n", b"9").unwrap_err().to_string().contains("a line has more than")
    );
    assert!(long(b"", b"\0").unwrap_err().to_string().contains("is no t"));
    assert!(long(b"t,x\n0,1\n1,2\n\"", b"a\n").unwrap_err().to_string().contains("quotation mark"));
    assert_eq!(long(b"t,x\n0,1\n1,2\n", b"\0").unwrap(), 1, "a table before NULs without end");
}

#[test]
fn a_file_of_any_length_takes_the_same_room_and_has_its_lines() {
    let mut table = Table::open(Path::new("x.csv"), Endless(0, b"0.25,1\r\n")).unwrap();
    for line in 1..300_000 {
        let row = table.next_row().unwrap().unwrap();
        assert_eq!((row.line, row.blank_before, row.number(0).unwrap()), (line, 0, 0.25));
    }
    let text = "a,\"b\nc\"\n1,\"x\n\ny\"\n\n\n2,z\n";
    for end in ["\n", "\r\n", "\r"] {
        let text = text.replace('\n', end);
        let mut table = Table::open(Path::new("x.csv"), text.as_bytes()).unwrap();
        let mut lines = Vec::new();
        while let Some(row) = table.next_row().unwrap() {
            lines.push((row.line, row.blank_before, row.cell(0).into_owned()));
        }
        assert_eq!(lines, [(3, 0, "1".to_owned()), (8, 2, "2".to_owned())], "{end:?}");
    }
}

#[test]
fn a_table_by_hand_keeps_every_line() {
    let mut table = Table::by_hand(
        Path::new("l.csv"),
        "\u{feff}recording;kind;onset_s\r\na;steady;\r\nb;onset;1,5".as_bytes(),
    )
    .unwrap();
    let onset = table.required("onset_s").unwrap();
    assert_eq!(table.next_row().unwrap().unwrap().cell(0), "a");
    assert_eq!(table.next_row().unwrap().unwrap().digits(onset), "1.5");
    assert!(table.next_row().unwrap().is_none());
    let mut table = Table::by_hand(Path::new("l.csv"), "a,b\n1,2\n3\n".as_bytes()).unwrap();
    assert!(table.next_row().unwrap().is_some());
    assert!(table.next_row().unwrap_err().to_string().contains("line 3: 1 fields"));
    let message = table.required("c").unwrap_err().to_string();
    assert!(message.contains("no column c") && message.contains("a, b"), "{message}");
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes: Vec<u8>) {
        let _ = try_read(&bytes);
    }

    #[test]
    fn no_text_like_a_table_makes_it_panic(text in "((sep=;|# |[a-z]{1,3}|[0-9]{1,3}|[0-9],[0-9]|-|NaN|\"|\u{b5})?[,;\t| \r\n\0]{1,2}){0,40}") {
        let _ = try_read(text.as_bytes());
    }

    #[test]
    fn numbers_pass_through_every_form(values in prop::collection::vec((any::<i16>(), any::<i16>()), 3..40), form in 0..6_usize) {
        let (delimiter, decimal) = [(",", "."), (";", ","), ("\t", ","), ("  ", "."), ("|", "."), (";", ".")][form];
        let number = |value: i16| format!("{:.2}", f64::from(value) / 100.0).replace('.', decimal);
        let rows: String = values.iter().map(|(a, b)| format!("{}{delimiter}{}\n", number(*a), number(*b))).collect();
        let found = read(format!("remark\nfirst{delimiter}second\n{rows}"));
        prop_assert_eq!(found.names, ["first", "second"]);
        for (row, (a, b)) in found.rows.iter().zip(&values) {
            prop_assert_eq!(row, &[Some(f64::from(*a) / 100.0), Some(f64::from(*b) / 100.0)]);
        }
        prop_assert_eq!(found.rows.len(), values.len());
    }
}
