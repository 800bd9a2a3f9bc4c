"""SAMPLES in, rows lost before each batch out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from ..messages import Samples

_MASK = 0xFFFFFFFF


@dataclass(frozen=True)
class Loss:
    """What is missing before a batch."""

    rows: int = 0
    """Rows missing according to the row numbers."""
    dropped_by_mcu: int = 0
    """Of these, rows the MCU says it dropped; the others were lost on the wire."""
    restarted: bool = False
    """The row numbers went back: nothing can be said about loss."""

    @property
    def is_contiguous(self) -> bool:
        """Whether the batch continues the one before."""
        return self.rows == 0 and not self.restarted


@dataclass
class LossCount:
    """Sums since the link opened."""

    received: int = 0
    lost: int = 0
    dropped_by_mcu: int = 0
    restarts: int = 0


class RowCount:
    """Follows the row numbers of one boot."""

    def __init__(self) -> None:
        self.count = LossCount()
        self._next: Optional[tuple[int, int]] = None

    def restart(self) -> None:
        """Takes the next batch as the first of its kind."""
        self._next = None

    def take(self, samples: Samples) -> Loss:
        """Counts a batch and says what is missing before it."""
        loss = Loss()
        if self._next is not None:
            expected, dropped = self._next
            missing = (samples.first_index - expected) & _MASK
            restarted = missing > _MASK // 2
            rows = 0 if restarted else missing
            loss = Loss(rows, min((samples.dropped_total - dropped) & _MASK, rows), restarted)
        self._next = ((samples.first_index + len(samples)) & _MASK, samples.dropped_total)
        self.count.received += len(samples)
        self.count.lost += loss.rows
        self.count.dropped_by_mcu += loss.dropped_by_mcu
        self.count.restarts += loss.restarted
        return loss
