#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/byte_io.hpp"

namespace mien::vectors {

inline std::filesystem::path folder() { return std::filesystem::path(MIEN_SOURCE_DIR) / "tests" / "vectors"; }

inline std::string read_text(const std::string& file) {
    std::ifstream in(folder() / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline Bytes read_file(const std::string& file) {
    const std::string text = read_text(file);
    Bytes bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return std::byte(c); });
    return bytes;
}
inline void write_file(const std::string& file, const Bytes& bytes) {
    std::ofstream(folder() / file, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

}  // namespace mien::vectors
