// Files of other tools, whatever they are written in, as one tree of checked fields (core/capture/node.h).
#ifndef FFP_RIG_DOCUMENT_H
#define FFP_RIG_DOCUMENT_H

#include "core/capture/node.h"

#define FFP_DOCUMENT_BYTES_MAX ((size_t)32 << 20)
#define FFP_DOCUMENT_DEPTH_MAX 64

// Reads JSON, XML or YAML, told apart by the first character. The root is an object or an array; it is
// released with ffp_node_close. Errors name the file and the line: broken text, nesting deeper than
// FFP_DOCUMENT_DEPTH_MAX, one key twice in one map, YAML aliases and XML entities.
// - YAML: plain scalars that are finite decimal numbers become numbers, all others texts. OpenCV's first line
//   "%YAML:1.0" is understood; tags are passed over.
// - XML: an element with children is an object, or an array when all of them are called "_"; without
//   children it is a number, a list of numbers, or a text. Attributes are passed over.
bool ffp_document_open(FfpNode *root, const char *path, FfpError *err);

// The value of a scalar that stands without quotes in a file: a number when all of it is one, otherwise a
// text. NULL when it is not valid UTF-8.
json_t *ffp_document_scalar(const char *text, size_t length);

// The formats behind it; `text` has a zero byte behind its end. NULL on failure.
json_t *ffp_yaml_parse(char *text, size_t size, const char *path, FfpError *err);
json_t *ffp_xml_parse(const char *text, size_t size, const char *path, FfpError *err);

// "FILE: line N" for errors.
bool ffp_document_fail(const char *path, size_t line, FfpError *err, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#endif
