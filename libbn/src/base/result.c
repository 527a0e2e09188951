/* SPDX-License-Identifier: Apache-2.0
 * Converts results and the version to strings. */
#include <bn/bn.h>

#define BN_STRINGIFY_(x) #x
#define BN_STRINGIFY(x) BN_STRINGIFY_(x)

const char *bn_result_string(bn_result result) {
    switch (result) {
    case BN_SUCCESS:
        return "success";
    case BN_ERROR_INVALID_ARGUMENT:
        return "invalid argument";
    case BN_ERROR_SIZE_MISMATCH:
        return "the count of an array does not match its extents";
    case BN_ERROR_OUT_OF_MEMORY:
        return "out of memory";
    case BN_ERROR_BAD_DATA:
        return "bad data";
    case BN_ERROR_UNSUPPORTED:
        return "not supported by this version or build";
    case BN_ERROR_RUNTIME:
        return "ONNX Runtime is missing or failed";
    case BN_ERROR_IO:
        return "a file cannot be opened or read";
    case BN_ERROR_CANCELLED:
        return "cancelled";
    default:
        return "unknown result";
    }
}

const char *bn_version_string(void) {
    return BN_STRINGIFY(BN_VERSION_MAJOR) "." BN_STRINGIFY(BN_VERSION_MINOR) "." BN_STRINGIFY(
        BN_VERSION_PATCH);
}
