#include <cstddef>
#include <cstdint>

#include "core/hash.hpp"
#include "io/marker_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* content, std::size_t size) {
    const mien::ByteView bytes(reinterpret_cast<const std::byte*>(content), size);
    (void)mien::io::parse_c3d(bytes);
    return 0;
}
