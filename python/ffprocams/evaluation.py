"""Evaluation, generated scenes, import of photographs and calibrations, and descriptions of files."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

from ._arguments import Seed, checked, one_of
from ._call import Call, Keep, PathLike, ProgressOption, holding, some
from ._library import ffi, lib
from .capture import record, three
from .devices import Calibration
from .gaussians import drawing_of
from .reconstruction import ModelOption, _automatic, model_of

_PREDICTORS = {
    "gaussians": lib.FFP_PREDICT_GAUSSIANS,
    "depth": lib.FFP_PREDICT_DEPTH,
    "match": lib.FFP_PREDICT_MATCH,
}
_SPLITS = {
    "all": lib.FFP_SPLIT_ALL,
    "train": lib.FFP_SPLIT_TRAIN,
    "validation": lib.FFP_SPLIT_VALIDATION,
    "test": lib.FFP_SPLIT_TEST,
}
_PRESETS = {"paper": lib.FFP_PRESET_PAPER, "smoke": lib.FFP_PRESET_SMOKE, "training": lib.FFP_PRESET_TRAINING}
_RIGS = {
    "turntable": lib.FFP_RIG_TURNTABLE,
    "free": lib.FFP_RIG_FREE,
    "sphere": lib.FFP_RIG_SPHERE,
    "walk": lib.FFP_RIG_WALK,
    "walk-two": lib.FFP_RIG_WALK_TWO,
}
_FITS = {"exact": lib.FFP_FIT_EXACT, "scaled": lib.FFP_FIT_SCALED, "cropped": lib.FFP_FIT_CROPPED}


@dataclass
class Score:
    """The figures of a capture under a protocol: means over its images. NaN where a figure does not apply."""

    capture: str  #: "mean" for the mean of several captures
    protocol: str  #: "novel_pattern", "novel_pose", "unseen", "rendering" or "given"
    psnr: float  #: dB, of the 8-bit sRGB prediction over black; 100 for identical pictures
    psnr_foreground: float  #: over pixels that the object covers
    ssim: float
    lpips: float
    psnr_gloss: float  #: under white, over pixels whose true specular part is above 0.05 (linear radiance)
    psnr_unseen_lollipops: float  #: "rendering" only: lollipops not given to the predictor
    images: int
    images_unseen: int
    reconstruct_s: float  #: seconds for the reconstruction
    render_s: float  #: seconds for all pictures of the row
    depth_lit_median: float  #: error in % of the object's radius, over pixels lit by white
    depth_lit_p90: float  #: 90th percentile
    depth_unlit_median: float  #: likewise over pixels not lit by it
    depth_unlit_p90: float
    albedo_mse: float  #: linear
    albedo_lit_mse: float
    albedo_unlit_mse: float


@checked
def evaluate(
    captures: PathLike | Sequence[PathLike],
    *,
    predictor: str = "gaussians",
    model: ModelOption = None,
    model_name: str | None = None,
    gaussians: PathLike | None = None,
    field: PathLike | None = None,
    targets: PathLike | Sequence[PathLike] = (),
    pattern: str | Sequence[str] | None = None,
    polish: int | None = None,
    noise: float | None = None,
    layers: float | None = None,
    save: PathLike | None = None,
    json: PathLike | None = None,
    report: PathLike | None = None,
    show_pattern: PathLike | None = None,
    perceptual: PathLike | None = None,
    form: str = "ours",
    samples: int = 0,
    force: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> list[Score]:
    """Evaluates capture folders by the paper's protocols: a row for each capture and protocol, then their means.

    Args:
        captures: folders, or JSON files in them.
        predictor: "gaussians" (reconstruct, or read, and render), "depth" (lookup at the true depth) or "match" (at
            the depth that projector matching finds).
        model, pattern, polish, noise, layers, form, samples, force, threads, device: as in reconstruct.
        model_name: name of the predictor in JSON and report; None: its file, or its kind.
        gaussians: PLY to evaluate instead of reconstructing.
        field: neural field to evaluate instead, as written by `ffprocams refine --from-scratch=field`.
        targets: pose files for "novel_pose": none, one per capture, or one path that is looked up in each capture.
        save: folder for every prediction, `CAPTURE/VIEW_PATTERN.png`.
        json, report: files for the rows and for an HTML report.
        show_pattern: image file; the report also shows views under it.
        perceptual: safetensors with LPIPS weights.
        progress: see ffprocams.ProgressOption.

    Raises:
        ArgumentError: an argument is wrong.
        Error: a file cannot be read or written; its subclass says why.
    """
    keep, weights = (
        Keep(),
        model_of(model) if predictor == "gaussians" and gaussians is field is None else None,
    )
    options = ffi.new("FfpEvaluation *", lib.ffp_evaluation_defaults())
    paths, poses = ([keep.path(p) for p in some(given)] for given in (captures, targets))
    options.captures, options.n_captures = keep.texts(paths), len(paths)
    options.targets, options.n_targets = keep.texts(poses), len(poses)
    options.predictor = one_of(_PREDICTORS, predictor, "predictor")
    options.model = ffi.NULL if weights is None else weights._pointer
    options.model_name = keep.text(model_name)
    names = [keep.text(p) for p in some(pattern or ())]
    options.patterns, options.n_patterns = keep.texts(names), len(names)
    options.polish = int(_automatic(polish, 0, "polish"))
    options.noise, options.layers = _automatic(noise, 0, "noise"), _automatic(layers, 0, "layers")
    files = {"gaussians": gaussians, "field": field, "save": save, "json": json, "report": report}
    files |= {"show_pattern": show_pattern, "perceptual": perceptual}
    for name, path in files.items():
        setattr(options, name, keep.path(path))
    options.drawing, options.force, count = drawing_of(form, samples), force, ffi.new("int *")
    with holding(weights), Call(progress, threads, device) as call:
        rows = call.take(lib.ffp_evaluate(call.context, options, count, call.error), lib.ffp_free)
    return [record(Score, rows[i]) for i in range(count[0])]


@checked
@dataclass
class SensorFaults:
    """Imperfections of the devices that see generated scenes. All 0: none."""

    exposure: float = 0.0  #: of the camera, stops, -8 to 8
    shot: float = 0.0  #: noise of a linear value v has the variance shot * v + read^2; 0 to 1 each
    read: float = 0.0
    defocus: float = 0.0  #: of the projector: standard deviation in its pixels, 0 to 64
    gamma: float = 0.0  #: the projector sends value^(1 + gamma), -0.9 to 4
    black_level: float = 0.0  #: and this share of white where a pattern is black, 0 to 0.9
    turn_error: float = 0.0  #: standard deviation of the written poses' rotation about each axis, degrees, 0 to 28
    shift_error: float = 0.0  #: and of their positions, world units, 0 to 0.5


@checked
@dataclass
class LightFaults:
    """Faults of the devices that change the light of generated scenes (docs/design/data.md, "Real light"). All 0: nothing."""

    real_light: float = 0.0  #: strength, 0 to 1, at which the seed draws all below that is 0
    spread: float = 0.0  #: share of the projector's light that is spread by a Gaussian, 0 to 0.5
    spread_reach: float = 0.0  #: its standard deviation, pixels of a panel 800 wide, 0 to 200; 0: 12
    glare: float = 0.0  #: share of the camera's light likewise, 0 to 0.5
    glare_reach: float = 0.0  #: share of the picture's longer side, 0 to 1; 0: 0.15
    power: float = 0.0  #: the projector sends value^power of the file's values, to 5; 0: sRGB and ``SensorFaults.gamma``
    vignetting: float = 0.0  #: share of the light that the camera loses at half a diagonal, 0 to 0.9
    throw_fall: float = 0.0  #: and the projector
    focus_blur: float = 0.0  #: standard deviation a world unit off the focal plane, pixels of a panel 800 wide
    focus_at: float = 0.0  #: that plane's distance, relative to the middle of the scene; 0: 1


@checked
def generate(
    folder: PathLike,
    *,
    split: str = "all",
    preset: str = "paper",
    first: int = 0,
    count: int = -1,
    resolution: int = 0,
    rig: str = "turntable",
    views: int = 0,
    seed: Seed | None = None,
    mesh: PathLike | None = None,
    material: PathLike | None = None,
    materials: PathLike | None = None,
    patterns: PathLike | None = None,
    sensor: SensorFaults | None = None,
    light: LightFaults | None = None,
    photographs: PathLike | None = None,
    attitudes: int | None = None,
    only: str | None = None,
    room: bool = False,
    other_projector: bool = False,
    quality: int | None = None,
    check: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
) -> list[Path]:
    """Generates captures with ground truth, one folder per scene. Existing scenes are kept.

    Args:
        folder: output, one capture folder per scene.
        split: "all", "train", "validation" or "test"; no mesh is in two of the last three.
        preset: "paper" (8 views of 128 x 128 pixels and 6 lollipops), "smoke" (small and quick), "training".
        first, count: scenes of the split; count -1: to the end, or one scene with ``mesh``.
        resolution: image side, pixels; 0: the preset's.
        rig: "turntable", "free" (each view has its own devices), "sphere" (only the camera moves), or, for whole
            scenes, "walk" or "walk-two" (two projectors).
        views: number of input views, 1 to 360; 0: the preset's.
        seed: of the scenes; None: the program's default.
        mesh: OBJ, PLY, STL or glTF file to use instead of the generated meshes.
        material: folder of basecolor, roughness and normal maps to use.
        materials: folder of pictures, each of which is a material, and of folders of maps; each scene draws one.
        patterns: folder of pictures that the projector shows in place of all lollipops but the first.
        sensor: imperfections of the devices.
        light: faults that change light.
        photographs: folder of patterns (write_patterns): instead of captures, write photographs of one object on a
            turntable under all of them, and of a chessboard, by a rig with lenses (docs/design/data.md, "Photographs").
        attitudes: number of attitudes of that chessboard, 0 to 64; None: the program's default.
        only: of those photographs only this folder (view-045, attitude-03, turntable or empty), the same as among all of them.
        room: take those photographs in a real room that the seed decides, with turns and patterns that are held out
            (docs/design/data.md, "Rooms").
        other_projector: the light of those photographs comes from another projector. Not with ``room``.
        quality: of the room's JPEG files, 1 to 100; None: the program's default.
        check: generate nothing, and raise an error that names the missing or incomplete scenes.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

    Returns:
        The capture folders in ``folder``.

    Raises:
        ArgumentError: an argument is wrong, or does not go with another.
        FileFormatError: with ``check``, scenes are missing.
        Error: a file cannot be read or written; its subclass says why.
    """
    keep, options = Keep(), ffi.new("FfpGeneration *", lib.ffp_generation_defaults())
    options.folder, options.mesh, options.material = keep.path(folder), keep.path(mesh), keep.path(material)
    options.materials, options.patterns = keep.path(materials), keep.path(patterns)
    options.split, options.preset = one_of(_SPLITS, split, "split"), one_of(_PRESETS, preset, "preset")
    options.rig, options.first, options.count = one_of(_RIGS, rig, "rig"), first, count
    options.resolution, options.views = resolution, views
    options.photographs, options.check = keep.path(photographs), check
    if attitudes is not None:
        options.attitudes = attitudes
    options.only = keep.text(only)
    options.room, options.other_projector = room, other_projector
    if quality is not None:
        options.quality = quality
    if seed is not None:
        options.seed = seed
    for name, value in vars(sensor or SensorFaults()).items():
        setattr(options.sensor, name, value)
    for name, value in vars(light or LightFaults()).items():
        setattr(options.light, name, value)
    with Call(progress, threads) as call:
        call.check(lib.ffp_generate(call.context, options, call.error))
    return sorted(p.parent for p in Path(os.fspath(folder)).glob("*/scene.json"))


@checked
@dataclass
class Turntable:
    """An object that turned in front of a fixed camera and projector, in camera coordinates and the calibration's unit;
    angles in degrees, right-handed about the axis."""

    angles: Sequence[float] = ()  #: rotation of the object at each stop
    axis: Sequence[float] = (0.0, 0.0, 0.0)  #: direction
    point: Sequence[float] = (0.0, 0.0, 0.0)  #: any point on the axis
    find_axis: bool = False  #: find axis and point from the pictures
    guessed: bool = False  #: start the search at ``axis`` and ``point``
    file: PathLike | None = None  #: JSON or YAML file that gives them instead; ``angles``, if any, replace those of the file


@checked
@dataclass
class CalibratedAt:
    """The size at which a device was calibrated, and how its pictures relate to that size."""

    width: int = 0  #: pixels; 0: given by the calibration's files
    height: int = 0
    fit: str = "exact"  #: "exact", "scaled" or "cropped"
    left: int = 0  #: pixels cut off
    top: int = 0


CalibrationOption = Union[PathLike, Calibration, Mapping[str, Any]]


@checked
def import_capture(
    folder: PathLike,
    calibrations: CalibrationOption | Sequence[CalibrationOption],
    *,
    images: Mapping[str, PathLike] | PathLike | None = None,
    shown: PathLike | None = None,
    patterns: Mapping[str, PathLike] | None = None,
    held_out: Mapping[str, PathLike] | None = None,
    gray_codes: PathLike | None = None,
    kept_codes: int = 8,
    empty: Mapping[str, PathLike] | None = None,
    turntable: Turntable | None = None,
    masks: str | None = None,
    projector_image: str | None = None,
    views: Sequence[str] = (),
    camera: CalibratedAt | None = None,
    projector: CalibratedAt | None = None,
    width: int = 0,
    fit_response: bool = False,
    scene: bool = False,
    linear_images: bool = False,
    linear_patterns: bool = False,
    other_projector: bool = False,
    exposure: float = 0.0,
    sphere: Sequence[float] | None = None,
    name: str | None = None,
    progress: ProgressOption = None,
    threads: int = 0,
) -> None:
    """Writes a capture folder from photographs and a calibration, completely or not at all: poses in the object's
    frame, pictures and patterns without lens distortion, masks applied.

    Args:
        folder: must be new or empty.
        calibrations: files of other tools (docs/reference/formats/calibrations.md), a Calibration, or a dict of matrices as for
            Calibration.from_dict.
        images: the photographs under each pattern ("black", "white" and those of ``patterns``): a path that contains
            {view}, {pattern}, {index} or {number}, or *, or both. Such a path alone: the photographs of all patterns
            in ``shown``, in their order, with or without the Gray codes. None: the pictures named by the calibration.
        shown: folder of write_patterns whose patterns the projector showed.
        patterns: the image that was projected, a file for each pattern name other than black and white.
        held_out: likewise, for testing only.
        gray_codes: photographs of the Gray codes of write_patterns, files as in ``images``, with {pattern} standing for
            gray_x_00, gray_x_00_inverse and so on: where codes can be decoded, depth is exact.
        kept_codes: of these, how many photographs each view keeps for fits, 0 to 32.
        empty: photographs of the stage without the object under "black", "white" and preferably every other pattern,
            files as in ``images``, or one for all stops of a turntable; what looks like it is background. Cannot be
            combined with files of masks.
        turntable: for a fixed rig with several views.
        masks: None: the photographs' alpha if present, otherwise as "light"; "light": computed from light;
            or files, as in ``images``, white on black.
        projector_image: COLMAP: the image that stands for the projector; None: "calib".
        views: ids to import; none: all.
        camera, projector: sizes at calibration, and how pictures relate to them.
        width: of the imported pictures, pixels; 0: as fine as the photographs show the object, whose longer side has
            at most 1024 pixels, all views two million, within half of the free memory and three minutes of a reconstruction;
            and cut to it.
        scene: a whole scene before which the projector stands and the camera walks: no masks, no turntable.
        fit_response: estimate the projector's gamma and black level from the pictures, and keep them if held-out views
            gain by it.
        linear_images, linear_patterns: integer files hold linear light instead of sRGB.
        other_projector: the photographs show the light of a projector that the calibration does not describe, whose
            panel's size ``projector`` gives; find_projector then finds it.
        exposure: adjustment of linear values, in stops.
        sphere: centre and radius of a sphere around the object, 4 numbers; None: estimated.
        name: of the capture; None: the folder's.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

    Raises:
        ArgumentError: an argument is wrong, or does not go with another.
        FileFormatError: a file is invalid, or the folder is not empty.
        Error: a file cannot be read or written; its subclass says why.
    """
    keep, options = Keep(), ffi.new("FfpImport *", lib.ffp_import_defaults())
    options.folder, options.name, options.projector_image = (
        keep.path(folder),
        keep.text(name),
        keep.text(projector_image),
    )
    ids = [keep.text(v) for v in views]
    options.views, options.n_views = keep.texts(ids), len(ids)
    _fill_pictures(options, images, patterns, held_out, keep)
    options.empty, options.n_empty = _listed_images(list((empty or {}).items()), keep), len(empty or {})
    _fill_turntable(options.turntable, turntable or Turntable(), keep)
    options.kept_codes = kept_codes
    options.gray_codes, options.shown = keep.path(gray_codes), keep.path(shown)
    options.masks = {None: lib.FFP_MASKS_FROM_ALPHA, "light": lib.FFP_MASKS_FROM_LIGHT}.get(
        masks, lib.FFP_MASKS_FROM_FILES
    )
    if options.masks == lib.FFP_MASKS_FROM_FILES:
        options.mask_files = keep.text(masks)
    options.width, options.fit_response, options.exposure = width, fit_response, exposure
    options.scene, options.other_projector = scene, other_projector
    options.linear_images, options.linear_patterns = linear_images, linear_patterns
    if sphere is not None:
        options.object = [float(x) for x in sphere]
    given = [calibrations] if isinstance(calibrations, (Calibration, Mapping)) else some(calibrations)
    with tempfile.TemporaryDirectory() as scratch:
        files, sizes = _calibration_files(given, Path(scratch))
        paths = [keep.path(f) for f in files]
        options.calibrations, options.n_calibrations = keep.texts(paths), len(paths)
        for at, known, c in zip((camera, projector), sizes, (options.camera, options.projector)):
            at = at or CalibratedAt()
            c.width, c.height = (at.width, at.height) if at.width else known
            c.fit, c.left, c.top = one_of(_FITS, at.fit, "fit"), at.left, at.top
        with Call(progress, threads) as call:
            call.check(lib.ffp_import_capture(call.context, options, call.error))


def _calibration_files(given: list[Any], scratch: Path) -> tuple[list[PathLike], list[tuple[int, int]]]:
    """Files of the calibrations, and the sizes of camera and projector given by those in memory."""
    files: list[PathLike] = []
    sizes = [(0, 0), (0, 0)]
    for i, one in enumerate(given):
        if isinstance(one, Mapping):
            one = Calibration.from_dict(one)
        if isinstance(one, Calibration):
            sizes = [(d.width, d.height) for d in (one.camera, one.projector)]
            file = scratch / f"calibration_{i}.json"
            one.save(file)
            one = file
        files.append(one)
    return files, sizes


def _listed_images(groups: Sequence[tuple[str | None, PathLike]], keep: Keep) -> Any:
    """Files of photographs by pattern; without a name, of all that was shown."""
    listed = keep(ffi.new("FfpImportImages[]", len(groups)))
    for i, (pattern, files) in enumerate(groups):
        if pattern is not None:
            listed[i].patterns, listed[i].n_patterns = keep.texts([keep.text(pattern)]), 1
        listed[i].files = keep.path(files)
    return listed


def _fill_pictures(
    options: Any,
    images: Mapping[str, PathLike] | PathLike | None,
    patterns: Mapping[str, PathLike] | None,
    held_out: Mapping[str, PathLike] | None,
    keep: Keep,
) -> None:
    groups: list[tuple[str | None, PathLike]] = []
    if isinstance(images, Mapping):
        groups = list(images.items())
    elif images is not None:
        groups = [(None, images)]
    options.images, options.n_images = _listed_images(groups, keep), len(groups)
    for field, named in (("patterns", patterns or {}), ("held_out", held_out or {})):
        of = keep(ffi.new("FfpImportPattern[]", len(named)))
        for i, (pattern, file) in enumerate(named.items()):
            of[i].name, of[i].file = keep.text(pattern), keep.path(file)
        setattr(options, field, of)
        setattr(options, f"n_{field}", len(named))


def _fill_turntable(c: Any, turntable: Turntable, keep: Keep) -> None:
    c.file, c.axis, c.point = keep.path(turntable.file), three(turntable.axis, "axis"), three(turntable.point, "point")
    c.angles = keep(ffi.new("double[]", [float(a) for a in turntable.angles]))
    c.n_angles = len(turntable.angles)
    c.find_axis, c.guessed = turntable.find_axis, turntable.guessed


@checked
def info(path: PathLike, report: PathLike | None = None) -> str:
    """Describes a capture, a weights file or a PLY in readable text.

    ``report`` names an HTML page to write of a capture: the same text, and a contact sheet of its
    masks in which doubtful views are marked.
    Raises MissingFileError or FileFormatError for a file that is missing or damaged.
    """
    keep = Keep()
    with Call() as call:
        if report is not None:
            call.check(lib.ffp_info_report(call.context, keep.path(path), keep.path(report), call.error))
        text = call.take(lib.ffp_info(call.context, keep.path(path), call.error), lib.ffp_free)
    out: str = ffi.string(text).decode("utf-8", "replace")
    return out
