"""protocol/vectors/*.tsv in, named cases out."""

from __future__ import annotations

from collections import namedtuple
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "vectors"


Valid = namedtuple("Valid", "name use direction type header fields wire")
Invalid = namedtuple("Invalid", "name role session wire verdicts error nack")


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
