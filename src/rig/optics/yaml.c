// YAML through libyaml's events. Aliases are refused: a few lines of them unfold into gigabytes, and no
// calibration needs them.
#include <stdlib.h>
#include <string.h>
#include <yaml.h>
#include "rig/optics/document.h"

typedef struct Reader {
    yaml_parser_t parser;
    const char *path;
    FfpError *err;
} Reader;

static bool fail_at(const Reader *reader, const yaml_mark_t *mark, const char *what) {
    return ffp_document_fail(reader->path, mark->line + 1, reader->err, "broken YAML: %s", what);
}

static bool next(Reader *reader, yaml_event_t *event) {
    if (yaml_parser_parse(&reader->parser, event)) return true;
    const char *problem = reader->parser.problem;
    return fail_at(reader, &reader->parser.problem_mark, problem ? problem : "cannot read it");
}

static json_t *scalar(const yaml_event_t *event) {
    const char *text = (const char *)event->data.scalar.value;
    const size_t length = event->data.scalar.length;
    if (event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE) {
        if (length == 0 || (length == 1 && *text == '~')) return json_null();
        return ffp_document_scalar(text, length);
    }
    return !memchr(text, 0, length) ? json_stringn(text, length) : NULL;
}

static json_t *read_node(Reader *reader, const yaml_event_t *event, int depth);

static bool read_items(Reader *reader, json_t *array, int depth) {
    for (;;) {
        yaml_event_t event;
        if (!next(reader, &event)) return false;
        const bool end = event.type == YAML_SEQUENCE_END_EVENT;
        json_t *value = end ? NULL : read_node(reader, &event, depth + 1);
        yaml_event_delete(&event);
        if (end) return true;
        if (!value || json_array_append_new(array, value) != 0) return false;
    }
}

static bool read_pair(Reader *reader, const yaml_event_t *key, json_t *object, int depth) {
    if (key->type != YAML_SCALAR_EVENT) return fail_at(reader, &key->start_mark, "a key must be a string");
    const char *name = (const char *)key->data.scalar.value;
    if (strlen(name) != key->data.scalar.length || json_object_get(object, name)) {
        return fail_at(reader, &key->start_mark, "a key is repeated, or contains a zero byte");
    }
    yaml_event_t event;
    if (!next(reader, &event)) return false;
    json_t *value = read_node(reader, &event, depth + 1);
    yaml_event_delete(&event);
    return value && json_object_set_new(object, name, value) == 0;
}

static bool read_pairs(Reader *reader, json_t *object, int depth) {
    for (;;) {
        yaml_event_t event;
        if (!next(reader, &event)) return false;
        const bool end = event.type == YAML_MAPPING_END_EVENT;
        const bool ok = end || read_pair(reader, &event, object, depth);
        yaml_event_delete(&event);
        if (end || !ok) return ok;
    }
}

// The node that `event` begins; NULL after an error.
static json_t *read_node(Reader *reader, const yaml_event_t *event, int depth) {
    json_t *value = NULL;
    bool ok = false;
    if (depth > FFP_DOCUMENT_DEPTH_MAX) {
        fail_at(reader, &event->start_mark, "nested too deeply");
    } else if (event->type == YAML_SCALAR_EVENT) {
        value = scalar(event);
        ok = value || fail_at(reader, &event->start_mark, "a string contains a zero byte");
    } else if (event->type == YAML_SEQUENCE_START_EVENT) {
        value = json_array();
        ok = read_items(reader, value, depth);
    } else if (event->type == YAML_MAPPING_START_EVENT) {
        value = json_object();
        ok = read_pairs(reader, value, depth);
    } else {
        fail_at(reader, &event->start_mark, "aliases are not supported");
    }
    if (ok) return value;
    json_decref(value);
    return NULL;
}

// Reads on to the end, which must come now.
static bool read_end(Reader *reader) {
    for (;;) {
        yaml_event_t event;
        if (!next(reader, &event)) return false;
        const yaml_event_type_t type = event.type;
        const yaml_mark_t mark = event.start_mark;
        yaml_event_delete(&event);
        if (type == YAML_STREAM_END_EVENT) return true;
        if (type != YAML_DOCUMENT_END_EVENT) return fail_at(reader, &mark, "a second document in the file");
    }
}

// Stream start, document start, one node, the end.
static json_t *read_document(Reader *reader) {
    for (;;) {
        yaml_event_t event;
        if (!next(reader, &event)) return NULL;
        json_t *value = NULL;
        const bool before = event.type == YAML_STREAM_START_EVENT || event.type == YAML_DOCUMENT_START_EVENT;
        if (event.type == YAML_STREAM_END_EVENT)
            fail_at(reader, &event.start_mark, "the file is empty");
        else if (!before)
            value = read_node(reader, &event, 0);
        yaml_event_delete(&event);
        if (before) continue;
        if (!value || read_end(reader)) return value;
        json_decref(value);
        return NULL;
    }
}

json_t *ffp_yaml_parse(char *text, size_t size, const char *path, FfpError *err) {
    // OpenCV's own way of writing the directive is no YAML: it becomes a comment.
    if (strncmp(text, "%YAML:", 6) == 0) text[0] = '#';
    Reader reader = {.path = path, .err = err};
    if (!yaml_parser_initialize(&reader.parser)) {
        ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
        return NULL;
    }
    yaml_parser_set_encoding(&reader.parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&reader.parser, (const unsigned char *)text, size);
    json_t *value = read_document(&reader);
    yaml_parser_delete(&reader.parser);
    return value;
}
