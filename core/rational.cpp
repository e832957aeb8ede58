#include "core/rational.hpp"

#include <charconv>
#include <limits>
#include <numeric>

namespace mien {

Rational Rational::inverse() const {
    assert(num != 0);
    return make_rational(den, num);
}

Rational make_rational(std::int64_t num, std::int64_t den) {
    assert(den != 0);
    if (den < 0) {
        num = -num;
        den = -den;
    }
    const std::int64_t divisor = std::gcd(num, den);
    return divisor > 1 ? Rational{num / divisor, den / divisor} : Rational{num, den};
}

namespace {

constexpr std::int64_t kMaxTerm = std::numeric_limits<std::int32_t>::max();

/// Decimal digits only, at most kMaxTerm; -1 when not that.
std::int64_t parse_term(std::string_view digits) {
    std::int64_t value = -1;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool whole = error == std::errc{} && end == digits.data() + digits.size();
    return whole && !digits.empty() && digits.front() != '-' && value <= kMaxTerm ? value : -1;
}

}  // namespace

Result<Rational> parse_rational(std::string_view text) {
    const Error error{ErrorCode::invalid, "'" + std::string(text) + "' is not a positive number or fraction such as 30 or 30000/1001"};
    std::int64_t num = -1;
    std::int64_t den = 1;
    if (const auto slash = text.find_first_of("/:"); slash != text.npos) {   // ffmpeg writes both
        num = parse_term(text.substr(0, slash));
        den = parse_term(text.substr(slash + 1));
    } else if (const auto point = text.find('.'); point != text.npos) {
        auto decimals = text.substr(point + 1);
        while (!decimals.empty() && decimals.back() == '0') decimals.remove_suffix(1);
        if (decimals.size() > 9) return error;
        for (std::size_t i = 0; i < decimals.size(); ++i) den *= 10;
        num = parse_term(std::string(text.substr(0, point)) + std::string(decimals));
    } else {
        num = parse_term(text);
    }
    if (num <= 0 || den <= 0) return error;
    return make_rational(num, den);
}

std::string to_string(Rational r) {
    return r.den == 1 ? std::to_string(r.num) : std::to_string(r.num) + "/" + std::to_string(r.den);
}

std::int64_t rescale(std::int64_t ticks, Rational from, Rational to) {
    __extension__ using Wide = __int128;
    const Wide num = Wide(ticks) * from.num * to.den;
    const Wide den = Wide(from.den) * to.num;
    assert(den > 0);
    const Wide half = den / 2;
    return static_cast<std::int64_t>(num >= 0 ? (num + half) / den : -((-num + half) / den));
}

}  // namespace mien
