"""Two files of NAME<tab>VALUE<tab>UNIT in, a table of ours beside theirs with ratios out.

`--gate OURS THEIRS` fails where a ratio is below its bound (the least that was published, less the noise of a busy
machine), and where neither of the vector widths of a bound was measured.
"""

import sys

GATE = 14.0
WANTED = (
    # ours, theirs, at least so many times as fast
    ("rprop surface2 f32 AVX-512", "fann rprop surface2", 25.0),
    ("rprop surface2 f32 AVX2", "fann rprop surface2", 17.0),
    ("rprop surface2 f32 portable", "fann rprop surface2", None),
    ("rprop surface2 f64 AVX-512", "fann rprop surface2", 8.0),
    ("rprop surface2 f64 AVX2", "fann rprop surface2", 8.0),
    ("rprop building1 f32 AVX-512", "fann rprop building1", 25.0),
    ("rprop building1 f32 AVX2", "fann rprop building1", 25.0),
    ("rprop kin32fm f32 AVX-512", "fann rprop kin32fm", 20.0),
    ("rprop kin32fm f32 AVX2", "fann rprop kin32fm", None),
    ("forward 2-10-1 throughput", "fann forward 2-10-1 throughput", None),
    ("forward 2-10-1 latency", "fann forward 2-10-1 latency", None),
    ("forward 16-32-16-1 throughput", "fann forward 16-32-16-1 throughput", None),
    ("forward 16-32-16-1 latency", "fann forward 16-32-16-1 latency", None),
)


def gate(ours, theirs):
    """Ends with 1 and the ratios that are too small: of the vector widths that were measured one must be fast enough."""
    for other in ("fann rprop surface2", "fann rprop building1"):
        ratios = [theirs[other][0] / ours[name][0] for name, of, _ in WANTED if of == other and " f32 AVX" in name and name in ours]
        if not ratios or max(ratios) < GATE:
            sys.exit(f"{other}: {ratios} times as fast, at least {GATE} expected")


def read(path):
    with open(path, encoding="utf-8") as file:
        fields = [line.rstrip("\n").split("\t") for line in file if line.count("\t") == 2]
    return {name: (float(value), unit) for name, value, unit in fields}


def main():
    ours, theirs = read(sys.argv[-2]), read(sys.argv[-1])
    print("| ours | | theirs | | ratio | wanted |\n|---|---|---|---|---|---|")
    for mine, other, wanted in WANTED:
        if mine not in ours or other not in theirs:
            continue
        (a, unit), (b, _) = ours[mine], theirs[other]
        word = "-" if wanted is None else f"{wanted:g}: {'kept' if b / a >= wanted else 'missed'}"
        print(f"| {mine} | {a:.3g} {unit} | {other} | {b:.4g} {unit} | {b / a:.1f} | {word} |")
    print("\n| within ours | ratio |\n|---|---|")
    for name, (value, _) in ours.items():
        if name.startswith("scg ") and not name.endswith(" gradients"):
            rprop = ours[name.replace("scg", "rprop", 1)][0]
            print(f"| epoch {name} / rprop | {value / rprop:.2f} |")
    if "--gate" in sys.argv:
        gate(ours, theirs)


main()
