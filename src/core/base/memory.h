// How much memory the machine has left.
#ifndef FFP_BASE_MEMORY_H
#define FFP_BASE_MEMORY_H

#include <stdbool.h>
#include "core/base/error.h"

// Bytes that a process may still take without anything being swapped out: what Linux calls available
// (/proc/meminfo), or what the limit of its control group (version 2, memory.max) leaves, whichever is less.
// Negative: not known.
double ffp_memory_available(void);

// Checks before an allocation that this many bytes are available: the error says what needs them ("the
// images"), how much memory is left and, unless `advice` is "", what to do about it.
bool ffp_memory_suffices(double bytes, const char *what, const char *advice, const char *where,
                         FfpError *err);

// The bytes that this process has in memory now, at which ffp_memory_peak starts again, and the most that it
// has had since then (VmHWM of /proc/self/status). Negative: not known.
double ffp_memory_mark(void);
double ffp_memory_peak(void);

#endif
