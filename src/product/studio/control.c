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
    PACKET_MOST = 4096, // bytes
    ADDRESS_MOST = 120, // characters of an address
    TEXT_MOST = 400,    // bytes of a text
    VALUES_MOST = 16,   // of a message
    NESTED_MOST = 4,    // bundles within bundles
    AT_ONCE = 64        // packets before others are served
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
        return isfinite(single) ? json_real((double)single) : NULL;
    case 'd':
        if (!take(r, 8, &bits)) return NULL;
        memcpy(&number, &bits, sizeof number);
        return isfinite(number) ? json_real(number) : NULL;
    case 's':
    case 'S':
        text = take_text(r, TEXT_MOST);
        return text ? json_string(text) : NULL; // NULL: not UTF-8
    default:
        return NULL;
    }
}

// Names between slashes, as docs/guide/show.md lists them; patterns are for senders that do not know them.
static bool is_address(const char *text) {
    const size_t length = strlen(text);
    return length > 1 && text[0] == '/' &&
           strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/_-.") == length;
}

// {"address", "values"}; NULL: not a valid message.
static json_t *take_message(Reader *r) {
    const char *address = take_text(r, ADDRESS_MOST), *types = ",";
    json_t *values = json_array();
    bool ok = address && is_address(address);
    if (ok && r->left > 0) types = take_text(r, VALUES_MOST + 1); // old senders leave it out
    ok = ok && types && types[0] == ',';
    for (size_t i = 1; ok && types[i]; i++) ok = json_array_append_new(values, take_value(r, types[i])) == 0;
    if (ok && r->left == 0) return json_pack("{s:s, s:o}", "address", address, "values", values);
    json_decref(values);
    return NULL;
}

static bool read_packet(Reader r, json_t *found, int nested) {
    uint64_t size;
    if (r.left == 0 || r.left % 4 != 0) return false;
    if (r.at[0] != '#') return json_array_append_new(found, take_message(&r)) == 0;
    const char *name = take_text(&r, 8);
    if (nested == NESTED_MOST || !name || strcmp(name, "#bundle") != 0 || !take(&r, 8, &size)) return false;
    while (r.left > 0) { // at once, whatever time it names
        if (!take(&r, 4, &size) || size > r.left ||
            !read_packet((Reader){r.at, (size_t)size}, found, nested + 1))
            return false;
        r.at += size, r.left -= (size_t)size;
    }
    return true;
}

json_t *ffp_studio_osc(const void *bytes, size_t size) {
    json_t *found = json_array();
    if (found && read_packet((Reader){bytes, size}, found, 0)) return found;
    json_decref(found);
    return NULL;
}

void ffp_studio_controlled(FfpStudio *studio) {
    unsigned char bytes[PACKET_MOST + 1];
    for (int i = 0; i < AT_ONCE; i++) {
        const ssize_t size = recv(studio->osc, bytes, sizeof bytes, MSG_DONTWAIT);
        if (size < 0) return; // no more, or one that the system refused
        json_t *found = size <= PACKET_MOST ? ffp_studio_osc(bytes, (size_t)size) : NULL, *message;
        size_t k;
        const uint64_t first = studio->controlled;
        const bool together = json_array_size(found) > 1; // a bundle
        json_array_foreach(found, k, message) {
            if (together) json_object_set_new(message, "bundle", json_integer((json_int_t)first));
            json_array_append(studio->controls, message);
            studio->controlled++;
        }
        json_decref(found);
        while (json_array_size(studio->controls) > FFP_STUDIO_CONTROLS)
            json_array_remove(studio->controls, 0);
    }
}

json_t *ffp_studio_controls(const FfpStudio *studio, uint64_t known) {
    const size_t kept = json_array_size(studio->controls);
    const uint64_t fresh = known < studio->controlled ? studio->controlled - known : 0;
    json_t *events = json_array();
    for (size_t i = fresh < kept ? kept - (size_t)fresh : 0; i < kept; i++)
        json_array_append(events, json_array_get(studio->controls, i));
    return json_pack("{s:s?, s:I, s:o}", "osc", studio->osc >= 0 ? studio->heard : NULL, "number",
                     (json_int_t)studio->controlled, "events", events);
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

bool ffp_studio_listen(FfpStudio *studio, const char *where, char said[FFP_STUDIO_SAID]) {
    const struct addrinfo hints = {.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV, .ai_socktype = SOCK_DGRAM};
    struct addrinfo *found = NULL;
    char host[64], *end;
    const char *port;
    const bool ok = split(where, host, &port);
    const long number = ok ? strtol(port, &end, 10) : 0;
    if (!ok || *end || number < 1 || number > 65535 || getaddrinfo(host, port, &hints, &found) != 0)
        return ffp_studio_say(
            said, "--osc: \"%.80s\" is not [ADDRESS:]PORT, such as 9000 or 192.168.1.5:9000", where);
    studio->osc = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const bool bound = studio->osc >= 0 && bind(studio->osc, found->ai_addr, found->ai_addrlen) == 0;
    const int why = errno;
    freeaddrinfo(found);
    if (!bound) return ffp_studio_say(said, "--osc: %.80s cannot be listened on: %s", where, strerror(why));
    snprintf(studio->heard, sizeof studio->heard, strchr(host, ':') ? "[%s]:%ld" : "%s:%ld", host, number);
    studio->controls = json_array();
    return studio->controls != NULL;
}
