// XML through expat, as OpenCV's FileStorage means it.
#include <expat.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "rig/optics/document.h"

#if XML_MAJOR_VERSION * 1000 + XML_MINOR_VERSION >= 2009 // which has deprecated the other
#define LINE_OF XML_GetCurrentLineNumber64
#else
#define LINE_OF XML_GetCurrentLineNumber
#endif

#define SPACE " \t\r\n"

// An element that is open: what came of it so far.
typedef struct Element {
    char name[64];
    json_t *object, *array; // children by name; children called "_"; NULL until there is one
    char *text;             // zero-terminated; NULL: none yet
    size_t length, room;
} Element;

typedef struct Reader {
    XML_Parser parser;
    const char *path;
    FfpError *err;
    Element stack[FFP_DOCUMENT_DEPTH_MAX];
    int depth;
    bool failed;
    json_t *root;
} Reader;

static void stop(Reader *reader, const char *what) {
    if (reader->failed) return;
    reader->failed = true;
    ffp_document_fail(reader->path, LINE_OF(reader->parser), reader->err, "broken XML: %s", what);
    XML_StopParser(reader->parser, XML_FALSE);
}

static void on_start(void *data, const XML_Char *name, const XML_Char **attributes) {
    (void)attributes;
    Reader *reader = data;
    if (reader->failed) return;
    if (reader->depth == FFP_DOCUMENT_DEPTH_MAX) {
        stop(reader, "nested too deeply");
        return;
    }
    Element *element = &reader->stack[reader->depth];
    if (strlen(name) >= sizeof element->name) {
        stop(reader, "an element's name is too long");
        return;
    }
    *element = (Element){0};
    memcpy(element->name, name, strlen(name) + 1);
    reader->depth++;
}

static void on_text(void *data, const XML_Char *text, int length) {
    Reader *reader = data;
    if (reader->failed || reader->depth == 0) return;
    Element *element = &reader->stack[reader->depth - 1];
    const size_t needed = element->length + (size_t)length + 1; // the file's size bounds it
    if (needed > element->room) {
        element->room = 2 * needed;
        char *more = ffp_try_grow(element->text, element->room, 1);
        if (!more) {
            stop(reader, "out of memory");
            if (reader->err) reader->err->code = FFP_ERROR_MEMORY;
            return;
        }
        element->text = more;
    }
    memcpy(element->text + element->length, text, (size_t)length);
    element->length += (size_t)length;
    element->text[element->length] = 0;
}

static void on_entity(void *data, const XML_Char *name, int is_parameter, const XML_Char *value, int length,
                      const XML_Char *base, const XML_Char *system, const XML_Char *public,
                      const XML_Char *notation) {
    (void)name, (void)is_parameter, (void)value, (void)length, (void)base, (void)system, (void)public;
    (void)notation;
    stop(data, "entities are not supported");
}

// A list of numbers when there are several and all are; otherwise one scalar.
static json_t *leaf(const Element *element) {
    const char *text = element->text ? element->text : "";
    text += strspn(text, SPACE);
    size_t length = strlen(text);
    while (length > 0 && strchr(SPACE, text[length - 1])) length--;
    if (strcspn(text, SPACE) >= length) return ffp_document_scalar(text, length);
    json_t *list = json_array();
    for (const char *at = text; at < text + length; at += strspn(at, SPACE)) {
        const size_t token = strcspn(at, SPACE);
        json_t *value = ffp_document_scalar(at, token);
        const bool number = json_is_number(value);
        if (value) json_array_append_new(list, value);
        if (!number) {
            json_decref(list);
            return ffp_document_scalar(text, length);
        }
        at += token;
    }
    return list;
}

static json_t *value_of(Reader *reader, Element *element) {
    const char *text = element->text ? element->text : "";
    if (!element->object && !element->array) {
        json_t *value = leaf(element);
        if (!value) stop(reader, "text that is not UTF-8");
        return value;
    }
    if (element->object && element->array)
        stop(reader, "an element holds both items called _ and others");
    else if (text[strspn(text, SPACE)] != 0)
        stop(reader, "an element holds both text and elements");
    return json_incref(element->object ? element->object : element->array);
}

static void release(Element *element) {
    json_decref(element->object);
    json_decref(element->array);
    ffp_free(element->text);
}

static void on_end(void *data, const XML_Char *name) {
    (void)name;
    Reader *reader = data;
    if (reader->failed || reader->depth == 0) return;
    Element *element = &reader->stack[reader->depth - 1];
    json_t *value = value_of(reader, element);
    reader->depth--;
    Element *parent = reader->depth > 0 ? &reader->stack[reader->depth - 1] : NULL;
    if (!parent) {
        reader->root = value;
    } else if (strcmp(element->name, "_") == 0) {
        if (!parent->array) parent->array = json_array();
        json_array_append_new(parent->array, value);
    } else {
        if (!parent->object) parent->object = json_object();
        if (json_object_get(parent->object, element->name)) stop(reader, "duplicate element");
        json_object_set_new(parent->object, element->name, value);
    }
    release(element);
}

json_t *ffp_xml_parse(const char *text, size_t size, const char *path, FfpError *err) {
    Reader *reader = ffp_alloc(1, sizeof *reader);
    reader->path = path, reader->err = err;
    reader->parser = XML_ParserCreate(NULL);
    XML_SetUserData(reader->parser, reader);
    XML_SetElementHandler(reader->parser, on_start, on_end);
    XML_SetCharacterDataHandler(reader->parser, on_text);
    XML_SetEntityDeclHandler(reader->parser, on_entity);
    // Not above FFP_DOCUMENT_BYTES_MAX, so it fits an int.
    if (XML_Parse(reader->parser, text, (int)size, 1) != XML_STATUS_OK)
        stop(reader, XML_ErrorString(XML_GetErrorCode(reader->parser)));
    for (int i = 0; i < reader->depth; i++) release(&reader->stack[i]);
    json_t *root = reader->root;
    if (reader->failed) {
        json_decref(root);
        root = NULL;
    }
    XML_ParserFree(reader->parser);
    ffp_free(reader);
    return root;
}
