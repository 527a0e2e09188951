/* SPDX-License-Identifier: Apache-2.0
 * Reads whole files without querying their size, because pipes have none and files can grow. The buffer
 * doubles from 64 KiB; at most twice the file's size is copied. */
#include "neural/files.h"
#include "base/memory.h"
#include <stdio.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>

wchar_t *bn_file_wide(const char *text) {
    const int size = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, text, -1, NULL, 0);
    wchar_t *wide = size > 0 ? bn_allocate((size_t)size, sizeof *wide) : NULL;
    if (wide != NULL) MultiByteToWideChar(CP_UTF8, 0, text, -1, wide, size);
    return wide;
}

static FILE *open_file(const char *path) {
    wchar_t *wide = bn_file_wide(path);
    FILE *file = wide != NULL ? _wfopen(wide, L"rb") : NULL;
    bn_free(wide);
    return file;
}
#else
static FILE *open_file(const char *path) {
    return fopen(path, "rb");
}
#endif

bn_result bn_file_read(const char *path, size_t limit, unsigned char **bytes, size_t *size) {
    FILE *file = open_file(path);
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
