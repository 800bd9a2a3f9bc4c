//! Files of other kinds, by the bytes that they begin with.

/// Magic bytes, the kind, and what makes a table of it; `FILE` stands for the name of the file.
const KINDS: [(&[u8], &str, &str); 26] = [
    (b"\x1f\x8b", "packed with gzip", "unpack it: gzip -d"),
    (b"\x28\xb5\x2f\xfd", "packed with zstd", "unpack it: zstd -d"),
    (b"\xfd7zXZ\0", "packed with xz", "unpack it: xz -d"),
    (b"BZh", "packed with bzip2", "unpack it: bzip2 -d"),
    (b"\x04\x22\x4d\x18", "packed with lz4", "unpack it: lz4 -d"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", "unpack it: 7z x"),
    (b"Rar!", "a RAR archive", "unpack it"),
    (
        b"\x93NUMPY",
        "an array of NumPy",
        "name it .npy, or save it with numpy.savez(\"x.npz\", t_s=..., vibration=...)",
    ),
    (
        b"MATLAB 7.3 MAT-file",
        "MATLAB v7.3",
        "in MATLAB: writetable(table(t, x), \"x.csv\"), or in Python with h5py: numpy.savez",
    ),
    (
        b"MATLAB 5.0 MAT-file",
        "MATLAB v5",
        "in MATLAB: writetable(table(t, x), \"x.csv\"), or in Python: scipy.io.loadmat and numpy.savez",
    ),
    (
        b"\x89HDF\r\n\x1a\n",
        "HDF5",
        "in Python with h5py: numpy.savez(\"x.npz\", t_s=..., vibration=...)",
    ),
    (b"TDSm", "TDMS of LabVIEW", "export it as CSV, or in Python with nptdms: numpy.savez"),
    (b"TDSh", "an index of TDMS", "take the .tdms beside it, exported as CSV"),
    (b"fLaC", "FLAC sound", "decode it: flac -d, or ffmpeg -i FILE sound.wav"),
    (b"OggS", "OGG sound", "decode it: ffmpeg -i FILE sound.wav"),
    (b"ID3", "MP3 sound", "decode it: ffmpeg -i FILE sound.wav"),
    (b"RIFF", "WAV sound", "name it .wav and use `gripctl import`"),
    (b"RF64", "WAV sound", "name it .wav and use `gripctl import`"),
    (b"FORM", "AIFF sound", "decode it: ffmpeg -i FILE sound.wav"),
    (
        b"PAR1",
        "Parquet",
        "in Python with pandas: read_parquet(\"x\").to_csv(\"x.csv\", index=False)",
    ),
    (
        b"SQLite format 3\0",
        "an SQLite file",
        "name a bag .db3 and use `gripctl import`; export other tables as CSV",
    ),
    (
        b"#ROSBAG",
        "a bag of ROS 1",
        "convert it: rosbags-convert --src FILE --dst FOLDER, then `gripctl import FOLDER`",
    ),
    (b"\x89MCAP0\r\n", "MCAP", "name it .mcap; `gripctl import` takes that of other programs"),
    (b"\x89PNG", "a picture", "export the numbers as CSV"),
    (b"%PDF", "a PDF", "export the numbers as CSV"),
    (b"\x7fELF", "a program", "name a file of numbers"),
];

/// What the file is, where it is no text, and the way out of that.
pub(crate) fn kind(start: &[u8]) -> Option<(&'static str, &'static str)> {
    if start.starts_with(b"PK\x03\x04") {
        return Some(archive(start));
    }
    if start.starts_with(b"\xd0\xcf\x11\xe0") {
        return Some(("an old file of Excel", "save it as .csv or .xlsx"));
    }
    if start.trim_ascii_start().starts_with(b"<?xml")
        || start.trim_ascii_start().starts_with(b"<!DOCTYPE")
    {
        return Some(("XML or HTML", "export the numbers as CSV"));
    }
    let found = KINDS.iter().find(|(magic, ..)| start.starts_with(magic));
    found.map(|(_, kind, remedy)| (*kind, *remedy))
}

fn archive(start: &[u8]) -> (&'static str, &'static str) {
    let has = |name: &[u8]| memchr::memmem::find(start, name).is_some();
    if has(b".npy") {
        ("an .npz of NumPy", "name it .npz")
    } else if has(b"[Content_Types].xml") || has(b"xl/") || has(b"_rels/") {
        ("a workbook of Excel", "save the sheet as CSV")
    } else if has(b"opendocument") {
        ("a workbook of LibreOffice", "save the sheet as CSV")
    } else {
        ("a ZIP archive", "unpack it: unzip")
    }
}
