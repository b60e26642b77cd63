// Checked access to the fields of an untrusted JSON file. A field knows its place, so that every error reads
// "WHAT (FILE: views[3].c2w)". Numbers must be numbers, finite and in range; names and files must be
// harmless.
#ifndef FFP_CAPTURE_NODE_H
#define FFP_CAPTURE_NODE_H

#include <jansson.h>
#include <stdbool.h>
#include "core/capture/capture.h"

typedef struct FfpNode {
    const char *file; // not owned
    char place[192];  // "" for the root
    json_t *value;    // borrowed
} FfpNode;

// Parses a JSON file whose root is an object. Released with ffp_node_close.
bool ffp_node_open(FfpNode *root, const char *path, FfpError *err);
void ffp_node_close(FfpNode *root);
// The JSON belongs to the current call (core/base/call.h) until it is released here.
void ffp_json_own(json_t *value);
void ffp_json_release(json_t *value);
// Adds a member to scene.json of a capture that was written into `folder`: to its object `section`, or, NULL,
// to the root. Takes `value` away in any case; NULL is an error.
bool ffp_scene_json_add(const char *folder, const char *section, const char *key, json_t *value,
                        FfpError *err);
bool ffp_node_fail(const FfpNode *field, FfpError *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

bool ffp_node_get(const FfpNode *parent, const char *key, FfpNode *out,
                  FfpError *err);                                         // missing or null: an error
bool ffp_node_find(const FfpNode *parent, const char *key, FfpNode *out); // false: missing or null
bool ffp_node_item(const FfpNode *array, int index, FfpNode *out, FfpError *err);
bool ffp_node_count(const FfpNode *array, int least, int most, int *count, FfpError *err); // of an array

bool ffp_node_number(const FfpNode *field, double low, double high, real *out, FfpError *err);
bool ffp_node_integer(const FfpNode *field, int low, int high, int *out, FfpError *err);
bool ffp_node_numbers(const FfpNode *field, int n, double low, double high, real *out,
                      FfpError *err); // [n]
bool ffp_node_text(const FfpNode *field, const char **out, FfpError *err);
// A name of views, patterns and captures, which becomes part of file names and of JSON: 1..FFP_NAME_MAX-1
// bytes of UTF-8, no '/', no '\', no control character, not "." or "..".
bool ffp_node_name(const FfpNode *field, char out[FFP_NAME_MAX], FfpError *err);
bool ffp_is_name(const char *text);
// True if JSON can contain the text: jansson accepts no other, and silently drops a field that it does not
// accept.
bool ffp_is_utf8(const char *text);
// A file name relative to the JSON's folder: not absolute and without "..".
bool ffp_node_file(const FfpNode *field, const char **out, FfpError *err);
bool ffp_is_inner_path(const char *text);

// Rows of a rigid 4x4 matrix, made exactly orthonormal. `blender`: x right, y up, -z forward in, OpenCV's
// axes out.
bool ffp_node_pose(const FfpNode *field, bool blender, real pose[16], FfpError *err);

// The same for numbers in memory; NULL, or a description of the fault.
const char *ffp_pose_settle(real pose[16], bool blender);

#define FFP_LENGTH_MAX 1e9 // of positions, world units; squares of it still fit a float

// child(parent, key) and its number in one step.
bool ffp_get_number(const FfpNode *parent, const char *key, double low, double high, real *out,
                    FfpError *err);
bool ffp_get_whole(const FfpNode *parent, const char *key, int low, int high, int *out, FfpError *err);

#endif
