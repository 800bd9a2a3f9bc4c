//! Recordings and columns in `.npz`: as CSV has them, and everything that can be wrong with one.
#![cfg(feature = "arrays")]

#[cfg(test)]
mod tests {
    use std::fs::{self, File};
    use std::io::Write as _;
    use std::path::{Path, PathBuf};

    use grip_record::{
        Channel, ChannelSet, CsvOptions, Notes, Npz, Recording, StylusKind, Taxels, parse_csv,
        read_recording, write_columns,
    };
    use ndarray::{arr1, arr2};
    use slip_core::sample::{Arrival, Sample};
    use slip_core::units::Micros;
    use zip::write::{SimpleFileOptions, ZipWriter};

    /// 80 MB of zeros in 80 kB.
    #[test]
    fn an_array_of_nothing_but_repetitions_is_refused_before_it_is_unpacked() {
        let npy = doubles(&vec![0.0; 10_000_000]);
        let (_folder, file) = archive(&[("a", npy.clone())], true);
        let error = Npz::open(&file).unwrap().numbers("a").unwrap_err().to_string();
        assert!(error.contains("more than 200 times its size"), "{error}");
        let (_folder, file) = archive(&[("a", npy)], false);
        assert_eq!(Npz::open(&file).unwrap().numbers("a").unwrap().len(), 10_000_000);
    }

    /// An archive in a folder of its own.
    fn archive(members: &[(&str, Vec<u8>)], compressed: bool) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("rec.npz");
        let method = if compressed {
            zip::CompressionMethod::Deflated
        } else {
            zip::CompressionMethod::Stored
        };
        let options = SimpleFileOptions::default().compression_method(method);
        let mut zip = ZipWriter::new(File::create(&file).unwrap());
        for (name, bytes) in members {
            zip.start_file(format!("{name}.npy"), options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        (folder, file)
    }

    /// A column as NumPy writes it.
    fn column<const N: usize>(kind: &str, values: impl IntoIterator<Item = [u8; N]>) -> Vec<u8> {
        let data: Vec<u8> = values.into_iter().flatten().collect();
        raw(&head(&format!("'{kind}'"), &format!("({},)", data.len() / N)), &data)
    }

    fn doubles(values: &[f64]) -> Vec<u8> {
        column("<f8", values.iter().map(|value| value.to_le_bytes()))
    }

    fn floats(values: &[f32]) -> Vec<u8> {
        column("<f4", values.iter().map(|value| value.to_le_bytes()))
    }

    /// An `.npy` with any header.
    fn raw(header: &str, data: &[u8]) -> Vec<u8> {
        let length = u16::try_from(header.len() + 1).unwrap().to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), b"\n", data].concat()
    }

    fn head(descr: &str, shape: &str) -> String {
        format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}")
    }

    fn fault(bytes: Vec<u8>) -> String {
        let (_folder, file) = archive(&[("x", bytes)], false);
        let error = Npz::open(&file).unwrap().numbers("x").unwrap_err().to_string();
        error.split_once("array \"x\" ").unwrap().1.to_owned()
    }

    fn message(file: &Path) -> String {
        let text = read_recording(file, &CsvOptions::default()).unwrap_err().to_string();
        text.replace(&file.display().to_string(), "rec.npz")
    }

    #[test]
    fn columns_of_every_type_read_like_a_csv_file() {
        let csv = "t_s,stylus,force_n,travel_mm,motion,arrived_us,age_us\n\
                   0,0.5,1,2,0,1000,10\n0.001,-0.25,,3,1,,\n0.002,NaN,3,4.5,1,3000,20\n";
        let parsed = parse_csv(Path::new("rec.csv"), csv.as_bytes(), &CsvOptions::default());
        let nan = f64::NAN;
        let members = [
            ("t_s", doubles(&[0.0, 0.001, 0.002])),
            ("stylus", floats(&[0.5, -0.25, f32::NAN])),
            ("force_n", floats(&[1.0, f32::NAN, 3.0])),
            ("travel_mm", doubles(&[2.0, 3.0, 4.5])),
            ("motion", column("|b1", [[0], [1], [1]])),
            ("arrived_us", doubles(&[1000.0, nan, 3000.0])),
            ("age_us", doubles(&[10.0, nan, 20.0])),
        ];
        for compressed in [false, true] {
            let (_folder, file) = archive(&members, compressed);
            let read = read_recording(&file, &CsvOptions::default()).unwrap();
            same(&read, parsed.as_ref().unwrap());
            assert_eq!((read.rate_hz, read.notes.empty_stylus), (1000.0, 0));
        }
        let integers = [
            ("a", column("<i8", [1_i64, -2].map(i64::to_le_bytes))),
            ("b", column("|u1", [[3], [4]])),
        ];
        let (_folder, file) = archive(&integers, false);
        let mut npz = Npz::open(&file).unwrap();
        assert_eq!(npz.numbers("a").unwrap(), arr1(&[1.0, -2.0]));
        assert_eq!(npz.texts("b").unwrap(), ["3", "4"]);
    }

    /// Samples bit by bit, so that a NaN equals itself.
    fn same(one: &Recording, other: &Recording) {
        let text = |recording: &Recording| format!("{:?}", recording.samples);
        assert_eq!(text(one), text(other));
        assert_eq!((&one.taxels, &one.channels), (&other.taxels, &other.channels));
    }

    fn recording() -> Recording {
        let channels = ChannelSet::new(StylusKind::Displacement)
            .with(Channel::NormalForce)
            .with(Channel::Travel)
            .with_taxels(2)
            .with_arrivals();
        let mut taxels = Taxels::new(2);
        let samples = (0..5_u64).map(|at| {
            let mut sample = Sample::stylus(Micros(at * 455 + 18_000_000_000), at as f32 / 3.0);
            sample.normal_force_n = (at != 2).then_some(at as f32 / 7.0);
            sample.arrival = (at > 0).then_some(Arrival { at: Micros(at), age: Micros(2 * at) });
            taxels.push(if at % 2 == 0 { &[0.1, 0.2] } else { &[] });
            sample
        });
        let samples = samples.collect();
        let (name, notes) = ("rec".to_owned(), Notes::default());
        Recording { name, channels, samples, taxels: Some(taxels), rate_hz: 2200.0, notes }
    }

    #[test]
    fn what_is_written_comes_back() {
        let (folder, recording) = (tempfile::tempdir().unwrap(), recording());
        let file = folder.path().join("rec.npz");
        recording.write_npz(File::create(&file).unwrap()).unwrap();
        let back = read_recording(&file, &CsvOptions::default()).unwrap();
        assert_eq!(back.columns(), ["stylus", "force_n", "travel_m", "pressure_0", "pressure_1"]);
        same(&back, &recording);
        assert_eq!(back.times_s(), recording.times_s());
    }

    /// One cell after the other.
    #[test]
    fn readings_are_those_of_the_samples() {
        let recording = recording();
        let (readings, columns) = (recording.readings(), recording.columns());
        assert_eq!(readings.dim(), (5, columns.len()));
        for (row, sample) in recording.samples.iter().enumerate() {
            let frame = recording.taxels.as_ref().unwrap().frame(row);
            let none = |value: Option<f32>| value.unwrap_or(f32::NAN).to_bits();
            let expected = [
                none(Some(sample.stylus)),
                none(sample.normal_force_n),
                none(sample.travel_m),
                none(frame.first().copied()),
                none(frame.get(1).copied()),
            ];
            let got: Vec<u32> = readings.row(row).iter().map(|value| value.to_bits()).collect();
            assert_eq!(got, expected);
        }
    }

    #[test]
    fn arrays_that_are_no_column_are_reported_with_their_name() {
        assert_eq!(
            fault(raw(&head("'<f8'", "(3,)"), &[0; 16])),
            "has 16 bytes where 3 values of 8 bytes were announced"
        );
        assert_eq!(
            fault(raw(&head("'<f8'", "(1152921504606846976,)"), &[0; 16])),
            "is too large: the columns of a file may take 1073741824 bytes unpacked"
        );
        assert_eq!(fault(doubles(&[1.0])[..20].to_vec()), "ends within its header");
        assert_eq!(fault(b"\x93NUMPY\x01".to_vec()), "ends within its header");
        assert_eq!(fault(b"t_s,stylus".to_vec()), "is no .npy");
        assert_eq!(
            fault([&b"\x93NUMPY\x09\x00"[..], &[0; 8]].concat()),
            "has version 9 of the format; 1 to 3 are read"
        );
        assert_eq!(
            fault(raw(&head("'<c8'", "(2,)"), &[0; 16])),
            "holds values of type \"<c8\": complex numbers; save .real or .imag of it"
        );
        assert_eq!(
            fault(column("<i8", [(1_i64 << 60).to_le_bytes()])),
            "holds integers beyond 2^53, which a double cannot keep"
        );
        assert_eq!(
            fault(raw(&head("'<f8'", "(1, 3)"), &[0; 24])),
            "has 2 dimensions (1 x 3); a column has one"
        );
        assert!(
            fault(raw(&head("[('a', '<f8')]", "(2,)"), &[0; 16])).starts_with("is a structured")
        );
    }

    /// Either would end the process in the parser of headers.
    #[test]
    fn headers_that_are_attacks_are_refused() {
        assert_eq!(
            fault(raw(&"(".repeat(9_000), &[])),
            "has a header that is not understood: recursion limit exceeded at line 1 column 128"
        );
        let huge = [&b"\x93NUMPY\x02\x00\xff\xff\xff\xff"[..], &[b' '; 64]].concat();
        assert_eq!(fault(huge), "has a header of 4294967295 bytes; 10000 are read");
    }

    #[test]
    fn recordings_that_can_not_be_read_say_why() {
        let time = || ("t_s", doubles(&[0.0, 0.001]));
        let of = |members: &[(&str, Vec<u8>)]| {
            let (_folder, file) = archive(members, false);
            message(&file)
        };
        let stylus = |values: &[f64]| ("stylus", doubles(values));
        assert!(of(&[time()]).starts_with("rec.npz: nothing was taken for a vibration"));
        assert!(of(&[stylus(&[1.0])]).starts_with("rec.npz: no column of times and no rate"));
        assert_eq!(
            of(&[time(), stylus(&[1.0])]),
            "rec.npz: array \"stylus\" has 1 values and \"t_s\" has 2; all columns need as many"
        );
        assert!(of(&[("t_s", doubles(&[])), stylus(&[])]).contains("no rows"));
        for bad in [f64::NAN, f64::INFINITY] {
            let text = of(&[("t_s", doubles(&[0.0, bad])), stylus(&[1.0, 2.0])]);
            assert!(
                text.contains("rec.npz: line 2, column t_s") && text.contains("is no time"),
                "{text}"
            );
        }
        let text = of(&[("t_s", doubles(&[0.1, 0.0])), stylus(&[1.0, 2.0])]);
        assert!(text.contains("goes backwards from 0.1 s to 0 s"), "{text}");
        let late = [("arrived_us", doubles(&[0.5, 1.0])), ("age_us", doubles(&[1.0, 1.0]))];
        let text = of(&[&[time(), stylus(&[1.0, 2.0])][..], &late].concat());
        assert!(text.contains("column arrived_us: \"0.5\" is not a number"), "{text}");
    }

    #[test]
    fn files_that_are_no_archive_say_so() {
        let (_folder, file) = archive(&[("t_s", doubles(&[0.0, 1.0]))], true);
        let whole = fs::read(&file).unwrap();
        for bytes in [&whole[..whole.len() / 2], b"", b"t_s,stylus\n0,1\n"] {
            fs::write(&file, bytes).unwrap();
            assert!(message(&file).starts_with("rec.npz: is no .npz: "), "{}", message(&file));
        }
        fs::write(&file, doubles(&[0.0])).unwrap();
        assert!(message(&file).contains("it is a single .npy, whose columns have no names"));
        let gone = read_recording(Path::new("no/such.npz"), &CsvOptions::default());
        assert!(gone.unwrap_err().to_string().starts_with("no/such.npz: cannot be read"));
        // A bit that fell over within the data.
        let mut damaged = whole;
        let at = damaged.len() / 2 - 20;
        damaged[at] ^= 0x10;
        fs::write(&file, damaged).unwrap();
        let read = Npz::open(&file).map(|mut npz| npz.numbers("t_s").map(drop));
        assert!(!matches!(read, Ok(Ok(()))));
    }

    #[test]
    fn columns_of_a_matrix_are_written_in_any_layout() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("rows.npz");
        let values = arr2(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        for values in [&values.view(), &values.t().to_owned().reversed_axes().view()] {
            write_columns(File::create(&file).unwrap(), &["a", "b", "c"], values).unwrap();
            let mut npz = Npz::open(&file).unwrap();
            assert_eq!(npz.names(), ["a", "b", "c"]);
            assert_eq!(npz.numbers("b").unwrap(), arr1(&[2.0, 5.0]));
            let missing = npz.numbers("d").unwrap_err().to_string();
            assert!(missing.ends_with("no array \"d\"; the file has: a, b, c"), "{missing}");
        }
    }

    /// As `numpy.savez` wrote it: the bytes before the numbers, and the numbers.
    #[test]
    fn an_array_is_written_as_numpy_writes_it() {
        let mut out = std::io::Cursor::new(Vec::new());
        write_columns(&mut out, &["a"], &arr2(&[[1.5], [2.0]])).unwrap();
        let numpy = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
        let numpy = [&b"\x93NUMPY\x01\0v\0"[..], format!("{numpy:117}\n").as_bytes()].concat();
        let array = [numpy, [1.5_f64, 2.0].map(f64::to_le_bytes).concat()].concat();
        assert!(out.into_inner().windows(array.len()).any(|bytes| bytes == array));
    }

    #[test]
    fn labels_are_texts_of_either_byte_order() {
        let text = |order: char, text: &str| -> Vec<u8> {
            let cells: Vec<u32> = text
                .split(',')
                .flat_map(|word| {
                    let mut letters: Vec<u32> = word.chars().map(u32::from).collect();
                    letters.resize(4, 0);
                    letters
                })
                .collect();
            let bytes = |letter: &u32| {
                if order == '>' { letter.to_be_bytes() } else { letter.to_le_bytes() }
            };
            raw(
                &head(&format!("'{order}U4'"), "(3,)"),
                &cells.iter().flat_map(bytes).collect::<Vec<u8>>(),
            )
        };
        for order in ['<', '>'] {
            let (_folder, file) = archive(&[("object", text(order, "dose,\u{dc},a b"))], false);
            let mut npz = Npz::open(&file).unwrap();
            assert_eq!(npz.texts("object").unwrap(), ["dose", "\u{dc}", "a b"]);
            assert!(npz.numbers("object").is_err());
        }
        for descr in ["'<U0'", "'<Ux'", "'<U99999999999999999999'", "'<U4611686018427387904'"] {
            let (_folder, file) = archive(&[("x", raw(&head(descr, "(3,)"), &[0; 4]))], false);
            assert!(Npz::open(&file).unwrap().texts("x").is_err(), "{descr}");
        }
        let (_folder, file) = archive(&[("x", raw(&head("'<U1'", "(1,)"), &[0xff; 4]))], false);
        assert!(Npz::open(&file).unwrap().texts("x").unwrap_err().to_string().contains("Unicode"));
    }

    #[test]
    fn a_matrix_beside_the_columns_is_left_alone() {
        let camera = raw(&head("'|u1'", "(3, 4)"), &[0; 12]);
        let members = [("stylus", doubles(&[1.0, 2.0])), ("camera", camera)];
        let (_folder, file) = archive(&members, false);
        let options = CsvOptions { rate_hz: Some(1000.0), ..CsvOptions::default() };
        let read = read_recording(&file, &options).unwrap();
        let remarks = read.notes.remarks.join("; ");
        assert_eq!((read.samples.len(), remarks.as_str()), (2, "not used: camera, of 4 values"));
    }
}
