#include <cstddef>
#include <cstdint>

#include "core/hash.hpp"
#include "io/clip_description.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* content, std::size_t size) {
    const mien::ByteView bytes(reinterpret_cast<const std::byte*>(content), size);
    mien::io::Findings findings;
    (void)mien::io::parse_description({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "/nonexistent", findings);
    return 0;
}
