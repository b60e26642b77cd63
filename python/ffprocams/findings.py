"""Faults found in a capture, as values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ._library import ffi, lib

_SEVERITIES = {
    lib.FFP_FINDING_OK: "ok",
    lib.FFP_FINDING_NOTE: "note",
    lib.FFP_FINDING_DOUBT: "doubt",
    lib.FFP_FINDING_FAULT: "fault",
}


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: what was seen, in which view, and what to do about it."""

    code: str  #: tells findings apart, such as "pattern-mirrored"; docs/guide/troubleshooting.md lists them
    severity: str  #: "ok", "note", "doubt" or "fault": such a capture is refused, unless force is given
    subject: str  #: what was looked at, such as "silhouettes"
    text: str  #: what was seen
    advice: str | None  #: what to do
    view: str | None  #: ids of the views it is about
    other: str | None
    figure: float | None  #: what was measured
    limit: float | None  #: where doubts begin
    setting: str | None  #: argument that may help, such as "force"


def finding_of(c: Any) -> Finding:
    """From an FfpFinding."""

    def text(name: str) -> Any:
        value = getattr(c, name)
        return None if value == ffi.NULL else ffi.string(value).decode("utf-8", "replace")

    def number(value: float) -> float | None:
        return None if math.isnan(value) else value

    texts = {name: text(name) for name in ("code", "subject", "text", "advice", "view", "other", "setting")}
    return Finding(severity=_SEVERITIES[c.severity], figure=number(c.figure), limit=number(c.limit), **texts)
