"""protocol/vectors/*.tsv in, named cases out."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).resolve().parents[2] / "vectors"


class Valid(NamedTuple):
    """A row of valid.tsv."""

    name: str
    use: str
    direction: str
    type: str
    header: str
    fields: str
    wire: str


class Invalid(NamedTuple):
    """A row of invalid.tsv."""

    name: str
    role: str
    session: str
    wire: str
    verdicts: str
    error: str
    nack: str


def _rows(name: str) -> list[list[str]]:
    lines = (FOLDER / name).read_text(encoding="ascii").splitlines()
    return [line.split("\t") for line in lines if not line.startswith("#")]


VALID = [Valid(*row) for row in _rows("valid.tsv")]
INVALID = [Invalid(*row) for row in _rows("invalid.tsv")]
CLIENTS = [Valid(*row) for row in _rows("clients.tsv")]
BAD_CLIENTS = [Invalid(*row) for row in _rows("clients-invalid.tsv")]


def words(text: str) -> dict[str, str]:
    """``name=value name=value`` as a dictionary."""
    return {} if text == "-" else dict(word.split("=", 1) for word in text.split(" "))
