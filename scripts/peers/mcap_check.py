"""Recordings of gripd as the Python packages mcap, mcap-ros2-support and rosbags see them.

Usage: mcap_check.py GRIPCTL FOLDER CUTS. Reads every .mcap in FOLDER, compares its samples with `gripctl csv`, then cuts copies
of whole.mcap off at CUTS places, recovers them and reads them again.
"""

import csv
import random
import struct
import subprocess
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

COLUMNS = ["force_n", "tangential_n", "travel_m", "velocity_m_s", "stylus2", "reference", "pressure", "motion"]
FIELDS = [
    "normal_force_n", "tangential_n", "travel_m", "velocity_m_s", "second_stylus", "reference", "pressure", "motion",
]
TOPICS = {
    "/gripper/" + name.lower(): "grip_msgs/msg/" + name
    for name in ["Sample", "State", "Event", "Command", "Client", "Link", "Wire", "Pipeline"]
}
FLUSH_NS = 250_000_000
# The recorder looks at the time every 50 ms.
TICK_NS = 50_000_000


def bits(value: float) -> bytes:
    """The f32, whatever it is."""
    return struct.pack("<f", value)


def read(file: Path) -> tuple[list, dict, object]:
    """Every message, decoded, in log order; attachments by name; the summary."""
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None, f"{file}: no summary"
        messages = [
            (schema, channel, message, decoded)
            for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False)
        ]
        attachments = {attachment.name: attachment for attachment in reader.iter_attachments()}
        titles = {metadata.name for metadata in reader.iter_metadata()}
    assert "recording" in titles, f"{file}: no metadata"
    return messages, attachments, summary


def check(file: Path) -> list:
    """The rules of the viewers; gives the messages."""
    messages, attachments, summary = read(file)
    found = {channel.topic: summary.schemas[channel.schema_id] for channel in summary.channels.values()}
    assert {topic: schema.name for topic, schema in found.items()} == TOPICS, found
    assert all(schema.encoding == "ros2msg" and schema.data for schema in found.values())
    assert all(channel.message_encoding == "cdr" for channel in summary.channels.values())
    times = [message.log_time for _, _, message, _ in messages]
    assert times == sorted(times), f"{file}: log times go back"
    with AnyReader([file]) as bag:
        kinds = [type(bag.deserialize(data, connection.msgtype)).__name__ for connection, _, data in bag.messages()]
    assert sorted(kinds) == sorted(schema.name.replace("/", "__") for schema, *_ in messages), f"{file}: rosbags"
    statistics = summary.statistics
    assert statistics.message_count == len(messages)
    assert statistics.chunk_count == len(summary.chunk_indexes) > 0
    assert statistics.attachment_count == len(attachments)
    assert (statistics.message_start_time, statistics.message_end_time) == (times[0], times[-1])
    for number, count in statistics.channel_message_counts.items():
        assert count == sum(1 for _, channel, _, _ in messages if channel.id == number)
    assert {"gripd.toml", "model.json"} <= set(attachments), set(attachments)
    for _, _, message, decoded in messages:
        assert decoded.stamp.sec * 10**9 + decoded.stamp.nanosec == message.log_time
    return messages


def samples(messages: list) -> list:
    return [decoded for _, channel, _, decoded in messages if channel.topic == "/gripper/sample"]


def check_csv(gripctl: str, file: Path) -> None:
    """The samples are, bit by bit, those of the CSV export."""
    table = file.with_suffix(".csv")
    subprocess.run([gripctl, "csv", file, "-o", table], check=True, stdout=subprocess.DEVNULL)
    with table.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    decoded = samples(check(file))
    assert len(rows) == len(decoded) > 1000
    for row, sample in zip(rows, decoded):
        seconds, micros = row["t_s"].split(".")
        assert int(seconds) * 10**6 + int(micros) == sample.device_time_us
        assert bits(float(row["stylus"])) == bits(sample.stylus)
        for bit, (column, field) in enumerate(zip(COLUMNS, FIELDS)):
            present = sample.present >> bit & 1 == 1
            assert present == (row[column] != ""), (row, column)
            if present:
                assert bits(float(row[column])) == bits(getattr(sample, field)), (row, column)
        taxels = [row[f"pressure_{i}"] for i in range(len(sample.taxels))]
        assert [bits(float(cell)) for cell in taxels] == [bits(value) for value in sample.taxels]
    replayed = subprocess.run([gripctl, "replay", file, "--check"], check=True, capture_output=True, text=True)
    first = replayed.stdout.splitlines()[0]
    print(f"{file.name}: {len(rows)} samples as in the CSV; {first}")


def check_cuts(gripctl: str, whole: Path, cuts: int) -> None:
    """Whatever length a kill leaves, recovery makes a file that this reader takes, and loses one flush at most."""
    bytes_of = whole.read_bytes()
    messages = check(whole)
    dice = random.Random(1)
    # The last chunk stands where the data end; what follows is the index, which recovery writes again.
    with whole.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    head = chunks[0].chunk_start_offset + chunks[0].chunk_length
    saved_least = None
    for number in range(cuts):
        length = dice.randrange(head, len(bytes_of))
        cut, recovered = whole.with_name("cut.mcap"), whole.with_name("recovered.mcap")
        cut.write_bytes(bytes_of[:length])
        recover = [gripctl, "recover", cut, "-o", recovered, "--force", "--json"]
        done = subprocess.run(recover, capture_output=True, text=True)
        assert done.returncode in (0, 3), done
        saved = check_again(recovered)
        kept = [message for message in messages[: len(saved)]]
        assert [m.data for _, _, m, _ in saved] == [m.data for _, _, m, _ in kept], f"cut {number} at {length}"
        # Everything in chunks that lie wholly before the cut was flushed before it.
        flushed = [c for c in chunks if c.message_end_time > 0 and c.chunk_start_offset + c.chunk_length <= length]
        open_ns = max(c.message_end_time - c.message_start_time for c in chunks)
        assert open_ns <= FLUSH_NS + TICK_NS, open_ns
        assert not flushed or (saved and saved[-1][2].log_time >= flushed[-1].message_end_time)
        saved_least = len(saved) if saved_least is None else min(saved_least, len(saved))
    print(f"{cuts} recordings cut off: all recovered, read and equal as far as they go; at most {open_ns / 1e6:.0f} ms in a chunk")


def check_again(file: Path) -> list:
    """A recovered file: whole, in order, with statistics; it may hold no message yet."""
    messages, _, summary = read(file)
    assert summary.statistics.message_count == len(messages)
    return messages


def main() -> None:
    gripctl, folder, cuts = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    for file in sorted(folder.glob("*.mcap")):
        check_csv(gripctl, file)
    check_cuts(gripctl, folder / "whole.mcap", cuts)


main()
