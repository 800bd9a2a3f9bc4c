#!/bin/bash
# Makes a book of the pages, which is read and searched without a network: target/book/html/index.html.
# Needs mdbook in the version below. Where it is not in the path it is built once, into target/tools, without the server and the watcher, and
# without optimisation: some 100 s of processor time.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/missing.sh

version=0.5.4
target=${CARGO_TARGET_DIR:-target}
mdbook=$(command -v mdbook || true)
if [ -z "$mdbook" ] || [ "$("$mdbook" --version)" != "mdbook v$version" ]; then
    mdbook=$target/tools/bin/mdbook
    if [ ! -x "$mdbook" ] || [ "$("$mdbook" --version)" != "mdbook v$version" ]; then
        # A target folder of its own: what it compiles serves nothing else, and goes afterwards.
        CARGO_TARGET_DIR="$target/tools/build" CARGO_PROFILE_DEV_DEBUG=0 cargo install mdbook --version "$version" --locked --quiet \
            --no-default-features --features search --debug --root "$target/tools" || { missing mdbook "mdbook $version"; exit 0; }
        rm -rf "$target/tools/build"
    fi
fi

book=$target/book
mkdir -p "$book"
book=$(cd "$book" && pwd)
python3 scripts/book.py "$book"
rm -rf "$book/html"
"$mdbook" build "$book" --dest-dir "$book/html"
# Links and headings are checked in the pages (doc-links.py); what a page of the book loads must come with it.
if grep -rnE --include='*.html' '<(script|img|link)[^>]* (src|href)="([a-z]+:)?//' "$book/html"; then
    echo "book: a page wants something of a network" >&2
    exit 1
fi
