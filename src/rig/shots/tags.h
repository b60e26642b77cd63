// The orientation tags of photographs. A rig stands still, so nothing turns between them: tags that differ
// are the camera's error.
#ifndef FFP_SHOTS_TAGS_H
#define FFP_SHOTS_TAGS_H

#include "core/base/error.h"

// The tag of photographs that belong together, 1 to 8 (1: upright, or none); 0 with an error: they have
// several. Files that are NULL are passed over.
int ffp_tag_of(const char *const *files, int n, const char *where, FfpError *err);
// The tag that most of n have; those that are 0 do not count.
int ffp_tag_usual(const int *tags, int n);
// Reports an orientation tag ("view 045", "attitude-03") that differs from the majority's. Returns false.
bool ffp_tag_fail(const char *whose, int tag, int usual, const char *where, FfpError *err);

#endif
