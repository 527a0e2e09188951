/* SPDX-License-Identifier: Apache-2.0
 * Reading option structures of older and newer headers. */
#ifndef BN_OPTIONS_H
#define BN_OPTIONS_H

#include <bn/bn.h>
#include <string.h>

/* Copies what the caller's structure holds over `options`, which the caller has filled with
 * defaults. `given` may be NULL. Every options structure starts with its struct_size. */
static inline bn_result bn_options_read(void *options, size_t size, const void *given) {
    size_t given_size;
    const unsigned char *bytes = (const unsigned char *)given;
    if (given == NULL) return BN_SUCCESS;
    memcpy(&given_size, given, sizeof given_size);
    if (given_size < sizeof given_size) return BN_ERROR_INVALID_ARGUMENT;
    for (size_t i = size; i < given_size; ++i) {
        if (bytes[i] != 0) return BN_ERROR_UNSUPPORTED;
    }
    memcpy(options, given, given_size < size ? given_size : size);
    memcpy(options, &size, sizeof size);
    return BN_SUCCESS;
}

#endif
