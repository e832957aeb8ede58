#include <cstddef>
#include <cstdint>

#include "core/hash.hpp"
#include "io/live_link.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* content, std::size_t size) {
    const mien::ByteView bytes(reinterpret_cast<const std::byte*>(content), size);
    (void)mien::io::parse_live_link({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    return 0;
}
