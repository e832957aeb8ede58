#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/hash.hpp"
#include "io/obj.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* content, std::size_t size) {
    const mien::ByteView bytes(reinterpret_cast<const std::byte*>(content), size);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const auto mesh = mien::io::parse_obj(text);
    const auto positions = mien::io::parse_obj_positions(text);
    // What one accepts, the other reads alike.
    if (mesh && (!positions || positions->rows() != mesh->positions.rows())) std::abort();
    return 0;
}
