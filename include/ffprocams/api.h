// The library is built with hidden symbols; FFP_API marks those that it exports.
#ifndef FFPROCAMS_API_H
#define FFPROCAMS_API_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define FFP_API __attribute__((visibility("default")))
#else
#define FFP_API
#endif

// Last in structs that programs hold by value and that have no `size`: room for fields of later versions.
// Programs leave it 0; 0 in a later field means what this version does.
#define FFP_RESERVED uint64_t reserved[8]

// Declares `type function(void)`: options with their defaults. It is compiled into the program, and returns
// as large a struct as the program knows; its part in the library is function_into(options, size).
// NOLINTBEGIN(bugprone-macro-parentheses): a type
#define FFP_DEFAULTS(type, function)                                                                         \
    FFP_API void function##_into(type *options, size_t size);                                                \
    static inline type function(void) {                                                                      \
        type options;                                                                                        \
        function##_into(&options, sizeof options);                                                           \
        return options;                                                                                      \
    }
// NOLINTEND(bugprone-macro-parentheses)

#endif
