"""A call of the library: its context, progress, cancellation and errors; and handles.

The GIL is released during a call. The library calls back repeatedly to ask whether to continue; this is where progress
is shown, and where Ctrl-C or an exception raised by the progress function ends the call.
"""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Callable, Optional, Union

from ._arguments import expects, one_of
from ._library import ffi, lib
from .errors import error_of

log = logging.getLogger("ffprocams")
log.addHandler(logging.NullHandler())

_INTERVAL = 0.1  # seconds between two checks for progress and Ctrl-C
_LEVELS = {lib.FFP_LOG_NOTE: logging.INFO, lib.FFP_LOG_WARNING: logging.WARNING}
_DEVICES = {"cpu": lib.FFP_DEVICE_CPU, "cuda": lib.FFP_DEVICE_CUDA}


@dataclass(frozen=True)
class Progress:
    """How far a call has got."""

    stage: str  #: such as "rendering"
    done: int  #: pictures, steps, scenes or seconds of the stage
    total: int
    elapsed_s: float  #: since the stage began
    left_s: float  #: estimate; negative: not known yet
    extra: str  #: a few words about the last step, or ""


#: The ``progress`` argument of calls: a function that receives reports and ends the call by returning False; True: a
#: tqdm bar; False: nothing; None: a bar if tqdm is installed and the output is a terminal or a notebook.
ProgressOption = Union[Callable[[Progress], Optional[bool]], bool, None]


class _Bar:
    """Stages as tqdm bars, one after the other."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm, self._bar, self._stage = tqdm, None, ("", 0)

    def __call__(self, now: Progress) -> None:
        if (now.stage, now.total) != self._stage:
            self.close()
            self._stage = (now.stage, now.total)
            self._bar = self._tqdm(total=now.total, desc=now.stage, leave=False, delay=0.5)
        bar: Any = self._bar
        bar.set_postfix_str(now.extra, refresh=False)
        bar.update(now.done - bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def _bar_for(progress: bool | None) -> _Bar | None:
    watched = "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())
    if progress is False or (progress is None and not watched):
        return None
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    return _Bar(tqdm)


class Call:
    """A call in progress. Pass ``context`` and ``error`` to the library, and its result to ``check``."""

    def __init__(self, progress: ProgressOption = False, threads: int = 0, device: str = "cpu") -> None:
        self._listener = progress if callable(progress) else _bar_for(progress)
        self._raised: BaseException | None = None
        self.inside = False  # in the progress function
        settings = ffi.new("FfpContextSettings *", lib.ffp_context_defaults())
        kind = one_of(_DEVICES, device, "device")
        expects(0 <= threads <= 4096, "threads", "0 to 4096", threads)
        settings.log, settings.progress = lib.ffp_python_log, lib.ffp_python_progress
        settings.interval_s, settings.threads, settings.device = _INTERVAL, threads, kind
        self.error = ffi.new("FfpError *")
        context = lib.ffp_context_new(settings, self.error)
        if context == ffi.NULL:
            raise error_of(self.error)
        self.context = ffi.gc(context, lib.ffp_context_free)

    def tell(self, progress: Any) -> bool:
        """Called by the progress callback: False ends the call."""
        if self._raised is not None:
            return False
        if self._listener is None or progress.stage == ffi.NULL:
            return True
        now = Progress(
            _text(progress.stage),
            progress.done,
            progress.total,
            progress.elapsed_s,
            progress.left_s,
            _text(progress.extra),
        )
        self.inside = True
        try:
            return self._listener(now) is not False
        finally:
            self.inside = False

    def keep(self, raised: BaseException) -> None:
        """Stores an exception raised by a callback: it ends the call, and is raised again after the call."""
        if self._raised is None:
            self._raised = raised

    def check(self, result: Any) -> Any:
        """The call's result, or the exception for it."""
        if self._raised is not None:
            raised, self._raised = self._raised, None
            raise raised
        failed = (
            result is False
            or (isinstance(result, int) and result < 0)
            or (isinstance(result, ffi.CData) and result == ffi.NULL)
        )
        if failed:
            raise error_of(self.error)
        return result

    def take(self, result: Any, close: Callable[[Any], None]) -> Any:
        """Like check, for a call that creates an object, which is closed when nothing refers to it any more."""
        if isinstance(result, ffi.CData) and result != ffi.NULL:
            result = ffi.gc(result, close)
        return self.check(result)

    def __enter__(self) -> Call:
        outer = getattr(_at_work, "call", None)
        if outer is not None and outer.inside:
            raise RuntimeError("a progress function must not call the library")
        self._outer = outer
        _at_work.call = self
        return self

    def __exit__(
        self, kind: type[BaseException] | None, raised: BaseException | None, trace: TracebackType | None
    ) -> None:
        _at_work.call = self._outer
        if isinstance(self._listener, _Bar):
            self._listener.close()


_at_work = threading.local()  # .call: the thread's call


def _text(characters: Any) -> str:
    return "" if characters == ffi.NULL else ffi.string(characters).decode("utf-8", "replace")


def _raised_in_callback(kind: Any, raised: BaseException, trace: Any) -> None:
    call = getattr(_at_work, "call", None)
    if call is not None:
        call.keep(raised)
    else:  # raised by a log handler, in one of the library's own threads
        log.debug("a log handler failed", exc_info=raised)


@ffi.def_extern(name="ffp_python_log", onerror=_raised_in_callback)  # type: ignore[untyped-decorator]
def _on_log(user: Any, level: int, text: Any) -> None:
    log.log(_LEVELS.get(level, logging.INFO), "%s", _text(text))


@ffi.def_extern(name="ffp_python_progress", error=False, onerror=_raised_in_callback)  # type: ignore[untyped-decorator]
def _on_progress(user: Any, progress: Any) -> bool:
    call: Call = _at_work.call
    return call.tell(progress)


class Handle:
    """An object of the library, closed when nothing refers to it any more. It serves one thread at a time."""

    def __init__(self, pointer: Any) -> None:
        self._pointer = pointer
        self._lock = threading.RLock()

    def __reduce__(self) -> Any:
        raise TypeError(f"{type(self).__name__} cannot be pickled: save it to a file")


@contextlib.contextmanager
def holding(*handles: Handle | None) -> Iterator[None]:
    """Locks the handles against other threads, in an order that cannot deadlock."""
    with contextlib.ExitStack() as stack:
        for handle in sorted((h for h in handles if h is not None), key=id):
            stack.enter_context(handle._lock)
        yield


PathLike = Union[str, "os.PathLike[str]"]


def path_of(path: PathLike) -> bytes:
    """A path in the library's encoding."""
    return os.fsencode(path)


class Keep:
    """C strings and arrays that must live until a call has returned."""

    def __init__(self) -> None:
        self.all: list[Any] = []

    def __call__(self, thing: Any) -> Any:
        self.all.append(thing)
        return thing

    def text(self, text: str | bytes | None) -> Any:
        if text is None:
            return ffi.NULL
        return self(ffi.new("char[]", text.encode() if isinstance(text, str) else text))

    def path(self, path: PathLike | None) -> Any:
        return ffi.NULL if path is None else self.text(path_of(path))

    def contents(self, data: bytes) -> Any:
        """FfpBytes of them."""
        view = self(ffi.from_buffer(data))
        return self(ffi.new("FfpBytes *", {"data": view, "size": len(view)}))

    def texts(self, texts: list[Any]) -> Any:
        """char *[], or NULL for none."""
        return self(ffi.new("char *[]", texts)) if texts else ffi.NULL


def some(names: Any) -> list[Any]:
    """One or several names, as a list."""
    return [names] if isinstance(names, (str, os.PathLike)) else list(names)
