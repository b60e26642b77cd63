// Checked access to the fields of a JSON file that came from outside. A field knows its place, so that every
// complaint reads "WHAT (FILE: views[3].c2w)". Numbers must be numbers, finite and in range; names and files
// must be harmless.
#ifndef FFP_CAPTURE_FIELDS_H
#define FFP_CAPTURE_FIELDS_H

#include <jansson.h>
#include <stdbool.h>
#include "capture/capture.h"

typedef struct FfpField {
    const char *file; // not owned
    char place[192];  // "" for the root
    json_t *value;    // borrowed
} FfpField;

// Parses a JSON file whose root is an object. Released with ffp_field_close.
bool ffp_field_open(FfpField *root, const char *path, FfpError *err);
void ffp_field_close(FfpField *root);
// The JSON belongs to the call at work (base/call.h) until it is released here.
void ffp_json_own(json_t *value);
void ffp_json_release(json_t *value);
bool ffp_field_fail(const FfpField *field, FfpError *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

bool ffp_field_get(const FfpField *parent, const char *key, FfpField *out,
                   FfpError *err);                                           // missing or null: an error
bool ffp_field_find(const FfpField *parent, const char *key, FfpField *out); // false: missing or null
bool ffp_field_item(const FfpField *array, int index, FfpField *out, FfpError *err);
bool ffp_field_count(const FfpField *array, int least, int most, int *count, FfpError *err); // of an array

bool ffp_field_number(const FfpField *field, double low, double high, real *out, FfpError *err);
bool ffp_field_whole(const FfpField *field, int low, int high, int *out, FfpError *err);
bool ffp_field_numbers(const FfpField *field, int n, double low, double high, real *out,
                       FfpError *err); // [n]
bool ffp_field_text(const FfpField *field, const char **out, FfpError *err);
// A name of views, patterns and captures, which becomes part of file names and of JSON: 1..FFP_NAME_MAX-1
// bytes of UTF-8, no '/', no '\', no control character, not "." or "..".
bool ffp_field_name(const FfpField *field, char out[FFP_NAME_MAX], FfpError *err);
bool ffp_is_name(const char *text);
// Whether JSON can hold it: jansson takes no other text, and a field that it does not take is not there.
bool ffp_is_utf8(const char *text);
// A file name relative to the JSON's folder: not absolute and without "..".
bool ffp_field_file(const FfpField *field, const char **out, FfpError *err);
bool ffp_is_inner_path(const char *text);

// Rows of a rigid 4x4 matrix, made exactly orthonormal. `blender`: x right, y up, -z forward in, OpenCV's
// axes out.
bool ffp_field_pose(const FfpField *field, bool blender, real pose[16], FfpError *err);

// The same for numbers that are there already; NULL, or what is wrong with them.
const char *ffp_pose_settle(real pose[16], bool blender);

#define FFP_LENGTH_MAX 1e9 // of positions, world units; squares of it still fit a float

// child(parent, key) and its number in one step.
bool ffp_get_number(const FfpField *parent, const char *key, double low, double high, real *out,
                    FfpError *err);
bool ffp_get_whole(const FfpField *parent, const char *key, int low, int high, int *out, FfpError *err);

#endif
