"""A bridge to a gripper that speaks lines of text, such as `A=0.012 F=5.12` (acceleration, force in N), and takes `SET 2.45`.

    stty -F /dev/ttyUSB0 921600 && python3 bridge.py /dev/ttyUSB0

Its readings become rows for gripd, and gripd's force commands become lines for it. Words behind the port are arguments of gripd.
"""
import json, os, subprocess, sys, threading, tty
from subprocess import PIPE

line = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
tty.setraw(line)
gripd = ["gripd", "--port", "rows:-", "--json", *sys.argv[2:]]
gripd = subprocess.Popen(gripd, stdin=PIPE, stdout=PIPE, text=True, bufsize=1)

def command():
    for event in map(json.loads, gripd.stdout):
        if event["type"] == "slip":
            print(f"slip at {event['t_s']:.2f} s", flush=True)
        elif event["type"] == "command" and event["mode"] == "force":
            os.write(line, f"SET {event['force_n']:.2f}\n".encode())  # no SET means: hold what you have

threading.Thread(target=command, daemon=True).start()
print("vibration,force_n,rate=1000", file=gripd.stdin)  # here the rate of your gripper
for text in os.fdopen(line, encoding="ascii", errors="replace"):
    values = dict(word.split("=") for word in text.split() if word.count("=") == 1)
    if "A" in values:  # a banner or an answer is no row
        print(values["A"], values.get("F", ""), sep=",", file=gripd.stdin)  # a force that is missing is no reading
