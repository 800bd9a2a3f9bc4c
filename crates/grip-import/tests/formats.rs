//! Files of other programs, each made here: what is taken for what, and the readings that come out.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]
#![expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "small numbers")]

use grip_import::{ImportOptions, Imported, TimeUnit, import};
use grip_record::{
    Channel, StylusKind,
    mcap::{CdrWriter, recover},
};
use std::{
    borrow::Cow,
    collections::BTreeMap,
    fs,
    io::{BufWriter, Cursor},
    path::{Path, PathBuf},
    sync::Arc,
};

const IMU: &str = "std_msgs/Header header\ngeometry_msgs/Vector3 linear_acceleration\nfloat32[] data\n\
    ================================================================================\n\
    MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ================================================================================\n\
    MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
    ================================================================================\n\
    MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    (folder, path)
}

fn with_map(map: &[(&str, &str)]) -> ImportOptions {
    let map = map.iter().map(|&(a, b)| (a.to_owned(), b.to_owned())).collect();
    ImportOptions { map, ..ImportOptions::default() }
}

fn uses(imported: &Imported) -> Vec<String> {
    imported.uses.iter().map(|used| format!("{}={}", used.ours, used.theirs)).collect()
}

fn taken(file: &Path) -> Imported {
    import(file, &ImportOptions::default()).unwrap()
}

#[track_caller]
fn refused(file: &Path, options: &ImportOptions, words: &[&str]) {
    let text = match import(file, options) {
        Ok(imported) => panic!("{:?} was taken", imported.uses),
        Err(error) => error.to_string(),
    };
    for word in words {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}

fn vibration(imported: &Imported) -> Vec<f32> {
    imported.recording.samples.iter().map(|sample| sample.stylus).collect()
}

#[test]
fn csv_with_times_in_every_unit() {
    let (_kept, folder) = folder();
    let file = folder.join("x.csv");
    let cases = [
        ("t_s,vibration", 1e-3, ','),
        ("time_ms;mic", 1.0, ';'),
        ("Time (us)\tVib [V]", 1e3, '\t'),
        ("stamp_ns,piezo", 1e6, ','),
        ("Zeit [ms];audio", 1.0, ';'),
    ];
    for (header, step, delimiter) in cases {
        let rows: String =
            (0..50).map(|k| format!("{}{delimiter}{}\n", f64::from(k) * step, k % 3)).collect();
        fs::write(&file, format!("# made by a test\n{header}\n{rows}")).unwrap();
        let imported = taken(&file);
        let recording = &imported.recording;
        assert_eq!((recording.rate_hz, recording.samples.len()), (1000.0, 50), "{header}");
        assert_eq!(recording.samples[7].t.0, 7000, "{header}");
        assert_eq!(imported.uses[0].ours, "vibration");
    }
    let rows: String = (0..50).map(|k| format!("{},{}\n", k * 28, k % 3)).collect();
    fs::write(&file, format!("timestamp,vibration\n{rows}")).unwrap();
    refused(&file, &ImportOptions::default(), &["35.7 Hz in ms", "--time-unit"]);
    let unit = ImportOptions { time_unit: Some(TimeUnit::Millis), ..ImportOptions::default() };
    assert!((import(&file, &unit).unwrap().recording.rate_hz - 35.714).abs() < 0.01);

    let epoch: String = (0..50)
        .map(|k| format!("{},{}\n", 1_700_000_000_000_000_000_i64 + k * 500_000, k % 3))
        .collect();
    fs::write(&file, format!("stamp,vibration\n{epoch}")).unwrap();
    let imported = taken(&file);
    assert_eq!(imported.recording.samples[0].t.0, 0);
    assert!(imported.notes[0].contains("1700000000.000000000"), "{:?}", imported.notes);
    assert_eq!(
        imported.recording.rate_hz, 2000.0,
        "no digit of the stamps is lost that a step needs"
    );
}

#[test]
fn csv_channels_by_name_unit_and_word() {
    let (_kept, folder) = folder();
    let file = folder.join("x.csv");
    let header = "t_s,acc_x,acc_y,acc_z,Force [mN],travel_um,electrode_1,electrode_2,note";
    let row = |k: u32| format!("{},1,2,3,1500,20,{k},7,\n", f64::from(k) * 1e-3);
    fs::write(&file, format!("{header}\n{}", (0..20).map(row).collect::<String>())).unwrap();
    let imported = import(&file, &with_map(&[("travel_m", "travel_um")])).unwrap();
    let expected = [
        "force_n=Force [mN]",
        "pressure_0=electrode_1",
        "pressure_1=electrode_2",
        "travel_m=travel_um",
        "vibration_x=acc_x",
        "vibration_y=acc_y",
        "vibration_z=acc_z",
    ];
    assert_eq!(
        (uses(&imported), imported.unused.clone()),
        (expected.map(str::to_owned).to_vec(), vec!["note".to_owned()])
    );
    let recording = &imported.recording;
    let sample = recording.samples[4];
    assert_eq!((sample.vibration(), sample.normal_force_n), ([1.0, 2.0, 3.0], Some(1.5)));
    assert!((sample.travel_m.unwrap() - 2e-5).abs() < 1e-10);
    assert_eq!(recording.taxels.as_ref().unwrap().frame(4), [4.0, 7.0]);

    // With another vibration, the acceleration of a robot is the motion reference.
    fs::write(&file, "t_s,mic,base_ax,base_ay\n0,1,2,3\n0.001,1,2,3\n0.002,1,2,3\n").unwrap();
    let imported = taken(&file);
    assert_eq!(uses(&imported), ["reference_x=base_ax", "reference_y=base_ay", "vibration=mic"]);
    assert_eq!(imported.recording.samples[1].reference_vector(), Some([2.0, 3.0, 0.0]));

    // One axis by name: the others are of the same sensor, which the slip shakes, and no reference.
    fs::write(&file, "t_s,acc_x,acc_y\n0,1,2\n0.001,1,2\n0.002,1,2\n").unwrap();
    let imported = import(&file, &with_map(&[("vibration", "acc_x")])).unwrap();
    assert_eq!(
        (uses(&imported), imported.unused),
        (vec!["vibration=acc_x".to_owned()], vec!["acc_y".to_owned()])
    );
}

#[test]
fn csv_that_cannot_be_used_states_where() {
    let (_kept, folder) = folder();
    let file = folder.join("x.csv");
    let none = ImportOptions::default();
    let put = |text: &str| fs::write(&file, text).unwrap();
    put("t_s,vibration\n0,1\n0.001,1,2\n0.002,1\n");
    refused(&file, &none, &["line 3", "3 fields"]);
    put("t_s,vibration\n0,1\n2,1\n1,1\n");
    refused(&file, &none, &["line 4", "split the file there"]);
    put("t_s,mic,audio\n0,1,1\n0.001,1,1\n");
    refused(&file, &none, &["the vibration may be any of mic, audio", "--map vibration=mic"]);
    put("t_s,a,b\n0,1,1\n0.001,1,1\n");
    refused(&file, &none, &["--map vibration=a", "a, b"]);
    refused(&file, &with_map(&[("vibration", "c")]), &["vibration=c: no such signal", "a, b"]);
    put("vibration\n1\n2\n");
    refused(&file, &none, &["--rate HZ"]);
    put("only words\nand more\n");
    refused(&file, &none, &["only words (text)"]);
    put("");
    refused(&file, &none, &["is empty"]);
    fs::write(&file, vec![0_u8; 3 << 20]).unwrap();
    refused(&file, &none, &["it is no table: a line has more than"]);
    fs::remove_file(&file).unwrap();
    refused(&file, &none, &["cannot be read"]);
    refused(Path::new("/dev/zero"), &none, &["not a regular file"]);
}

#[test]
fn a_robotiq_tsf_85() {
    let (_kept, folder) = folder();
    let file = folder.join("x.csv");
    let finger = |f: u32| {
        let taxels: String = (0..28).map(|k| format!("S{k}_{f};")).collect();
        format!("D0_{f};{taxels}Ax{f};Ay{f};Az{f};Gx{f};Gy{f};Gz{f}")
    };
    let row = |time: u32, dynamic: u32| {
        let taxels: String = (0..28).map(|k| format!("{};", 100 * dynamic + k)).collect();
        let finger = format!("{dynamic};{taxels}1;2;3;4;5;6");
        format!("{time};{finger};{finger}\n")
    };
    let rows: String = (0..40).map(|k| row(k, k % 5)).collect();
    let text = format!("Time(ms);{};{}\n{}{rows}", finger(0), finger(1), row(0, 999));
    fs::write(&file, text).unwrap();
    let imported = taken(&file);
    assert_eq!(imported.format, "Robotiq TSF-85");
    assert_eq!(imported.recording.rate_hz, 1000.0);
    assert_eq!(
        vibration(&imported)[..6],
        [0.0, 1.0, 2.0, 3.0, 4.0, 0.0],
        "the baseline is no sample"
    );
    let taxels = imported.recording.taxels.as_ref().unwrap();
    assert_eq!((taxels.count(), taxels.frame(3)[27]), (28, 327.0));
    assert!(
        imported.unused.contains(&"Ax0".to_owned()) && imported.unused.contains(&"D0_1".to_owned())
    );
    let other = ImportOptions { finger: Some(1), ..ImportOptions::default() };
    assert!(uses(&import(&file, &other).unwrap()).contains(&"vibration=D0_1".to_owned()));
    refused(&file, &ImportOptions { finger: Some(7), ..ImportOptions::default() }, &["[0, 1]"]);
}

/// An IMU message with this stamp (ns).
fn imu(stamp: u64, axes: [f64; 3], data: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut out = CdrWriter::new(&mut bytes);
    out.i32((stamp / 1_000_000_000) as i32).u32((stamp % 1_000_000_000) as u32).text("finger");
    for axis in axes {
        out.f64(axis);
    }
    out.floats(data);
    bytes
}

const EPOCH: u64 = 1_700_000_000_000_000_000;

/// 200 messages of an IMU at 1 kHz, stamped, and 20 of a force at 100 Hz as JSON.
fn bag(compression: Option<mcap::Compression>, keep: usize) -> Vec<u8> {
    let options = mcap::WriteOptions::new().compression(compression).chunk_size(Some(2048));
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/Imu", "ros2msg", IMU.as_bytes()).unwrap();
    let imu_channel = writer.add_channel(schema, "/finger/imu", "cdr", &BTreeMap::new()).unwrap();
    let force = writer.add_channel(0, "/gripper", "json", &BTreeMap::new()).unwrap();
    for k in 0..200_u64 {
        let header = |channel_id, k: u64| mcap::records::MessageHeader {
            channel_id,
            sequence: k as u32,
            log_time: EPOCH + k * 1_000_000 + 40_000_000,
            publish_time: 0,
        };
        let data = imu(EPOCH + k * 1_000_000, [k as f64, 1.0, 9.81], &[0.5, k as f32]);
        writer.write_to_known_channel(&header(imu_channel, k), &data).unwrap();
        if k % 10 == 0 {
            let json = format!(
                "{{\"force\": {}, \"name\": \"x\", \"deep\": {{\"list\": [1, 2]}}}}",
                k / 10
            );
            writer.write_to_known_channel(&header(force, k), json.as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    bytes[..bytes.len() * keep / 100].to_vec()
}

fn check_bag(imported: &Imported) {
    let expected = [
        "force_n=/gripper.force",
        "vibration_x=/finger/imu.linear_acceleration.x",
        "vibration_y=/finger/imu.linear_acceleration.y",
        "vibration_z=/finger/imu.linear_acceleration.z",
    ];
    assert_eq!(uses(imported), expected);
    let recording = &imported.recording;
    assert_eq!((recording.channels.stylus, recording.rate_hz), (StylusKind::Vibration, 1000.0));
    assert!(recording.channels.has(Channel::NormalForce));
    assert_eq!((imported.clock.as_str(), recording.samples.len()), ("stamps of the headers", 200));
    let at = |k: usize| recording.samples[k];
    assert_eq!((at(7).t.0, at(7).vibration()), (7000, [7.0, 1.0, 9.81]));
    // The force has log times only, which are 40 ms later: known at 40 ms, held until the next.
    assert_eq!((at(39).normal_force_n, at(40).normal_force_n), (None, Some(0.0)));
    assert_eq!((at(59).normal_force_n, at(60).normal_force_n), (Some(1.0), Some(2.0)));
    assert!(imported.unused.contains(&"/gripper.deep.list[1]".to_owned()), "{:?}", imported.unused);
}

#[test]
fn mcap_with_ros_and_json() {
    let (_kept, folder) = folder();
    let file = folder.join("x.mcap");
    for compression in [None, Some(mcap::Compression::Lz4)] {
        fs::write(&file, bag(compression, 100)).unwrap();
        check_bag(&taken(&file));
    }
    check_bag(&taken(&folder));

    let by_group = with_map(&[
        ("vibration", "/finger/imu.linear_acceleration"),
        ("pressure", "/finger/imu.data"),
    ]);
    let imported = import(&file, &by_group).unwrap();
    assert_eq!(imported.recording.taxels.as_ref().unwrap().frame(9), [0.5, 9.0]);
    let topic = ImportOptions { topics: vec!["/gripper".to_owned()], ..ImportOptions::default() };
    refused(&file, &topic, &["nothing was taken", "/gripper.force"]);

    fs::write(&file, bag(None, 50)).unwrap();
    let cut = taken(&file);
    assert!((50..150).contains(&cut.recording.samples.len()));
    assert!(cut.notes.iter().any(|note| note.contains("ends early")), "{:?}", cut.notes);

    let mut damaged = bag(Some(mcap::Compression::Lz4), 100);
    let middle = damaged.len() / 3;
    damaged[middle..middle + 200].fill(0xA5);
    fs::write(&file, damaged).unwrap();
    refused(&file, &ImportOptions::default(), &["damaged"]);
    fs::write(&file, b"no mcap at all").unwrap();
    refused(&file, &ImportOptions::default(), &["no MCAP file"]);
}

#[test]
fn mcap_chunks_of_zstd_are_read() {
    let (_kept, folder) = folder();
    let file = folder.join("x.mcap");
    let plain = bag(None, 100);
    fs::write(&file, zstd_chunks(&plain)).unwrap();
    check_bag(&taken(&file));
}

/// Every whole message of a file in zstd is recovered, wherever it is cut off.
#[test]
fn mcap_chunks_of_zstd_are_recovered() {
    let recovered = |bytes: &[u8]| {
        let mut out = Vec::new();
        let saved = recover(Path::new("x.mcap"), bytes, &mut out, "test 1", grip_import::unpack);
        (saved.unwrap(), out)
    };
    let whole = zstd_chunks(&bag(None, 100));
    let (saved, _) = recovered(&whole);
    // Only the index is not there.
    assert!(saved.holes.is_empty() && saved.cut_at == Some(whole.len() as u64), "{saved:?}");
    let (all, mut least) = (saved.messages, 0);
    for len in (8..whole.len()).step_by(97) {
        let (saved, out) = recovered(&whole[..len]);
        assert!(saved.messages >= least && saved.holes.is_empty(), "{len}: {saved:?}");
        least = saved.messages;
        assert_eq!(recovered(&out).0.messages, least);
    }
    assert!(least > all / 2, "{least} of {all}");
}

/// The same file with each chunk packed by zstd.
fn zstd_chunks(plain: &[u8]) -> Vec<u8> {
    let mut out = plain[..8].to_vec();
    let mut at = 8;
    while at + 9 <= plain.len() - 8 {
        let opcode = plain[at];
        let len = u64::from_le_bytes(plain[at + 1..at + 9].try_into().unwrap()) as usize;
        let body = &plain[at + 9..at + 9 + len];
        at += 9 + len;
        if opcode == 0x0f {
            break;
        }
        let packed;
        let body = if opcode == 0x06 {
            let (head, rest) = body.split_at(28);
            let name = u32::from_le_bytes(rest[..4].try_into().unwrap());
            assert_eq!(name, 0, "a plain chunk");
            let records = &rest[12..];
            let data = ruzstd::encoding::compress_to_vec(
                records,
                ruzstd::encoding::CompressionLevel::Fastest,
            );
            let size = data.len() as u64;
            packed = [head, &4_u32.to_le_bytes(), b"zstd", &size.to_le_bytes(), &data].concat();
            packed.as_slice()
        } else {
            body
        };
        out.push(opcode);
        out.extend_from_slice(&(body.len() as u64).to_le_bytes());
        out.extend_from_slice(body);
    }
    // End of the data, without a checksum and without an index.
    out.extend_from_slice(&[0x0f, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    out
}

fn put_db3(file: &Path, definitions: bool) {
    let _ = fs::remove_file(file);
    let db = rusqlite::Connection::open(file).unwrap();
    db.execute_batch(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
         INSERT INTO topics VALUES (1, '/finger/imu', 'our_msgs/msg/Imu', 'cdr'), (2, '/strange', 'a/msg/B', 'cdr');
         INSERT INTO topics VALUES (3, '/level', 'std_msgs/msg/Float32', 'cdr');",
    )
    .unwrap();
    if definitions {
        db.execute_batch("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT, encoded_message_definition TEXT);").unwrap();
        let text = "INSERT INTO message_definitions VALUES (1, 'our_msgs/msg/Imu', 'ros2msg', ?1)";
        db.execute(text, [IMU]).unwrap();
    }
    db.execute("INSERT INTO messages VALUES (1, 2, ?1, x'00')", [EPOCH as i64]).unwrap();
    for k in 0..100_u64 {
        // Every tenth came late.
        let late = if k % 10 == 0 { 5_000_000 } else { 0 };
        let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        let data = imu(EPOCH + k * 1_000_000, [k as f64, 1.0, 2.0], &[]);
        let at = (EPOCH + k * 1_000_000 + late) as i64;
        db.execute(insert, rusqlite::params![1, at, data]).unwrap();
        let mut level = Vec::new();
        CdrWriter::new(&mut level).f32(0.5);
        db.execute(insert, rusqlite::params![3, at, level]).unwrap();
    }
}

/// A blob of 900 MB, views and pages without end: a message, soon and in little memory.
#[test]
fn a_hostile_file_of_sqlite_costs_little() {
    let (_kept, folder) = folder();
    let file = folder.join("bag_0.db3");
    let endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)";
    let column = "zeroblob(i % 2 + 900000000)";
    let cases = [
        (
            "INSERT INTO messages VALUES (7000, 1, 1, zeroblob(90000000))".to_owned(),
            "string or blob too big",
        ),
        (
            format!(
                "{endless} INSERT INTO topics SELECT i + 100, '/t' || i, 'std_msgs/msg/Float64', 'cdr' FROM n LIMIT 10001; INSERT INTO messages SELECT id + 9000, id, 1, x'00' FROM topics WHERE id > 100"
            ),
            "choose some with --topic NAME",
        ),
        (
            format!(
                "DROP TABLE topics; CREATE VIEW topics AS {endless} SELECT i AS id, 'x' AS name, 'std_msgs/msg/Float32' AS type, 'cdr' AS serialization_format FROM n"
            ),
            "it has no table topics",
        ),
        (
            format!(
                "DROP TABLE messages; CREATE VIEW messages AS {endless} SELECT i AS id, 1 AS topic_id, i AS timestamp, {column} AS data FROM n"
            ),
            "it has no table messages",
        ),
        (
            format!(
                "DROP TABLE message_definitions; CREATE VIEW message_definitions AS {endless} SELECT i AS id, 'x' AS topic_type, 'ros2msg' AS encoding, 'x' AS encoded_message_definition FROM n; DELETE FROM messages"
            ),
            "",
        ),
    ];
    for (change, words) in cases {
        put_db3(&file, true);
        rusqlite::Connection::open(&file).unwrap().execute_batch(&change).unwrap();
        refused(&file, &ImportOptions::default(), &[words]);
    }
}

#[test]
fn rosbag2_of_sqlite() {
    let (_kept, folder) = folder();
    let file = folder.join("bag_0.db3");
    put_db3(&file, true);
    for place in [&file, &folder] {
        let imported = taken(place);
        assert_eq!((imported.format, imported.uses.len()), ("rosbag2", 3));
        let samples = &imported.recording.samples;
        assert_eq!((samples.len(), samples[41].vibration()), (100, [41.0, 1.0, 2.0]));
        assert!(
            samples.is_sorted_by_key(|sample| sample.t) && imported.recording.rate_hz == 1000.0
        );
        let noted = |text: &str| imported.notes.iter().any(|note| note.contains(text));
        assert!(noted("/strange") && noted("out of order"), "{:?}", imported.notes);
        assert!(imported.unused.contains(&"/level.data".to_owned()));
    }
    // Without definitions only types that everybody knows can be read.
    put_db3(&file, false);
    refused(&file, &ImportOptions::default(), &["--map vibration=/level.data"]);
    let level = import(&file, &with_map(&[("vibration", "/level.data")])).unwrap();
    assert_eq!(vibration(&level), vec![0.5; 100]);

    fs::write(&file, b"no database").unwrap();
    refused(&file, &ImportOptions::default(), &["cannot be read"]);
    fs::write(&file, [b"SQLite format 3\0".as_slice(), &[7; 4096]].concat()).unwrap();
    refused(&file, &ImportOptions::default(), &["no rosbag2"]);
    fs::remove_file(&file).unwrap();
    refused(&folder, &ImportOptions::default(), &["neither .mcap nor .db3"]);
}

#[test]
fn a_recording_of_gripd_is_sent_to_where_it_is_read() {
    let (_kept, folder) = folder();
    let file = folder.join("run.mcap");
    let out = BufWriter::new(fs::File::create(&file).unwrap());
    let mut writer = mcap::Writer::new(out).unwrap();
    let data = Cow::Borrowed(b"".as_slice());
    let schema = mcap::Schema {
        id: 1,
        name: "grip_msgs/msg/Sample".to_owned(),
        encoding: "ros2msg".to_owned(),
        data,
    };
    let channel = mcap::Channel {
        id: 1,
        topic: "/gripper/sample".to_owned(),
        schema: Some(Arc::new(schema)),
        message_encoding: "cdr".to_owned(),
        metadata: BTreeMap::new(),
    };
    writer
        .write(&mcap::Message {
            channel: Arc::new(channel),
            sequence: 0,
            log_time: 1,
            publish_time: 1,
            data: Cow::Borrowed(&[0, 1, 0, 0]),
        })
        .unwrap();
    writer.finish().unwrap();
    drop(writer);
    let next = format!("gripctl replay {}", grip_record::shell(&file.display().to_string()));
    refused(&folder, &ImportOptions::default(), &[&next, "gripctl csv"]);
}

/// An MCAP of JSON messages of one topic: (channel, time in ns, value).
fn json_mcap(file: &Path, messages: impl Iterator<Item = (usize, u64, f64)>) {
    let out = BufWriter::new(fs::File::create(file).unwrap());
    let mut writer = mcap::Writer::new(out).unwrap();
    // What differs between two runs of one publisher.
    let runs = ["first", "second"].map(|run| BTreeMap::from([("run".to_owned(), run.to_owned())]));
    let mut channels: Vec<u16> = Vec::new();
    for run in &runs {
        channels.push(writer.add_channel(0, "/vib", "json", run).unwrap());
    }
    // The same fields under another type.
    let other = writer.add_schema("vib/v2", "jsonschema", b"{}").unwrap();
    channels.push(writer.add_channel(other, "/vib", "json", &runs[0]).unwrap());
    for (channel, log_time, value) in messages {
        let channel_id = channels[channel];
        let header =
            mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time: 0 };
        let json = format!("{{\"vibration\": {value}}}");
        writer.write_to_known_channel(&header, json.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn a_publisher_that_started_again_is_one_topic() {
    let (_kept, folder) = folder();
    let row = |k: u32| (usize::from(k >= 150), u64::from(k) * 1_000_000, f64::from(k % 7));
    json_mcap(&folder.join("x.mcap"), (0..400).map(row));
    let imported = taken(&folder.join("x.mcap"));
    assert_eq!((imported.recording.samples.len(), imported.recording.rate_hz), (400, 1000.0));
    // And so are the files of a bag, by their numbers: the tenth is behind the second.
    fs::remove_file(folder.join("x.mcap")).unwrap();
    for (part, name) in ["bag_1.mcap", "bag_2.mcap", "bag_10.mcap"].into_iter().enumerate() {
        let first = 100 * u32::try_from(part).unwrap();
        json_mcap(&folder.join(name), (first..first + 100).map(row));
    }
    let imported = taken(&folder);
    let samples = &imported.recording.samples;
    assert_eq!((samples.len(), samples[299].t.0, imported.recording.notes.gaps), (300, 299_000, 0));
    assert!(!imported.notes.iter().any(|note| note.contains("out of order")));
    fs::write(folder.join("bag_11.mcap.zstd"), "").unwrap();
    refused(&folder, &ImportOptions::default(), &["zstd -d --rm"]);
}

#[test]
fn a_topic_under_two_types_is_joined_or_asked_about() {
    let (_kept, folder) = folder();
    let file = folder.join("x.mcap");
    let put = |is_later: fn(u32) -> bool| {
        let channel = |k| if is_later(k) { 2 } else { 0 };
        let row = |k: u32| (channel(k), u64::from(k) * 1_000_000, f64::from(k));
        json_mcap(&file, (0..400).map(row));
    };
    for is_later in [|k| k >= 150, |k| k < 150] {
        put(is_later);
        let imported = taken(&file);
        let samples = &imported.recording.samples;
        assert_eq!((samples.len(), samples[399].vibration()[0]), (400, 399.0));
        let joined = |note: &String| {
            note.contains("250 rows under two types") || note.contains("and 150 rows under")
        };
        assert!(imported.notes.iter().any(joined), "{:?}", imported.notes);
    }
    put(|k| k % 2 == 1);
    let names = ["/vib#1.vibration, /vib#2.vibration", "--map 'vibration=/vib#1.vibration'"];
    refused(&file, &ImportOptions::default(), &names);
    refused(&file, &with_map(&[("vibration", "/vib.vibration")]), &["no such signal", names[0]]);
    let second = import(&file, &with_map(&[("vibration", "/vib#2.vibration")])).unwrap();
    assert_eq!(second.recording.samples.len(), 200);
}

#[test]
fn bursts_with_one_stamp_become_rows_at_the_rate() {
    let (_kept, folder) = folder();
    let file = folder.join("x.mcap");
    json_mcap(&file, (0..400).map(|k| (0, k / 16 * 10_000_000, f64::from(k as u32 % 7))));
    let given = ImportOptions { rate_hz: Some(1600.0), ..ImportOptions::default() };
    for options in [ImportOptions::default(), given] {
        let imported = import(&file, &options).unwrap();
        let recording = &imported.recording;
        assert!((recording.rate_hz - 1600.0).abs() < 8.0, "{}", recording.rate_hz);
        assert_eq!((recording.samples.len(), recording.notes.repeated_times), (400, 0));
        let said = |note: &String| note.contains("375 of 400 repeat the one before");
        assert!(imported.notes.iter().any(said), "{:?}", imported.notes);
    }
}

#[test]
fn messages_that_are_packed_one_by_one_are_unpacked() {
    let (_kept, folder) = folder();
    let file = folder.join("x.db3");
    put_db3(&file, true);
    let db = rusqlite::Connection::open(&file).unwrap();
    let ids: Vec<i64> = {
        let mut rows = db.prepare("SELECT id FROM messages").unwrap();
        rows.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect()
    };
    for id in ids {
        let get = "SELECT data FROM messages WHERE id = ?1";
        let data: Vec<u8> = db.query_row(get, [id], |row| row.get(0)).unwrap();
        let fast = ruzstd::encoding::CompressionLevel::Fastest;
        let packed = ruzstd::encoding::compress_to_vec(data.as_slice(), fast);
        let put = "UPDATE messages SET data = ?1 WHERE id = ?2";
        db.execute(put, rusqlite::params![packed, id]).unwrap();
    }
    drop(db);
    let samples = taken(&file).recording.samples;
    assert_eq!((samples.len(), samples[41].vibration()), (100, [41.0, 1.0, 2.0]));
}

#[test]
fn a_second_finger_is_no_motion_reference() {
    let (_kept, folder) = folder();
    let file = folder.join("x.csv");
    let rows: String = (0..40).map(|k| format!("{},1,2,3,4,5,6\n", f64::from(k) / 1e3)).collect();
    let put = |second: &str| {
        let header = format!("t_s,imu1_ax,imu1_ay,imu1_az,{second}_ax,{second}_ay,{second}_az");
        fs::write(&file, format!("{header}\n{rows}")).unwrap();
    };
    put("imu2");
    refused(&file, &ImportOptions::default(), &["imu1_a, imu2_a", "--map vibration=imu1_a"]);
    let one = import(&file, &with_map(&[("vibration", "imu1_a")])).unwrap();
    assert_eq!((one.uses.len(), one.unused.len()), (3, 3));
    assert!(one.notes[0].contains("--map reference=imu2_a"), "{:?}", one.notes);
    let both = with_map(&[("vibration", "imu1_a"), ("reference", "imu2_a")]);
    assert_eq!(import(&file, &both).unwrap().uses.len(), 6);
    put("wrist");
    assert_eq!(taken(&file).uses.len(), 6, "by its name it is that of the robot");
}

#[test]
fn counters_are_asked_about_and_units_are_converted() {
    let (_kept, folder) = folder();
    let file = folder.join("x.csv");
    let rate = ImportOptions { rate_hz: Some(1600.0), ..ImportOptions::default() };
    let rows =
        |first: u32| -> String { (0..50).map(|k| format!("{},{}\n", first + k, k % 7)).collect() };
    for (header, first) in [("", 0), ("", 1), (",0\n", 0), ("t,vibration\n", 0)] {
        fs::write(&file, format!("{header}{}", rows(first))).unwrap();
        refused(&file, &ImportOptions::default(), &["--rate HZ", "--time-unit"]);
        let imported = import(&file, &rate).unwrap();
        assert_eq!((imported.uses.len(), imported.recording.rate_hz), (1, 1600.0), "{header}");
        assert_eq!(imported.recording.samples[3].t.0, 1875);
    }
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (50, 2), }";
    let mut npy = [&b"\x93NUMPY\x01\0v\0"[..], format!("{head:117}\n").as_bytes()].concat();
    npy.extend((0..50).flat_map(|row| [row, row % 7]).flat_map(|n| f64::from(n).to_le_bytes()));
    fs::write(folder.join("x.npy"), npy).unwrap();
    refused(&folder.join("x.npy"), &ImportOptions::default(), &["--rate HZ", "--time-unit"]);
    assert_eq!(import(&folder.join("x.npy"), &rate).unwrap().uses.len(), 1);

    let rows: String = (0..20).map(|k| format!("{k};1,5;2;0,25\n")).collect();
    fs::write(&file, format!("Zeit (ms);acc_x [g];Force [kN];travel_mm\n{rows}")).unwrap();
    let sample = taken(&file).recording.samples[3];
    assert_eq!((sample.t.0, sample.normal_force_n), (3000, Some(2000.0)));
    assert!((sample.stylus - 14.709_975).abs() < 1e-5 && sample.travel_m == Some(0.000_25));
    fs::write(&file, "t_s,vib,force [stone]\n0,1,2\n0.001,1,2\n0.002,1,2\n").unwrap();
    refused(&file, &ImportOptions::default(), &["stone", "kgf"]);
}
