// Masks from the empty stage: a red ball that a turntable carries round in front of a lit, chequered wall, on
// which its shadow falls; drawn here, so that every pixel is known.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "named.h"
#include "rig/masks/free_space.h"
#include "rig/masks/steps.h"

enum { VIEWS = 8, WIDTH = 120, HEIGHT = 96, PATTERNS = 3, PANEL_WIDTH = 256, PANEL_HEIGHT = 128 };

static const double ball_radius = 0.6, axis_far = 5, wall_far = 7.5, lamp[3] = {2.4, -1.2, 0};
static FfpError err;

typedef struct Room {
    FfpCapture capture;
    FfpImage truth[VIEWS];
    FfpEmptyStage stage;
    const FfpEmptyStage *stages[VIEWS];
    const char *paths[VIEWS];
} Room;

// Distance along a ray to a ball; INFINITY when it misses.
static double hit(const double from[3], const double d[3], const double centre[3]) {
    double b = 0, c = -ball_radius * ball_radius;
    for (int i = 0; i < 3; i++) b += (from[i] - centre[i]) * d[i], c += pow(from[i] - centre[i], 2);
    const double root = b * b - c, t = -b - sqrt(fmax(root, 0));
    return root > 0 && t > 1e-4 ? t : INFINITY;
}

// The projector's light under a pattern in a direction, x / z: black, white, stripes of three widths.
static double sent(double direction, int pattern, int channel) {
    static const double frequencies[3] = {6, 14, 33};
    return pattern < 2 ? pattern : 0.5 + 0.5 * sin(frequencies[channel] * direction);
}

// Linear light of a point of a surface with this normal; a shadow leaves the room's.
static void light(const double point[3], const double normal[3], const double albedo[3], bool shadow,
                  int pattern, double out[3]) {
    double to[3], square = 0, cosine = 0;
    for (int i = 0; i < 3; i++) to[i] = lamp[i] - point[i], square += to[i] * to[i];
    for (int i = 0; i < 3; i++) cosine += to[i] * normal[i] / sqrt(square);
    const double lit = shadow ? 0 : fmax(cosine, 0) * 12 / square;
    const double direction = (point[0] - lamp[0]) / (point[2] - lamp[2]);
    for (int c = 0; c < 3; c++)
        out[c] = albedo[c] * (0.02 + lit * sent(direction, pattern, c) + 0.01 * (pattern > 0));
}

// The light along a pixel's ray; true if it is the ball's. NULL: there is no ball.
static bool shade(const double d[3], const double centre[3], int pattern, double out[3]) {
    static const double red[3] = {0.7, 0.2, 0.1}, forward[3] = {0, 0, -1}, origin[3] = {0, 0, 0};
    double point[3], normal[3], to[3], length = 0;
    const double near = centre ? hit(origin, d, centre) : INFINITY;
    const double t = isfinite(near) ? near : wall_far / d[2];
    for (int i = 0; i < 3; i++) point[i] = t * d[i];
    if (isfinite(near)) {
        for (int i = 0; i < 3; i++) normal[i] = (point[i] - centre[i]) / ball_radius;
        light(point, normal, red, false, pattern, out);
        return true;
    }
    for (int i = 0; i < 3; i++) to[i] = lamp[i] - point[i], length += to[i] * to[i];
    for (int i = 0; i < 3; i++) to[i] /= sqrt(length);
    const bool dark = ((int)floor(point[0]) + (int)floor(point[1])) % 2 != 0;
    const double grey[3] = {dark ? 0.3 : 0.6, dark ? 0.3 : 0.6, dark ? 0.28 : 0.6};
    light(point, forward, grey, centre && isfinite(hit(point, to, centre)), pattern, out);
    return false;
}

// 3 x 3 samples a pixel, and noise that repeats.
static FfpImage draw(const double centre[3], int pattern, FfpImage *share) {
    FfpImage out = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < 9 * WIDTH * HEIGHT; i++) {
        const int pixel = i / 9, k = i % 9;
        double d[3] = {(pixel % WIDTH + (k % 3 + 0.5) / 3 - WIDTH / 2.0) / 130,
                       (pixel / WIDTH + (k / 3 + 0.5) / 3 - HEIGHT / 2.0) / 130, 1},
               colour[3];
        const double length = sqrt(d[0] * d[0] + d[1] * d[1] + 1);
        for (int c = 0; c < 3; c++) d[c] /= length;
        const bool ball = shade(d, centre, pattern, colour);
        for (int c = 0; c < 3; c++) out.data[3 * pixel + c] += (real)(colour[c] / 9);
        if (share) share->data[pixel] += ball ? 1.0F / 9 : 0;
    }
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        out.data[i] = (real)fmax(0, (double)out.data[i] + 0.0015 * sin(12.9898 * i + 78.233 * pattern));
    return out;
}

static void place(FfpCamera *camera, double angle) {
    const double c = cos(angle), s = sin(angle);
    const double pose[16] = {c, 0, s, -s * axis_far, 0, 1, 0, 0, -s, 0, c, -c * axis_far, 0, 0, 0, 1};
    *camera = (FfpCamera){
        .width = WIDTH, .height = HEIGHT, .fx = 130, .fy = 130, .cx = WIDTH / 2.0F, .cy = HEIGHT / 2.0F};
    for (int i = 0; i < 16; i++) camera->pose[i] = (real)pose[i];
}

// The lamp is a projector that looks the camera's way.
static void place_projector(FfpCamera *projector, const FfpCamera *camera) {
    *projector =
        (FfpCamera){.width = PANEL_WIDTH, .height = PANEL_HEIGHT, .fx = 120, .fy = 120, .cx = 200, .cy = 40};
    for (int i = 0; i < 16; i++) projector->pose[i] = camera->pose[i];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) projector->pose[4 * i + 3] += camera->pose[4 * i + k] * (real)lamp[k];
}

static FfpPattern new_pattern(int number, const FfpCamera *projector) {
    static const char *const names[PATTERNS] = {"black", "white", "stripes"};
    FfpPattern out = {.image = ffp_image_new(PANEL_WIDTH, PANEL_HEIGHT, 3)};
    snprintf(out.name, sizeof out.name, "%s", names[number]);
    for (int i = 0; i < 3 * PANEL_WIDTH * PANEL_HEIGHT; i++) {
        const double u = i / 3 % PANEL_WIDTH + 0.5;
        out.image.data[i] = (real)sent((u - (double)projector->cx) / (double)projector->fx, number, i % 3);
    }
    return out;
}

static Room *new_room(bool with_ball) {
    Room *room = ffp_alloc(1, sizeof *room);
    FfpCapture *capture = &room->capture;
    capture->n_views = VIEWS, capture->n_patterns = PATTERNS, capture->white = 1;
    capture->views = ffp_alloc(VIEWS, sizeof *capture->views);
    room->stage.images = ffp_alloc(PATTERNS, sizeof(FfpImage));
    for (int p = 0; p < PATTERNS; p++) room->stage.images[p] = draw(NULL, p, NULL);
    for (int v = 0; v < VIEWS; v++) {
        FfpView *view = &capture->views[v];
        const double angle = v * acos(-1.0) / 4; // of the camera; the ball turns the other way
        const double centre[3] = {0.5 * cos(angle), 0.1, axis_far + 0.5 * sin(angle)};
        place(&view->camera, angle);
        place_projector(&view->projector, &view->camera);
        view->images = ffp_alloc(PATTERNS, sizeof(FfpImage));
        room->truth[v] = ffp_image_new(WIDTH, HEIGHT, 1);
        for (int p = 0; p < PATTERNS; p++)
            view->images[p] = draw(with_ball ? centre : NULL, p, p == 0 ? &room->truth[v] : NULL);
        room->stages[v] = &room->stage, room->paths[v] = "white.png";
    }
    capture->patterns = ffp_alloc(PATTERNS, sizeof *capture->patterns);
    for (int p = 0; p < PATTERNS; p++) capture->patterns[p] = new_pattern(p, &capture->views[0].projector);
    return room;
}

static void free_room(Room *room) {
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&room->stage.images[p]);
    for (int v = 0; v < VIEWS; v++) ffp_image_free(&room->truth[v]);
    ffp_free(room->stage.images);
    ffp_capture_free(&room->capture);
    ffp_free(room);
}

typedef struct Agreement {
    double overlap, missing, extra, edge; // shares of the object; mean difference on the outline
} Agreement;

static Agreement compare(const Room *room) {
    double both = 0, either = 0, object = 0, off = 0, n = 0;
    for (int v = 0; v < VIEWS; v++)
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const double t = (double)room->truth[v].data[i],
                         m = (double)room->capture.views[v].coverage.data[i];
            both += t >= 0.5 && m >= 0.5, either += t >= 0.5 || m >= 0.5, object += t >= 0.5;
            if (t > 0.05 && t < 0.95) off += fabs(t - m), n++;
        }
    const Agreement out = {both / either, 1 - both / object, (either - object) / object, off / n};
    printf("overlap %.3f, missing %.4f, extra %.4f, outline off by %.3f\n", out.overlap, out.missing,
           out.extra, out.edge);
    return out;
}

// Masks as `import` makes them.
static bool make_masks(Room *room, FfpStageMasks *report, bool posed) {
    FfpCapture *capture = &room->capture;
    if (!ffp_stage_masks(report, capture, room->stages, posed, room->paths, &err)) return false;
    for (int v = 0; v < VIEWS; v++)
        ffp_soften_edges(capture, &capture->views[v], room->stages[v], report->noise[v]);
    return true;
}

// The ball's dark side and its shadow are told apart, and its outline is soft.
static void the_ball_is_found_in_its_room(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpStageMasks report;
    if (!make_masks(room, &report, true)) fail_msg("%s", err.text);
    const Agreement found = compare(room);
    assert_true(found.overlap > 0.95);
    assert_true(found.missing < 0.02);
    assert_true(found.edge < 0.25);
    assert_true(report.stage > 0.5 && report.object > 0.01);
    assert_float_equal(report.gain_least, 1, 0.02);
    free_room(room);
}

// Camera and projector see through what lies before the ball, and not through the ball.
static void space_before_the_ball_is_free(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpCapture *capture = &room->capture;
    FfpFreeSpace space;
    capture->radius = 0.8F, capture->centre[0] = 0.5F, capture->centre[1] = 0.1F; // where the ball stands
    for (int v = 0; v < VIEWS; v++) {
        ffp_image_free(&capture->views[v].coverage);
        capture->views[v].coverage = ffp_image_copy(&room->truth[v]);
    }
    assert_true(ffp_free_space_new(&space, capture));
    int before = 0, inside = 0;
    for (int v = 0; v < VIEWS; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        real to[3], point[3], length = 0;
        for (int k = 0; k < 3; k++) {
            to[k] = camera->pose[4 * k + 3] - capture->centre[k];
            length += to[k] * to[k];
        }
        for (int k = 0; k < 3; k++)
            point[k] = capture->centre[k] + 1.4F * (real)ball_radius * to[k] / sqrtf((float)length);
        before += ffp_free_space_votes(&space, v, point, 0.05F);
        inside += ffp_free_space_votes(&space, v, capture->centre, 0.05F);
    }
    assert_true(before >= VIEWS); // of two witnesses each, the camera at least
    assert_int_equal(inside, 0);
    ffp_free_space_free(&space);
    free_room(room);
}

// Without poses there is no hull: what is lit is object, and nothing in the shadow.
static void without_poses_light_alone_decides(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpStageMasks report;
    assert_true(make_masks(room, &report, false));
    const Agreement found = compare(room);
    assert_true(found.extra < 0.03);
    assert_true(found.missing < 0.3);
    free_room(room);
}

static void a_view_like_the_stage_is_refused(void **state) {
    (void)state;
    Room *room = new_room(false);
    FfpStageMasks report;
    assert_false(make_masks(room, &report, true));
    must_be(&err, FFP_RULE_NO_OBJECT);
    free_room(room);
}

static void turn_over(FfpImage *image) {
    for (int i = 0; i < 3 * WIDTH * HEIGHT / 2; i++) {
        const real kept = image->data[i];
        image->data[i] = image->data[3 * WIDTH * HEIGHT - 1 - i];
        image->data[3 * WIDTH * HEIGHT - 1 - i] = kept;
    }
}

// Another exposure is made up for, up to a point; a moved camera is refused.
static void other_light_is_told(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpStageMasks report;
    for (int p = 0; p < PATTERNS; p++)
        for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) room->stage.images[p].data[i] *= 1.25F;
    assert_true(make_masks(room, &report, true));
    assert_float_equal(report.gain_least, 0.8, 0.03);
    for (int p = 1; p < PATTERNS; p++) turn_over(&room->stage.images[p]);
    assert_false(make_masks(room, &report, true));
    assert_non_null(strstr(err.text, "white.png"));
    must_be(&err, FFP_RULE_STAGE_UNLIKE);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) room->stage.images[0].data[i] = 0.5F;
    assert_false(make_masks(room, &report, true));
    must_be(&err, FFP_RULE_STAGE_DIFFERS);
    free_room(room);
}

static char told[1024]; // by the last call: codes and views

static void keep_finding(void *user, const FfpFinding *f) {
    (void)user;
    const size_t length = strlen(told);
    snprintf(told + length, sizeof told - length, "%s %s;", f->code, f->view ? f->view : "");
}

static bool compare_with_stage(void *room, FfpError *e) {
    Room *r = room;
    bool made[VIEWS];
    FfpEmptyStage stages[VIEWS];
    for (int v = 0; v < VIEWS; v++) made[v] = true, stages[v] = r->stage;
    return ffp_masks_check_stage(&(FfpMasking){.capture = &r->capture, .made = made, .stages = stages}, e);
}

// The finding about the room's stage.
static const char *told_of(Room *room) {
    FfpContext context = {.settings = {.finding = keep_finding}};
    told[0] = 0;
    assert_true(ffp_call_run(&context, compare_with_stage, room, &err));
    return told;
}

static bool complete(void *room, FfpError *e) {
    Room *r = room;
    bool made[VIEWS];
    FfpEmptyStage stages[VIEWS];
    for (int v = 0; v < VIEWS; v++) made[v] = true, stages[v] = r->stage;
    return ffp_masks_complete(
        &(FfpMasking){
            .capture = &r->capture, .made = made, .stages = stages, .paths = r->paths, .posed = true},
        e);
}

// Another exposure of the stage, and then poses that are wrong.
static void what_makes_masks_doubtful_is_told(void **state) {
    (void)state;
    static const char *const codes[3] = {"", "stage-exposure ;", "masks-disagree ;"};
    FfpContext context = {.settings = {.finding = keep_finding}};
    for (int k = 0; k < 3; k++) {
        Room *room = new_room(true);
        for (int p = 0; p < PATTERNS && k == 1; p++)
            for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) room->stage.images[p].data[i] *= 1.25F;
        for (int v = 0; v < VIEWS && k == 2; v++) room->capture.views[v].camera.cx += v % 2 ? 12 : -12;
        told[0] = 0;
        if (!ffp_call_run(&context, complete, room, &err)) fail_msg("%s", err.text);
        assert_string_equal(told, codes[k]);
        free_room(room);
    }
}

// Picture content to the right by n pixels; what leaves comes back on the left.
static void push(FfpImage *image, int n) {
    FfpImage before = ffp_image_copy(image);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 3; c++)
            image->data[3 * (i - i % WIDTH + (i + n) % WIDTH) + c] = before.data[3 * i + c];
    ffp_image_free(&before);
}

// A lamp, a stage from another place, and one view from another place each have their own warning.
static void what_changed_since_the_stage_is_named(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpImage *images = room->stage.images;
    assert_string_equal(told_of(room), "");
    for (int p = 0; p < PATTERNS; p++) push(&room->capture.views[3].images[p], 4);
    snprintf(room->capture.views[3].id, FFP_NAME_MAX, "135");
    assert_string_equal(told_of(room), "view-elsewhere 135;");
    for (int p = 0; p < PATTERNS; p++) push(&room->capture.views[3].images[p], WIDTH - 4);
    for (int p = 0; p < PATTERNS; p++) push(&images[p], 4);
    assert_non_null(strstr(told_of(room), "stage-elsewhere"));
    for (int p = 0; p < PATTERNS; p++) push(&images[p], WIDTH - 4);
    for (int p = 0; p < PATTERNS; p++)
        for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) images[p].data[i] += 0.01F;
    assert_non_null(strstr(told_of(room), "stage-light"));
    assert_null(strstr(told, "elsewhere"));
    free_room(room);
}

static void an_exchanged_stage_is_refused(void **state) {
    (void)state;
    FfpContext context = {.settings = {.finding = keep_finding}};
    Room *room = new_room(true);
    FfpImage *images = room->stage.images, black = images[0];
    images[0] = images[1], images[1] = black;
    assert_false(ffp_call_run(&context, compare_with_stage, room, &err));
    must_be(&err, FFP_RULE_STAGE_EXCHANGED);
    free_room(room);
}

// The views' common look is that of the empty stage, and makes nearly as good masks.
static void what_stays_the_same_is_the_stage(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpEmptyStage stage;
    FfpCommon found;
    FfpStageMasks report;
    double off = 0, n = 0;
    assert_true(ffp_common_stage(&stage, &found, &room->capture));
    assert_true(found.known > 0.8 && found.lit > 0.5 && found.lit <= found.known);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) {
        if (!(stage.known.data[i / 3] > 0)) continue;
        off += fabs((double)(stage.images[1].data[i] - room->stage.images[1].data[i])), n++;
    }
    assert_true(off / n < 0.005);
    for (int v = 0; v < VIEWS; v++) room->stages[v] = &stage;
    assert_true(make_masks(room, &report, true));
    const Agreement agreement = compare(room);
    assert_true(agreement.overlap > 0.85);
    assert_true(agreement.missing < 0.04);
    ffp_common_stage_free(&stage, PATTERNS);
    room->capture.n_views = 4;
    assert_false(ffp_common_stage(&stage, &found, &room->capture));
    room->capture.n_views = VIEWS;
    free_room(room);
}

// Dark and blue beside the object, a red line round it, its own colours in it.
static void the_contact_sheet_shows_the_masks(void **state) {
    (void)state;
    Room *room = new_room(true);
    FfpImage thumbs[VIEWS];
    for (int v = 0; v < VIEWS; v++) {
        room->capture.views[v].coverage = ffp_image_copy(&room->truth[v]);
        thumbs[v] = ffp_contact_thumb(&room->capture.views[v].images[1]);
    }
    FfpImage sheet = ffp_contact_sheet(&room->capture, thumbs);
    assert_int_equal(sheet.width, 3 * (WIDTH + 4));
    assert_int_equal(sheet.height, 3 * (HEIGHT + 4));
    int red = 0, object = 0, beside = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const real *p = sheet.data + 3 * ((ptrdiff_t)(i / WIDTH) * sheet.width + i % WIDTH);
        const bool in = room->truth[0].data[i] >= 0.5F;
        const bool line = p[0] > 0.99F && p[1] < 0.01F;
        red += line, object += in && !line, beside += !in && p[2] > p[0];
        if (!in) assert_false(line);
    }
    assert_true(red > 40 && object > 400 && beside > WIDTH * HEIGHT / 2);
    for (int v = 0; v < VIEWS; v++) ffp_image_free(&thumbs[v]);
    ffp_image_free(&sheet);
    free_room(room);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_ball_is_found_in_its_room),
        cmocka_unit_test(space_before_the_ball_is_free),
        cmocka_unit_test(without_poses_light_alone_decides),
        cmocka_unit_test(a_view_like_the_stage_is_refused),
        cmocka_unit_test(other_light_is_told),
        cmocka_unit_test(what_makes_masks_doubtful_is_told),
        cmocka_unit_test(what_changed_since_the_stage_is_named),
        cmocka_unit_test(an_exchanged_stage_is_refused),
        cmocka_unit_test(what_stays_the_same_is_the_stage),
        cmocka_unit_test(the_contact_sheet_shows_the_masks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
