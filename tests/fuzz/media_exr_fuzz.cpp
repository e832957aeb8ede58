#include <cstddef>
#include <cstdint>

#include "core/hash.hpp"
#include "media/float_picture.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* content, std::size_t size) {
    const mien::ByteView bytes(reinterpret_cast<const std::byte*>(content), size);
    (void)mien::media::decode_exr(bytes);
    return 0;
}
