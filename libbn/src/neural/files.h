/* SPDX-License-Identifier: Apache-2.0
 * Reads whole files. Nothing else in the library opens files. */
#ifndef BN_FILES_H
#define BN_FILES_H

#include <bn/bn.h>

/* Reads a file of at most `limit` bytes; free *bytes with bn_free(). Errors: IO (it cannot be
 * opened or read), BAD_DATA (it is empty or exceeds the limit), OUT_OF_MEMORY. */
bn_result bn_file_read(const char *path, size_t limit, unsigned char **bytes, size_t *size);

#endif
