// A word of a command as one types it into a shell.
#ifndef FFP_STUDIO_TYPED_H
#define FFP_STUDIO_TYPED_H

#include <stdio.h>
#include <string.h>

static inline void ffp_studio_type(FILE *out, const char *word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=,+:@%-";
    if (*word && strspn(word, plain) == strlen(word)) {
        fputs(word, out);
        return;
    }
    fputc('\'', out);
    for (const char *c = word; *c; c++) {
        if (*c == '\'')
            fputs("'\\''", out);
        else
            fputc(*c, out);
    }
    fputc('\'', out);
}

#endif
