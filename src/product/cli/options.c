// Parsing by a command's table, on top of getopt_long.
#include "options.h"
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "cli.h"

enum { OPTIONS_MAX = 64, LONG_BASE = 256 }; // getopt's value of a long option is its index and LONG_BASE

bool ffp_cli_number(const char *text, int64_t low, int64_t high, int64_t *out) {
    char *end;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    if (errno || end == text || *end || value < low || value > high) return false;
    *out = value;
    return true;
}

bool ffp_cli_pair(const char *text, char between, int64_t low, int *a, int *b) {
    char first[16];
    const char *place = strchr(text, between);
    int64_t x = 0, y = 0;
    if (!place || (size_t)(place - text) >= sizeof first) return false;
    memcpy(first, text, (size_t)(place - text));
    first[place - text] = 0;
    if (!ffp_cli_number(first, low, 1000000, &x) || !ffp_cli_number(place + 1, low, 1000000, &y))
        return false;
    *a = (int)x;
    *b = (int)y;
    return true;
}

double ffp_cli_decimal(const char *text, const char **end) {
    char *behind;
    const double value = strtod(text, &behind);
    *end = behind;
    for (const char *at = text; at < behind; at++)
        if (*at == 'x' || *at == 'X') *end = at; // hexadecimal: the number is the 0 before
    if (*end == text || !isfinite(value)) return NAN;
    return *end < behind ? 0 : value;
}

bool ffp_cli_real(const char *text, double low, double high, double *out) {
    const char *end;
    const double value = ffp_cli_decimal(text, &end);
    if (*end || !(value >= low && value <= high)) return false;
    *out = value;
    return true;
}

const char *ffp_cli_angles(const char *text, FfpAngles *angles, const char **where) {
    angles->count = 0;
    for (const char *at = text, *end;; at = end + 1) {
        double count = 1, first = ffp_cli_decimal(at, &end), step = 0;
        *where = at;
        if (isnan(first)) return "is not a number";
        if (*end == 'x') {
            count = first;
            first = 0;
            step = ffp_cli_decimal(end + 1, &end);
            if (isnan(step)) return "is not a number";
            if (!(count >= 1 && count <= FFP_CLI_ANGLES_MAX) || count != floor(count))
                return "must begin with a number of stops from 1 to 512";
            if (step == 0) return "puts all stops at the same angle";
        }
        if (angles->count + count > FFP_CLI_ANGLES_MAX) return "exceeds the limit of 512 angles";
        for (int i = 0; i < (int)count; i++) angles->degrees[angles->count++] = first + i * step;
        if (!*end) return NULL;
        if (*end != ',') return "is not a number";
    }
}

// --- What an option takes, in words. ---

static void append(char *text, size_t size, const char *more) {
    const size_t length = strlen(text);
    snprintf(text + length, size - length, "%s", more);
}

void ffp_cli_takes(const FfpOption *option, char *text, size_t size) {
    const bool whole = option->type == FFP_OPTION_INT || option->type == FFP_OPTION_INT64;
    const bool number = whole || option->type == FFP_OPTION_REAL;
    char range[96] = "";
    snprintf(text, size, "%s", option->takes ? option->takes : "");
    if (option->takes) return;
    if (whole && option->high == INT64_MAX)
        snprintf(range, sizeof range, "a number of at least %lld", (long long)option->low);
    else if (whole)
        snprintf(range, sizeof range, "a number from %lld to %lld", (long long)option->low,
                 (long long)option->high);
    else if (number && isinf(option->most))
        snprintf(range, sizeof range, "a number of at least %g", option->least);
    else if (number)
        snprintf(range, sizeof range, "a number from %g to %g", option->least, option->most);
    for (const FfpWord *word = option->words; word && word->name; word++) {
        const bool last = !number && !word[1].name;
        if (word != option->words) append(text, size, last ? " or " : ", ");
        append(text, size, word->name);
    }
    if (number && option->words) append(text, size, " or ");
    append(text, size, range);
}

// --- Values. ---

static const FfpWord *find_word(const FfpWord *words, const char *text) {
    for (; words && words->name; words++)
        if (strcmp(words->name, text) == 0) return words;
    return NULL;
}

static void put_int(void *destination, int64_t value) {
    const int small = (int)value;
    memcpy(destination, &small, sizeof small);
}

// Takes a number, or the word that stands for one; false when the text is neither.
static bool put_number(const FfpOption *option, const char *text, void *destination) {
    const FfpWord *word = find_word(option->words, text);
    int64_t whole = word ? (int64_t)word->value : 0;
    double real = word ? word->value : 0;
    if (option->type == FFP_OPTION_REAL) {
        if (!word && !ffp_cli_real(text, option->least, option->most, &real)) return false;
        memcpy(destination, &real, sizeof real);
        return true;
    }
    if (!word &&
        (option->type == FFP_OPTION_CHOICE || !ffp_cli_number(text, option->low, option->high, &whole)))
        return false;
    if (option->type == FFP_OPTION_INT64)
        memcpy(destination, &whole, sizeof whole);
    else
        put_int(destination, whole);
    return true;
}

static void put_in_list(FfpList *list, const char *text) {
    list->values[list->count++] = text;
}

static bool put_value(const FfpOption *option, const char *text, void *destination) {
    switch (option->type) {
    case FFP_OPTION_FLAG:
        *(bool *)destination = true;
        return true;
    case FFP_OPTION_INT:
    case FFP_OPTION_INT64:
    case FFP_OPTION_REAL:
    case FFP_OPTION_CHOICE:
        return put_number(option, text, destination);
    case FFP_OPTION_PARSED:
        return option->parse(text, destination);
    default:
        break;
    }
    if (option->type == FFP_OPTION_NAME && !find_word(option->words, text)) return false;
    if (option->repeated)
        put_in_list(destination, text);
    else
        *(const char **)destination = text ? text : "";
    return true;
}

// --- Mistakes. ---

// Optimal string alignment: insertions, deletions, replacements and swaps of neighbours.
static int distance(const char *a, const char *b) {
    enum { LONGEST = 31 };
    int rows[3][LONGEST + 1];
    const int n = (int)strlen(a), m = (int)strlen(b);
    if (n > LONGEST || m > LONGEST) return LONGEST;
    for (int j = 0; j <= m; j++) rows[0][j] = j;
    for (int i = 1; i <= n; i++) {
        int *row = rows[i % 3];
        const int *above = rows[(i - 1) % 3], *higher = rows[(i + 1) % 3];
        row[0] = i;
        for (int j = 1; j <= m; j++) {
            int least = above[j - 1] + (a[i - 1] != b[j - 1]);
            if (above[j] + 1 < least) least = above[j] + 1;
            if (row[j - 1] + 1 < least) least = row[j - 1] + 1;
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && higher[j - 2] + 1 < least) least = higher[j - 2] + 1;
            row[j] = least;
        }
    }
    return rows[n % 3][m];
}

const char *ffp_cli_nearest(const char *word, const char *const *names) {
    const size_t length = strlen(word);
    const char *nearest = NULL;
    int least = (int)(length + 2) / 3; // a third of its letters may be wrong
    for (; *names; names++) {
        const bool begins = length >= 2 && strncmp(word, *names, length) == 0;
        const int far = begins ? 0 : distance(word, *names);
        if (far < least || (far == least && !nearest)) {
            nearest = *names;
            least = far;
        }
    }
    return nearest;
}

static int count_options(const FfpCommand *command) {
    int n = 0;
    while (command->options[n].name) n++;
    return n;
}

// --output, which most commands have, for one that takes where it writes without an option.
static int tell_no_output(const FfpCommand *command, const char *word) {
    const FfpPositional *positional = &command->positional;
    if (!positional->name) return ffp_cli_usage(command->name, "unknown option %s", word);
    return ffp_cli_usage(command->name, "unknown option %s: %s stands alone, ffprocams %s %s", word,
                         positional->name, command->name, positional->name);
}

// A word in place of an option's name: what is wrong with it.
static int tell_unknown(const FfpCommand *command, const char *word) {
    const char *names[OPTIONS_MAX + 2] = {"help"};
    const int n = count_options(command);
    const int length = (int)strcspn(word, "=");
    char name[64], first[64] = "";
    snprintf(name, sizeof name, "%.*s", length, word);
    for (int i = 0; i < n; i++) {
        names[i + 1] = command->options[i].name;
        if (strcmp(names[i + 1], name) == 0) return ffp_cli_usage(command->name, "--%s takes no value", name);
    }
    for (int i = 0; i <= n; i++) {
        if (strncmp(names[i], name, strlen(name)) != 0) continue;
        if (first[0])
            return ffp_cli_usage(command->name, "ambiguous option --%s: --%s or --%s", name, first, names[i]);
        snprintf(first, sizeof first, "%s", names[i]);
    }
    const char *nearest = ffp_cli_nearest(name, names);
    if (nearest)
        return ffp_cli_usage(command->name, "unknown option --%s: did you mean --%s?", word, nearest);
    if (strcmp(name, "output") == 0) return tell_no_output(command, "--output");
    return ffp_cli_usage(command->name, "unknown option --%s", word);
}

static int find_option(const FfpCommand *command, int got) {
    if (got >= LONG_BASE) return got - LONG_BASE;
    for (int i = 0; command->options[i].name; i++)
        if (command->options[i].letter == got) return i;
    return -1;
}

// getopt's '?' and ':'.
static int tell_wrong(const FfpCommand *command, int got, char **argv) {
    const char *word = argv[optind - 1];
    if (got == ':') {
        const FfpOption *option = &command->options[find_option(command, optopt)];
        return ffp_cli_usage(command->name, "--%s needs a value: %s", option->name, option->argument);
    }
    if (strncmp(word, "--", 2) == 0) return tell_unknown(command, word + 2);
    if (optopt == 'o') return tell_no_output(command, "-o");
    return ffp_cli_usage(command->name, "unknown option -%c", optopt);
}

// "-output x" is "-o utput" to getopt, and never what was meant.
static const FfpOption *one_dash_too_few(const FfpCommand *command, const char *word) {
    if (word[0] != '-' || word[1] == '-') return NULL;
    for (const FfpOption *option = command->options; option->name; option++)
        if (strcmp(option->name, word + 1) == 0) return option;
    return NULL;
}

// --- The command line. ---

static void describe(const FfpCommand *command, struct option *longs, char *shorts) {
    *shorts++ = ':';
    *shorts++ = 'h';
    for (int i = 0; command->options[i].name; i++, longs++) {
        const FfpOption *option = &command->options[i];
        const int argument = option->type == FFP_OPTION_FLAG ? no_argument
                             : option->optional_value        ? optional_argument
                                                             : required_argument;
        *longs = (struct option){option->name, argument, NULL, LONG_BASE + i};
        if (!option->letter) continue;
        *shorts++ = option->letter;
        if (argument == required_argument) *shorts++ = ':';
    }
    *longs++ = (struct option){"help", no_argument, NULL, 'h'};
    *longs = (struct option){0};
    *shorts = 0;
}

static int take_option(const FfpCommand *command, const FfpOption *option, bool again, char **argv,
                       void *arguments) {
    const FfpOption *meant = option->letter ? one_dash_too_few(command, argv[optind - 1]) : NULL;
    if (meant)
        return ffp_cli_usage(command->name, "unknown option -%s: did you mean --%s?", meant->name,
                             meant->name);
    if (again && !option->repeated)
        return ffp_cli_usage(command->name, "--%s may be given only once", option->name);
    if (option->type != FFP_OPTION_FLAG && !option->optional_value && !*optarg) // such as "$UNSET"
        return ffp_cli_usage(command->name, "--%s needs a value: %s", option->name, option->argument);
    if (put_value(option, optarg, (char *)arguments + option->offset)) return -1;
    char takes[256];
    ffp_cli_takes(option, takes, sizeof takes);
    return ffp_cli_usage(command->name, "--%s takes %s, not '%s'", option->name, takes, optarg);
}

static int take_positionals(const FfpCommand *command, int argc, char **argv, void *arguments) {
    const FfpPositional *positional = &command->positional;
    const int n = argc - optind;
    char *destination = (char *)arguments + positional->offset;
    if (!positional->name && n && positional->excess)
        return ffp_cli_usage(command->name, "unexpected argument %s: %s", argv[optind], positional->excess);
    if (!positional->name && n) return ffp_cli_usage(command->name, "unexpected argument %s", argv[optind]);
    if (positional->name && n < positional->least)
        return ffp_cli_usage(command->name, "give %s one %s", positional->most == 1 ? "exactly" : "at least",
                             positional->name);
    if (positional->name && n > positional->most)
        return ffp_cli_usage(command->name, "give exactly one %s: unexpected argument %s", positional->name,
                             argv[optind + 1]);
    for (int i = optind; i < argc; i++)
        if (!*argv[i]) return ffp_cli_usage(command->name, "%s is empty", positional->name);
    if (n && positional->most == 1) *(const char **)destination = argv[optind];
    for (int i = optind; positional->most > 1 && i < argc; i++) put_in_list((FfpList *)destination, argv[i]);
    return -1;
}

static int check_required(const FfpCommand *command, const bool *seen) {
    for (int i = 0; command->options[i].name; i++) {
        const FfpOption *option = &command->options[i];
        if (!option->required || seen[i]) continue;
        return ffp_cli_usage(command->name, "%s%.1s%s--%s %s is missing", option->letter ? "-" : "",
                             &option->letter, option->letter ? ", " : "", option->name, option->argument);
    }
    return -1;
}

static bool is_seen(const FfpCommand *command, const bool *seen, const char *name) {
    for (int i = 0; name && command->options[i].name; i++)
        if (seen[i] && strcmp(command->options[i].name, name) == 0) return true;
    return false;
}

// Options that need or exclude others.
static int check_together(const FfpCommand *command, const bool *seen) {
    for (int i = 0; command->options[i].name; i++) {
        const FfpOption *option = &command->options[i];
        if (seen[i] && option->needs && !is_seen(command, seen, option->needs))
            return ffp_cli_usage(command->name, "--%s requires --%s", option->name, option->needs);
        if (seen[i] && is_seen(command, seen, option->excludes))
            return ffp_cli_usage(command->name, "--%s cannot be combined with --%s", option->name,
                                 option->excludes);
    }
    return -1;
}

// Fills the arguments; -1 to go on, otherwise the exit code (help was printed, or what is wrong was told).
static int parse(const FfpCommand *command, int argc, char **argv, void *arguments) {
    struct option longs[OPTIONS_MAX + 2];
    char shorts[2 * OPTIONS_MAX + 3];
    bool seen[OPTIONS_MAX] = {false};
    describe(command, longs, shorts);
    opterr = 0; // the messages are ours
    optind = 0; // again, should it have been used before
    for (int got; (got = getopt_long(argc, argv, shorts, longs, NULL)) != -1;) {
        if (got == 'h') {
            ffp_cli_command_help(command, stdout);
            return FFP_EXIT_OK;
        }
        if (got == '?' || got == ':') return tell_wrong(command, got, argv);
        const int i = find_option(command, got);
        const int status = take_option(command, &command->options[i], seen[i], argv, arguments);
        if (status >= 0) return status;
        seen[i] = true;
    }
    int status = take_positionals(command, argc, argv, arguments);
    if (status < 0) status = check_required(command, seen);
    if (status < 0) status = check_together(command, seen);
    return status >= 0 ? status : ffp_cli_check_outputs(command, arguments);
}

// --- Running. ---

static FfpList *list_of(const FfpOption *option, void *arguments) {
    const bool list = option->repeated && option->type != FFP_OPTION_PARSED;
    return list ? (FfpList *)((char *)arguments + option->offset) : NULL;
}

static FfpList *positional_list(const FfpCommand *command, void *arguments) {
    return command->positional.most > 1 ? (FfpList *)((char *)arguments + command->positional.offset) : NULL;
}

// Room in each list for all arguments: there cannot be more values.
static bool make_lists(const FfpCommand *command, int argc, void *arguments) {
    FfpList *last = positional_list(command, arguments);
    bool ok = !last || (last->values = calloc((size_t)argc, sizeof *last->values));
    for (const FfpOption *option = command->options; option->name; option++) {
        FfpList *list = list_of(option, arguments);
        if (list) ok = (list->values = calloc((size_t)argc, sizeof *list->values)) && ok;
    }
    return ok;
}

static void free_lists(const FfpCommand *command, void *arguments) {
    FfpList *last = positional_list(command, arguments);
    if (last) free(last->values);
    for (const FfpOption *option = command->options; option->name; option++) {
        FfpList *list = list_of(option, arguments);
        if (list) free(list->values);
    }
}

int ffp_cli_run(const FfpCommand *command, int argc, char **argv) {
    static const FfpError no_memory = {.text = "out of memory", .code = FFP_ERROR_MEMORY};
    void *arguments = calloc(1, command->size);
    if (!arguments) return ffp_cli_fail(&no_memory);
    if (command->set_defaults) command->set_defaults(arguments);
    int status = make_lists(command, argc, arguments) ? parse(command, argc, argv, arguments)
                                                      : ffp_cli_fail(&no_memory);
    if (status < 0) status = command->run(arguments);
    free_lists(command, arguments);
    free(arguments);
    return status;
}
