#pragma once

#include <bit>
#include <cstring>
#include <string>
#include <string_view>

#include "core/hash.hpp"

namespace mien {

/// Reads little-endian fields one by one. The error is sticky: after a short read every field is zero and ok() stays
/// false, so a parser reads like the format's description and tests once at the end.
class ByteReader {
public:
    explicit ByteReader(ByteView bytes) : bytes_(bytes) {}

    std::uint8_t u8() { return static_cast<std::uint8_t>(little(1)); }
    std::uint16_t u16() { return static_cast<std::uint16_t>(little(2)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(little(4)); }
    std::uint64_t u64() { return little(8); }
    float f32() { return std::bit_cast<float>(u32()); }

    /// LEB128: seven bits a byte, lowest first, top bit set on all but the last; at most ten bytes, shortest form only.
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 70; shift += 7) {
            const std::uint8_t b = u8();
            if (!ok_) return 0;
            if ((shift == 63 && b > 1) || (shift > 0 && b == 0)) break;
            value |= std::uint64_t(b & 127) << shift;
            if (b < 128) return value;
        }
        fail();
        return 0;
    }
    /// Signed, zigzag over varint: 0, -1, 1, -2, ...
    std::int64_t svarint() {
        const std::uint64_t v = varint();
        return static_cast<std::int64_t>(v >> 1) ^ -static_cast<std::int64_t>(v & 1);
    }
    /// The next `size` bytes; empty and failed when there are fewer.
    ByteView bytes(std::uint64_t size) {
        if (!ok_ || size > remaining()) return fail(), ByteView{};
        const ByteView view = bytes_.subspan(at_, size);
        at_ += size;
        return view;
    }
    /// A varint length of at most `limit`, then that many bytes of UTF-8.
    std::string text(std::size_t limit) {
        const std::uint64_t size = varint();
        if (size > limit) return fail(), std::string{};
        const ByteView view = bytes(size);
        return {reinterpret_cast<const char*>(view.data()), view.size()};
    }
    Hash hash() {
        Hash hash;
        const ByteView view = bytes(hash.bytes.size());
        if (ok_) std::memcpy(hash.bytes.data(), view.data(), view.size());
        return hash;
    }

    bool ok() const { return ok_; }
    bool at_end() const { return at_ == bytes_.size(); }
    std::size_t position() const { return at_; }
    std::size_t remaining() const { return bytes_.size() - at_; }
    void fail() { ok_ = false; }

private:
    std::uint64_t little(int size) {
        if (!ok_ || remaining() < std::size_t(size)) return fail(), 0;
        std::uint64_t value = 0;
        for (int i = 0; i < size; ++i) value |= std::uint64_t(std::to_integer<std::uint8_t>(bytes_[at_++])) << 8 * i;
        return value;
    }

    ByteView bytes_;
    std::size_t at_ = 0;
    bool ok_ = true;
};

/// Appends what ByteReader reads.
class ByteWriter {
public:
    void u8(std::uint8_t v) { little(v, 1); }
    void u16(std::uint16_t v) { little(v, 2); }
    void u32(std::uint32_t v) { little(v, 4); }
    void u64(std::uint64_t v) { little(v, 8); }
    void f32(float v) { u32(std::bit_cast<std::uint32_t>(v)); }
    void varint(std::uint64_t v) {
        for (; v >= 128; v >>= 7) u8(static_cast<std::uint8_t>(v | 128));
        u8(static_cast<std::uint8_t>(v));
    }
    void svarint(std::int64_t v) { varint(static_cast<std::uint64_t>(v) << 1 ^ static_cast<std::uint64_t>(v >> 63)); }
    void bytes(ByteView view) { bytes_.insert(bytes_.end(), view.begin(), view.end()); }
    void text(std::string_view s) {
        varint(s.size());
        bytes(std::as_bytes(std::span(s)));
    }
    void hash(const Hash& h) { bytes(std::as_bytes(std::span(h.bytes))); }

    const Bytes& view() const { return bytes_; }
    Bytes take() { return std::move(bytes_); }
    std::size_t size() const { return bytes_.size(); }

private:
    void little(std::uint64_t v, int size) {
        for (int i = 0; i < size; ++i) bytes_.push_back(static_cast<std::byte>(v >> 8 * i));
    }

    Bytes bytes_;
};

}  // namespace mien
