#include "core/base/text.h"
#include <stdlib.h>
#include "core/base/call.h"

void ffp_put_html(FILE *out, const char *text) {
    for (; *text; text++) {
        if (*text == '&')
            fputs("&amp;", out);
        else if (*text == '<')
            fputs("&lt;", out);
        else if (*text == '>')
            fputs("&gt;", out);
        else if (*text == '"')
            fputs("&quot;", out);
        else
            fputc(*text, out);
    }
}

void ffp_put_plain(FILE *out, const char *text) {
    for (; *text; text++) fputc((unsigned char)*text < ' ' && *text != '\n' ? '?' : *text, out);
}

struct FfpText {
    FILE *stream;
    char *bytes; // the stream's
    size_t size;
};

static void release(void *thing) {
    FfpText *text = thing;
    if (text->stream) fclose(text->stream);
    free(text->bytes);
    ffp_free(text);
}

FfpText *ffp_text_new(void) {
    FfpText *text = ffp_alloc(1, sizeof *text);
    ffp_own(text, release);
    text->stream = open_memstream(&text->bytes, &text->size);
    if (!text->stream) ffp_no_memory(0);
    return text;
}

FILE *ffp_text_stream(FfpText *text) {
    return text->stream;
}

const char *ffp_text_so_far(FfpText *text, size_t *size) {
    if (fflush(text->stream) != 0) ffp_no_memory(text->size);
    if (size) *size = text->size;
    return text->bytes;
}

char *ffp_text_end(FfpText *text) {
    char *copy = ffp_copy_text(ffp_text_so_far(text, NULL));
    ffp_text_free(text);
    return copy;
}

void ffp_text_free(FfpText *text) {
    ffp_disown(text);
    if (text) release(text);
}
