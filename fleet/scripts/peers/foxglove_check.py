"""The live view of `gripfleet foxglove` as an app sees it, against the recording of the same run.

Usage: foxglove_check.py GRIPD GRIPFLEET FOLDER. Runs gripd on the simulator with a recording, connects to gripfleet with the protocol of
Foxglove, decodes messages with the advertised schemas, and compares each with what the recording holds. Then gripd is killed and comes
back, and everything is ended.
"""

import bisect
import contextlib
import json
import math
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from websockets.sync.client import connect

TOPICS = {"/gripper/" + name.lower(): "grip_msgs/msg/" + name for name in ["Sample", "State", "Event", "Link", "Health"]}
RECORDED = ["/gripper/sample", "/gripper/state", "/gripper/event", "/gripper/link"]
# Longer than anything takes, however busy the machine.
PATIENCE_S = 120
# A log time is that of the recording but for the line and the scheduler; this finds wrong units, epochs and offsets.
TIME_NS = 5_000_000_000
SAMPLES = 3000
STATES = 200
SLIPPING = 3


def single(value: float) -> bytes:
    """The bits as f32; one NaN is as good as another."""
    return b"nan" if math.isnan(value) else struct.pack("<f", value)


def fields(message: object, leave: tuple = ()) -> dict:
    """The fields of a decoded message by name, numbers as the bits of an f32."""
    named = {name: getattr(message, name) for name in message.__slots__ if name not in ("stamp", *leave)}
    return {name: single(value) if isinstance(value, float) else value for name, value in named.items()}


class App:
    """One connection of an app."""

    def __init__(self, address: str) -> None:
        self.connection = contextlib.ExitStack()
        wanted = connect(address, subprotocols=["foxglove.sdk.v1"], max_size=None)
        self.socket = self.connection.enter_context(wanted)
        assert self.socket.subprotocol == "foxglove.sdk.v1", self.socket.subprotocol
        self.channels, self.decoders, self.status = {}, {}, []
        self.messages = {topic: [] for topic in TOPICS}
        while len(self.channels) < len(TOPICS):
            self.hear()

    def hear(self, timeout: float = PATIENCE_S) -> None:
        """Takes one message of the server."""
        data = self.socket.recv(timeout=timeout)
        if isinstance(data, str):
            self.told(json.loads(data))
            return
        code, subscription, log_time = struct.unpack_from("<BIQ", data)
        assert code == 1, code
        topic = next(topic for topic, channel in self.channels.items() if channel["id"] == subscription)
        decoded = self.decoders[topic](data[13:])
        assert decoded.stamp.sec * 10**9 + decoded.stamp.nanosec == log_time, topic
        self.messages[topic].append((log_time, decoded))

    def told(self, message: dict) -> None:
        if message["op"] == "serverInfo":
            assert message["name"].startswith("gripd at unix:"), message
            assert message["capabilities"] == [], message
        elif message["op"] == "advertise":
            for channel in message["channels"]:
                schema = Schema(channel["id"], channel["schema"].encode(), channel["schemaEncoding"], channel["schemaName"])
                self.channels[channel["topic"]] = channel
                self.decoders[channel["topic"]] = DecoderFactory().decoder_for(channel["encoding"], schema)
        elif message["op"] == "status":
            self.status.append(message["message"])
        else:
            assert message["op"] == "removeStatus", message

    def subscribe(self, *topics: str) -> None:
        # The number of the channel serves as that of the subscription.
        numbers = [self.channels[topic]["id"] for topic in topics]
        wanted = [{"id": number, "channelId": number} for number in numbers]
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))

    def unsubscribe(self, topic: str) -> None:
        self.socket.send(json.dumps({"op": "unsubscribe", "subscriptionIds": [self.channels[topic]["id"]]}))

    def until(self, so: object, what: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not so():
            assert time.monotonic() < end, f"{what} did not come; {self.status}"
            self.hear()


def gripd(program: str, folder: Path, recording: str) -> subprocess.Popen:
    listen = f"unix:{folder}/gripd.sock"
    command = [program, "--port", "sim", "--listen", listen, "--record", folder / recording, "--json"]
    with (folder / "gripd.txt").open("a") as out:
        return subprocess.Popen(command, stdout=out, stderr=out, cwd=folder)


def read(file: Path) -> tuple[dict, dict]:
    """Schemas and messages of a recording by topic."""
    messages = {}
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        schemas = {channel.topic: summary.schemas[channel.schema_id] for channel in summary.channels.values()}
        for _, channel, message, decoded in reader.iter_decoded_messages():
            messages.setdefault(channel.topic, []).append((message.log_time, decoded))
    return schemas, messages


def check_channels(app: App, schemas: dict) -> None:
    assert {topic: channel["schemaName"] for topic, channel in app.channels.items()} == TOPICS
    for channel in app.channels.values():
        assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg"), channel
    for topic in RECORDED:
        schema, channel = schemas[topic], app.channels[topic]
        assert (schema.name, schema.data.decode()) == (channel["schemaName"], channel["schema"]), topic


def check_times(app: App) -> None:
    now = time.time_ns()
    for topic, messages in app.messages.items():
        times = [log_time for log_time, _ in messages]
        assert times == sorted(times), f"{topic}: log times go back"
        if topic != "/gripper/event":
            assert not times or abs(now - times[-1]) < PATIENCE_S * 10**9, f"{topic}: {times[-1]} is far from now"


def check_samples(app: App, recorded: list) -> str:
    """Every sample that came is, bit by bit, the recorded one of its number; none is missing between them.

    When a sample was taken in (and its stamp) is known to the recorder only: the live view says 0 there.
    """
    arrival = ("arrived_us", "age_us")
    known = {decoded.index: (log_time, decoded) for log_time, decoded in recorded}
    live = app.messages["/gripper/sample"]
    numbers = [decoded.index for _, decoded in live]
    missing = numbers[-1] - numbers[0] + 1 - len(numbers)
    assert len(set(numbers)) == len(numbers) and numbers == sorted(numbers)
    late = []
    for log_time, decoded in live:
        time_ns, sample = known[decoded.index]
        assert fields(decoded, arrival) == fields(sample, arrival), (decoded, sample)
        assert abs(log_time - time_ns) < TIME_NS, (decoded.index, log_time, time_ns)
        late.append(time_ns - log_time)
    # Times of the live view follow the gripper's own clock: no two samples share one.
    steps = [after[0] - before[0] for before, after in zip(live, live[1:])]
    share = sum(step > 0 for step in steps) / len(steps)
    assert share > 0.99, f"only {share:.3f} of the log times increase"
    late.sort()
    return f"{len(live)} samples, {missing} missing, recorded {late[len(late) // 2] / 1e6:.2f} ms later (median)"


def check_states(app: App, recorded: list) -> str:
    """A state of the recording's moment is that state; one between two recorded ones fits between them.

    The age of the newest row at the last command is not told to clients: NaN in the live view.
    """
    times = [decoded.device_time_us for _, decoded in recorded]
    same = between = 0
    for _, decoded in app.messages["/gripper/state"]:
        place = bisect.bisect_left(times, decoded.device_time_us)
        if place == len(times):
            continue
        after = recorded[place][1]
        if after.device_time_us == decoded.device_time_us:
            assert fields(decoded, ("late_ms",)) == fields(after, ("late_ms",)), (decoded, after)
            same += 1
        elif place > 0:
            before = recorded[place - 1][1]
            # The recorder misses no change of scene and controller.
            assert (decoded.scene, decoded.grip) == (before.scene, before.grip), (before, decoded)
            assert decoded.sample_rate_hz == before.sample_rate_hz
            assert before.lost <= decoded.lost <= after.lost
            # Within a slip the command rises and falls; while the object is held it stands.
            if before.scene != SLIPPING and single(before.command_n) == single(after.command_n):
                assert single(decoded.command_n) == single(after.command_n), (before, decoded, after)
                between += 1
    assert same + between >= STATES // 4, (same, between)
    return f"{same} states as recorded, {between} as the recorded ones before and after"


def check_events(app: App, recorded: list) -> str:
    """Slips that came are recorded ones, but for the printed line, which does not travel."""
    known = {(round(1e6 * decoded.t_s), decoded.type): decoded for _, decoded in recorded}
    live = [decoded for _, decoded in app.messages["/gripper/event"] if decoded.type != "health"]
    assert live and any(decoded.type == "slip" for decoded in live)
    for decoded in live:
        event = known[round(1e6 * decoded.t_s), decoded.type]
        leave = ("json", "t_s")
        assert decoded.json == "" and fields(decoded, leave) == fields(event, leave), (decoded, event)
    return f"{len(live)} events"


def end(process: subprocess.Popen, how: signal.Signals) -> int:
    process.send_signal(how)
    return process.wait(timeout=PATIENCE_S)


def watch(address: str) -> tuple[App, list]:
    """An app that looks at news and states."""
    app = App(address)
    app.subscribe("/gripper/link", "/gripper/state")
    return app, app.messages["/gripper/link"]


def first_run(address: str) -> App:
    """What an app sees while gripd runs; the connection has ended when it comes back, so that nothing is dropped for it."""
    app = App(address)
    app.subscribe("/gripper/state", "/gripper/health", "/gripper/link")
    app.until(lambda: len(app.messages["/gripper/state"]) > STATES, "states")
    app.until(lambda: app.messages["/gripper/health"], "figures")
    assert app.messages["/gripper/sample"] == []
    app.subscribe("/gripper/sample", "/gripper/event")
    app.until(lambda: len(app.messages["/gripper/sample"]) > SAMPLES, "samples")
    app.until(lambda: any(m.type == "slip_end" for _, m in app.messages["/gripper/event"]), "a slip")
    check_times(app)
    app.connection.close()
    return app


def come_back(address: str, start: object, processes: list) -> None:
    """gripd ends, is killed, and comes back: news, states and samples go on."""
    app, news = watch(address)
    told = lambda kind: sum(decoded.kind == kind for _, decoded in news)
    app.until(lambda: news and app.messages["/gripper/state"], "the present state")
    for turn, how in enumerate([signal.SIGINT, signal.SIGKILL], start=1):
        code = end(processes[-1], how)
        assert code in (0, 3, -how), code
        app.until(lambda: told("daemon_lost") == turn, "that gripd is gone")
        processes.append(start(f"run-{turn}.mcap"))
        app.until(lambda: told("daemon") == turn, "that gripd is back")
        states = len(app.messages["/gripper/state"])
        app.until(lambda: len(app.messages["/gripper/state"]) > states + 20, "states after it came back")
        samples = len(app.messages["/gripper/sample"])
        app.subscribe("/gripper/sample")
        app.until(lambda: len(app.messages["/gripper/sample"]) > samples + 200, "samples after it came back")
        app.unsubscribe("/gripper/sample")
    check_times(app)
    app.connection.close()


def main() -> None:
    program, gripfleet, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3]).resolve()
    command = [gripfleet, "foxglove", f"unix:{folder}/gripd.sock", "--listen", "127.0.0.1:0", "--every", "1"]
    processes = []
    try:
        # It comes before the daemon, and waits for it.
        with (folder / "gripfleet.txt").open("w") as err:
            server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=err, text=True)
        processes.append(server)
        address = server.stdout.readline().strip().removeprefix("Foxglove opens ")
        early = App(address)
        early.until(lambda: any("no daemon" in text for text in early.status), "that there is no daemon")
        early.connection.close()
        start = lambda recording: gripd(program, folder, recording)
        processes.append(start("run.mcap"))
        app = first_run(address)
        come_back(address, start, processes)
        code = end(server, signal.SIGTERM)
        told = (folder / "gripfleet.txt").read_text()
        # 3 says that something was dropped, which it must have said then.
        assert code == 0 or (code == 3 and "dropped" in told), (code, told)
        assert "panicked" not in told, told
        schemas, recorded = read(folder / "run.mcap")
        check_channels(app, schemas)
        print(check_samples(app, recorded["/gripper/sample"]))
        print(check_states(app, recorded["/gripper/state"]))
        print(check_events(app, recorded["/gripper/event"]), "as recorded")
        print(f"went on after an end and a kill of gripd; ended by SIGTERM with {code}")
    finally:
        for process in processes:
            process.kill()
            process.wait()


main()
