//! What the reader accepts, what it counts and what it refuses, by line and column.
#![expect(clippy::unwrap_used, reason = "helpers of the tests stand outside the test functions")]

use std::path::Path;

use grip_record::{Channel, CsvError, CsvOptions, Recording, StylusKind, parse_csv, read_csv};
use grip_table::TableError;
use proptest::prelude::*;
use slip_core::units::Micros;

fn options(rate_hz: Option<f32>, map: &[(&str, &str)]) -> CsvOptions {
    CsvOptions {
        rate_hz,
        map: map.iter().map(|(ours, theirs)| ((*ours).to_owned(), (*theirs).to_owned())).collect(),
        ..CsvOptions::default()
    }
}

fn read_with(text: &str, options: &CsvOptions) -> Result<Recording, CsvError> {
    parse_csv(Path::new("dir/rec.csv"), text.as_bytes(), options)
}

fn read(text: &str) -> Recording {
    read_with(text, &CsvOptions::default()).unwrap()
}

fn refused(text: &str) -> CsvError {
    read_with(text, &CsvOptions::default()).unwrap_err()
}

#[test]
fn every_channel_reaches_its_field() {
    let text = "t_s,stylus,force_n,tangential_n,travel_mm,velocity_m_s,stylus2,reference,pressure,motion\n\
                0,1,2,3,4,5,6,7,8,9\n0.001,1,,,,,,,,\n";
    let recording = read(text);
    assert_eq!(recording.name, "rec");
    let first = recording.samples[0];
    assert_eq!(
        (first.stylus, first.normal_force_n, first.tangential_n),
        (1.0, Some(2.0), Some(3.0))
    );
    assert_eq!(
        (first.travel_m, first.velocity_m_s, first.second_stylus),
        (Some(0.004), Some(5.0), Some(6.0))
    );
    let others = (first.reference, first.pressure, first.motion);
    assert_eq!(others, (Some(7.0), Some(8.0), Some(9.0)));
    for channel in Channel::ALL {
        assert!(recording.channels.has(channel));
        assert_eq!(channel.reading(&recording.samples[1]), None, "an empty cell is no reading");
    }
    assert_eq!(recording.channels.optional[&Channel::Travel], "travel_mm");
    assert!((recording.rate_hz - 1000.0).abs() < 1e-3, "{}", recording.rate_hz);
    assert_eq!(recording.notes.to_string(), "");
}

#[test]
fn windows_files_and_untidy_headers_read_the_same() {
    let tidy = read("t_s,vibration,pressure\n0,483,62\n0.000455,507,62\n");
    let untidy =
        read("\u{feff}t_s , vibration,  pressure\r\n0, 483 ,62\r\n0.000455,507,62\r\n\r\n");
    assert_eq!(tidy, untidy);
    assert_eq!(tidy.channels.stylus, StylusKind::Vibration);
    assert_eq!(tidy.samples[1].t, Micros(455));
}

#[test]
fn unknown_columns_and_trailing_commas_are_noted() {
    let recording = read("t_s,odd,stylus,\n0,x,1,\n0.001,y,2,\n");
    assert_eq!(recording.notes.ignored_columns, ["odd (text)"]);
    assert!(recording.notes.trailing_comma);
    assert_eq!(
        recording.notes.to_string(),
        "every line ends with a comma; columns not used: odd (text)"
    );
}

#[test]
fn a_broken_sensor_passes_and_is_counted() {
    let recording = read("t_s,stylus,force_n\n0,NaN,nan\n1,inf,1e400\n2,1e30,1\n3,,\n4,-inf,5\n");
    let stylus: Vec<f32> = recording.samples.iter().map(|sample| sample.stylus).collect();
    assert!(stylus[0].is_nan() && stylus[3].is_nan());
    assert_eq!((stylus[1], stylus[2], stylus[4]), (f32::INFINITY, 1e30, f32::NEG_INFINITY));
    assert_eq!(recording.samples[1].normal_force_n, Some(f32::INFINITY));
    assert_eq!(recording.samples[3].normal_force_n, None);
    let notes = &recording.notes;
    assert_eq!((notes.nan, notes.infinite, notes.huge, notes.empty_stylus), (2, 3, 1, 1));
}

#[test]
fn without_times_the_rate_makes_them() {
    let recording = read_with("stylus\n1\n\n3\n\n\n", &options(Some(3000.0), &[])).unwrap();
    let times: Vec<u64> = recording.samples.iter().map(|sample| sample.t.0).collect();
    assert_eq!(times, [0, 333, 667], "the blank line between is a reading that is missing");
    assert!(recording.samples[1].stylus.is_nan());
    assert_eq!((recording.notes.empty_stylus, recording.notes.blank_lines), (1, 0));
    assert_eq!((recording.rate_hz, recording.channels.time_source), (3000.0, None));
}

#[test]
fn a_given_rate_beside_times_is_reported_and_questioned() {
    let recording = read_with("t_s,stylus\n0,1\n0.001,1\n", &options(Some(500.0), &[])).unwrap();
    assert_eq!((recording.rate_hz, recording.samples[1].t), (500.0, Micros(1000)));
    assert_eq!(recording.notes.to_string(), "rate given: 500 Hz, by the times: 1000 Hz");
}

#[test]
fn renamed_columns_win_over_their_own_names() {
    let text = "time_s,acc,stylus,vibration\n0,1,2,3\n1,1,2,3\n";
    let read = |map: &[(&str, &str)]| {
        read_with(text, &options(Some(1.0), map)).map(|r| (r.samples[0].stylus, r))
    };
    let (value, recording) = read(&[("stylus", "acc"), ("t_s", "time_s")]).unwrap();
    assert_eq!((value, recording.channels.stylus), (1.0, StylusKind::Displacement));
    assert_eq!(recording.channels.stylus_source.as_deref(), Some("acc"));
    assert_eq!(recording.channels.time_source.as_deref(), Some("time_s"));
    assert_eq!(recording.notes.ignored_columns, ["stylus", "vibration"]);
    let (value, recording) = read(&[("vibration", "vibration")]).unwrap();
    assert_eq!((value, recording.channels.stylus), (3.0, StylusKind::Vibration));
    let (value, recording) = read(&[("stylus", "vibration"), ("reference", "stylus")]).unwrap();
    assert_eq!((value, recording.samples[0].reference), (3.0, Some(2.0)));
    let both = [("vibration", "vibration"), ("stylus", "stylus")];
    assert!(matches!(read(&both).unwrap_err(), CsvError::Ambiguous { .. }));
    assert!(matches!(
        read(&[]).unwrap_err(),
        CsvError::Ambiguous { first: "stylus", second: "vibration", .. }
    ));
}

#[test]
fn unusable_renamings_and_rates_are_refused() {
    let text = "t_s,stylus\n0,1\n1,2\n";
    let message =
        |rate, map: &[(&str, &str)]| read_with(text, &options(rate, map)).unwrap_err().to_string();
    let unknown = message(None, &[("styluss", "acc")]);
    assert!(
        unknown
            .starts_with("--map styluss=acc: \"styluss\" is not a known column; known are: t_s,"),
        "{unknown}"
    );
    let absent = message(None, &[("stylus", "acc")]);
    assert_eq!(absent, "dir/rec.csv: --map stylus=acc: no such signal; the file has: t_s, stylus");
    let twice = message(None, &[("stylus", "t_s"), ("reference", "t_s")]);
    assert!(twice.contains("\"t_s\" twice"), "{twice}");
    for rate in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e7] {
        assert!(message(Some(rate), &[]).starts_with("--rate"), "{rate}");
    }
}

#[test]
fn messages_name_line_column_text_and_remedy() {
    let cases = [
        (
            "",
            "dir/rec.csv: is empty; the first line must name the columns, e.g. t_s,stylus or x_mm,height_um",
        ),
        ("t_s,stylus\n", "dir/rec.csv: has a header but no rows; record at least one row"),
        (
            "t_s,a b,c\n0,1,2\n",
            "dir/rec.csv: nothing was taken for a vibration, a stylus, a travel or taxels; say which it is, for example \
             --map 'vibration=a b'; the file has: t_s, a b, c",
        ),
        (
            "stylus,x\n1,2\n",
            "dir/rec.csv: no column of times and no rate; give --rate HZ, or name the times with --map t_s=NAME; \
             the file has: stylus, x",
        ),
        (
            "\nt_s,stylus,x,stylus\n",
            "dir/rec.csv: line 2: columns 2 and 4 are both named \"stylus\"; rename or remove one of them",
        ),
        (
            "t_s,stylus\r\n0,1\r\n\r\n1,abc\r\n",
            "dir/rec.csv: line 4, column stylus: \"abc\" is not a number; write digits with a decimal point, \
             NaN for a bad reading",
        ),
        (
            "t_s,stylus\n0,1\n,1\n",
            "dir/rec.csv: line 3, column t_s: \"\" is not a number; write digits with a decimal point",
        ),
        (
            "t_s,stylus\n0,1\n1,2,3\n2,1\n",
            "dir/rec.csv: line 3: 3 fields where the header names 2; remove the extra commas",
        ),
        (
            "t_s,stylus\n0,1\n0\n2,1\n",
            "dir/rec.csv: line 3: 1 fields where the header names 2; add the missing fields (an empty one is a comma)",
        ),
        (
            "t_s,stylus\n0.3,1\n0.1,2\n",
            "dir/rec.csv: line 3, column t_s: time goes backwards from 0.3 s to 0.1 s; \
             split the file there, sorting would mix two recordings",
        ),
        (
            "t_s,stylus\nNaN,1\n",
            "dir/rec.csv: line 2, column t_s: \"NaN\" is no time; remove the row",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(refused(text).to_string(), message, "{text:?}");
    }
}

#[test]
fn other_faults_have_their_own_kind() {
    assert!(matches!(
        refused("t_s,stylus,travel_m,travel_mm\n0,1,2,3\n"),
        CsvError::Ambiguous { .. }
    ));
    assert!(matches!(refused("t_s,stylus\ninf,1\n"), CsvError::TimeOutOfRange { line: 2, .. }));
    assert!(matches!(refused("t_s,stylus\n0,1\n"), CsvError::NoRate { rows: 1, .. }));
    assert!(matches!(refused("t_s,stylus\n0,1\n0,1\n0,2\n"), CsvError::NoRate { rows: 3, .. }));
    assert!(matches!(
        refused("t_s,stylus,x,stylus\n0,1,2,3\n"),
        CsvError::Table(TableError::Repeated { first: 2, second: 4, .. })
    ));
    let missing =
        read_csv(Path::new("no/such.csv"), &CsvOptions::default()).unwrap_err().to_string();
    assert!(
        missing.starts_with("no/such.csv: cannot be read (")
            && missing.ends_with("check the path and its permissions")
    );
}

#[test]
fn several_axes_are_one_sensor() {
    let recording = read(
        "t_s,vibration,vibration_x,vibration_y,vibration_z,reference_x,reference_y\n\
         0,9,1,2,3,4,5\n1,9,1,,3,4,\n2,9,1,2,3,4,5\n",
    );
    let [first, second, _] = recording.samples[..] else { panic!("{recording:?}") };
    assert_eq!(
        (first.vibration(), first.reference_vector()),
        ([1.0, 2.0, 3.0], Some([4.0, 5.0, 0.0]))
    );
    assert!(second.stylus == 1.0 && second.stylus_axes[0].is_nan(), "{second:?}");
    assert_eq!((second.reference, second.reference_axes), (None, [0.0; 2]));
    assert_eq!(recording.channels.stylus, StylusKind::Vibration);
    assert_eq!(recording.channels.axes, ["vibration_x", "vibration_y", "vibration_z"]);
    assert_eq!(recording.notes.ignored_columns, ["vibration"], "it is their norm");

    let one = read("t_s,vibration_x\n0,1\n1,2\n");
    assert_eq!((one.samples[1].vibration(), one.channels.axes.len()), ([2.0, 0.0, 0.0], 0));
    let map = [("vibration_y", "ay"), ("vibration_x", "ax")];
    let mapped = read_with("t_s,ax,ay\n0,1,2\n1,3,4\n", &options(None, &map)).unwrap();
    assert_eq!(mapped.samples[1].vibration(), [3.0, 4.0, 0.0]);
}

#[test]
fn equal_times_are_counted_not_refused() {
    let notes = read("t_s,stylus\n0,1\n1,1\n1,1\n2,1\n3,1\n9,1\n").notes;
    assert_eq!((notes.repeated_times, notes.gaps, notes.irregular_steps), (1, 1, 1));
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes: Vec<u8>, rate in proptest::option::of(any::<f32>())) {
        let _ = parse_csv(Path::new("x.csv"), &bytes, &options(rate, &[]));
    }

    #[test]
    fn no_text_like_a_recording_makes_it_panic(
        header in "(\u{feff})?(t_s,)?(stylus|vibration|\"stylus\")(,travel_mm)?(,|,x)?",
        body in "(([0-9]{0,4}|[0-9.eE+-]{0,5}|nan|inf|\"1\"|\")(,|,|\r|\n|\r\n|\n\n)){0,8}",
        rate in proptest::option::of(0.5_f32..5000.0),
    ) {
        let text = format!("{header}\n{body}");
        if let Ok(recording) = read_with(&text, &options(rate, &[])) {
            prop_assert!(recording.samples.is_sorted_by_key(|sample| sample.t));
            prop_assert!(recording.rate_hz > 0.0 && !recording.samples.is_empty());
        }
    }
}

/// A recording of an array with `taxels`, two frames.
fn array(taxels: usize) -> String {
    let names: Vec<_> = (0..taxels).map(|taxel| format!("pressure_{taxel}")).collect();
    let row = |value: usize| vec![value.to_string(); taxels].join(",");
    format!("t_s,{}\n0,{}\n0.01,{}\n", names.join(","), row(1), row(2))
}

#[test]
fn an_array_has_1_to_256_taxels() {
    for taxels in [1, 64, 65, 256] {
        let recording = read(&array(taxels));
        assert_eq!(recording.taxels.unwrap().frame(1), vec![2.0; taxels]);
    }
    let reported = refused(&array(257)).to_string();
    assert_eq!(reported, "dir/rec.csv: 257 taxels; an array has 1 to 256");
}
