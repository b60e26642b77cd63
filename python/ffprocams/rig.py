"""Your own rig: patterns for its projector, its calibration, and a network trained for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ._arguments import checked, one_of
from ._call import Call, Keep, PathLike, ProgressOption, some
from ._library import ffi, lib
from .capture import record

_TERMS = {
    "k1": lib.FFP_FIX_K1,
    "k2": lib.FFP_FIX_K2,
    "k3": lib.FFP_FIX_K3,
    "tangential": lib.FFP_FIX_TANGENTIAL,
    "centre": lib.FFP_FIX_CENTRE,
    "aspect": lib.FFP_FIX_ASPECT,
}


@checked
def write_patterns(
    folder: PathLike,
    width: int = 1920,
    height: int = 1080,
    *,
    calibrations: PathLike | Sequence[PathLike] = (),
    lollipops: int | None = None,
    focus: bool = True,
    capture: bool = True,
    gray_codes: bool = True,
    greys: int = 0,
) -> list[Path]:
    """Writes the patterns that a projector shows while a rig is photographed, instructions as text, and a page that
    shows the patterns.

    Args:
        folder: must be new or empty.
        width, height: of the projector's panel, pixels.
        calibrations: files of a rig's calibration, which then tell the panel's size.
        lollipops: number of these patterns; None: the program's default.
        focus: a chart for focusing and for placing the object.
        capture: black, white and the lollipops.
        gray_codes: of columns and rows, each with its inverse.
        greys: number of even greys between black and white, which tell the projector's response, 0 to 64.

    Returns:
        The pictures in display order.

    Raises:
        ArgumentError: an argument is wrong.
        FileFormatError: the folder is not empty.
    """
    keep, options = Keep(), ffi.new("FfpPatterns *", lib.ffp_patterns_defaults())
    options.folder, options.width, options.height = keep.path(folder), width, height
    options.focus, options.capture, options.gray_codes = focus, capture, gray_codes
    options.greys = greys
    paths = [keep.path(p) for p in some(calibrations)]
    options.calibrations, options.n_calibrations = keep.texts(paths), len(paths)
    if lollipops is not None:
        options.lollipops = lollipops
    with Call() as call:
        if lib.ffp_write_patterns(call.context, options, call.error) < 0:
            call.check(False)
    return sorted(Path(folder).glob("*.png"))


@dataclass
class RigCalibrationStats:
    """Statistics of calibrate_rig. Errors in pixels are root mean squares."""

    attitudes: int = 0  #: of the board
    used: int = 0
    camera: float = 0.0  #: error of the separate fit, pixels
    projector: float = 0.0
    both: float = 0.0  #: error of all corners in both devices, with one pose of the board for both, pixels
    corners: int = 0  #: of the attitudes used, in camera and projector
    left_out: int = 0
    open_terms: int = 0  #: terms that the photographs do not determine; warnings name them
    has_axis: bool = False  #: the turntable's axis was found; the following fields describe it
    axis: tuple[float, ...] = ()  #: camera coordinates; points up in the picture
    point: tuple[float, ...] = ()
    reversed: bool = False  #: the angles are left-handed about it: clockwise as seen from above
    stops: int = 0
    stops_used: int = 0
    stops_rms: float = 0.0
    tilt: float = 0.0  #: standard deviation, degrees
    shift: float = 0.0  #: standard deviation, in the unit of ``square``


@checked
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
    seen: PathLike | None = None,
    linear: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
) -> RigCalibrationStats:
    """Calibrates camera and projector from photographs of a chessboard under Gray codes in at least three attitudes,
    and finds a turntable's axis. Nothing is written until everything has been found.

    Args:
        file: for the calibration, OpenCV FileStorage (.xml, .yml); None: only the turntable's board is used.
        attitudes: folders of one attitude of the board each, or folders of such folders (docs/guide/own-rig.md).
        board: columns and rows of inner corners, where four squares meet.
        square: side of a square, which sets the unit of length of all results.
        projector: width and height of its panel, pixels; None: those of ``shown``, or 1920 x 1080.
        shown: folder of write_patterns; the folders may then contain a photograph of each of its patterns.
        fix_camera, fix_projector: terms to hold fixed: "k1", "k2", "k3", "tangential", "centre", "aspect".
        report: file for an HTML page.
        turntable_board: folder of photographs of a chessboard on the table, in the order of ``angles``.
        angles: of the table, degrees.
        turntable_file: for the axis, as read by import_capture (Turntable.file, with the object's angles; JSON).
        calibrations: without attitudes: files that contain the camera's calibration.
        seen: JSON file for where the board is in photographs (docs/reference/formats/calibrations.md, "Where a board is");
            ``attitudes`` are photographs of the board then, ``file`` is None, and nothing is calibrated.
        linear: PNG and JPEG files of photographs hold linear light instead of sRGB.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

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
    options.file, options.report, options.seen = keep.path(file), keep.path(report), keep.path(seen)
    options.linear = linear
    options.turntable_board, options.turntable_file = keep.path(turntable_board), keep.path(turntable_file)
    options.angles, options.n_angles = keep(ffi.new("double[]", [float(a) for a in angles])), len(angles)
    stats = ffi.new("FfpRigCalibrationStats *")
    with Call(progress, threads) as call:
        call.check(lib.ffp_calibrate_rig(call.context, options, stats, call.error))
    out: RigCalibrationStats = record(RigCalibrationStats, stats)
    return out


def _terms(names: Sequence[str], what: str) -> int:
    return sum(one_of(_TERMS, name, what) for name in set(names))


@checked
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
    """Trains a network to the end or until cancelled, in which case it writes a checkpoint first and returns.

    Args:
        out: folder for checkpoint.safetensors, weights.safetensors, metrics.jsonl and pictures.
        captures: folder of your own captures, for fine-tuning to their photographs (docs/lab/retrain.md).
            Every fourth is held out, and the weights written are those that predict its photographs best. None: scenes
            are generated or read.
        config: JSON file; None: the defaults.
        initial: weights to start from; None: the shipped ones with ``captures``, otherwise random ones.
        perceptual: safetensors for the perceptual loss; None: off.
        steps: number of steps; -1: as in the configuration.
        stop_at: stop at this step with a checkpoint; 0: run to the end.
        resume: continue from the checkpoint in ``out``.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.
        device: "cpu" or "cuda".

    Returns:
        The file of the weights.

    Raises:
        ArgumentError: an argument is wrong.
        Error: a file cannot be read or written; its subclass says why.
    """
    keep, options = Keep(), ffi.new("FfpTraining *", lib.ffp_training_defaults())
    options.out, options.captures, options.config = keep.path(out), keep.path(captures), keep.path(config)
    options.initial, options.perceptual = keep.path(initial), keep.path(perceptual)
    options.steps, options.stop_at, options.resume = steps, stop_at, resume
    with Call(progress, threads, device) as call:
        call.check(lib.ffp_train_model(call.context, options, call.error))
    return Path(out) / "weights.safetensors"
