#include "rig/shots/tags.h"
#include "core/base/file.h"
#include "core/image/image.h"
#include "rig/findings/tell.h"

enum { TAGS = 8 };

static const char *words_of(int tag) {
    return tag > 1 ? ffp_orientation_words(tag) : "upright";
}

int ffp_tag_of(const char *const *files, int n, const char *where, FfpError *err) {
    const char *first = NULL;
    int tag = 1;
    for (int i = 0; i < n; i++) {
        if (!files[i]) continue;
        const int own = ffp_image_orientation(files[i]);
        if (!first) first = files[i], tag = own;
        if (own == tag) continue;
        ffp_fail_by(FFP_RULE_TAGS_MIXED,
                    &(FfpFacts){.a = ffp_basename(first), .b = words_of(tag), .c = ffp_basename(files[i])},
                    where, err);
        return 0;
    }
    return tag;
}

int ffp_tag_usual(const int *tags, int n) {
    int count[TAGS + 1] = {0}, usual = 1;
    for (int i = 0; i < n; i++)
        if (tags[i] > 0 && ++count[tags[i]] > count[usual]) usual = tags[i];
    return usual;
}

bool ffp_tag_fail(const char *whose, int tag, int usual, const char *where, FfpError *err) {
    return ffp_fail_by(FFP_RULE_TAGS_DIFFER,
                       &(FfpFacts){.a = whose, .b = words_of(tag), .c = words_of(usual)}, where, err);
}
