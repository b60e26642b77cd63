// The text at the head of a PLY file, and the rows behind it as numbers: any elements, any types of property,
// in each of the format's three encodings.
#ifndef FFP_GAUSSIANS_PLY_HEADER_H
#define FFP_GAUSSIANS_PLY_HEADER_H

#include <stdio.h>
#include "core/base/error.h"
#include "core/gaussians/gaussians.h"

typedef enum FfpPlyEncoding { FFP_PLY_ASCII, FFP_PLY_LITTLE, FFP_PLY_BIG } FfpPlyEncoding;
typedef enum FfpPlyType {
    FFP_PLY_INT8,
    FFP_PLY_UINT8,
    FFP_PLY_INT16,
    FFP_PLY_UINT16,
    FFP_PLY_INT32,
    FFP_PLY_UINT32,
    FFP_PLY_FLOAT,
    FFP_PLY_DOUBLE,
    FFP_PLY_NO_TYPE
} FfpPlyType;

int ffp_ply_bytes(FfpPlyType type);

enum { FFP_PLY_NAME = 64, FFP_PLY_ELEMENTS = 32, FFP_PLY_PROPERTIES = 1024 }; // the most of a file

typedef struct FfpPlyProperty {
    char name[FFP_PLY_NAME];
    FfpPlyType type;
    FfpPlyType length; // of a list's length; FFP_PLY_NO_TYPE: a single number
} FfpPlyProperty;

typedef struct FfpPlyElement {
    char name[FFP_PLY_NAME];
    int64_t count;
    int first, properties; // among those of the file
    int stride;            // bytes of a row in binary, of lists only the length
    bool lists;
} FfpPlyElement;

typedef struct FfpPly {
    FfpPlyEncoding encoding;
    FfpPlyElement elements[FFP_PLY_ELEMENTS];
    int n_elements;
    FfpPlyProperty properties[FFP_PLY_PROPERTIES];
    int n_properties;
    char made_from[FFP_MADE_FROM];
    FfpBakedShadows baked;
} FfpPly;

// Reads up to and including the line "end_header". Errors: not a PLY, an unknown encoding or type, a count
// that is not a number or above FFP_GAUSSIANS_MAX, an element or property that is there twice, more of them
// than above.
bool ffp_ply_header_read(FfpPly *ply, FILE *stream, const char *path, FfpError *err);
// That of `count` of the Gaussians.
void ffp_ply_header_write(FILE *stream, int64_t count, const FfpGaussians *gaussians);

const FfpPlyElement *ffp_ply_element(const FfpPly *ply, const char *name); // NULL: there is none
// Where the property is in the element's rows, counted from 0; -1: there is none.
int ffp_ply_find(const FfpPly *ply, const FfpPlyElement *element, const char *name);

// Checks that the rows fit into what follows the header, so that a count can never ask for more memory than
// the file's size warrants. A note counts the bytes that are left, unless there are lists or text.
bool ffp_ply_check_size(const FfpPly *ply, FILE *stream, const char *path, FfpError *err);
// The next row of the element: one number for each property (room for FFP_PLY_PROPERTIES), for a list its
// length. Error: the file ends, or holds text that is not a number.
bool ffp_ply_row(const FfpPly *ply, const FfpPlyElement *element, FILE *stream, double *values,
                 const char *path, FfpError *err);
bool ffp_ply_skip(const FfpPly *ply, const FfpPlyElement *element, FILE *stream, const char *path,
                  FfpError *err); // all rows

#endif
