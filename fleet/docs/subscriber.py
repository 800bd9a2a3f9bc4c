"""Events of all grippers on a network as JSON lines, each once and in order (docs/fleet.md): ENDPOINT FILE; pip install eclipse-zenoh."""

import json, sys, zenoh
def take(event):  # whether it is new; known: of each gripper the last event of each run, the latest run at the end
    runs = known.setdefault(f"{event['site']}/{event['uid']}", {})
    if event["seq"] <= runs.get(event["run"], 0):
        return False
    runs[event["run"]] = event["seq"]
    return True
known, config, file = {}, zenoh.Config(), open(sys.argv[2], "a+b")
file.seek(0)
lines = file.readlines()
if lines and not lines[-1].endswith(b"\n"):  # a kill has cut it off; it is asked for again
    file.truncate(file.tell() - len(lines.pop()))
[take(json.loads(line)) for line in lines]
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
session = zenoh.open(config)
subscriber = session.declare_subscriber("grip/v1/*/*/json/**", zenoh.handlers.RingChannel(1000))
for sample in subscriber:
    seen = json.loads(sample.payload.to_bytes())  # an event or HEALTH: its number shows whether something is missing
    gripper = f"{seen['site']}/{seen['uid']}"
    runs = known.get(gripper, {})
    if seen["seq"] > runs.get(seen["run"], -1):
        after = ",".join(f"{run}.{seq}" for run, seq in [*runs.items()][:-9:-1])
        question = f"grip/v1/{gripper}/json/events/**?after={after}"
        answers = session.get(question, consolidation=zenoh.ConsolidationMode.NONE)
        for event in (json.loads(reply.ok.payload.to_bytes()) for reply in answers if reply.ok):
            if take(event):
                file.write(json.dumps(event).encode() + b"\n")
                file.flush()
                print(json.dumps(event), flush=True)
