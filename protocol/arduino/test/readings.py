#!/usr/bin/env python3
"""Two seconds at 1600 Hz as f32 on stdout: noise, and a slip of 0.2 s in it."""

import math
import random
import struct
import sys

noise = random.Random(1)
readings = [noise.gauss(0, 1) + (20 * math.sin(2000 * i / 1600) if 1600 <= i < 1920 else 0) for i in range(3200)]
sys.stdout.buffer.write(struct.pack(f"<{len(readings)}f", *readings))
