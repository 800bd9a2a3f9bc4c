"""docs/subscriber.py beside a router, a gripd on its simulator and a gripfleet: each event once and in order, through restarts.

Usage: fleet_check.py SUBSCRIBER GRIPD GRIPFLEET FOLDER. The subscriber, gripfleet and the router are killed in turn and started again.
At the end it must have what `gripfleet events --all` gets: the log of the gripper.
"""

import json
import socket
import subprocess
import sys
import time
from pathlib import Path

PATIENCE_S = 60
subscriber, gripd, gripfleet, folder = sys.argv[1:]
folder = Path(folder).resolve()
with socket.create_server(("127.0.0.1", 0)) as free:
    endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
(folder / "gripd.toml").write_text(
    f'listen = "unix:{folder}/gripd.sock"\nallow_commands = true\n'
    f'[fleet]\nsite = "hall"\nrouter = "{endpoint}"\nspool = "spool"\ncommands = true\n'
)
COMMANDS = {
    "router": [gripfleet, "router", "--listen", endpoint],
    "gripd": [gripd, "--port", "sim", "--json", "--config", "gripd.toml"],
    "gripfleet": [gripfleet, "--config", "gripd.toml"],
    "subscriber": [sys.executable, str(Path(subscriber).resolve()), endpoint, "events.jsonl"],
}
running = {}


def start(name: str) -> None:
    with (folder / f"{name}.log").open("ab") as log:
        running[name] = subprocess.Popen(COMMANDS[name], cwd=folder, stdout=log, stderr=log)


def kill(name: str) -> None:
    running[name].kill()
    running[name].wait()


def events() -> list[dict]:
    lines = (folder / "events.jsonl").read_bytes().splitlines(keepends=True) if (folder / "events.jsonl").exists() else []
    return [json.loads(line) for line in lines if line.endswith(b"\n")]


def wait(what: str, is_so) -> None:
    until = time.monotonic() + PATIENCE_S
    while not is_so():
        ended = {name: one.returncode for name, one in running.items() if one.poll() is not None}
        assert not ended, f"ended: {ended}; their output is in {folder}"
        assert time.monotonic() < until, f"not within {PATIENCE_S} s: {what}; the output of all is in {folder}"
        time.sleep(0.05)


def make_event() -> bool:
    """A command is an event; a gripper whose object fell takes this one too. While nobody takes it, again."""
    gripper = next(f"{event['site']}/{event['uid']}" for event in events())
    command = [gripfleet, "command", gripper, "clear-fault", "0201", "--router", endpoint]
    return subprocess.run(command, capture_output=True).returncode == 0


def commands(found: list[dict]) -> int:
    return sum(event["type"] == "notice" and event["about"] == "client" for event in found)


def more(count: int) -> None:
    """So many commands, and all of them received."""
    before = commands(events())
    for _ in range(count):
        wait("a command that is taken", make_event)
    wait("its event", lambda: commands(events()) >= before + count)


def main() -> None:
    for name in COMMANDS:
        start(name)
    wait("a first event", events)
    more(3)
    for name in ["subscriber", "gripfleet", "router"]:
        kill(name)
        if name == "subscriber":
            for _ in range(3):
                wait("a command while nobody listens", lambda: make_event())
        start(name)
        more(3)
    listed = subprocess.Popen([gripfleet, "events", "--all", "--json", "--router", endpoint], stdout=subprocess.PIPE, text=True)
    wanted, got = [], events()
    while len(wanted) < len(got):
        line = json.loads(listed.stdout.readline())
        wanted += [line] if "id" in line else []
    listed.kill()
    assert got == wanted, f"the subscriber has something else than gripfleet; see {folder}/events.jsonl"
    numbers = [(event["run"], event["seq"]) for event in got]
    assert len(set(numbers)) == len(numbers), "an event came twice"
    runs = list(dict.fromkeys(run for run, _ in numbers))
    assert len(runs) == 2 and numbers == [(run, seq) for run in runs for seq in range(1, 1 + sum(run == other for other, _ in numbers))], numbers
    print(f"fleet-check: {len(got)} events of 2 runs once and in order, through kills of the subscriber, gripfleet and the router")


try:
    main()
finally:
    for one in running.values():
        one.kill()
