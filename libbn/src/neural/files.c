/* SPDX-License-Identifier: Apache-2.0
 * Reads whole files without querying their size, because pipes have none and files can grow. */
#include "neural/files.h"
#include "base/memory.h"
#include <stdio.h>
#include <string.h>

bn_result bn_file_read(const char *path, size_t limit, unsigned char **bytes, size_t *size) {
    FILE *file = fopen(path, "rb");
    unsigned char *buffer = NULL;
    size_t capacity = 0, count = 0;
    bn_result result = BN_SUCCESS;
    if (file == NULL) return BN_ERROR_IO;
    for (;;) {
        if (count == capacity) {
            const size_t larger = capacity == 0 ? (size_t)1 << 16 : 2 * capacity;
            unsigned char *grown = bn_allocate(larger, 1);
            if (grown == NULL) {
                result = BN_ERROR_OUT_OF_MEMORY;
                break;
            }
            if (count != 0) memcpy(grown, buffer, count);
            bn_free(buffer);
            buffer = grown;
            capacity = larger;
        }
        const size_t got = fread(buffer + count, 1, capacity - count, file);
        count += got;
        if (count > limit) {
            result = BN_ERROR_BAD_DATA;
            break;
        }
        if (got == 0) {
            result = ferror(file) ? BN_ERROR_IO : count == 0 ? BN_ERROR_BAD_DATA : BN_SUCCESS;
            break;
        }
    }
    fclose(file);
    if (result != BN_SUCCESS) {
        bn_free(buffer);
        return result;
    }
    *bytes = buffer;
    *size = count;
    return BN_SUCCESS;
}
