"""Slips of a recording, one JSON object a line: python ten_lines.py FILE"""

import json
import sys

import slipgrip

recording = slipgrip.read(sys.argv[1])
for event in slipgrip.detect(recording).events:
    print(json.dumps(event))
