"""Checks of what is passed to public functions, by their annotations."""

from __future__ import annotations

import ast
import functools
import inspect
import math
import numbers
import os
import reprlib
from collections.abc import Mapping
from typing import Any, Callable, NamedTuple, TypeVar

import numpy as np

from .errors import ArgumentError, ArgumentTypeError, ErrorCode

Seed = int  #: An integer of up to 63 bits; others have 31.
_Public = TypeVar("_Public", bound=Callable[..., Any])


def expects(fits: bool, name: str, what: str, given: object, kind: type[ArgumentError] = ArgumentError) -> None:
    """Raises an error that names the argument, what is expected and what was given, unless that fits."""
    if not fits:
        given = given.item() if isinstance(given, np.generic) else given
        told = reprlib.repr(given) if type(given).__module__ == "builtins" else type(given).__name__
        raise kind(f"expected {what}, not {told} ({name})", ErrorCode.ARGUMENT, name)


def one_of(table: Mapping[str, int], name: str, what: str) -> int:
    """The value that a name stands for."""
    expects(name in table, what, f"one of {', '.join(table)}", name)
    return table[name]


class _Kind(NamedTuple):
    """The values that an annotation allows."""

    one: str
    several: str
    fits: Callable[[Any], bool]


def _is_text(given: Any) -> bool:
    return isinstance(given, str) and "\0" not in given


def _is_path(given: Any) -> bool:
    return isinstance(given, (str, os.PathLike)) and _is_text(os.fspath(given))


def _is_integer(given: Any, bits: int = 31) -> bool:
    return isinstance(given, numbers.Integral) and not isinstance(given, bool) and -(2**bits) <= given < 2**bits


def _is_number(given: Any) -> bool:
    try:
        return isinstance(given, numbers.Real) and not isinstance(given, bool) and math.isfinite(given)
    except OverflowError:  # an integer that no float reaches
        return False


def _is_array(given: Any, least_dimensions: int = 1) -> bool:
    try:
        array = np.asarray(given)
    except (TypeError, ValueError, RuntimeError):  # ragged; a tensor on a GPU or with a gradient
        return False
    return array.dtype.kind in "biuf" and array.ndim >= (array.dtype.kind == "b" or least_dimensions)


def _is_dtype(given: Any) -> bool:
    try:
        return np.dtype(given).kind in "biuf"
    except TypeError:
        return False


def _is_several(given: Any) -> bool:
    return hasattr(given, "__iter__") and getattr(given, "ndim", 1) > 0 and not isinstance(given, (str, bytes, Mapping))


_ARRAY = _Kind("an array of numbers", "arrays of numbers", _is_array)
_NUMBERS = _Kind("numbers", "numbers", lambda given: _is_array(given, 0))
_KINDS = {
    "None": _Kind("None", "None", lambda given: given is None),
    "bool": _Kind("True or False", "booleans", lambda given: isinstance(given, (bool, np.bool_))),
    "int": _Kind("an integer", "integers", _is_integer),
    "Seed": _Kind("an integer", "integers", lambda given: _is_integer(given, 63)),
    "float": _Kind("a finite number", "finite numbers", _is_number),
    "str": _Kind("a string", "strings", _is_text),
    "bytes": _Kind("bytes", "bytes", lambda given: isinstance(given, (bytes, bytearray, memoryview))),
    "slice": _Kind("a slice", "slices", lambda given: isinstance(given, slice)),
    "PathLike": _Kind("a path", "paths", _is_path),
    "Callable": _Kind("a function", "functions", callable),
    "Predictor": _Kind("a function", "functions", callable),
    "Any": _Kind("anything", "anything", lambda given: True),
    "Array": _ARRAY,
    "Floats": _ARRAY,
    "Doubles": _ARRAY,
    "npt.ArrayLike": _NUMBERS,
    "npt.DTypeLike": _Kind("a type of numbers", "types of numbers", _is_dtype),
}
_ALIASES = {
    "ProgressOption": "Callable | bool | None",
    "ModelOption": "Model | PathLike | None",
    "CalibrationOption": "PathLike | Calibration | Mapping[str, Any]",
    "AnyDevices": "Devices | Sequence[Pinhole] | Pinhole",
}


def _class(name: str) -> _Kind:
    """One of the package's types, which this module cannot import."""
    article = "" if name.endswith("s") else "an " if name[0] in "AEIOU" else "a "
    plural = name if name.endswith("s") else name + "s"
    return _Kind(article + name, plural, lambda given: any(c.__name__ == name for c in type(given).__mro__))


def _container(outer: str, inner: list[list[_Kind]]) -> _Kind:
    item = inner[-1]
    several = _told([kind.several for kind in item])

    def fit(items: Any) -> bool:
        return all(any(kind.fits(i) for kind in item) for i in items)

    if outer == "Mapping":
        what = f"{_told([kind.several for kind in inner[0]])} to {several}"
        return _Kind(
            f"a mapping of {what}", f"mappings of {what}",
            lambda given: isinstance(given, Mapping) and all(map(_is_text, given)) and fit(given.values()),
        )  # fmt: skip
    if outer == "tuple":
        return _Kind(
            f"{len(inner)} {several}", f"{len(inner)} {several} each",
            lambda given: _is_several(given) and hasattr(given, "__len__") and len(given) == len(inner) and fit(given),
        )  # fmt: skip
    if outer == "Iterable":  # which may be read only once
        return _Kind(f"several {several}", f"several {several} each", _is_several)
    return _Kind(
        f"a sequence of {several}", f"sequences of {several}",
        lambda given: _is_several(given) and hasattr(given, "__len__") and fit(given),
    )  # fmt: skip


def _kinds(node: ast.expr) -> list[_Kind]:
    """The alternatives of an annotation."""
    if isinstance(node, ast.BinOp):
        return _kinds(node.left) + _kinds(node.right)
    if isinstance(node, ast.Subscript) and ast.unparse(node.value) != "Callable":
        inner = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return [_container(ast.unparse(node.value), [_kinds(n) for n in inner])]
    name = ast.unparse(node).partition("[")[0]
    if name in _ALIASES:
        return _kinds(ast.parse(_ALIASES[name], mode="eval").body)
    return [_KINDS[name] if name in _KINDS else _class(name)]


def _told(names: list[str]) -> str:
    return " or ".join((", ".join(names[:-1]), names[-1]) if names[1:] else names)


def _checked_function(function: Callable[..., Any]) -> Callable[..., Any]:
    signature = inspect.signature(function)
    kinds = {
        p.name: _kinds(ast.parse(p.annotation, mode="eval").body)
        for p in signature.parameters.values()
        if isinstance(p.annotation, str) and p.kind != p.VAR_POSITIONAL
    }

    @functools.wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        for name, given in signature.bind(*args, **named).arguments.items():
            if name in kinds:
                fits = any(kind.fits(given) for kind in kinds[name])
                expects(fits, name, _told([kind.one for kind in kinds[name]]), given, ArgumentTypeError)
        return function(*args, **named)

    return call


def checked(public: _Public) -> _Public:
    """A function, or a class with its public methods, that refuses arguments of other types than its annotations."""
    if not inspect.isclass(public):
        return _checked_function(public)  # type: ignore[return-value]
    for name, member in list(vars(public).items()):
        if name.startswith("_") and name not in ("__init__", "__getitem__"):
            continue
        if isinstance(member, classmethod):
            setattr(public, name, classmethod(_checked_function(member.__func__)))
        elif inspect.isfunction(member):
            setattr(public, name, _checked_function(member))
    return public
