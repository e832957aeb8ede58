#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/hash.hpp"
#include "io/marker_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* content, std::size_t size) {
    const mien::ByteView bytes(reinterpret_cast<const std::byte*>(content), size);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (const auto table = mien::io::parse_number_table(text)) (void)mien::io::parse_marker_table(*table);
    (void)mien::io::parse_trc(text);
    return 0;
}
