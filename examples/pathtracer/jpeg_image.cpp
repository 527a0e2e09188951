// SPDX-License-Identifier: Apache-2.0
// JPEG through the TurboJPEG interface of libjpeg-turbo.
#include "jpeg_image.h"

#include <turbojpeg.h>

#include <cstring>
#include <memory>
#include <new>

#include "error.h"

std::vector<uint8_t> jpeg_decode_rgba(const std::vector<unsigned char> &bytes, int width,
                                      int height, bool &cut_short) {
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitDecompress(), tjDestroy);
    if (!jpeg) throw std::bad_alloc();
    const auto size = static_cast<unsigned long>(bytes.size());
    int stated_width = 0, stated_height = 0, subsampling = 0, colours = 0;
    if (tjDecompressHeader3(jpeg.get(), bytes.data(), size, &stated_width, &stated_height,
                            &subsampling, &colours) != 0 ||
        stated_width != width || stated_height != height)
        throw Error("is damaged: it cannot be decoded");
    if (colours == TJCS_CMYK || colours == TJCS_YCCK)
        throw Error("is a JPEG in CMYK, for print; save it in RGB");
    std::vector<uint8_t> rgba(size_t{4} * static_cast<size_t>(width) * static_cast<size_t>(height));
    // Viewers show what a warning is about, too.
    if (tjDecompress2(jpeg.get(), bytes.data(), size, rgba.data(), width, 0, height, TJPF_RGBA,
                      TJFLAG_ACCURATEDCT) != 0) {
        // An error after a warning counts as one, too, but leaves texels unwritten.
        if (tjGetErrorCode(jpeg.get()) != TJERR_WARNING || rgba.back() != 255)
            throw Error("is damaged: it cannot be decoded");
        // libjpeg's words, the only sign of it.
        cut_short = std::strstr(tjGetErrorStr2(jpeg.get()), "Premature end of JPEG") != nullptr;
    }
    return rgba;
}
