// The folder of what is to be shown: numbered pictures, a text, and a page that shows them.
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/base64.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/patterns/patterns.h"

static const char page_head[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>FF-ProCams patterns</title>\n"
    "<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n"
    "html,body{margin:0;height:100%;background:#000;overflow:hidden;cursor:none}\n"
    "img{position:fixed;left:0;top:0;image-rendering:pixelated}\n"
    "#help{position:fixed;inset:0;display:grid;place-items:center;background:#111;color:#ddd;cursor:default;"
    "font:18px/1.6 system-ui,sans-serif;padding:1em}\n#help div{max-width:36em}\n"
    "kbd{border:1px solid #666;border-radius:4px;padding:0 .4em}\n.bad{color:#fa6}\n</style></head><body>\n"
    "<img id=\"picture\" alt=\"\">\n<div id=\"help\"><div><h1>Patterns to photograph</h1>\n"
    "<p>Move this window to the projector and press <kbd>F</kbd> for full screen.</p>\n"
    "<p><kbd>Space</kbd> or a click: next picture. <kbd>Backspace</kbd>: previous one. <kbd>H</kbd>: this "
    "page, which shows "
    "where you are. <kbd>Home</kbd>: first picture. A number and <kbd>Enter</kbd>: that picture.</p>\n"
    "<p id=\"where\"></p><p id=\"size\"></p></div></div>\n<script>\nconst pictures = [\n";

static const char page_tail[] =
    "];\n"
    "const $ = (id) => document.getElementById(id);\n"
    "let at = -1, typed = '';\n"
    "function show(index, help) {\n"
    "  at = Math.max(-1, Math.min(index, pictures.length - 1));\n"
    "  const scale = 1 / window.devicePixelRatio, image = $('picture');\n"
    "  if (at >= 0 && image.dataset.at !== String(at)) {\n"
    "    image.src = 'data:image/png;base64,' + pictures[at][1];\n"
    "    image.dataset.at = String(at);\n"
    "  }\n"
    "  image.style.width = panel[0] * scale + 'px';\n"
    "  image.style.height = panel[1] * scale + 'px';\n"
    "  image.hidden = at < 0;\n"
    "  $('help').hidden = !help && at >= 0;\n"
    "  $('help').style.display = $('help').hidden ? 'none' : 'grid';\n"
    "  const last = first + pictures.length - 1;\n"
    "  $('where').textContent = at < 0 ? pictures.length + ' pictures.'\n"
    "    : 'Now: ' + (first + at) + ' of ' + last + ', ' + pictures[at][0] + '.';\n"
    "  const window_size = [Math.round(innerWidth / scale), Math.round(innerHeight / scale)];\n"
    "  const fits = window_size[0] === panel[0] && window_size[1] === panel[1];\n"
    "  $('size').className = fits ? '' : 'bad';\n"
    "  $('size').textContent = fits ? 'This window has the size of the patterns.'\n"
    "    : 'This window has ' + window_size.join(' x ') + ' pixels, the patterns have ' + panel.join(' x ')\n"
    "      + ': full screen on the projector, both should be the same.';\n"
    "}\n"
    "addEventListener('keydown', (event) => {\n"
    "  const key = event.key;\n"
    "  if (key >= '0' && key <= '9') { typed += key; return; }\n"
    "  if (key === 'Enter' && typed) show(Number(typed) - first);\n"
    "  else if (key === ' ' || key === 'ArrowRight' || key === 'PageDown') show(at + 1);\n"
    "  else if (key === 'Backspace' || key === 'ArrowLeft' || key === 'PageUp') show(at - 1);\n"
    "  else if (key === 'Home') show(0);\n"
    "  else if (key === 'h' || key === 'H' || key === '?') show(at, $('help').hidden);\n"
    "  else if (key === 'f' || key === 'F') document.documentElement.requestFullscreen();\n"
    "  else return;\n"
    "  typed = '';\n"
    "  event.preventDefault();\n"
    "});\n"
    "addEventListener('click', () => show(at + 1));\n"
    "addEventListener('resize', () => show(at, !$('help').hidden));\n"
    "show(-1);\n"
    "</script></body></html>\n";

static const char *const what_for[] = {
    [FFP_SHOW_FOCUS] = "Focus the projector until the spokes merge as close to the stars' centres as\n"
                       "possible, and place the object inside the frame. Not photographed.",
    [FFP_SHOW_CAPTURE] = "For a reconstruction; one lollipop is enough:",
    [FFP_SHOW_GRAY_CODES] =
        "For the calibration and an exact shape: every column (x) and row (y) of the panel in\n"
        "Gray code, the coarsest bit first, each followed by its inverse:",
};

typedef struct Writing {
    const FfpShow *show;
    const char *folder;
    FILE *text, *page;
} Writing;

static bool write_one(const Writing *w, int index, int *last_part, FfpError *err) {
    char name[32], file[64], path[FFP_PATH_MAX];
    FfpShowPart part;
    unsigned char *bytes = NULL;
    size_t size = 0;
    FfpImage image = ffp_show_picture(w->show, index, name, &part);
    snprintf(file, sizeof file, "%03d_%s.png", ffp_show_number(w->show, index), name);
    const bool ok =
        ffp_join_path(path, w->folder, file)
            ? ffp_image_encode_png(&image, &bytes, &size, err) && ffp_write_file(path, bytes, size, err)
            : ffp_fail(err, FFP_ERROR_ARGUMENT, w->folder, "the path is too long");
    ffp_image_free(&image);
    if (ok) {
        if (*last_part != (int)part) fprintf(w->text, "\n%s\n\n", what_for[part]);
        *last_part = (int)part;
        if (w->show->greys > 0 && ffp_grey_named(name) == ffp_show_grey(w->show->greys, 0))
            fputs("\nGreys, which tell how much light the projector makes of a value:\n\n", w->text);
        fprintf(w->text, "    %s\n", file);
        fprintf(w->page, "['%s', '", name);
        ffp_write_base64(w->page, bytes, size);
        fputs("'],\n", w->page);
    }
    ffp_free(bytes);
    return ok;
}

static const char setting_up[] =
    "Show them full screen, one pixel of a picture on one of the projector's: set the projector as a screen\n"
    "of its own at its native resolution, no keystone correction, no overscan, no dynamic contrast, and\n"
    "open show.html there (F: full screen, space bar: the next one). In a dark room, with the camera on a\n"
    "tripod: fixed focus, aperture, ISO, white balance and exposure time (a multiple of the projector's\n"
    "frame time, 1/60 s or 1/30 s), so that white is bright but not clipped.\n\n";

static const char import_by_hand[] =
    "Gray codes in folders of their own are named by --graycode 'codes/{view}/*.JPG'. Masks are made of the\n"
    "light, and completed where the views tell what lies in shadow. Silhouettes drawn by hand, white on\n"
    "black, one picture for each view, are better: -m 'masks/{view}.png'\n";

// The list of photographs, folder by folder, in the order that wastes least: nothing is moved twice.
static void list_photographs(const Writing *w) {
    const FfpShow *show = w->show;
    const int capture = show->capture ? 2 + show->lollipops : 0, all = ffp_show_count(show) - show->focus;
    fprintf(
        w->text,
        "The photographs, in the order of the patterns' numbers, those of each place in a folder of their\n"
        "own. What the camera calls them does not matter as long as the numbers count up:\n\n");
    if (show->capture)
        fprintf(w->text, "    empty/              the stage without the object: 001 to %03d\n", capture);
    if (show->capture && show->gray_codes)
        fprintf(
            w->text,
            "    attitude-00/ ...    if you have one, a chessboard, five to fifteen times, tilted another "
            "way\n"
            "                        each time: 001 to %03d\n"
            "    turntable/          the chessboard on the turntable, white, one photograph at each of some\n"
            "                        angles (0, 15, 30, 45, 60)\n",
            all);
    if (show->capture)
        fprintf(w->text,
                "    view-000/           the object: 001 to %03d%s\n"
                "    view-045/ ...       likewise, all the way round\n",
                all, show->gray_codes ? " (with a chessboard the codes may be left out)" : "");
    fputs("\n", w->text);
}

// Without a board, and with one.
static void list_calibrations(const Writing *w) {
    const FfpShow *show = w->show;
    fputs("    ffprocams calibrate shots/view-* --without-board --angles 8x45 --shown PATTERNS \\\n"
          "        -o calibration.xml --turntable-output axis.json\n"
          "    ffprocams import -c calibration.xml -t axis.json --shown PATTERNS \\\n"
          "        -i 'shots/{view}/*.JPG' -o vase\n\n"
          "Or with the chessboard, which measures in millimetres:\n\n",
          w->text);
    fprintf(w->text,
            "    ffprocams calibrate shots/attitude-* --shown PATTERNS -o calibration.xml --board %dx%d \\\n"
            "        --square %.6g --turntable-board shots/turntable --angles 0,15,30,45,60 \\\n"
            "        --turntable-output axis.json\n",
            show->columns > 0 ? show->columns : 9, show->columns > 0 ? show->rows : 6,
            show->columns > 0 ? show->square : 25);
}

static void list_commands(const Writing *w) {
    const FfpShow *show = w->show;
    if (show->columns > 0)
        fprintf(w->text,
                "The chessboard, for printing at 100 %%, is in chessboard.pdf and chessboard.svg: %d x %d "
                "inner corners,\n"
                "squares of %.6g mm. Measure them on the print, over as many as you can.\n\n",
                show->columns, show->rows, show->square);
    fputs("Afterwards, with PATTERNS for the name of this folder:\n\n", w->text);
    if (show->capture && show->gray_codes) list_calibrations(w);
    if (show->capture)
        fputs("    ffprocams import -c calibration.xml -t axis.json --angles 8x45 --shown PATTERNS \\\n"
              "        -i 'shots/view-{view}/*.JPG' -o vase\n\n",
              w->text);
    fputs(import_by_hand, w->text);
}

static void begin(const Writing *w) {
    fprintf(w->text, "Patterns for a projector of %d x %d pixels\n\n%s", w->show->width, w->show->height,
            setting_up);
    list_photographs(w);
    list_commands(w);
    fputs(page_head, w->page);
}

static bool write_all(Writing *w, FfpError *err) {
    const int count = ffp_show_count(w->show);
    const FfpTask task = ffp_task("drawing patterns", count);
    int part = -1;
    bool ok = true;
    begin(w);
    for (int i = 0; ok && i < count; i++) {
        ffp_cancel_point();
        ok = write_one(w, i, &part, err);
        ffp_task_step(&task, i + 1, NULL);
    }
    fprintf(w->page, "];\nconst first = %d, panel = [%d, %d", ffp_show_number(w->show, 0), w->show->width,
            w->show->height);
    fputs(page_tail, w->page);
    ffp_task_end(&task);
    return ok;
}

bool ffp_show_write(const FfpShow *show, const char *path, FfpError *err) {
    char text[FFP_PATH_MAX], page[FFP_PATH_MAX];
    FfpOutput out[2];
    if (!ffp_join_path(text, path, "README.txt") || !ffp_join_path(page, path, "show.html"))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "the path is too long");
    if (!ffp_output_open(&out[0], text, err)) return false;
    bool ok = ffp_output_open(&out[1], page, err);
    if (ok) {
        Writing writing = {show, path, out[0].stream, out[1].stream};
        ok = write_all(&writing, err) && ffp_output_commit(&out[0], err) && ffp_output_commit(&out[1], err);
        ffp_output_abort(&out[1]);
    }
    ffp_output_abort(&out[0]);
    return ok;
}

bool ffp_show_write_folder(const FfpShow *show, const char *path, FfpError *err) {
    FfpOutput folder;
    if (!ffp_output_open_folder(&folder, path, true, err)) return false;
    const bool ok = ffp_show_write(show, folder.temporary, err) &&
                    (show->columns == 0 ||
                     ffp_board_write(folder.temporary, show->columns, show->rows, show->square, err)) &&
                    ffp_output_commit(&folder, err);
    ffp_output_abort(&folder);
    return ok;
}
