/* SPDX-License-Identifier: Apache-2.0
 * Reading files whole. The one place that knows files. */
#ifndef BN_FILES_H
#define BN_FILES_H

#include <bn/bn.h>

/* A file of at most `limit` bytes, to be given back with bn_free(). Errors: IO (it cannot be opened
 * or read), BAD_DATA (it is empty or larger), OUT_OF_MEMORY. */
bn_result bn_file_read(const char *path, size_t limit, unsigned char **bytes, size_t *size);

#endif
