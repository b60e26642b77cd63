// YAML, as OpenCV's FileStorage writes it and as people do.
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include "fuzz.h"
#include "rig/optics/document.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpError err = {0};
    char *text = malloc(size + 1); // the parser may change it, and relies on the zero byte
    if (!text) return 0;
    memcpy(text, data, size);
    text[size] = 0;
    json_t *value = ffp_yaml_parse(text, size, "fuzz.yml", &err);
    fuzz_verdict(value != NULL, &err);
    json_decref(value);
    free(text);
    return 0;
}
