# The extension module (python/wrap_header.py): the public header's functions in `lib`, cffi's tools in `ffi`.
from typing import Any

lib: Any
ffi: Any
