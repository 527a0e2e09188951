/* SPDX-License-Identifier: Apache-2.0
 * Reads Protocol Buffers messages as spans of bytes: every length is checked against its span, and
 * nothing is allocated. */
#ifndef BN_PROTOBUF_H
#define BN_PROTOBUF_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { WIRE_VARINT = 0, WIRE_64_BIT = 1, WIRE_BYTES = 2, WIRE_32_BIT = 5 };

typedef struct span {
    const unsigned char *at, *end;
} span;

typedef struct field {
    uint32_t number, wire;
    uint64_t value; /* of a varint */
    span bytes;     /* of a length-delimited field */
} field;

static inline int read_varint(span *s, uint64_t *value) {
    *value = 0;
    for (uint32_t shift = 0; shift < 64; shift += 7) {
        if (s->at == s->end) return 0;
        const unsigned char byte = *s->at++;
        if (shift == 63 && byte > 1) return 0;
        *value |= (uint64_t)(byte & 0x7f) << shift;
        if ((byte & 0x80) == 0) return 1;
    }
    return 0;
}

/* Reads the next field of a message: 1, 0 at its end, -1 if it is malformed. */
static inline int next_field(span *s, field *f) {
    uint64_t key, length;
    if (s->at == s->end) return 0;
    if (!read_varint(s, &key) || key >> 3 == 0 || key >> 32 != 0) return -1;
    f->number = (uint32_t)(key >> 3);
    f->wire = (uint32_t)(key & 7);
    f->value = 0;
    f->bytes.at = f->bytes.end = NULL;
    switch (f->wire) {
    case WIRE_VARINT:
        return read_varint(s, &f->value) ? 1 : -1;
    case WIRE_64_BIT:
    case WIRE_32_BIT:
        length = f->wire == WIRE_64_BIT ? 8 : 4;
        break;
    case WIRE_BYTES:
        if (!read_varint(s, &length)) return -1;
        break;
    default: /* groups are not in the schema */
        return -1;
    }
    if (length > (uint64_t)(s->end - s->at)) return -1;
    f->bytes.at = s->at;
    s->at += length;
    f->bytes.end = s->at;
    return 1;
}

static inline int is_text(span s, const char *text) {
    const size_t length = strlen(text);
    return (size_t)(s.end - s.at) == length && (length == 0 || memcmp(s.at, text, length) == 0);
}

static inline int is_bytes(const field *f) {
    return f->wire == WIRE_BYTES;
}

/* Finds the only field `number` of a message; 0 if there is none or more than one. */
static inline int only_message(span s, uint32_t number, span *message) {
    field f;
    int state, count = 0;
    message->at = message->end = s.end;
    while ((state = next_field(&s, &f)) == 1) {
        if (f.number != number) continue;
        if (!is_bytes(&f) || count++) return 0;
        *message = f.bytes;
    }
    return state == 0 && count == 1;
}

#endif
