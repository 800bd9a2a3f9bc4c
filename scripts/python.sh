#!/bin/sh
# Prints the interpreter of a virtual environment with everything that the checks need from the package index (scripts/requirements.txt, and
# the Python peer with its tests). It lies under the target folder and is made anew where one of these lists has changed. PYTHON names another
# interpreter than python3. Fails where it cannot be made.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/python"
home=$(cd "$target/python" && pwd)
python=$home/bin/python
wanted=$(cat "$root/scripts/requirements.txt" "$root/protocol/python/pyproject.toml" && echo "$root")

if [ ! -x "$python" ] || [ "$(cat "$home/wanted" 2>/dev/null)" != "$wanted" ]; then
    "${PYTHON:-python3}" -m venv --clear "$home" >&2 || {
        echo "python.sh: ${PYTHON:-python3} makes no virtual environment (Debian: python3-venv)" >&2
        exit 1
    }
    "$python" -m pip install --quiet --disable-pip-version-check --retries 1 \
        --requirement "$root/scripts/requirements.txt" --editable "$root/protocol/python[dev]" >&2 || {
        echo "python.sh: pip cannot install scripts/requirements.txt and protocol/python[dev]; it needs a package index" >&2
        exit 1
    }
    printf %s "$wanted" >"$home/wanted"
fi
echo "$python"
