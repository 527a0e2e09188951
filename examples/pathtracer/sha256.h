// SPDX-License-Identifier: Apache-2.0
// SHA-256 (NIST, FIPS 180-4), to tell whether a file has changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

class Sha256 {
  public:
    void add(const void *bytes, size_t count);
    // The digest of all bytes, in lower-case hexadecimal. Call it once, last.
    std::string hex();

  private:
    void add_block(const uint8_t *block);

    uint32_t state_[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                          0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    uint8_t rest_[64]; // bytes that fill no block yet
    uint64_t size_ = 0;
};
