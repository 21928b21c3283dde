"""Progress and counts of a run: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

SECONDS_BETWEEN_LINES = 5.0
SECONDS_BETWEEN_BARS = 0.2
WIDTH = 30


@dataclass
class Counts:
    """Shards by what has become of them."""

    total: int
    stored: int = 0
    """Found in the store."""
    computed: int = 0
    wrong: int = 0
    """Stored or computed, with a claim that does not hold."""
    failed: int = 0
    """Not computed."""
    workers: int = 0

    @property
    def done(self) -> int:
        """The shards that nothing is left to do for."""
        return self.stored + self.computed + self.failed

    def text(self) -> str:
        """The counts in words."""
        return (
            f"{self.done} of {self.total} shards: {self.computed} computed, {self.stored} from the store, "
            f"{self.wrong} wrong, {self.failed} failed; {self.workers} workers"
        )


class Progress:
    """Shows counts on standard error."""

    def __init__(self, counts: Counts) -> None:
        """Shows these counts, which the owner changes."""
        self.counts = counts
        self._is_terminal = sys.stderr.isatty()
        self._begin = time.monotonic()
        self._last = self._begin if not self._is_terminal else 0.0
        self._last_text = ""

    def is_due(self) -> bool:
        """Whether enough time has passed to show the counts again."""
        wait = SECONDS_BETWEEN_BARS if self._is_terminal else SECONDS_BETWEEN_LINES
        return time.monotonic() - self._last >= wait

    def show(self, is_last: bool = False) -> None:
        """Shows the counts."""
        now = time.monotonic()
        self._last = now
        text = self.counts.text() + self._pace(now)
        if self._is_terminal:
            filled = WIDTH * self.counts.done // max(1, self.counts.total)
            end = "\n" if is_last else ""
            print(f"\r\x1b[K{'#' * filled}{'-' * (WIDTH - filled)} {text}", end=end, file=sys.stderr, flush=True)
        elif text != self._last_text:
            print(text, file=sys.stderr, flush=True)
        self._last_text = text

    def say(self, message: str) -> None:
        """Prints a message above the bar."""
        print(("\r\x1b[K" if self._is_terminal else "") + message, file=sys.stderr, flush=True)

    def _pace(self, now: float) -> str:
        left = self.counts.total - self.counts.done
        if self.counts.computed == 0 or left == 0:
            return ""
        seconds = left * (now - self._begin) / self.counts.computed
        return f"; {seconds:.0f} s left"
