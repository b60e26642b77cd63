// XML, as OpenCV's FileStorage writes it.
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include "fuzz.h"
#include "rig/optics/document.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpError err = {0};
    char *text = malloc(size + 1); // the parser relies on the zero byte
    if (!text) return 0;
    memcpy(text, data, size);
    text[size] = 0;
    json_t *value = ffp_xml_parse(text, size, "fuzz.xml", &err);
    fuzz_verdict(value != NULL, &err);
    json_decref(value);
    free(text);
    return 0;
}
