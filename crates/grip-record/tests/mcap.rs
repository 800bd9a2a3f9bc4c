//! MCAP recordings: everything comes back bit by bit, and whatever is done to a file, what is whole of it is saved.
#![expect(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "test code")]

use grip_record::mcap::{
    Attached, CommandRecord, Entry, EventRecord, LinkRecord, McapError, McapIndex, McapReader,
    McapWriter, PipelineRecord, Record, SampleRecord, WireRecord, no_unpack, recover,
};
use proptest::prelude::{Just, Strategy, any, prop_assert, prop_assert_eq, prop_oneof, proptest};
use slip_core::ClientCommand;
use slip_core::PipelineState;
use slip_core::{
    Arrival, Sample, grip::GripState, health::SensorHealth, sample::Scene, units::Micros,
};
use slip_msg::{EXTRAPOLATED, FaultCode, INFORMATIVE, Reading};
use std::{collections::BTreeMap, io::Cursor, path::Path};

const ZERO_NS: u64 = 1_763_766_000_000_000_000;

/// Writes to memory that outlives the writer.
#[derive(Clone, Default)]
struct Shared(std::rc::Rc<core::cell::RefCell<Vec<u8>>>);

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// What `write` puts into a finished file.
fn file_of(write: impl FnOnce(&mut McapWriter<Shared>)) -> Vec<u8> {
    let out = Shared::default();
    let mut writer = McapWriter::new(out.clone(), "test 1", ZERO_NS).unwrap();
    write(&mut writer);
    let written = writer.finish().unwrap();
    let bytes = out.0.take();
    assert_eq!(written.bytes, bytes.len() as u64);
    bytes
}

/// `count` samples, one a millisecond, flushed every `flush`.
fn samples(count: u32, flush: u32) -> Vec<u8> {
    file_of(|writer| {
        let model = Attached {
            name: "model.json".into(),
            media_type: "application/json".into(),
            data: vec![7; 300],
        };
        writer.attach(0, &model).unwrap();
        for index in 0..count {
            let t = u64::from(index) * 1000;
            let sample = Sample::stylus(Micros(t), (index as f32).sin());
            writer.write(t, &Record::Sample(SampleRecord { index, sample, taxels: &[] })).unwrap();
            if index % flush == flush - 1 {
                writer.flush().unwrap();
            }
        }
    })
}

/// Indices of the samples before the end or the first fault.
fn indices(bytes: &[u8]) -> (Vec<u32>, Option<McapError>) {
    let mut found = Vec::new();
    let mut reader = match McapReader::new(Path::new("x.mcap"), Cursor::new(bytes)) {
        Ok(reader) => reader,
        Err(error) => return (found, Some(error)),
    };
    loop {
        match reader.next_entry() {
            Ok(Some(Entry::Message { record: Record::Sample(sample), .. })) => {
                found.push(sample.index);
            }
            Ok(Some(_)) => {}
            Ok(None) => return (found, None),
            Err(error) => return (found, Some(error)),
        }
    }
}

/// Every sample and every fault with where reading stood, to the end of what can be read.
fn course(bytes: &[u8], ahead: bool) -> Vec<String> {
    let input = Cursor::new(bytes.to_vec());
    let mut reader = match McapReader::new(Path::new("x.mcap"), input) {
        Ok(reader) if ahead => reader.read_ahead().unwrap(),
        Ok(reader) => reader,
        Err(error) => return vec![error.to_string()],
    };
    let mut course = Vec::new();
    while reader.goes_on() {
        let entry = format!("{:?}", reader.next_entry());
        course.push(format!("{} {entry}", reader.position()));
    }
    course
}

fn recovered(bytes: &[u8]) -> Option<(grip_record::mcap::Recovered, Vec<u8>)> {
    let out = Shared::default();
    let (file, input) = (Path::new("x.mcap"), Cursor::new(bytes));
    let saved = recover(file, input, out.clone(), "test 1", no_unpack).ok()?;
    Some((saved, out.0.take()))
}

fn same(a: &Sample, b: &Sample) -> bool {
    let bits = |s: &Sample| {
        let options = [
            s.normal_force_n,
            s.tangential_n,
            s.travel_m,
            s.velocity_m_s,
            s.second_stylus,
            s.reference,
            s.pressure,
            s.motion,
        ];
        (s.t, s.arrival, s.stylus.to_bits(), options.map(|value| value.map(f32::to_bits)))
    };
    bits(a) == bits(b)
}

const STATE: PipelineState = PipelineState {
    t: Micros(5),
    scene: Scene::Slipping,
    grip: GripState::Released,
    sensors: [
        SensorHealth::Drifting,
        SensorHealth::Backwards,
        SensorHealth::Failed,
        SensorHealth::Lost,
    ],
    notes: INFORMATIVE | EXTRAPOLATED,
    esc_kind: Reading::Literal,
    statistic: Some(1.5),
    command_n: Some(2.5),
    esc: Some(1e-30),
    estimate_n: Some(0.1),
    rate_hz: 20_000,
    lost: u64::MAX,
    late_ms: Some(1.5),
    need_low_n: Some(3.0),
    need_n: Some(4.0),
    need_high_n: Some(5.5),
    admissible_m_s2: Some(2.25),
    ..PipelineState::UNKNOWN
};

const COMMAND: CommandRecord = CommandRecord {
    cmd_id: u32::MAX,
    mode: 2,
    flags: 3,
    ttl_ms: 50,
    force_mn: -1,
    slew_mn_s: 7,
    cause_sample: 9,
};

const EVENT: EventRecord<'_> = EventRecord {
    t_s: 1.25,
    kind: "health",
    phase: "p",
    method: "m",
    channel: "c",
    health: "frozen",
    duration_s: 1.0,
    esc_w: 2.0,
    esc_value: 3.0,
    statistic: 4.0,
    confidence: 5.0,
    speed_m_s: 6.0,
    speed_sigma_m_s: 7.0,
    moved_m: 8.0,
    irregularities: 9.0,
    estimate_n: 10.0,
    command_n: 11.0,
    json: "{\"type\":\"health\",\"t_s\":1.25}",
};

const PIPELINE: PipelineRecord<'_> = PipelineRecord {
    continued: true,
    carried_n: Some(4.0),
    least_n: 1.0,
    released: true,
    taxels: 16,
    rate_hz: 10_000.0,
    grips: true,
    config: "{}",
};

#[test]
fn every_kind_of_record_comes_back() {
    let records = [
        Record::State(STATE),
        Record::Event(EVENT),
        Record::Command(COMMAND),
        Record::Client(ClientCommand::AtLeast(5.5)),
        Record::Client(ClientCommand::ClearFault(FaultCode(0x0102))),
        Record::Client(ClientCommand::Stop),
        Record::Link(LinkRecord { kind: "status", detail: "{\"a\":\"\u{e4}\"}" }),
        Record::Wire(WireRecord { to_device: true, bytes: &[0, 255, 7] }),
        Record::Pipeline(PIPELINE),
    ];
    let title = BTreeMap::from([("uid".to_owned(), "ab".to_owned())]);
    let bytes = file_of(|writer| {
        writer.metadata("gripper", &title).unwrap();
        for (host_us, record) in (10..).zip(&records) {
            writer.write(host_us, record).unwrap();
        }
    });
    let mut reader = McapReader::new(Path::new("x.mcap"), Cursor::new(&bytes)).unwrap();
    let first = reader.next_entry().unwrap();
    assert_eq!(first, Some(Entry::Metadata { name: "gripper".to_owned(), values: title }));
    for (host_us, record) in (10..).zip(records) {
        let log_ns = ZERO_NS + host_us * 1000;
        assert_eq!(reader.next_entry().unwrap(), Some(Entry::Message { log_ns, record }));
    }
    assert_eq!(reader.next_entry().unwrap(), None);
}

#[test]
fn log_times_never_go_back() {
    let bytes = file_of(|writer| {
        for host_us in [5, 9, 3, 9, 12] {
            writer.write(host_us, &Record::Client(ClientCommand::Grasp)).unwrap();
        }
    });
    let mut reader = McapReader::new(Path::new("x"), Cursor::new(&bytes)).unwrap();
    let mut times = Vec::new();
    while let Some(Entry::Message { log_ns, .. }) = reader.next_entry().unwrap() {
        times.push((log_ns - ZERO_NS) / 1000);
    }
    assert_eq!(times, [5, 9, 9, 9, 12]);
}

/// A kill at any byte costs at most what came after the last flush.
#[test]
fn a_file_cut_off_anywhere_keeps_what_was_flushed() {
    let (count, flush) = (120, 20);
    let whole = samples(count, flush);
    assert!(recovered(&whole).unwrap().0.was_whole());
    let mut flushed_before = 0;
    for len in 0..whole.len() {
        let cut = whole.get(..len).unwrap();
        let (found, error) = indices(cut);
        if len < 8 {
            assert!(matches!(error, Some(McapError::NoMcap { .. })), "{len}");
            assert!(recovered(cut).is_none());
            continue;
        }
        assert!(found.iter().copied().eq(0..found.len() as u32), "in order, from the first: {len}");
        assert_eq!(found.len() as u32 % flush, 0, "whole flushes");
        assert!(found.len() >= flushed_before, "a longer file has no less: {len}");
        flushed_before = found.len();
        if len % 7 == 0 {
            let (saved, out) = recovered(cut).unwrap();
            // What a reader of live recordings leaves for later is saved too: the whole messages of the last chunk.
            assert_eq!(saved.messages, found.len() as u64 + saved.of_cut_chunk);
            assert!(indices(&out).0.iter().copied().eq(0..saved.messages as u32), "{len}");
            assert!(indices(&out).1.is_none() && recovered(&out).unwrap().0.was_whole());
        }
    }
    assert_eq!(flushed_before as u32, count);
}

/// Where the file ends in a chunk, its whole messages are saved, compressed or not; zeros behind the end are no data.
#[test]
fn a_chunk_that_is_cut_off_gives_its_whole_messages() {
    for compression in [None, Some(mcap::Compression::Lz4)] {
        let mut out = Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new().compression(compression).chunk_size(None);
        let mut writer = options.library("other 1").profile("p").create(&mut out).unwrap();
        let id = writer.add_channel(0, "/x", "json", &BTreeMap::new()).unwrap();
        let mut random = 1_u32;
        for sequence in 0..4000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let header = mcap::records::MessageHeader {
                channel_id: id,
                sequence,
                log_time: u64::from(sequence),
                publish_time: 0,
            };
            let text = format!("{{\"a\":{random},\"b\":\"{random:x}\"}}");
            writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let whole = out.into_inner();
        let (saved, copy) = recovered(&whole).unwrap();
        assert!(saved.was_whole() && !saved.was_ours() && saved.messages == 4000, "{saved:?}");
        assert_eq!(&copy[17..22], b"\x01\0\0\0p", "the profile stays");
        let mut least = 0;
        let end = whole.windows(9).rposition(|w| w == [0x0f, 4, 0, 0, 0, 0, 0, 0, 0]).unwrap();
        for len in (8..end).step_by(1999) {
            let (saved, copy) = recovered(&whole[..len]).unwrap();
            assert!(saved.messages >= least && saved.cut_at.is_some(), "{len}: {saved:?}");
            least = saved.messages;
            assert_eq!(recovered(&copy).unwrap().0.messages, least, "{len}");
            let mut zeros = whole[..len].to_vec();
            zeros.resize(whole.len(), 0);
            let (padded, _) = recovered(&zeros).unwrap();
            assert!(padded.messages <= least && padded.messages + 1 >= least, "{len}: {padded:?}");
        }
        assert!(least > 2000, "{least} of {compression:?}");
    }
}

/// Without its index a file can be replayed, but no viewer takes it.
#[test]
fn a_lost_index_is_written_again() {
    let whole = samples(60, 20);
    let data_end = whole.windows(9).rposition(|w| w == [0x0f, 4, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    for len in (data_end + 9..whole.len()).step_by(5) {
        let (saved, out) = recovered(whole.get(..len).unwrap()).unwrap();
        assert_eq!((saved.messages, saved.cut_at, saved.holes.len()), (60, Some(len as u64), 0));
        assert!(recovered(&out).unwrap().0.was_whole());
    }
    let mut bytes = whole.clone();
    bytes[data_end + 40] ^= 1;
    let (saved, _) = recovered(&bytes).unwrap();
    assert_eq!((saved.messages, saved.was_whole()), (60, false), "a damaged index is no index");
}

#[test]
fn damage_in_one_chunk_costs_that_chunk() {
    let whole = samples(400, 25);
    // In the middle of the file there are chunks and their indexes only.
    let mut lost = 0;
    for at in (whole.len() / 3..whole.len() / 2).step_by(11) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        let (saved, out) = recovered(&bytes).unwrap();
        assert!(saved.messages >= 375 || saved.cut_at.is_some(), "{at}: {saved:?}");
        assert_eq!(indices(&out).0.len() as u64, saved.messages, "{at}");
        lost += u32::from(!saved.was_whole());
    }
    assert!(lost > 0, "none of the damage was seen");
}

/// `mcap::parse_record` of 0.26 alone panics at an attachment without room for its checksum.
#[test]
fn an_attachment_that_ends_too_early_is_damage() {
    let whole = samples(0, 1);
    let record = |from: &[u8]| 9 + u64::from_le_bytes(*from[1..].first_chunk().unwrap()) as usize;
    let at = 8 + record(&whole[8..]);
    let end = at + record(&whole[at..]);
    let first = |len: usize| {
        let (start, body) = (&whole[..=at], &whole[at + 9..end]);
        let bytes = [start, &(len as u64).to_le_bytes(), &body[..len], &whole[end..]].concat();
        McapReader::new(Path::new("x"), Cursor::new(&bytes)).unwrap().next_entry().is_ok()
    };
    let len = end - at - 9;
    assert!((0..len).all(|len| !first(len)) && first(len));
}

#[test]
fn what_is_foreign_is_refused() {
    // Chunks in a compression that gripd does not use are no damage.
    let mut chunk = mcap::MAGIC.to_vec();
    let body = [&[0; 28][..], &4_u32.to_le_bytes(), b"zstd", &[0; 8]].concat();
    chunk.push(6);
    chunk.extend((body.len() as u64).to_le_bytes());
    chunk.extend(body);
    let (_, error) = indices(&chunk);
    let text = error.unwrap().to_string();
    assert!(text.contains("zstd; `gripctl import x.mcap -o run.mcap`"), "{text}");
    let mut out = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut out).unwrap();
    let schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data").unwrap();
    writer.add_channel(schema, "/chatter", "cdr", &BTreeMap::new()).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let (_, error) = indices(out.get_ref());
    let text = error.unwrap().to_string();
    assert!(
        text.contains("x.mcap: was not recorded by gripd") && text.contains("std_msgs"),
        "{text}"
    );
    let (_, error) = indices(b"t_s,stylus\n0,1\n");
    assert!(matches!(error, Some(McapError::NoMcap { .. })), "{error:?}");
    // Somebody else's file can be recovered all the same.
    assert!(recovered(out.get_ref()).unwrap().0.was_whole());
}

fn reading() -> impl Strategy<Value = f32> {
    prop_oneof![any::<f32>(), any::<u32>().prop_map(f32::from_bits), Just(f32::NAN), Just(-0.0)]
}

#[test]
fn more_taxels_than_an_array_has_are_refused() {
    let frame = [1.0; 257];
    let sample = Sample::stylus(Micros(1), 0.0);
    let records = [
        Record::Pipeline(PipelineRecord { taxels: u32::MAX, ..PIPELINE }),
        Record::Sample(SampleRecord { index: 0, sample, taxels: &frame }),
    ];
    for (record, count) in records.iter().zip(["4294967295", "257"]) {
        let bytes = file_of(|writer| writer.write(1, record).unwrap());
        let mut reader = McapReader::new(Path::new("x"), Cursor::new(&bytes)).unwrap();
        let reported = reader.next_entry().unwrap_err().to_string();
        assert!(
            reported.ends_with(&format!("{count} taxels; an array has 1 to 256")),
            "{reported}"
        );
    }
}

proptest! {
    #[test]
    fn any_sample_comes_back_bit_by_bit(
        t in any::<u64>(), index in any::<u32>(), stylus in reading(),
        options in proptest::array::uniform8(proptest::option::of(reading())),
        taxels in proptest::collection::vec(reading(), 0..20),
        arrived in proptest::option::of((1..u64::MAX, any::<u32>())),
    ) {
        let arrival = arrived.map(|(at, age)| Arrival { at: Micros(at), age: Micros(age.into()) });
        let [normal_force_n, tangential_n, travel_m, velocity_m_s, second_stylus, reference, pressure, motion] = options;
        let sample = Sample {
            t: Micros(t), stylus, normal_force_n, tangential_n, travel_m, velocity_m_s, second_stylus, reference, pressure, motion, arrival,
            ..Sample::default()
        };
        let bytes = file_of(|writer| {
            writer.write(1, &Record::Sample(SampleRecord { index, sample, taxels: &taxels })).unwrap();
        });
        let mut reader = McapReader::new(Path::new("x"), Cursor::new(&bytes)).unwrap();
        let Some(Entry::Message { record: Record::Sample(back), .. }) = reader.next_entry().unwrap() else {
            return Err(proptest::test_runner::TestCaseError::fail("no sample"));
        };
        prop_assert_eq!(back.index, index);
        prop_assert!(same(&back.sample, &sample), "{:?} {:?}", back.sample, sample);
        prop_assert!(back.taxels.iter().map(|v| v.to_bits()).eq(taxels.iter().map(|v| v.to_bits())));
    }

    /// Whatever is written over, cut off or put in: no panic, and what recovery writes is whole.
    #[test]
    fn damage_never_breaks_the_reader(
        places in proptest::collection::vec((any::<usize>(), any::<u8>()), 0..6),
        cut in any::<usize>(), cuts in any::<bool>(),
        junk in proptest::collection::vec(any::<u8>(), 0..40),
    ) {
        let mut bytes = samples(60, 20);
        for (at, value) in places {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        if cuts {
            bytes.truncate(cut % bytes.len());
        }
        let at = cut % (bytes.len() + 1);
        bytes.splice(at..at, junk);
        prop_assert_eq!(course(&bytes, true), course(&bytes, false));
        let (found, _) = indices(&bytes);
        if let Some((saved, out)) = recovered(&bytes) {
            prop_assert!(found.len() as u64 <= saved.messages, "recovery saves at least what can be read");
            prop_assert!(recovered(&out).is_some_and(|(again, _)| again.was_whole() && again.messages == saved.messages));
        }
    }

    #[test]
    fn rubbish_is_never_a_recording(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let mut file = b"\x89MCAP0\r\n".to_vec();
        file.extend(bytes);
        let (found, _) = indices(&file);
        prop_assert!(found.is_empty());
        recovered(&file);
    }
}

#[test]
fn an_index_leads_into_the_middle_and_a_broken_one_is_not_believed() {
    let bytes = samples(1000, 100);
    let index = McapIndex::read(Cursor::new(&bytes)).unwrap().unwrap();
    // The first one announces topics and ends before the attachment.
    assert_eq!(index.chunks.len(), 11);
    let sixth = index.chunks[6];
    assert_eq!((sixth.from_ns, sixth.to_ns), (ZERO_NS + 500_000_000, ZERO_NS + 599_000_000));
    let reader = || McapReader::new(Path::new("x.mcap"), Cursor::new(bytes.clone())).unwrap();
    for mut reader in [reader(), reader().read_ahead().unwrap()] {
        // The start announces what the messages are.
        while !matches!(reader.next_entry().unwrap(), Some(Entry::Message { .. })) {}
        reader.jump(sixth.offset).unwrap();
        let Some(Entry::Message { record: Record::Sample(sample), .. }) =
            reader.next_entry().unwrap()
        else {
            panic!("no sample")
        };
        assert_eq!(sample.index, 500);
    }
    for cut in [1, 9, 30, 200] {
        let cut = &bytes[..bytes.len() - cut];
        assert_eq!(McapIndex::read(Cursor::new(cut)).unwrap(), None);
    }
    let mut wrong = bytes.clone();
    let place = bytes.len() - 100;
    wrong[place] ^= 1;
    assert_eq!(McapIndex::read(Cursor::new(&wrong)).unwrap(), None);
    assert_eq!(McapIndex::read(Cursor::new(b"short")).unwrap(), None);
}
