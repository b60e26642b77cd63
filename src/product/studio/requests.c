// Requests of a page: a photograph, a picture of the user's, or a verb (verbs.c).
#include <stdlib.h>
#include <string.h>
#include "rules.h"

static bool store(FfpStudio *studio, const FfpStudioRequest *r, char *said) {
    char *end;
    const long shot = r->number ? strtol(r->number, &end, 10) : -1;
    if (!r->set || !r->number || *end || shot < 0 || shot > 999)
        return ffp_studio_say(said, "a photograph needs its set and its number");
    return ffp_studio_store(studio, r->set, (int)shot, r->body, r->size, said);
}

static bool act(FfpStudio *studio, const FfpStudioRequest *r, char *said) {
    if (strcmp(r->path, "photograph") == 0) return store(studio, r, said);
    if (strcmp(r->path, "own") == 0)
        return ffp_studio_store_own(studio, r->watch && strcmp(r->watch, "true") == 0, r->body, r->size,
                                    said);
    json_t *asked = json_loadb(r->body, r->size, JSON_REJECT_DUPLICATES, NULL);
    const bool ok =
        json_is_object(asked) ? ffp_studio_do(studio, asked, said) : ffp_studio_say(said, "this is not JSON");
    json_decref(asked);
    return ok;
}

json_t *ffp_studio_answer(FfpStudio *studio, const FfpStudioRequest *request, bool *ok) {
    char said[FFP_STUDIO_SAID] = "";
    *ok = act(studio, request, said);
    json_t *state = ffp_studio_state(studio);
    if (!*ok && state) json_object_set_new(state, "error", json_string(said));
    return state;
}
