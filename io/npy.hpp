#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/result.hpp"
#include "io/file.hpp"

namespace mien::io {

/// An array as NumPy stores it, in C order. Whatever number type the file had (little-endian floats of 16, 32, 64 bits,
/// integers of 8 to 64 bits, bool), values are floats here: indices below 2^24 stay exact.
struct NpyArray {
    std::vector<std::int64_t> shape;
    std::vector<float> values;  ///< product of shape

    std::string shape_text() const;  ///< "[600, 11248, 3]"
};

/// NPY format versions 1 to 3. Errors: bad_magic, truncated, trailing_bytes, unsupported_version; invalid for Fortran order,
/// big-endian or structured types, each saying how to save the array instead.
Result<NpyArray> parse_npy(ByteView bytes);
/// The same from a file, converted piece by piece, so that only the floats take memory.
Result<NpyArray> read_npy(const std::filesystem::path& path);
/// Its shape alone.
Result<std::vector<std::int64_t>> read_npy_shape(const std::filesystem::path& path);

/// Writes float32, version 1, value by value as they come. Throws EnvironmentError.
class NpyWriter {
public:
    NpyWriter(const std::filesystem::path& path, const std::vector<std::int64_t>& shape);
    void write(std::span<const float> values);
    void commit();  ///< every value the shape promises must have been written

private:
    OutputFile file_;
    std::int64_t missing_;
};

/// A whole array at once. values.size() is the product of shape.
void write_npy(const std::filesystem::path& path, const std::vector<std::int64_t>& shape, std::span<const float> values);

}  // namespace mien::io
