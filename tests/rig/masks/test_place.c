// A ball of one colour stands on the axis of a turntable, and another beside it on the table, which does not
// turn: both look the same at all stops, and only the first one is the object's. Drawn here.
#include <math.h>
#include "core/base/alloc.h"
#include "rig/masks/place.h"
#include "support.h"

enum { VIEWS = 8, WIDTH = 120, HEIGHT = 96, PATTERNS = 3, PANEL = 256 };

typedef struct Ball {
    double centre[3], radius;
} Ball;

static const Ball round_one = {{0, 0, 0.5}, 0.5}, beside = {{0.2, 0.75, 0.2}, 0.2};
static const double away = 5, pitch = 0.45, lamp = 2; // of the camera from the origin; to its right

typedef struct Room {
    FfpCapture capture;
    FfpEmptyStage stage;
    unsigned char shows[HEIGHT * WIDTH]; // 1: the table; 2: the ball on the axis; 3: the other
} Room;

// Looks at the origin from an angle about z, from above, `right` units to the right of the camera's place.
static void place(FfpCamera *device, double angle, double right) {
    const double s = sin(pitch), c = cos(pitch), ca = cos(angle), sa = sin(angle);
    const double pose[16] = {-sa, s * ca, -c * ca, away * c * ca - right * sa,
                             ca,  s * sa, -c * sa, away * c * sa + right * ca,
                             0,   -c,     -s,      away * s,
                             0,   0,      0,       1};
    for (int i = 0; i < 16; i++) device->pose[i] = (real)pose[i];
}

static double hit(const Ball *ball, const real from[3], const real d[3]) {
    double a = 0, b = 0, c = -ball->radius * ball->radius;
    for (int i = 0; i < 3; i++) {
        const double to = (double)from[i] - ball->centre[i];
        a += (double)d[i] * (double)d[i], b += to * (double)d[i], c += to * to;
    }
    return b * b - a * c > 0 ? (-b - sqrt(b * b - a * c)) / a : INFINITY;
}

// Stripes of three widths across the panel, which the lamp's columns are.
static double sent(double column, int pattern, int channel) {
    static const double frequencies[3] = {0.05, 0.12, 0.27};
    return pattern < 2 ? pattern : 0.5 + 0.5 * sin(frequencies[channel] * column);
}

static void draw_pixel(Room *room, int pixel) {
    const FfpView *view = &room->capture.views[0];
    real d[3], point[3], u, v;
    ffp_pixel_ray(&view->camera, (real)(pixel % WIDTH) + 0.5F, (real)(pixel / WIDTH) + 0.5F, d);
    const real from[3] = {view->camera.pose[3], view->camera.pose[7], view->camera.pose[11]};
    const double table = -(double)from[2] / (double)d[2], one = hit(&round_one, from, d),
                 two = hit(&beside, from, d), t = fmin(table, fmin(one, two));
    for (int i = 0; i < 3; i++) point[i] = from[i] + (real)t * d[i];
    ffp_project(&view->projector, point, &u, &v);
    room->shows[pixel] = t == one ? 2 : t == two ? 3 : 1;
    for (int p = 0; p < PATTERNS; p++)
        for (int c = 0; c < 3; c++)
            room->stage.images[p].data[3 * pixel + c] =
                (real)(0.02 + 0.4 * sent((double)u, p, c) + 0.001 * sin(12.9898 * pixel + 7.1 * c + p));
}

static Room *new_room(void) {
    Room *room = ffp_alloc(1, sizeof *room);
    FfpCapture *capture = &room->capture;
    *capture = (FfpCapture){.n_views = VIEWS, .n_patterns = PATTERNS, .white = 1, .radius = 0.8F};
    capture->centre[2] = 0.5F;
    capture->views = ffp_alloc(VIEWS, sizeof *capture->views);
    capture->patterns = ffp_alloc(PATTERNS, sizeof *capture->patterns);
    room->stage.images = ffp_alloc(PATTERNS, sizeof(FfpImage));
    room->stage.known = ffp_image_new(WIDTH, HEIGHT, 1);
    for (int v = 0; v < VIEWS; v++) {
        FfpView *view = &capture->views[v];
        view->camera = (FfpCamera){.width = WIDTH, .height = HEIGHT, .fx = 150, .fy = 150};
        view->camera.cx = WIDTH / 2.0F, view->camera.cy = HEIGHT / 2.0F;
        view->projector =
            (FfpCamera){.width = PANEL, .height = PANEL, .fx = 200, .fy = 200, .cx = 200, .cy = 128};
        place(&view->camera, v * acos(-1.0) / 4, 0), place(&view->projector, v * acos(-1.0) / 4, lamp);
        view->images = ffp_alloc(PATTERNS, sizeof(FfpImage));
        view->coverage = ffp_image_new(WIDTH, HEIGHT, 1);
    }
    for (int p = 0; p < PATTERNS; p++) {
        capture->patterns[p].image = ffp_image_new(PANEL, PANEL, 3);
        for (int i = 0; i < 3 * PANEL * PANEL; i++)
            capture->patterns[p].image.data[i] = (real)sent(i / 3 % PANEL + 0.5, p, i % 3);
        room->stage.images[p] = ffp_image_new(WIDTH, HEIGHT, 3);
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++) room->stage.known.data[i] = 1, draw_pixel(room, i);
    for (int v = 0; v < VIEWS; v++)
        for (int p = 0; p < PATTERNS; p++)
            capture->views[v].images[p] = ffp_image_copy(&room->stage.images[p]);
    return room;
}

static void free_room(Room *room) {
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&room->stage.images[p]);
    ffp_free(room->stage.images);
    ffp_image_free(&room->stage.known);
    ffp_capture_free(&room->capture);
    ffp_free(room);
}

// The masks hold the ball on the axis down to a row of the picture.
static void mask_down_to(Room *room, int row) {
    for (int v = 0; v < VIEWS; v++)
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            room->capture.views[v].coverage.data[i] = room->shows[i] == 2 && i / WIDTH < row;
}

static void only_what_is_round_is_marked(void **state) {
    (void)state;
    Room *room = new_room();
    unsigned char *marks = ffp_alloc(WIDTH * HEIGHT, 1);
    int shown = 0, found = 0, table = 0, other = 0;
    mask_down_to(room, HEIGHT / 2);
    assert_true(ffp_place_above(marks, &room->capture, &room->stage) > 0.5);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        shown += room->shows[i] == 2, found += room->shows[i] == 2 && marks[i];
        table += room->shows[i] == 1 && marks[i], other += room->shows[i] == 3 && marks[i];
    }
    printf("%d of %d pixels of the ball, %d of the table, %d of the other ball\n", found, shown, table,
           other);
    assert_true(found > 0.8 * shown);
    assert_true(table < 0.03 * shown);
    assert_true(other < 0.03 * shown);
    ffp_free(marks);
    free_room(room);
}

// Parts of which no two stops share a look are not marked.
static void only_what_is_known_is_marked(void **state) {
    (void)state;
    Room *room = new_room();
    unsigned char *marks = ffp_alloc(WIDTH * HEIGHT, 1);
    for (int i = 0; i < WIDTH * HEIGHT; i++) room->stage.known.data[i] = room->shows[i] == 1;
    mask_down_to(room, HEIGHT);
    assert_true(ffp_place_above(marks, &room->capture, &room->stage) < 0.03);
    ffp_free(marks);
    free_room(room);
}

static void without_a_pattern_nothing_is_known(void **state) {
    (void)state;
    Room *room = new_room();
    unsigned char *marks = ffp_alloc(WIDTH * HEIGHT, 1);
    mask_down_to(room, HEIGHT);
    room->capture.n_patterns = 2;
    assert_true(ffp_place_above(marks, &room->capture, &room->stage) == 0);
    room->capture.n_patterns = PATTERNS;
    ffp_free(marks);
    free_room(room);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_what_is_round_is_marked),
        cmocka_unit_test(only_what_is_known_is_marked),
        cmocka_unit_test(without_a_pattern_nothing_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
