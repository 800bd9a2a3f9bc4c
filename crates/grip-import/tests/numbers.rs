//! WAV, NPY and NPZ, each made here: every way to write numbers, cut off and damaged, and what is read of them.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small numbers")]

use grip_import::{ImportOptions, Imported, import, open};
use std::{fs, io::Write as _, path::Path};

const RATE: u32 = 8000;

fn options(rate_hz: Option<f32>, map: &[(&str, &str)]) -> ImportOptions {
    let map = map.iter().map(|&(a, b)| (a.to_owned(), b.to_owned())).collect();
    ImportOptions { rate_hz, map, ..ImportOptions::default() }
}

fn uses(imported: &Imported) -> Vec<String> {
    imported.uses.iter().map(|used| format!("{}={}", used.ours, used.theirs)).collect()
}

fn vibration(imported: &Imported) -> Vec<f32> {
    imported.recording.samples.iter().map(|sample| sample.stylus).collect()
}

/// Reads `bytes` as a file of that name, held and as it is read: both are the same samples.
#[track_caller]
fn read(name: &str, bytes: &[u8], options: &ImportOptions) -> Result<Imported, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    let text = |error: grip_import::ImportError| error.to_string();
    let held = import(&file, options).map_err(text)?;
    let opened = open(&file, options).map_err(text)?;
    assert!(opened.recording.samples.is_empty());
    let rows = opened.rows.as_ref().unwrap();
    let (mut samples, mut found) = (rows.samples().unwrap(), Vec::new());
    while let Some((sample, _)) = samples.next_sample().unwrap() {
        found.push(sample);
    }
    assert_eq!(rows.count(), found.len());
    assert_eq!(format!("{found:?}"), format!("{:?}", held.recording.samples));
    let notes = |imported: &Imported| imported.recording.notes.clone();
    assert_eq!((notes(&opened), &opened.notes), (notes(&held), &held.notes));
    Ok(held)
}

#[track_caller]
fn refused(name: &str, bytes: &[u8], options: &ImportOptions, words: &[&str]) {
    match read(name, bytes, options) {
        Ok(imported) => panic!("{:?} was taken", imported.uses),
        Err(text) => {
            words.iter().for_each(|word| assert!(text.contains(word), "no {word:?} in {text}"))
        }
    }
}

/// Two channels, 0.5 and 0 or -0.25, as `size` bytes in format `tag`.
fn samples(tag: u16, size: usize, count: usize) -> Vec<u8> {
    let value = |value: f64| match (tag, size) {
        (1, 1) => vec![(128.0 + 128.0 * value) as u8],
        (1, _) => ((value * 2.0_f64.powi(63)) as i64).to_le_bytes()[8 - size..].to_vec(),
        (3, 4) => (value as f32).to_le_bytes().to_vec(),
        (3, _) => value.to_le_bytes().to_vec(),
        // G.711 has neither 0.5 nor 0 exactly.
        (6, _) => vec![if value == 0.5 { 0xa5 } else { 0xd5 }],
        _ => vec![if value == 0.5 { 0x8f } else { 0xff }],
    };
    (0..count).flat_map(|k| [value(0.5), value(-0.25 * (k % 2) as f64)].concat()).collect()
}

fn chunk(name: &[u8; 4], length: u32, bytes: &[u8]) -> Vec<u8> {
    let pad = if bytes.len() % 2 == 1 { &b"\0"[..] } else { b"" };
    [name, &length.to_le_bytes()[..], bytes, pad].concat()
}

fn whole(name: &[u8; 4], bytes: &[u8]) -> Vec<u8> {
    chunk(name, bytes.len() as u32, bytes)
}

fn fmt(tag: u16, size: usize, rate: u32) -> Vec<u8> {
    let frame = 2 * size as u32;
    let words = [tag, 2].map(u16::to_le_bytes).concat();
    let rates = [rate, rate * frame].map(u32::to_le_bytes).concat();
    let sizes = [frame as u16, 8 * size as u16].map(u16::to_le_bytes).concat();
    whole(b"fmt ", &[words, rates, sizes].concat())
}

fn riff(chunks: &[Vec<u8>]) -> Vec<u8> {
    let content = [b"WAVE".to_vec(), chunks.concat()].concat();
    [&b"RIFF"[..], &(content.len() as u32).to_le_bytes(), &content].concat()
}

fn plain() -> ImportOptions {
    ImportOptions::default()
}

#[test]
fn wav_of_every_kind() {
    let kinds = [(1, 1), (1, 2), (1, 3), (1, 4), (1, 8), (3, 4), (3, 8), (6, 1), (7, 1)];
    for (tag, size) in kinds {
        let data = whole(b"data", &samples(tag, size, 100));
        // The format of an extensible header stands further on.
        let extensible = [&[0; 8][..], &tag.to_le_bytes(), &[0; 14]].concat();
        let long = [&fmt(0xfffe, size, RATE)[8..], &extensible].concat();
        for header in [fmt(tag, size, RATE), whole(b"fmt ", &long)] {
            let imported = read("x.wav", &riff(&[header, data.clone()]), &plain()).unwrap();
            assert_eq!(uses(&imported), ["vibration_1=channel_1", "vibration_2=channel_2"]);
            let recording = &imported.recording;
            assert_eq!((recording.rate_hz, recording.samples.len()), (8000.0, 100));
            let [first, second, _] = recording.samples[1].vibration();
            let expected = if tag < 6 { -0.25 } else { 0.0 };
            assert!(
                (first - 0.5).abs() < 0.02 && (second - expected).abs() < 0.001,
                "{tag} {size}"
            );
            assert!(tag >= 6 || first == 0.5, "{tag} {size}");
            assert_eq!((recording.samples[8].t.0, recording.notes.cut), (1000, false));
        }
    }
    let one = options(None, &[("vibration", "channel_2")]);
    let bytes = riff(&[fmt(1, 2, RATE), whole(b"data", &samples(1, 2, 100))]);
    assert_eq!(uses(&read("x.WAV", &bytes, &one).unwrap()), ["vibration=channel_2"]);
    // A rate that contradicts the header is taken, and named.
    for (rate_hz, named) in [(1000.0, true), (8000.0, false)] {
        let imported = read("x.wav", &bytes, &options(Some(rate_hz), &[])).unwrap();
        let note = "taken at 1000 Hz as --rate states, not at the 8000 Hz of its header";
        assert_eq!(imported.recording.rate_hz, rate_hz);
        assert_eq!(imported.notes.iter().any(|text| text == note), named, "{:?}", imported.notes);
    }
}

/// The same 100 samples, however the file is laid out.
#[test]
fn wav_of_every_layout() {
    let pcm = samples(1, 2, 100);
    let (format, data) = (fmt(1, 2, RATE), whole(b"data", &pcm));
    let odd = whole(b"junk", b"abc");
    let long = |magic: &[u8], bytes: &[u8]| {
        let sizes = [&[0; 8][..], &(pcm.len() as u64).to_le_bytes(), &[0; 12]].concat();
        let head = [magic, &[0xff; 4], b"WAVE", &whole(b"ds64", &sizes)].concat();
        [&head[..], &format, &chunk(b"data", u32::MAX, bytes)].concat()
    };
    let w64 = |name: &[u8], bytes: &[u8]| {
        let tail = [0xf3, 0xac, 0xd3, 0x11, 0x8c, 0xd1, 0x00, 0xc0, 0x4f, 0x8e, 0xdb, 0x8a];
        let mut chunk = [name, &tail, &(24 + bytes.len() as u64).to_le_bytes(), bytes].concat();
        chunk.resize(chunk.len().next_multiple_of(8), 0);
        chunk
    };
    let riff_w64 = [&b"riff"[..], &[0; 20], b"wave", &[0; 12]].concat();
    let w64 = [riff_w64, w64(b"fmt ", &format[8..]), w64(b"data", &pcm)].concat();
    let swapped: Vec<u8> = pcm.chunks_exact(2).flat_map(|pair| [pair[1], pair[0]]).collect();
    let rifx = [&[0, 1, 0, 2, 0, 0, 0x1f, 0x40, 0, 0, 0x7d, 0, 0, 4, 0, 16][..]].concat();
    let rifx = [
        &b"RIFX\0\0\0\0WAVEfmt \0\0\0\x10"[..],
        &rifx,
        b"data",
        &(swapped.len() as u32).to_be_bytes(),
        &swapped,
    ]
    .concat();
    let streamed = |length| riff(&[format.clone(), chunk(b"data", length, &pcm)]);
    let list = whole(b"LIST", b"INFOISFT\x04\0\0\0abcd");
    for (name, bytes) in [
        ("list before", riff(&[list.clone(), format.clone(), data.clone()])),
        ("list behind", riff(&[format.clone(), data.clone(), list, odd.clone()])),
        ("odd chunk", riff(&[format.clone(), odd.clone(), data.clone()])),
        ("odd chunk without its pad", riff(&[format.clone(), odd[..11].to_vec(), data.clone()])),
        (
            "tag before",
            [b"ID3\x03\0\0\0\0\0\x05....." as &[u8], &riff(&[format.clone(), data])].concat(),
        ),
        ("pipe", streamed(u32::MAX)),
        ("sox", streamed(0x7fff_f000)),
        ("2^31", streamed(1 << 31)),
        ("killed", streamed(0)),
        ("RF64", long(b"RF64", &pcm)),
        ("BW64", long(b"BW64", &pcm)),
        ("RIFX", rifx),
        ("Wave64", w64),
    ] {
        let imported =
            read("x.wav", &bytes, &plain()).unwrap_or_else(|text| panic!("{name}: {text}"));
        let recording = &imported.recording;
        assert_eq!((recording.samples.len(), recording.notes.cut), (100, false), "{name}");
        assert_eq!(recording.samples[99].vibration(), [0.5, -0.25, 0.0], "{name}");
        let ends = ["pipe", "sox", "2^31", "killed"].contains(&name);
        assert_eq!(imported.notes.iter().any(|note| note.contains("no length")), ends, "{name}");
    }
    let cut = |bytes: &[u8]| read("x.wav", &bytes[..bytes.len() - 42], &plain()).unwrap();
    for bytes in [streamed(400), long(b"RF64", &pcm)] {
        let cut = cut(&bytes);
        assert_eq!(
            (cut.recording.samples.len(), cut.recording.notes.cut, cut.notes.join("; ")),
            (89, true, "cut off: 89 of 100 samples are there".to_owned())
        );
    }
}

#[test]
fn wav_that_cannot_be_read_says_why() {
    let data = || whole(b"data", &samples(1, 2, 100));
    let silent = riff(&[fmt(1, 2, 0), data()]);
    refused("x.wav", &silent, &plain(), &["states 0 samples a second; give --rate HZ"]);
    assert_eq!(
        read("x.wav", &silent, &options(Some(500.0), &[])).unwrap().recording.rate_hz,
        500.0
    );
    let adpcm = riff(&[fmt(0x11, 2, RATE), data()]);
    refused("x.wav", &adpcm, &plain(), &["IMA ADPCM", "ffmpeg -i '", "x.plain.wav'"]);
    let empty = riff(&[fmt(1, 2, RATE), whole(b"data", b""), whole(b"LIST", b"INFO")]);
    refused("x.wav", &empty, &plain(), &["has no sample"]);
    refused("x.wav", &riff(&[data()]), &plain(), &["does not state its format"]);
    for bytes in [&b"RIFF...."[..], b"", b"t_s,vibration\n0,1\n", b"RIFF\0\0\0\0AVI LIST"] {
        refused("x.wav", bytes, &plain(), &["x.wav"]);
    }
    refused("x.wav", &riff(&[fmt(1, 2, 100_000), data()]), &plain(), &["100000 samples a second"]);
    // Whatever the header asks for, nothing is made that large.
    let whole = riff(&[fmt(1, 2, RATE), data()]);
    for at in 0..60 {
        for byte in [0, 0x7f, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            let _ = read("x.wav", &bytes, &plain());
        }
    }
}

/// A table of `width` columns, or one column where it is 0.
fn npy(kind: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let kind = if kind.starts_with('[') { kind.to_owned() } else { format!("'{kind}'") };
    let header = format!("{{'descr': {kind}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
    [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
}

fn doubles(numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    numbers.flat_map(f64::to_le_bytes).collect()
}

#[test]
fn npy_of_every_kind() {
    let rate = options(Some(1000.0), &[]);
    let one = |kind, data: &[u8]| read("x.npy", &npy(kind, "False", "(3,)", data), &rate);
    for (kind, data) in [
        ("<i2", vec![1, 0, 2, 0, 0xfd, 0xff]),
        (">i2", vec![0, 1, 0, 2, 0xff, 0xfd]),
        ("<f2", vec![0x00, 0x3c, 0x00, 0x40, 0x00, 0xc2]),
        ("|i1", vec![1, 2, 0xfd]),
        ("<f8", doubles([1.0, 2.0, -3.0].into_iter())),
    ] {
        let read = one(kind, &data).unwrap();
        assert_eq!(
            (uses(&read), vibration(&read)),
            (vec!["vibration=column_0".to_owned()], vec![1.0, 2.0, -3.0])
        );
    }
    assert_eq!(vibration(&one("|b1", &[1, 0, 1]).unwrap()), [1.0, 0.0, 1.0]);
    for (kind, words) in
        [("<c16", "complex"), ("|O", "Python objects"), ("<U4", "texts"), ("<M8[D]", "times")]
    {
        refused("x.npy", &npy(kind, "False", "(3,)", &[0; 48]), &rate, &[words, kind]);
    }
    refused(
        "x.npy",
        &npy("<f4", "False", "(2, 2, 2)", &[0; 32]),
        &rate,
        &["3 dimensions (2 x 2 x 2)"],
    );
    refused("x.npy", &npy("<f4", "False", "(3,)", &[0; 12]), &plain(), &["--rate HZ"]);
    refused("x.npy", &npy("<f4", "False", "(2, 999999999)", &[0; 8]), &rate, &["x.npy"]);
    refused(
        "x.npy",
        &npy("<f4", "False", "(9999999999, 99999)", &[0; 8]),
        &rate,
        &["99999 columns"],
    );
    refused(
        "x.npy",
        &npy("<f4", "False", "(40, 9)", &[0; 1440]),
        &rate,
        &["--map vibration=column_0", "column_8"],
    );
    refused("x.npy", b"\x93NUMPY", &rate, &["x.npy"]);
    refused("x.npy", &npy("<f2", "False", "(400, 2)", &[0; 1600]), &plain(), &["float16"]);
}

#[test]
fn npy_of_every_layout() {
    // Times in us, and two signals.
    let value = |row: usize, column: usize| {
        if column == 0 { 500.0 * row as f64 } else { (row * column) as f64 }
    };
    let rows = || (0..400).flat_map(|row| (0..3).map(move |column| value(row, column)));
    let columns = || (0..3).flat_map(|column| (0..400).map(move |row| value(row, column)));
    for (fortran, shape, data) in [
        ("False", "(400, 3)", doubles(rows())),
        ("True", "(400, 3)", doubles(columns())),
        ("False", "(3, 400)", doubles(columns())),
        ("True", "(3, 400)", doubles(rows())),
    ] {
        let bytes = npy("<f8", fortran, shape, &data);
        let timed = read("x.npy", &bytes, &plain()).unwrap();
        assert_eq!(uses(&timed), ["vibration_1=column_1", "vibration_2=column_2"]);
        assert!(timed.clock.contains("(us)") && timed.recording.rate_hz == 2000.0, "{timed:?}");
        assert_eq!(timed.recording.samples[7].vibration(), [7.0, 14.0, 0.0]);
        assert_eq!(timed.notes.iter().any(|note| note.contains("taken as")), shape == "(3, 400)");
        // A rate makes of the times no vibration.
        let rated = read("x.npy", &bytes, &options(Some(2000.0), &[])).unwrap();
        assert_eq!(uses(&rated), uses(&timed));
        let cut = read("x.npy", &bytes[..bytes.len() - 100], &plain()).unwrap();
        let left = if (fortran == "False") == (shape == "(400, 3)") { 395 } else { 387 };
        assert_eq!(cut.recording.samples.len(), left, "{fortran} {shape}");
        assert!(cut.recording.notes.cut && cut.notes.join("; ").contains("cut off:"));
    }
    let back = npy("<f8", "False", "(400, 2)", &doubles((0..800).map(|k| f64::from(-k))));
    refused("x.npy", &back, &plain(), &["--rate HZ"]);
}

#[test]
fn npy_of_structures() {
    let kind = "[('stamp', '<M8[us]'), ('vibration', '>f4'), ('acc', '<i2', (2,)), ('phase', '<U2'), ('', '|V2')]";
    let first = 1_767_000_000_000_000_i64;
    let row = |k: u8| {
        let stamp = (first + 1000 * i64::from(k)).to_le_bytes();
        [&stamp[..], &f32::from(k).to_be_bytes(), &[k, 0, 0, 0], &[0; 8], b"??"].concat()
    };
    let data: Vec<u8> = (0..100).flat_map(row).collect();
    let bytes = npy(kind, "False", "(100,)", &data);
    let imported = read("x.npy", &bytes, &plain()).unwrap();
    assert_eq!(uses(&imported), ["vibration=vibration"]);
    assert_eq!(
        (imported.unused.join(" "), imported.recording.rate_hz),
        ("acc_0 acc_1".to_owned(), 1000.0)
    );
    assert_eq!(imported.recording.samples[99].t.0, 99_000);
    assert!(
        imported.notes.iter().any(|note| note.contains("phase, which holds")),
        "{:?}",
        imported.notes
    );
    let axis = read("x.npy", &bytes, &options(None, &[("vibration", "acc_0")])).unwrap();
    assert_eq!(vibration(&axis)[..3], [0.0, 1.0, 2.0]);
    // Fields without end.
    let deep = "[('a', ".repeat(7) + "'<f8'" + &", (4096,))]".repeat(7);
    refused("x.npy", &npy(&deep, "False", "(1,)", &[0; 8]), &plain(), &["x.npy"]);
    let wide = "[('a', [('', '|V1', (4096,))], (4096,))]";
    refused("x.npy", &npy(wide, "False", "(1,)", &[0; 8]), &plain(), &["4096 columns"]);
}

fn npz(file: &Path, arrays: &[(&str, Vec<u8>)]) {
    let mut zip = zip::ZipWriter::new(fs::File::create(file).unwrap());
    let method = zip::CompressionMethod::Deflated;
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in arrays {
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}

#[test]
fn npz_of_any_names() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.npz");
    let ramp = |step: f64| doubles((0..500).map(|k| step * f64::from(k)));
    let column = |step| npy("<f8", "False", "(500,)", &ramp(step));
    let arrays = [
        ("time_ms", column(0.5)),
        ("mic", column(-1.0)),
        ("tip", npy("<f8", "True", "(500, 2)", &[ramp(2.0), ramp(3.0)].concat())),
        ("fs", npy("<f8", "False", "()", &[0; 8])),
        ("short", npy("<f8", "False", "(2,)", &[0; 16])),
    ];
    npz(&file, &arrays);
    let imported = import(&file, &plain()).unwrap();
    assert_eq!(
        (uses(&imported), imported.recording.rate_hz),
        (vec!["vibration=mic".to_owned()], 2000.0)
    );
    assert_eq!(
        (imported.unused.join(" "), vibration(&imported)[3]),
        ("tip_0 tip_1".to_owned(), -3.0)
    );
    let notes = imported.notes.join("; ");
    assert!(
        notes.contains("fs, which has no dimension") && notes.contains("short, of 2 values"),
        "{notes}"
    );
    let axis = import(&file, &options(None, &[("vibration", "tip_1")])).unwrap();
    assert_eq!(vibration(&axis)[3], 9.0);
    // A bit that fell over is the fault, and not the numbers that it makes.
    let whole = fs::read(&file).unwrap();
    let mut refusals = 0;
    for at in (100..whole.len() / 2).step_by(97) {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        fs::write(&file, bytes).unwrap();
        refusals += usize::from(import(&file, &plain()).is_err());
    }
    assert!(refusals > 3, "{refusals}");
}
