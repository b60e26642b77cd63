"""wrap_header.py INCLUDE OUT.c: writes the extension module's C source from the public headers.

Python sees all that the headers declare: nothing is listed twice.
"""

import re
import sys
from pathlib import Path

from cffi import FFI

# The functions of FfpContextSettings, in Python (ffprocams/_call.py).
CALLBACKS = """
extern "Python" void ffp_python_log(void *user, FfpLogLevel level, const char *text);
extern "Python" bool ffp_python_progress(void *user, const FfpProgress *progress);
"""


def declarations(header: str) -> str:
    """The header without what cffi's parser does not know: comments, directives, attributes."""
    text = re.sub(r"//.*", "", header)
    text = re.sub(r"#ifdef __cplusplus.*?#endif", "", text, flags=re.DOTALL)
    text = re.sub(r"^#(.*\\\n)*.*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"^FFP_DEFAULTS\((\w+), (\w+)\)", r"\1 \2(void);", text, flags=re.MULTILINE)
    return text.replace("FFP_API ", "").replace("FFP_RESERVED;", "uint64_t reserved[...];")


def headers(include: Path, name: str, seen: list[str]) -> list[str]:
    """The texts of a header and of those that it includes, each once, after those that it includes."""
    if name in seen:
        return []
    seen.append(name)
    if not (include / name).exists():  # version.h, which the build writes: macros alone
        return []
    text = (include / name).read_text(encoding="utf-8")
    included = re.findall(r'^#include "(.*)"', text, re.MULTILINE)
    return [part for other in included for part in headers(include, other, seen)] + [text]


def main() -> None:
    include, out = Path(sys.argv[1]), sys.argv[2]
    ffi = FFI()
    for header in headers(include, "ffprocams.h", []):
        ffi.cdef(declarations(header))
    ffi.cdef(CALLBACKS)
    ffi.set_source("ffprocams._library", '#include "ffprocams.h"\n')
    ffi.emit_c_code(out)


if __name__ == "__main__":
    main()
