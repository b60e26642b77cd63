"""wrap_header.py INCLUDE OUT.c: writes the extension module's C source from the public header.

Python sees all that the header declares: nothing is listed twice.
"""

import re
import sys
from pathlib import Path

from cffi import FFI

HEADERS = (
    "ffprocams/error.h",
    "ffprocams/findings.h",
    "ffprocams/context.h",
    "ffprocams.h",
    "ffprocams/baselines.h",
)

# The functions of FfpContextSettings, in Python (ffprocams/_call.py).
CALLBACKS = """
extern "Python" void ffp_python_log(void *user, FfpLogLevel level, const char *text);
extern "Python" bool ffp_python_progress(void *user, const FfpProgress *progress);
"""


def declarations(header: str) -> str:
    """The header without what cffi's parser does not know: comments, directives, attributes."""
    text = re.sub(r"//.*", "", header)
    text = re.sub(r"#ifdef __cplusplus.*?#endif", "", text, flags=re.DOTALL)
    text = re.sub(r"^#.*$", "", text, flags=re.MULTILINE)
    return text.replace("FFP_API ", "")


def main() -> None:
    include, out = Path(sys.argv[1]), sys.argv[2]
    ffi = FFI()
    for name in HEADERS:
        ffi.cdef(declarations((include / name).read_text(encoding="utf-8")))
    ffi.cdef(CALLBACKS)
    ffi.set_source("ffprocams._library", '#include "ffprocams/baselines.h"\n')
    ffi.emit_c_code(out)


if __name__ == "__main__":
    main()
