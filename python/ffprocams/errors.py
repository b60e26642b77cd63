"""Errors of the library, as exceptions."""

from __future__ import annotations

import errno
import os
from enum import IntEnum
from typing import Any

from ._library import ffi, lib


class ErrorCode(IntEnum):
    """The kind of error (FfpErrorCode of the library)."""

    ARGUMENT = lib.FFP_ERROR_ARGUMENT
    FILE = lib.FFP_ERROR_FILE
    UNSUPPORTED = lib.FFP_ERROR_UNSUPPORTED
    MEMORY = lib.FFP_ERROR_MEMORY
    CANCELLED = lib.FFP_ERROR_CANCELLED
    IO = lib.FFP_ERROR_IO
    FAULT = lib.FFP_ERROR_FAULT


class Error(Exception):
    """An error of the library. ``str(error)`` is its message, "WHAT (WHERE)".

    Attributes:
        code: the kind of error.
        what: the message without the place.
        file: the file concerned, or None.
        field: the field of that file, or the argument concerned, or None.
        finding: the code of the finding that it tells of ("pattern-mirrored"), or None.
    """

    code: ErrorCode
    what: str
    file: str | None
    field: str | None
    finding: str | None = None

    def __str__(self) -> str:
        return str(self.args[0])

    def __init__(self, text: str, code: ErrorCode, where: str = "") -> None:
        super().__init__(text)
        self.code = code
        self.what = text.removesuffix(f" ({where})")
        self.file, self.field = _place(where, code)


class ArgumentError(Error, ValueError):
    """An error by the caller: a value out of range, an unknown name."""


class ArgumentTypeError(ArgumentError, TypeError):
    """An argument of another type than its function expects."""


class FileFormatError(Error, ValueError):
    """An input file has invalid or missing content."""


class UnsupportedError(Error):
    """The input is valid, but not supported by this library, build or machine."""


class OutOfMemoryError(Error, MemoryError):
    """There is not enough memory."""


class CancelledError(Error):
    """The progress function ended the call."""


class InputOutputError(Error, OSError):
    """The system could not open, read, write or rename a file."""


class MissingFileError(InputOutputError, FileNotFoundError):
    """A file or folder does not exist."""

    def __init__(self, text: str, code: ErrorCode, where: str = "") -> None:
        super().__init__(text, code, where)
        self.errno, self.filename, self.strerror = errno.ENOENT, self.file, self.what


class FaultError(Error, ValueError):
    """A mistake found in a capture; ``force=True`` goes on."""


_CLASSES: dict[ErrorCode, type[Error]] = {
    ErrorCode.ARGUMENT: ArgumentError,
    ErrorCode.FILE: FileFormatError,
    ErrorCode.UNSUPPORTED: UnsupportedError,
    ErrorCode.MEMORY: OutOfMemoryError,
    ErrorCode.CANCELLED: CancelledError,
    ErrorCode.IO: InputOutputError,
    ErrorCode.FAULT: FaultError,
}


def argument_error(what: str, where: str = "") -> ArgumentError:
    """An error found by the Python package itself."""
    return ArgumentError(f"{what} ({where})" if where else what, ErrorCode.ARGUMENT, where)


def error_of(err: Any) -> Error:
    """The exception for an FfpError."""
    try:
        code = ErrorCode(err.code)
    except ValueError:
        code = ErrorCode.UNSUPPORTED
    text, where = (ffi.string(part).decode("utf-8", "replace") for part in (err.text, err.where))
    error = _CLASSES[code](text, code, where)
    missing = error.what.endswith((os.strerror(errno.ENOENT), "no such file or folder"))
    if missing and code in (ErrorCode.IO, ErrorCode.FILE):
        return MissingFileError(text, ErrorCode.IO, where)
    error.finding = ffi.string(err.finding).decode() if err.finding else None
    return error


def _place(where: str, code: ErrorCode) -> tuple[str | None, str | None]:
    """WHERE as file and field."""
    if not where:
        return None, None
    file, colon, field = where.partition(": ")
    if colon and (os.sep in file or os.path.lexists(file) or "." in file):
        return file, field
    if code in (ErrorCode.FILE, ErrorCode.IO) or os.sep in where or os.path.lexists(where):
        return where, None
    return None, where
