// Control of the show from outside: OSC messages over UDP (Open Sound Control 1.0, Wright 2002), which the
// pages ask for. Every packet is hostile until it is read to its end.
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>
#include "work.h"

enum {
    PACKET_MOST = 65507, // bytes, as UDP's
    ADDRESS_MOST = 120,  // characters of an address
    TEXT_MOST = 400,     // bytes of a text
    VALUES_MOST = 16,    // of a message
    NESTED_MOST = 4,     // bundles within bundles
    AT_ONCE = 1024       // messages before others are served, but for those of the last packet
};

typedef struct Reader {
    const unsigned char *at;
    size_t left; // bytes; always a multiple of four
} Reader;

static bool take(Reader *r, size_t size, uint64_t *value) {
    if (r->left < size) return false;
    *value = 0;
    for (size_t i = 0; i < size; i++) *value = *value << 8 | r->at[i];
    r->at += size, r->left -= size;
    return true;
}

// A text that ends in one to four zeros, to a multiple of four bytes.
static const char *take_text(Reader *r, size_t most) {
    const char *text = (const char *)r->at;
    const size_t length = strnlen(text, r->left), size = length / 4 * 4 + 4;
    if (length == r->left || length > most || size > r->left) return NULL;
    for (size_t i = length; i < size; i++)
        if (text[i]) return NULL;
    r->at += size, r->left -= size;
    return text;
}

// A finite number, or NULL.
static json_t *real(double number) {
    return isfinite(number) ? json_real(number) : NULL;
}

// Null for a value that no control has a meaning for; NULL: it cannot be read.
static json_t *take_value(Reader *r, char type) {
    uint64_t bits;
    uint32_t half;
    float single;
    double number;
    const char *text;
    switch (type) {
    case 'T':
        return json_true();
    case 'F':
        return json_false();
    case 'i':
        return take(r, 4, &bits) ? json_integer((int32_t)(uint32_t)bits) : NULL;
    case 'h':
        return take(r, 8, &bits) ? json_integer((int64_t)bits) : NULL;
    case 'f':
        if (!take(r, 4, &bits)) return NULL;
        half = (uint32_t)bits;
        memcpy(&single, &half, sizeof single);
        return real((double)single);
    case 'd':
        if (!take(r, 8, &bits)) return NULL;
        memcpy(&number, &bits, sizeof number);
        return real(number);
    case 's':
    case 'S':
        text = take_text(r, TEXT_MOST);
        return text ? json_string(text) : NULL; // NULL: not UTF-8
    case 'c':                                   // a character, a colour, a MIDI message
    case 'r':
    case 'm':
        return take(r, 4, &bits) ? json_null() : NULL;
    case 't':
        return take(r, 8, &bits) ? json_null() : NULL;
    case 'b':
        if (!take(r, 4, &bits) || bits > r->left) return NULL;
        bits = (bits + 3) / 4 * 4;
        r->at += bits;
        r->left -= (size_t)bits;
        return json_null();
    default:
        return NULL;
    }
}

// {"address", "values"}; NULL: not a valid message. Nil, impulse and the brackets of lists
// are left out.
static json_t *take_message(Reader *r, const char **address) {
    const char *types = ",";
    json_t *values = json_array(), *name = NULL;
    *address = take_text(r, ADDRESS_MOST);
    bool ok = *address && (*address)[0] == '/' && (*address)[1] && (name = json_string(*address)); // UTF-8
    if (ok && r->left > 0) types = take_text(r, VALUES_MOST + 1); // old senders leave it out
    ok = ok && types && types[0] == ',';
    for (size_t i = 1; ok && types[i]; i++)
        if (!strchr("NI[]", types[i])) ok = json_array_append_new(values, take_value(r, types[i])) == 0;
    if (ok && r->left == 0) return json_pack("{s:o, s:o}", "address", name, "values", values);
    json_decref(name);
    json_decref(values);
    return NULL;
}

// A message that cannot be read is passed over alone.
static void pass_over(FfpStudioServer *server, const char *address) {
    server->passed_over++;
    size_t n = 0;
    for (; address && address[n] >= ' ' && address[n] <= '~' && n + 1 < sizeof server->passed_last; n++)
        server->passed_last[n] = address[n];
    server->passed_last[n] = 0;
}

static void read_packet(FfpStudioServer *server, Reader r, json_t *found, int nested) {
    uint64_t size;
    const char *address = NULL, *name;
    if (r.left == 0 || r.left % 4 != 0) {
        pass_over(server, NULL);
        return;
    }
    if (r.at[0] != '#') {
        if (json_array_append_new(found, take_message(&r, &address)) != 0) pass_over(server, address);
        return;
    }
    name = take_text(&r, 8);
    bool ok = nested < NESTED_MOST && name && strcmp(name, "#bundle") == 0 && take(&r, 8, &size);
    while (ok && r.left > 0) { // at once, whatever time it names
        ok = take(&r, 4, &size) && size <= r.left;
        if (!ok) break;
        read_packet(server, (Reader){r.at, (size_t)size}, found, nested + 1);
        r.at += size;
        r.left -= (size_t)size;
    }
    if (!ok) pass_over(server, name);
}

// --- What is kept until the pages have asked for it. ---

enum { FOREIGN, PRESS, OTHER, SORTS };

// True if it is the control, one below it, or a pattern that may mean it.
static bool is_of(const char *address, const char *control) {
    const size_t length = strlen(control), plain = strcspn(address, "*?[{");
    if (strncmp(address, control, plain < length ? plain : length) != 0) return false;
    return plain < length ? address[plain] != 0 : strchr("/*?[{", address[length]) != NULL;
}

// FOREIGN: no control begins like it. PRESS: no later message takes its place.
static int sort_of(const char *address) {
    static const char *const presses[] = {"/go", "/hold", "/back", "/cue"};
    static const char *const others[] = {"/fade", "/blackout", "/test", "/level", "/projector"};
    for (size_t i = 0; i < sizeof presses / sizeof *presses; i++)
        if (is_of(address, presses[i])) return PRESS;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (is_of(address, others[i])) return OTHER;
    return FOREIGN;
}

static const char *address_of(const json_t *message) {
    return json_string_value(json_object_get(message, "address"));
}

static bool has_value(const json_t *message) {
    return json_array_size(json_object_get(message, "values")) > 0;
}

// Removes the earlier value of the same fader, back to the last press, which may be meant to find it.
static void supersede(json_t *kept, const char *address) {
    for (size_t i = json_array_size(kept); i-- > 0;) {
        const json_t *one = json_array_get(kept, i);
        if (sort_of(address_of(one)) == PRESS) return;
        if (strcmp(address_of(one), address) != 0) continue;
        if (has_value(one)) json_array_remove(kept, i); // one without a value turns a switch, and stays
        return;
    }
}

// Makes room: presses have half of it, whatever else there is; of the rest what is foreign goes first.
static void make_room(json_t *kept) {
    size_t first[SORTS] = {0}, n[SORTS] = {0};
    for (size_t i = 0; i < json_array_size(kept); i++) {
        const int sort = sort_of(address_of(json_array_get(kept, i)));
        if (n[sort]++ == 0) first[sort] = i;
    }
    json_array_remove(kept, first[n[PRESS] > FFP_STUDIO_CONTROLS / 2 ? PRESS : n[FOREIGN] ? FOREIGN : OTHER]);
}

static void keep(FfpStudioServer *server, json_t *message) {
    json_t *kept = server->controls;
    const char *address = address_of(message);
    if (sort_of(address) != PRESS && has_value(message)) supersede(kept, address);
    json_object_set_new(message, "number", json_integer((json_int_t)++server->controlled));
    json_array_append(kept, message);
    if (json_array_size(kept) > FFP_STUDIO_CONTROLS) make_room(kept);
}

void ffp_server_controlled(FfpStudioServer *server) {
    static unsigned char bytes[PACKET_MOST + 1]; // with the lock
    const uint64_t before = server->controlled + server->passed_over;
    while (server->controlled + server->passed_over - before < AT_ONCE) {
        const ssize_t size = recv(server->osc, bytes, sizeof bytes, MSG_DONTWAIT);
        if (size < 0) return; // no more, or one that the system refused
        json_t *found = json_array(), *message;
        size_t k;
        read_packet(server, (Reader){bytes, (size_t)size}, found, 0);
        const uint64_t first = server->controlled;
        const bool together = json_array_size(found) > 1; // a bundle
        json_array_foreach(found, k, message) {
            if (together) json_object_set_new(message, "bundle", json_integer((json_int_t)first));
            keep(server, message);
        }
        json_decref(found);
    }
}

json_t *ffp_server_controls(const FfpStudioServer *server, uint64_t known) {
    json_t *events = json_array(), *message;
    size_t i;
    json_array_foreach(server->controls, i, message) {
        const uint64_t number = (uint64_t)json_integer_value(json_object_get(message, "number"));
        if (number > known) json_array_append(events, message);
    }
    return json_pack("{s:s?, s:I, s:o, s:I, s:s}", "osc", server->osc >= 0 ? server->heard : NULL, "number",
                     (json_int_t)server->controlled, "events", events, "passed_over",
                     (json_int_t)server->passed_over, "passed_last", server->passed_last);
}

// "9000", "192.168.1.5:9000" or "[::1]:9000" as an address and a port.
static bool split(const char *where, char host[64], const char **port) {
    const char *colon = strrchr(where, ':');
    const size_t length = colon ? (size_t)(colon - where) : 0;
    const bool brackets = length > 2 && where[0] == '[' && where[length - 1] == ']';
    *port = colon ? colon + 1 : where;
    if (length >= 64) return false;
    if (!colon) return snprintf(host, 64, "127.0.0.1") > 0;
    snprintf(host, 64, "%.*s", (int)(brackets ? length - 2 : length), where + brackets);
    return length > 0;
}

bool ffp_server_listen(FfpStudioServer *server, const char *where, char said[FFP_STUDIO_SAID]) {
    const struct addrinfo hints = {.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV, .ai_socktype = SOCK_DGRAM};
    struct addrinfo *found = NULL;
    char host[64], *end;
    const char *port;
    const bool ok = split(where, host, &port);
    const long number = ok ? strtol(port, &end, 10) : 0;
    if (!ok || *end || number < 1 || number > 65535 || getaddrinfo(host, port, &hints, &found) != 0)
        return ffp_studio_say(
            said, "--osc: \"%.80s\" is not [ADDRESS:]PORT, such as 9000 or 192.168.1.5:9000", where);
    server->osc = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const bool bound = server->osc >= 0 && bind(server->osc, found->ai_addr, found->ai_addrlen) == 0;
    const int why = errno;
    freeaddrinfo(found);
    if (!bound) return ffp_studio_say(said, "--osc: %.80s cannot be listened on: %s", where, strerror(why));
    snprintf(server->heard, sizeof server->heard, strchr(host, ':') ? "[%s]:%ld" : "%s:%ld", host, number);
    server->controls = json_array();
    return server->controls != NULL;
}
