// Which scene a draw uses. Everything here follows from the configuration, the draw, the step that the run
// began at and whose turn it is; threads only decide who makes a scene.
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "lab/train/captures.h"
#include "lab/train/queue.h"

struct FfpStream {
    const FfpTrainConfig *config;
    FfpSceneOrigin origin;
    FfpRank turn;
    int64_t first, end; // draws of this run: first <= draw < end
    FfpQueue *queue;    // NULL: scenes are made by the caller
    FfpScene *slots;    // [pool]
    bool *full;         // [pool]
};

int ffp_scene_slot(const FfpTrainConfig *config, int64_t draw) {
    return (int)(draw % config->pool);
}

// The slots' changes are staggered over `reuse` rounds: slot s counts its rounds from here.
static int64_t shift_of(const FfpTrainConfig *config, int64_t slot) {
    return slot * config->reuse / config->pool;
}

int64_t ffp_scene_number(const FfpTrainConfig *config, int64_t draw) {
    const int64_t slot = draw % config->pool, round = draw / config->pool;
    return (round + shift_of(config, slot)) / config->reuse * config->pool + slot;
}

// The first draw from `from` on whose turn it is.
static int64_t own_draw(const FfpStream *stream, int64_t from) {
    const FfpRank t = stream->turn;
    return from + (t.rank - from % t.count + t.count) % t.count;
}

// The first draw from `from` on at which `slot` takes its next number.
static int64_t next_number(const FfpTrainConfig *config, int64_t slot, int64_t from) {
    const int64_t round = (from - slot + config->pool - 1) / config->pool;
    const int64_t uses = (round + shift_of(config, slot)) % config->reuse;
    return (round + (config->reuse - uses) % config->reuse) * config->pool + slot;
}

static int64_t next_scene(const void *context, int64_t from) {
    const FfpStream *stream = context;
    const FfpTrainConfig *config = stream->config;
    int64_t best = stream->end;
    from = own_draw(stream, from);
    if (from < stream->first + config->pool) best = from; // at the beginning of the run every slot changes
    for (int slot = stream->turn.rank; slot < config->pool; slot += stream->turn.count) {
        const int64_t draw = next_number(config, slot, from);
        best = draw < best ? draw : best;
    }
    return best < stream->end ? best : -1;
}

static bool make_scene(const void *context, int64_t draw, FfpScene *scene, FfpError *err) {
    const FfpStream *stream = context;
    const FfpTrainConfig *config = stream->config;
    const int64_t number = ffp_scene_number(config, draw);
    const FfpSceneOrigin *from = &stream->origin;
    if (from->captures) return ffp_captures_scene(scene, config, from->captures, number, err);
    if (from->rooms && ffp_is_room(config, number))
        return ffp_rooms_scene(scene, config, from->rooms, number, err);
    return from->folder ? ffp_scene_read(scene, config, from->folder, number, err)
                        : ffp_scene_open(scene, config, from->stock, "train", number, err);
}

// The scenes in the slots may come from threads of the queue, whose calls have ended: nobody else gives them
// back when the call at work is left.
static void free_stream(void *thing) {
    FfpStream *stream = thing;
    ffp_queue_free(stream->queue);
    for (int i = 0; i < stream->config->pool; i++)
        if (stream->full[i]) ffp_scene_close(&stream->slots[i]);
    ffp_free(stream->slots);
    ffp_free(stream->full);
    ffp_free(stream);
}

FfpStream *ffp_stream_new(const FfpTrainConfig *config, const FfpSceneOrigin *origin, FfpRank turn,
                          int64_t first, int64_t end, atomic_bool *stop, FfpError *err) {
    FfpStream *stream = ffp_alloc(1, sizeof *stream);
    *stream = (FfpStream){.config = config,
                          .origin = *origin,
                          .turn = turn,
                          .first = first * config->batch,
                          .end = end * config->batch};
    stream->slots = ffp_alloc((size_t)config->pool, sizeof *stream->slots);
    stream->full = ffp_alloc((size_t)config->pool, sizeof *stream->full);
    if (config->generators > 0) {
        const FfpSceneSource source = {stream, next_scene, make_scene};
        stream->queue = ffp_queue_new(&source, stream->first, config->generators, config->queue, stop, err);
        if (!stream->queue) {
            free_stream(stream);
            return NULL;
        }
    }
    ffp_own(stream, free_stream);
    return stream;
}

bool ffp_stream_scene(FfpStream *stream, int64_t draw, const FfpScene **scene, bool *fresh, FfpError *err) {
    const int slot = ffp_scene_slot(stream->config, draw);
    FfpScene *place = &stream->slots[slot];
    bool stopped = false;
    *scene = place;
    *fresh = next_scene(stream, draw) == draw;
    if (!*fresh) return true;
    if (stream->full[slot]) ffp_scene_close(place);
    stream->full[slot] = false; // making the next one may leave the call
    const bool ok = stream->queue ? ffp_queue_take(stream->queue, place, &stopped, err)
                                  : make_scene(stream, draw, place, err);
    stream->full[slot] = ok && !stopped;
    if (!stream->full[slot]) *scene = NULL;
    return ok;
}

void ffp_stream_free(FfpStream *stream) {
    ffp_disown(stream);
    if (stream) free_stream(stream);
}
