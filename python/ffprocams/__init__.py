"""FF-ProCams: relightable 3D Gaussians from projector-camera photographs, in seconds.

    import ffprocams
    capture = ffprocams.Capture.open("data/sample")
    gaussians = ffprocams.reconstruct(capture)
    renderer = ffprocams.Renderer().aim(gaussians, capture.camera(0), capture.projector(0))
    picture = renderer.shade(pattern, capture.intensity)

All the work is done in the C library; arrays are NumPy's. Other Python threads run during a call, and Ctrl-C ends it.
Each handle (Capture, Gaussians, Model, Renderer) serves one thread at a time; other threads wait. The library's
messages go to the logger "ffprocams". Errors are subclasses of Error with the attributes code, file and field.
"""

from . import protocols
from ._call import PathLike, Progress, ProgressOption
from ._library import ffi as _ffi
from ._library import lib as _lib
from ._pixels import Array, Floats, decode, encode
from .applications import Compensation, CompensationStats, MapStats, compensate, maps
from .capture import AlignStats, Capture, FoundProjector, View, align, find_projector
from .devices import Calibration, Pinhole, pinholes_from_pycolmap
from .errors import (
    ArgumentError,
    ArgumentTypeError,
    CancelledError,
    Error,
    ErrorCode,
    FaultError,
    FileFormatError,
    InputOutputError,
    MissingFileError,
    OutOfMemoryError,
    UnsupportedError,
)
from .evaluation import CalibratedAt, LightFaults, Score, SensorFaults, Turntable, evaluate, generate, import_capture, info
from .findings import Finding
from .gaussians import ExportStats, Gaussians, Model, PageStats
from .reconstruction import (
    ModelOption,
    Reconstructed,
    ReconstructionStats,
    Refined,
    RefinementStats,
    fit_from_scratch,
    reconstruct,
    refine,
)
from .renderer import Renderer
from .rig import RigCalibrationStats, calibrate_rig, train, write_patterns

__version__: str = _ffi.string(_lib.ffp_version()).decode()

__all__ = [
    "AlignStats", "ArgumentError", "ArgumentTypeError", "Array", "CalibratedAt", "Calibration", "CancelledError", "Capture",
    "Compensation", "CompensationStats", "Error", "ErrorCode", "ExportStats", "FaultError", "FileFormatError", "Finding", "Floats", "FoundProjector", "Gaussians",
    "InputOutputError", "LightFaults", "MapStats", "MissingFileError", "Model", "ModelOption", "OutOfMemoryError", "PageStats", "PathLike", "Pinhole", "Progress",
    "ProgressOption", "Reconstructed", "ReconstructionStats", "Refined", "RefinementStats", "Renderer",
    "RigCalibrationStats", "Score", "SensorFaults", "Turntable", "UnsupportedError", "View", "align", "calibrate_rig",
    "compensate", "decode", "encode", "evaluate", "find_projector", "fit_from_scratch", "generate", "import_capture", "info", "maps",
    "pinholes_from_pycolmap", "protocols", "reconstruct", "refine", "train", "write_patterns",
]  # fmt: skip
