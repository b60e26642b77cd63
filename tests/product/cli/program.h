// Running the program as a user would.
#ifndef FFP_TESTS_PROGRAM_H
#define FFP_TESTS_PROGRAM_H

#include "core/base/alloc.h"
#include "scratch.h"

// Runs the program with the arguments (shell syntax) and returns its exit code; standard output and error
// come back as text.
typedef struct ProgramRun {
    int status;
    char out[65536], err[65536];
} ProgramRun;

static inline void read_text(const char *path, char *text, size_t size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = 0;
    fclose(file);
    assert_int_equal(remove(path), 0);
}

static inline void run_program(ProgramRun *run, const char *arguments) {
    char command[4096], out[128], err[128];
    snprintf(out, sizeof out, "%s.out", scratch);
    snprintf(err, sizeof err, "%s.err", scratch);
    assert_true((size_t)snprintf(command, sizeof command, "'%s' %s >%s 2>%s", FFP_PROGRAM, arguments, out,
                                 err) < sizeof command);
    const int status = system(command);
    run->status = status >= 0 && (status & 0x7f) == 0 ? status >> 8 & 0xff : -1;
    read_text(out, run->out, sizeof run->out);
    read_text(err, run->err, sizeof run->err);
}

// The same with arguments as printf makes them; returns the exit code.
static inline int run_format(ProgramRun *run, const char *format, ...) __attribute__((format(printf, 2, 3)));
static inline int run_format(ProgramRun *run, const char *format, ...) {
    char arguments[2048];
    va_list list;
    va_start(list, format);
    assert_true((size_t)vsnprintf(arguments, sizeof arguments, format, list) < sizeof arguments);
    va_end(list);
    run_program(run, arguments);
    if (run->status != 0) printf("%s: exit %d\n%s", arguments, run->status, run->err);
    return run->status;
}

// True if a run with `--events 1` told a finding, by its code or another of its texts.
static inline bool has_told(const ProgramRun *run, const char *code) {
    char text[96];
    snprintf(text, sizeof text, "\"%s\"", code);
    return strstr(run->out, text) != NULL;
}

#endif
