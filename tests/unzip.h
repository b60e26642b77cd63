// Files of a ZIP archive, found as readers find them: from the list at its end.
#ifndef FFP_TESTS_UNZIP_H
#define FFP_TESTS_UNZIP_H

#include <string.h>
#include <zlib.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "support.h"

static inline unsigned number_at(const unsigned char *bytes, int size) {
    unsigned number = 0;
    for (int i = size - 1; i >= 0; i--) number = number << 8 | bytes[i];
    return number;
}

// Into `out`; its size.
static inline size_t unpack(const char *archive, const char *name, unsigned char *out, size_t room) {
    char *data;
    size_t size;
    assert_true(ffp_read_file(archive, 1 << 26, &data, &size, NULL));
    const unsigned char *bytes = (const unsigned char *)data, *end = bytes + size - 22,
                        *list = bytes + number_at(end + 16, 4);
    assert_int_equal(number_at(end, 4), 0x06054b50);
    while (strncmp((const char *)list + 46, name, strlen(name)) != 0) {
        assert_int_equal(number_at(list, 4), 0x02014b50);
        list += 46 + number_at(list + 28, 2);
    }
    const unsigned char *local = bytes + number_at(list + 42, 4);
    assert_memory_equal(local + 4, list + 6, 26);
    const size_t full = number_at(list + 24, 4);
    assert_true(full <= room);
    z_stream stream = {.next_in = (z_const Bytef *)local + 30 + number_at(local + 26, 2),
                       .avail_in = number_at(list + 20, 4),
                       .next_out = out,
                       .avail_out = (uInt)room};
    assert_int_equal(inflateInit2(&stream, -MAX_WBITS), Z_OK);
    assert_int_equal(inflate(&stream, Z_FINISH), Z_STREAM_END);
    assert_true(stream.total_out == full && stream.avail_in == 0);
    assert_int_equal(crc32(0, out, (uInt)full), number_at(list + 16, 4));
    inflateEnd(&stream);
    ffp_free(data);
    return full;
}

#endif
