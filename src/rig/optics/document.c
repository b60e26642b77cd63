#include "rig/optics/document.h"
#include <string.h>
#include "core/base/file.h"

static json_t *parse_json(const char *text, size_t size, const char *path, FfpError *err) {
    json_error_t why;
    json_t *value = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
    if (!value) ffp_document_fail(path, (size_t)why.line, err, "broken JSON: %s", why.text);
    return value;
}

bool ffp_document_open(FfpNode *root, const char *path, FfpError *err) {
    *root = (FfpNode){.file = path};
    char *text = NULL;
    size_t size = 0;
    if (!ffp_read_text(path, FFP_DOCUMENT_BYTES_MAX, &text, &size, err)) return false;
    static const char *const others[][2] = {{"PK\3\4", "numpy archive"},
                                            {"\x93NUMPY", "numpy archive"},
                                            {"MATLAB 5.0", "MATLAB file"},
                                            {"\x80", "Python pickle"}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        if (strncmp(text, others[i][0], strlen(others[i][0])) != 0) continue;
        ffp_free(text);
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "is a %s: write its matrices as YAML or JSON (camK, prjK, camKc, prjKc, R and T), as "
                        "cv2.FileStorage does",
                        others[i][1]);
    }
    const char first = text[strspn(text, " \t\r\n")];
    if (first == '{' || first == '[')
        root->value = parse_json(text, size, path, err);
    else if (first == '<')
        root->value = ffp_xml_parse(text, size, path, err);
    else
        root->value = ffp_yaml_parse(text, size, path, err);
    ffp_free(text);
    if (!root->value) return false;
    if (json_is_object(root->value) || json_is_array(root->value)) {
        ffp_json_own(root->value);
        return true;
    }
    json_decref(root->value);
    root->value = NULL;
    return ffp_fail(err, FFP_ERROR_FILE, path, "contains no keys: is it a calibration in JSON, YAML or XML?");
}
