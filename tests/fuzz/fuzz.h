// Common code of the fuzzers. Each fuzz_<parser>.c is a libFuzzer program for one parser of files from
// outside.
#ifndef FFP_TESTS_FUZZ_H
#define FFP_TESTS_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "core/base/error.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// For parsers that take a path: a file in memory with these bytes. The path is good until the next call.
const char *fuzz_file(const uint8_t *data, size_t size);

// For parsers that look for other files beside the one they read: a folder in memory, made once and removed
// at the end, with pictures of 8 x 8 (a.png, b.png, c.png, a_depth.png, a_mask.png) and patterns of 4 x 4
// (patterns/black.png, patterns/white.png, patterns/dots.png). Puts the bytes into a file of it; the path is
// good until the next call.
const char *fuzz_neighbour(const char *name, const uint8_t *data, size_t size);

// Ends the program when a parser failed without saying what and where.
void fuzz_verdict(bool ok, const FfpError *err);

#endif
