// A hash: FNV-1a of 64 bits (Fowler, Noll and Vo).
#ifndef FFP_BASE_HASH_H
#define FFP_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define FFP_HASH_NONE 0xcbf29ce484222325ULL // of no bytes

static inline uint64_t ffp_hash(uint64_t so_far, const void *data, size_t size) {
    const unsigned char *bytes = (const unsigned char *)data;
    for (size_t i = 0; i < size; i++)
        so_far = (so_far ^ bytes[i]) * // NOLINT(clang-analyzer-core.UndefinedBinaryOperatorResult)
                 0x100000001b3ULL;     // the analyser does not see into an array of other numbers
    return so_far;
}

// Includes the terminating zero, so that "ab", "c" differs from "a", "bc".
static inline uint64_t ffp_hash_text(uint64_t so_far, const char *text) {
    return ffp_hash(so_far, text, strlen(text) + 1);
}

#endif
