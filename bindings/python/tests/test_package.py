"""Every name has a docstring, every stub a counterpart, and the version is one."""

from __future__ import annotations

import re
from pathlib import Path

import slipgrip

HERE = Path(__file__).resolve().parents[1]


def test_every_public_name_is_explained() -> None:
    for name in slipgrip.__all__:
        item = getattr(slipgrip, name)
        assert item.__doc__, name
        if isinstance(item, type) and item.__module__ == "slipgrip":
            for part in vars(item):
                if not part.startswith("_"):
                    assert getattr(item, part).__doc__, f"{name}.{part}"


def test_the_stubs_name_what_there_is() -> None:
    text = (Path(slipgrip.__file__).parent / "_core.pyi").read_text()
    for name in re.findall(r"^(?:class|def) (\w+)", text, re.M):
        assert hasattr(slipgrip, name), name
    for name, body in re.findall(r"^class (\w+):\n((?:    .*\n|\n)+)", text, re.M):
        item = getattr(slipgrip, name)
        stubbed = {part for part in re.findall(r"    def (\w+)\(", body) if not part.startswith("_")}
        assert stubbed == {part for part in vars(item) if not part.startswith("_")}, name


def test_shared_crates_have_the_versions_of_the_main_workspace() -> None:
    def versions(lock: Path) -> "dict[str, set[str]]":
        found: "dict[str, set[str]]" = {}
        for name, version in re.findall(r'^name = "(.+)"\nversion = "(.+)"', lock.read_text(), re.M):
            found.setdefault(name, set()).add(version)
        return found

    here, root = versions(HERE / "Cargo.lock"), versions(HERE.parents[1] / "Cargo.lock")
    other = {name: here[name] - root[name] for name in here if name in root and here[name] - root[name]}
    assert not other, f"copy Cargo.lock of the main workspace here and build: {other}"


def test_versions_agree() -> None:
    for file in ("pyproject.toml", "Cargo.toml"):
        found = re.search(r'^version = "(.+)"', (HERE / file).read_text(), re.M)
        assert found and found[1] == slipgrip.__version__, file
