#!/bin/sh
# The pictures of docs/figures.md: one of each command that draws, into docs/images (that of `profile` is docs/profile.svg, which docs/commands.md shows too).
# GRIP_BIN names a folder that holds gripctl already; without it a release build is made. The recordings for `gripctl score`
# stand beside the project or in the folder named by GRIP_DATA (CONTRIBUTING.md).
set -eu
cd "$(dirname "$0")/.."
. scripts/missing.sh

bin=${GRIP_BIN:-}
if [ -z "$bin" ]; then
    cargo build --release --locked -p gripctl --bin gripctl
    bin=${CARGO_TARGET_DIR:-target}/release
fi
images=docs/images
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

"$bin/gripctl" study --out "$work/study" --quick > /dev/null
cp "$work/study/figures/fig-3-default.png" "$images/study.png"

recordings=${GRIP_DATA:-../shared/data}/biotac_slide
if [ -f "$recordings/labels.csv" ]; then
    "$bin/gripctl" score "$recordings" --guard-ms 60 --detectors stylus,esc,fused --curve "$images/score.svg" > /dev/null
else
    missing data "$recordings: $images/score.svg stays as it is"
fi

"$bin/gripctl" grasp --all --trials 20 --plot "$images/grasp.svg" > /dev/null

"$bin/gripctl" profile docs/profile.csv --speed 0.05 --force 2 --cutoff-mm 0.8 --form-degree 2 --plot docs/profile.svg > /dev/null
