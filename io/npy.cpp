#include "io/npy.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>

#include "io/text.hpp"

static_assert(std::endian::native == std::endian::little, "NPY values are converted as little-endian memory");

namespace mien::io {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";

struct ElementType {
    char kind = 'f';  // f, i, u, b as NumPy names them
    std::size_t size = 4;
};

struct Header {
    ElementType type;
    std::vector<std::int64_t> shape;
    std::int64_t count = 1;
};

/// The value that follows 'key': in a Python dictionary literal, up to the end of the text.
std::optional<std::string_view> value_of(std::string_view dictionary, std::string_view key) {
    for (const char quote : {'\'', '"'}) {
        const std::size_t at = dictionary.find(fmt::format("{0}{1}{0}", quote, key));
        if (at == std::string_view::npos) continue;
        std::string_view rest = trimmed(dictionary.substr(at + key.size() + 2));
        if (!rest.starts_with(':')) return std::nullopt;
        return trimmed(rest.substr(1));
    }
    return std::nullopt;
}

Result<ElementType> parse_type(std::string_view text) {
    if (text.size() < 2 || (text[0] != '\'' && text[0] != '"'))
        return Error{ErrorCode::invalid, "the array is structured; save plain numbers (astype('float32'))"};
    const std::string_view descr = text.substr(1, std::min(text.find(text[0], 1), text.size()) - 1);
    if (descr.starts_with('>'))
        return Error{ErrorCode::invalid, "the array is big-endian; save it with astype('<f4')"};
    const std::string_view name = descr.empty() ? descr : descr.substr(1);
    for (const auto& [known, type] : std::initializer_list<std::pair<std::string_view, ElementType>>{
             {"f2", {'f', 2}}, {"f4", {'f', 4}}, {"f8", {'f', 8}}, {"i1", {'i', 1}}, {"i2", {'i', 2}}, {"i4", {'i', 4}},
             {"i8", {'i', 8}}, {"u1", {'u', 1}}, {"u2", {'u', 2}}, {"u4", {'u', 4}}, {"u8", {'u', 8}}, {"b1", {'u', 1}}})
        if (name == known) return type;
    return Error{ErrorCode::invalid, fmt::format("the array's type is '{}'; save it with astype('float32')", descr)};
}

Result<Header> parse_header(std::string_view dictionary) {
    const auto descr = value_of(dictionary, "descr");
    const auto order = value_of(dictionary, "fortran_order");
    auto shape = value_of(dictionary, "shape");
    if (!descr || !order || !shape || !shape->starts_with('('))
        return Error{ErrorCode::damaged, "the NPY header lacks descr, fortran_order or shape"};
    Header header;
    MIEN_TRY(type, parse_type(*descr));
    header.type = type;
    const std::size_t close = shape->find(')');
    if (close == std::string_view::npos) return Error{ErrorCode::damaged, "the NPY header's shape does not end"};
    for (const std::string_view field : split(shape->substr(1, close - 1), ',')) {
        if (field.empty()) continue;  // the comma after the last size
        const auto size = parse_integer(field);
        if (!size || *size < 0) return Error{ErrorCode::damaged, "the NPY header's shape is not made of sizes"};
        if (header.shape.size() == 8 || *size > kMaxValues || (*size > 0 && header.count > kMaxValues / *size))
            return Error{ErrorCode::limit_exceeded, "the array is larger than any clip"};
        header.shape.push_back(*size);
        header.count *= *size;
    }
    if (!order->starts_with("False") && header.shape.size() > 1)
        return Error{ErrorCode::invalid, "the array is in Fortran order; save it with numpy.ascontiguousarray"};
    return header;
}

float half_to_float(std::uint16_t half) {
    const int exponent = half >> 10 & 31;
    const int mantissa = half & 1023;
    float value;
    if (exponent == 31)
        value = mantissa ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
    else
        value = std::ldexp(float(exponent ? mantissa + 1024 : mantissa), (exponent ? exponent : 1) - 25);
    return half & 0x8000 ? -value : value;
}

template <class T>
void convert(const std::byte* from, std::size_t count, float* to) {
    for (std::size_t i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, from + i * sizeof(T), sizeof(T));
        to[i] = static_cast<float>(value);
    }
}

void convert(ElementType type, const std::byte* from, std::size_t count, float* to) {
    switch (type.kind == 'f' ? type.size * 16 : type.size * (type.kind == 'i' ? 1 : 2) + 256) {
        case 2 * 16:
            for (std::size_t i = 0; i < count; ++i) {
                std::uint16_t half;
                std::memcpy(&half, from + 2 * i, 2);
                to[i] = half_to_float(half);
            }
            return;
        case 4 * 16: std::memcpy(to, from, count * 4); return;
        case 8 * 16: return convert<double>(from, count, to);
        default: break;
    }
    const bool is_signed = type.kind == 'i';
    switch (type.size) {
        case 1: return is_signed ? convert<std::int8_t>(from, count, to) : convert<std::uint8_t>(from, count, to);
        case 2: return is_signed ? convert<std::int16_t>(from, count, to) : convert<std::uint16_t>(from, count, to);
        case 4: return is_signed ? convert<std::int32_t>(from, count, to) : convert<std::uint32_t>(from, count, to);
        case 8: return is_signed ? convert<std::int64_t>(from, count, to) : convert<std::uint64_t>(from, count, to);
        default: assert(false);
    }
}

/// Reads exactly that many bytes, or says no.
using ReadBytes = std::function<bool(std::byte*, std::size_t)>;

/// `size`: bytes in all, so that a header cannot ask for more than there is. Leaves `read` at the first value.
Result<Header> read_header(const ReadBytes& read, std::uint64_t size) {
    const Error truncated{ErrorCode::truncated, "the NPY file ends inside its header"};
    std::uint8_t prefix[12];
    if (size < 10 || !read(reinterpret_cast<std::byte*>(prefix), 10)) {
        return size >= 6 || size == 0 ? truncated : Error{ErrorCode::bad_magic, "this is not an NPY file"};
    }
    if (std::memcmp(prefix, kMagic.data(), kMagic.size()) != 0) return Error{ErrorCode::bad_magic, "this is not an NPY file"};
    const int version = prefix[6];
    if (version < 1 || version > 3)
        return Error{ErrorCode::unsupported_version, fmt::format("NPY version {}.{} is unknown", version, int(prefix[7]))};
    std::uint64_t header_size = prefix[8] | prefix[9] << 8;
    std::uint64_t start = 10;
    if (version >= 2) {
        if (!read(reinterpret_cast<std::byte*>(prefix + 10), 2)) return truncated;
        header_size |= std::uint64_t(prefix[10]) << 16 | std::uint64_t(prefix[11]) << 24;
        start = 12;
    }
    if (header_size > size - start) return truncated;
    if (header_size > 65536) return Error{ErrorCode::limit_exceeded, "the NPY header is longer than 64 KiB"};
    std::string text(header_size, '\0');
    if (!read(reinterpret_cast<std::byte*>(text.data()), header_size)) return truncated;
    MIEN_TRY(header, parse_header(text));

    const std::uint64_t wanted = std::uint64_t(header.count) * header.type.size;
    const std::uint64_t there = size - start - header_size;
    if (there < wanted)
        return Error{ErrorCode::truncated,
                     fmt::format("the NPY file ends {} bytes before its array of shape {} does", wanted - there, fmt::format("[{}]", fmt::join(header.shape, ", ")))};
    if (there > wanted)
        return Error{ErrorCode::trailing_bytes, fmt::format("the NPY file has {} bytes after its array", there - wanted)};
    return header;
}

Result<NpyArray> parse(const ReadBytes& read, std::uint64_t size) {
    MIEN_TRY(header, read_header(read, size));
    NpyArray array;
    array.shape = header.shape;
    array.values.resize(std::size_t(header.count));
    std::vector<std::byte> piece(std::min<std::uint64_t>(std::uint64_t(header.count) * header.type.size, 1 << 20));
    const std::size_t per_piece = std::max<std::size_t>(piece.size() / header.type.size, 1);
    for (std::size_t at = 0; at < array.values.size(); at += per_piece) {
        const std::size_t count = std::min(per_piece, array.values.size() - at);
        if (!read(piece.data(), count * header.type.size)) return Error{ErrorCode::truncated, "the NPY file ends inside its array"};
        convert(header.type, piece.data(), count, array.values.data() + at);
    }
    return array;
}

std::string header_text(const std::vector<std::int64_t>& shape) {
    std::string dictionary = fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}{}), }}",
                                         fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
    // The array starts at a multiple of 64 bytes, the header ends in a line feed: so NumPy can map the file.
    dictionary.resize((10 + dictionary.size() + 1 + 63) / 64 * 64 - 11, ' ');
    dictionary += '\n';
    std::string text(kMagic);
    text += '\1';
    text += '\0';
    text += static_cast<char>(dictionary.size() & 255);
    text += static_cast<char>(dictionary.size() >> 8);
    return text + dictionary;
}

}  // namespace

std::string NpyArray::shape_text() const { return fmt::format("[{}]", fmt::join(shape, ", ")); }

Result<NpyArray> parse_npy(ByteView bytes) {
    std::size_t at = 0;
    return parse(
        [&](std::byte* to, std::size_t size) {
            if (size > bytes.size() - at) return false;
            if (size) std::memcpy(to, bytes.data() + at, size);
            at += size;
            return true;
        },
        bytes.size());
}

namespace {

/// Calls take(read, size) with an opened file.
template <class T>
Result<T> with_file(const std::filesystem::path& path, Result<T> (*take)(const ReadBytes&, std::uint64_t)) {
    MIEN_TRY(file, open_to_read(path));
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    if (error) return Error{ErrorCode::unavailable, fmt::format("{} has no size: {}", path.string(), error.message())};
    auto taken = take([&](std::byte* to, std::size_t n) { return std::fread(to, 1, n, file.get()) == n; }, size);
    if (!taken) return in_file(path, taken.error());
    return taken;
}

}  // namespace

Result<NpyArray> read_npy(const std::filesystem::path& path) { return with_file<NpyArray>(path, parse); }

Result<std::vector<std::int64_t>> read_npy_shape(const std::filesystem::path& path) {
    MIEN_TRY(header, with_file<Header>(path, read_header));
    return std::move(header.shape);
}

NpyWriter::NpyWriter(const std::filesystem::path& path, const std::vector<std::int64_t>& shape) : file_(path), missing_(1) {
    for (const std::int64_t size : shape) missing_ *= size;
    file_.write(header_text(shape));
}

void NpyWriter::write(std::span<const float> values) {
    missing_ -= std::int64_t(values.size());
    file_.write(std::as_bytes(values));
}

void NpyWriter::commit() {
    assert(missing_ == 0);
    file_.commit();
}

void write_npy(const std::filesystem::path& path, const std::vector<std::int64_t>& shape, std::span<const float> values) {
    NpyWriter writer(path, shape);
    writer.write(values);
    writer.commit();
}

}  // namespace mien::io
