// Text as JSON.
#ifndef FFP_API_JSON_H
#define FFP_API_JSON_H

#include <stdio.h>

// A JSON string with its quotes; of text that is not UTF-8, bytes beyond ASCII become question marks.
void ffp_put_json(FILE *out, const char *text);

#endif
