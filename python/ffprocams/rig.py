"""Your own rig: what its projector shows, its calibration, and a network trained for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ._call import Call, Keep, PathLike, ProgressOption, some
from ._library import ffi, lib
from .capture import record
from .errors import argument_error

_TERMS = {
    "k1": lib.FFP_FIX_K1,
    "k2": lib.FFP_FIX_K2,
    "k3": lib.FFP_FIX_K3,
    "tangential": lib.FFP_FIX_TANGENTIAL,
    "centre": lib.FFP_FIX_CENTRE,
    "aspect": lib.FFP_FIX_ASPECT,
}


def write_patterns(
    folder: PathLike,
    width: int,
    height: int,
    *,
    lollipops: int | None = None,
    focus: bool = True,
    capture: bool = True,
    gray_codes: bool = True,
) -> list[Path]:
    """Writes what a projector shows while it is photographed, with a text that says how and a page that shows it.

    Args:
        folder: must be new or empty.
        width, height: of the projector's panel, pixels.
        lollipops: how many of these patterns; None: the program's.
        focus: a chart to focus and to place the object by.
        capture: black, white and the lollipops.
        gray_codes: of columns and rows, each with its inverse.

    Returns:
        The pictures in the order to show them.
    """
    keep, options = Keep(), ffi.new("FfpPatterns *", lib.ffp_patterns_defaults())
    options.folder, options.width, options.height = keep.path(folder), width, height
    options.focus, options.capture, options.gray_codes = focus, capture, gray_codes
    if lollipops is not None:
        options.lollipops = lollipops
    with Call() as call:
        if lib.ffp_write_patterns(call.context, options, call.error) < 0:
            call.check(False)
    return sorted(Path(folder).glob("*.png"))


@dataclass
class RigCalibrationStats:
    """What calibrate_rig found. Pixels are root mean squares."""

    attitudes: int = 0  #: of the board
    used: int = 0
    camera: float = 0.0  #: pixels, of its fit alone
    projector: float = 0.0
    both: float = 0.0  #: pixels, of all corners in both, with one pose of the board for both
    corners: int = 0  #: of the attitudes used
    left_out: int = 0
    open_terms: int = 0  #: that the photographs do not determine; warnings name them
    has_axis: bool = False  #: and so on: of the turntable
    axis: tuple[float, ...] = ()  #: camera coordinates; points up in the picture
    point: tuple[float, ...] = ()
    reversed: bool = False  #: the angles are left-handed about it: clockwise as seen from above
    stops: int = 0
    stops_used: int = 0
    stops_rms: float = 0.0
    tilt: float = 0.0  #: standard deviation, degrees
    shift: float = 0.0  #: the square's unit


def calibrate_rig(
    file: PathLike | None,
    attitudes: PathLike | Sequence[PathLike] = (),
    *,
    board: tuple[int, int],
    square: float,
    projector: tuple[int, int] | None = None,
    shown: PathLike | None = None,
    fix_camera: Sequence[str] = (),
    fix_projector: Sequence[str] = (),
    report: PathLike | None = None,
    turntable_board: PathLike | None = None,
    angles: Sequence[float] = (),
    turntable_file: PathLike | None = None,
    calibrations: PathLike | Sequence[PathLike] = (),
    progress: ProgressOption = None,
    threads: int = 0,
) -> RigCalibrationStats:
    """Calibrates camera and projector from photographs of a chessboard under Gray codes in at least three attitudes,
    and finds a turntable's axis. Nothing is written before all is found.

    Args:
        file: for the calibration, OpenCV's FileStorage (.xml, .yml); None: only the turntable's board is looked at.
        attitudes: folders of one attitude of the board each, or of such folders (docs/guide/own-rig.md).
        board: corners inside it, columns and rows.
        square: side of a square: the unit of length of all that comes out.
        projector: width and height of its panel, pixels; None: those of ``shown``, or 1920 x 1080.
        shown: folder of write_patterns; the folders may then hold a photograph of each of its patterns.
        fix_camera, fix_projector: terms that are not fitted: "k1", "k2", "k3", "tangential", "centre", "aspect".
        report: file for an HTML page.
        turntable_board: folder of photographs of a chessboard on the table, in the order of ``angles``.
        angles: degrees by which the table had turned.
        turntable_file: for the axis, as import_capture reads it (Turntable.file, beside the object's angles).
        calibrations: without attitudes: files that hold the camera's calibration.
        progress: see ffprocams.ProgressOption.
        threads: that may work at a time; 0: all processors.

    Raises:
        UnsupportedError: the library was built without OpenCV.
    """
    keep, options = Keep(), ffi.new("FfpRigCalibration *", lib.ffp_rig_calibration_defaults())
    for name, given in (("attitudes", attitudes), ("calibrations", calibrations)):
        paths = [keep.path(p) for p in some(given)]
        setattr(options, name, keep.texts(paths))
        setattr(options, f"n_{name}", len(paths))
    options.columns, options.rows = board
    options.square, options.shown = square, keep.path(shown)
    if projector is not None:
        options.width, options.height = projector
    options.fix_camera, options.fix_projector = (
        _terms(fix_camera, "fix_camera"),
        _terms(fix_projector, "fix_projector"),
    )
    options.file, options.report = keep.path(file), keep.path(report)
    options.turntable_board, options.turntable_file = keep.path(turntable_board), keep.path(turntable_file)
    options.angles, options.n_angles = keep(ffi.new("double[]", [float(a) for a in angles])), len(angles)
    stats = ffi.new("FfpRigCalibrationStats *")
    with Call(progress, threads) as call:
        call.check(lib.ffp_calibrate_rig(call.context, options, stats, call.error))
    out: RigCalibrationStats = record(RigCalibrationStats, stats)
    return out


def _terms(names: Sequence[str], what: str) -> int:
    for name in names:
        if name not in _TERMS:
            raise argument_error(f"'{name}' is none of {', '.join(_TERMS)}", what)
    return sum(_TERMS[name] for name in set(names))


def train(
    out: PathLike,
    *,
    captures: PathLike | None = None,
    config: PathLike | None = None,
    initial: PathLike | None = None,
    perceptual: PathLike | None = None,
    steps: int = -1,
    stop_at: int = 0,
    resume: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Path:
    """Trains a network to the end; cancelled, it writes a checkpoint first and returns.

    Args:
        out: folder for checkpoint.safetensors, weights.safetensors, metrics.jsonl and pictures.
        captures: folder of your own captures, for fine-tuning on their photographs (docs/lab/training.md).
            Every fourth is held out and chooses the weights that are written. None: scenes are generated or read.
        config: JSON file; None: the defaults.
        initial: weights to start from; None: with captures the shipped ones, otherwise none.
        perceptual: safetensors of the perceptual term; None: without it.
        steps: -1: as the configuration says.
        stop_at: stop at this step with a checkpoint; 0: go to the end.
        resume: go on from the checkpoint in ``out``.
        progress: see ffprocams.ProgressOption.
        threads: that may work at a time; 0: all processors.
        device: "cpu" or "cuda".

    Returns:
        The file of the weights.
    """
    keep, options = Keep(), ffi.new("FfpTraining *", lib.ffp_training_defaults())
    options.out, options.captures, options.config = keep.path(out), keep.path(captures), keep.path(config)
    options.initial, options.perceptual = keep.path(initial), keep.path(perceptual)
    options.steps, options.stop_at, options.resume = steps, stop_at, resume
    with Call(progress, threads, device) as call:
        call.check(lib.ffp_train_model(call.context, options, call.error))
    return Path(out) / "weights.safetensors"
