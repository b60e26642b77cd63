# The extension module (python/wrap_header.py): the public headers' functions in `lib`, cffi's tools in `ffi`.
from typing import Any

lib: Any
ffi: Any
