"""Shows the progress of long work with tqdm, or as a line on standard error."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

# Time between two lines, in s.
_PERIOD_S = 0.2


class Progress:
    """A context in which :meth:`tell` shows the progress, if wanted."""

    def __init__(self, what: str, is_shown: bool) -> None:
        self._what = what
        self._bar: Any = None
        self._is_shown = is_shown
        self._written_s = 0.0
        self._width = 0

    def __enter__(self) -> Progress:
        if self._is_shown:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                return self
            self._bar = tqdm(unit=f" {self._what}")
        return self

    def tell(self, done: int, all: int) -> None:
        """Shows that ``done`` of ``all`` items are done."""
        if self._bar is not None:
            self._bar.total = all
            self._bar.update(done - self._bar.n)
        elif self._is_shown and (done == all or time.monotonic() - self._written_s >= _PERIOD_S):
            self._written_s = time.monotonic()
            line = f"{done} of {all} {self._what}"
            self._width = max(self._width, len(line))
            print(f"\r{line:<{self._width}}", end="", file=sys.stderr, flush=True)

    def tell_of(self, what: str, done: int, all: int) -> None:
        """Shows that ``done`` of ``all`` items of another kind are done; 0 of ``all`` if their number is unknown."""
        if what != self._what:
            self._what = what
            if self._bar is not None:
                self._bar.reset(all or None)
                self._bar.unit = f" {what}"
        self.tell(done, all or max(done, 1))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, place: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.close()
        elif self._width:
            print(file=sys.stderr)
