/* SPDX-License-Identifier: Apache-2.0
 * Reads options structures from older and newer headers. */
#ifndef BN_OPTIONS_H
#define BN_OPTIONS_H

#include <bn/bn.h>
#include <string.h>

/* The largest structure that a newer header might define. A larger struct_size must be uninitialised. */
enum { BN_OPTIONS_MOST_BYTES = 4096 };

/* Copies the caller's structure over `options`, which holds the defaults. `given` may be NULL. Every
 * options structure starts with its struct_size. A structure smaller than this version's is rejected: there
 * is no older version, and a smaller size could end inside a pointer. Once a structure has grown, pass its
 * older sizes and accept only those. Errors: INVALID_ARGUMENT (an impossible size), UNSUPPORTED (the
 * structure sets options that this library lacks). */
static inline bn_result bn_options_read(void *options, size_t size, const void *given) {
    size_t given_size;
    const unsigned char *bytes = (const unsigned char *)given;
    if (given == NULL) return BN_SUCCESS;
    memcpy(&given_size, given, sizeof given_size);
    if (given_size < size || given_size > BN_OPTIONS_MOST_BYTES) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    for (size_t i = size; i < given_size; ++i) {
        if (bytes[i] != 0) return BN_ERROR_UNSUPPORTED;
    }
    memcpy(options, given, size);
    memcpy(options, &size, sizeof size);
    return BN_SUCCESS;
}

#endif
