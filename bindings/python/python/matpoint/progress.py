"""A progress bar for terminals and notebooks."""

from __future__ import annotations

import math
import sys
import time
from typing import Protocol

_WIDTH = 30
_SECONDS_BETWEEN = 0.1


class Bar(Protocol):
    """What `Simulation.run` shows its progress with."""

    def show(self, now: float, substeps: int) -> None:
        """Shows a time [s] and the substeps taken."""

    def close(self) -> None:
        """Wipes the line."""


class _Hidden:
    def show(self, now: float, substeps: int) -> None:
        pass

    def close(self) -> None:
        pass


class _Line:
    def __init__(self, start: float, until: float, particles: int) -> None:
        self.start, self.until, self.particles = start, until, particles
        self.began = self.shown = time.monotonic()
        self.length = 0

    def show(self, now: float, substeps: int) -> None:
        clock = time.monotonic()
        if clock - self.shown < _SECONDS_BETWEEN:
            return
        self.shown = clock
        elapsed = clock - self.began
        share = (now - self.start) / (self.until - self.start) if math.isfinite(self.until) else 0.0
        left = f"{math.ceil(elapsed / share - elapsed)} s left" if share > 0.0 else ""
        rate = 1e-6 * substeps * self.particles / elapsed
        filled = round(share * _WIDTH)
        self._write(
            f"{'█' * filled}{'░' * (_WIDTH - filled)} {share:4.0%}  t = {now:.4g} / {self.until:.4g} s  "
            f"{rate:.3g} million particle-steps/s  {left}"
        )

    def close(self) -> None:
        if self.length > 0:
            self._write("")
            sys.stderr.write("\r")
            sys.stderr.flush()

    def _write(self, text: str) -> None:
        sys.stderr.write("\r" + text.ljust(self.length))
        sys.stderr.flush()
        self.length = len(text)


def bar(start: float, until: float, particles: int) -> Bar:
    """A bar on stderr where somebody sees it, else one that does nothing."""
    stream = sys.stderr
    seen = stream is not None and (stream.isatty() or type(stream).__module__.startswith("ipykernel"))
    return _Line(start, until, particles) if seen else _Hidden()
