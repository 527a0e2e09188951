/* SPDX-License-Identifier: Apache-2.0
 * Reads whole files. Paths are UTF-8 on Windows, and any bytes elsewhere. */
#ifndef BN_FILES_H
#define BN_FILES_H

#include <bn/bn.h>

/* Reads a file of at most `limit` bytes; free *bytes with bn_free(). Errors: IO (it cannot be
 * opened or read), BAD_DATA (it is empty or exceeds the limit), OUT_OF_MEMORY. */
bn_result bn_file_read(const char *path, size_t limit, unsigned char **bytes, size_t *size);

#if defined(_WIN32)
/* Converts UTF-8 to the characters of Windows; free the result with bn_free(). Returns NULL if `text` is not
 * valid UTF-8 or memory runs out. */
wchar_t *bn_file_wide(const char *text);
#endif

#endif
