#!/bin/sh
# The page for Prometheus, as a test of grip-daemon writes it, read by the parser of the Python client.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
python_work metrics-check

# Written anew, so that a test that has another name now is noticed.
rm -f "$target/tmp/metrics.txt"
(cd "$root" && CARGO_TARGET_DIR="$target" cargo test --quiet --locked --workspace --test service shown)

"$python" - "$target/tmp/metrics.txt" <<'PY'
import sys
from prometheus_client.parser import text_string_to_metric_families

families = {family.name: family for family in text_string_to_metric_families(open(sys.argv[1]).read())}
assert len(families) > 40, sorted(families)
assert families["gripd_samples"].type == "counter", families["gripd_samples"]
assert families["gripd_samples"].samples[0].value == 20000
causes = {sample.labels["cause"]: sample.value for sample in families["gripd_frames_bad"].samples}
assert causes["crc"] == 4 and sum(causes.values()) == 4, causes
latency = families["gripd_latency_seconds"]
assert latency.type == "histogram", latency
buckets = [sample for sample in latency.samples if sample.name.endswith("_bucket")]
assert [sample.value for sample in buckets] == sorted(sample.value for sample in buckets)
assert buckets[-1].labels["le"] == "+Inf" and buckets[-1].value == 1000
samples = sum(len(family.samples) for family in families.values())
print(f"{len(families)} metrics, {samples} samples read by prometheus_client")
PY
