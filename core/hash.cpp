#include "core/hash.hpp"

#include <openssl/evp.h>

#include "core/environment_error.hpp"

namespace mien {

std::string Hash::hex() const {
    static constexpr char digits[] = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t b : bytes) {
        text += digits[b >> 4];
        text += digits[b & 15];
    }
    return text;
}

Hash sha256(ByteView bytes) {
    Hash hash;
    unsigned size = 0;
    if (EVP_Digest(bytes.data(), bytes.size(), hash.bytes.data(), &size, EVP_sha256(), nullptr) != 1)
        throw EnvironmentError("the OpenSSL library offers no SHA-256; install a complete libcrypto");
    return hash;
}

namespace {

/// Tables for eight bytes a step ("slicing by 8"): table[k][b] is the CRC of byte b followed by k zero bytes.
struct CrcTables {
    std::uint32_t table[8][256];
    constexpr CrcTables() : table{} {
        for (std::uint32_t b = 0; b < 256; ++b) {
            std::uint32_t crc = b;
            for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0x82F63B78u : 0u);
            table[0][b] = crc;
        }
        for (int k = 1; k < 8; ++k)
            for (int b = 0; b < 256; ++b) table[k][b] = (table[k - 1][b] >> 8) ^ table[0][table[k - 1][b] & 255];
    }
};
constexpr CrcTables kCrc;

}  // namespace

std::uint32_t crc32c(ByteView bytes, std::uint32_t previous) {
    std::uint32_t crc = ~previous;
    const auto* p = reinterpret_cast<const std::uint8_t*>(bytes.data());
    std::size_t n = bytes.size();
    const auto& t = kCrc.table;
    for (; n >= 8; n -= 8, p += 8) {
        const std::uint32_t low = crc ^ (p[0] | p[1] << 8 | p[2] << 16 | std::uint32_t(p[3]) << 24);
        crc = t[7][low & 255] ^ t[6][low >> 8 & 255] ^ t[5][low >> 16 & 255] ^ t[4][low >> 24] ^ t[3][p[4]] ^
              t[2][p[5]] ^ t[1][p[6]] ^ t[0][p[7]];
    }
    for (; n > 0; --n, ++p) crc = (crc >> 8) ^ t[0][(crc ^ *p) & 255];
    return ~crc;
}

}  // namespace mien
