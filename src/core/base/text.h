// Text that grows in memory as it is written.
#ifndef FFP_BASE_TEXT_H
#define FFP_BASE_TEXT_H

#include <stdio.h>
#include "core/base/alloc.h"

// For an HTML page or an attribute in it: escapes special characters.
void ffp_put_html(FILE *out, const char *text);
// The end of an HTML report's style: its colours where the reader's screen is dark; .open and .look stand
// out.
#define FFP_REPORT_DARK                                                                                      \
    ":root{color-scheme:light dark}@media(prefers-color-scheme:dark){"                                       \
    "body{color:#ddd;background:#17171a}a{color:#8bf}figcaption{color:#aaa}"                                 \
    "td,th,h2{border-color:#444}.open,.look{color:#f96}}"
// For a terminal: strings from files may contain anything, and only text may reach it.
void ffp_put_plain(FILE *out, const char *text);

typedef struct FfpText FfpText;
FfpText *ffp_text_new(void);
FILE *ffp_text_stream(FfpText *text);
const char *ffp_text_so_far(FfpText *text, size_t *size); // valid until more is written
char *ffp_text_end(FfpText *text);                        // all of it, released with ffp_free; frees the rest
void ffp_text_free(FfpText *text);                        // NULL is allowed

#endif
