#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Small tools for text formats. No allocation where a view will do; CR LF, LF and a UTF-8 byte-order mark all welcome.
namespace mien::io {

/// Walks lines. A line excludes its end ("\n", "\r\n" or a lone "\r" of old Macs).
class Lines {
public:
    explicit Lines(std::string_view text);
    bool next(std::string_view& line);  ///< false at the end
    std::size_t number() const { return number_; }  ///< of the line last returned, from 1

private:
    std::string_view rest_;
    std::size_t number_ = 0;
    bool done_;
};

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);  ///< ASCII only

/// Takes the next word (no spaces or tabs in it) off the front of `text`; empty at the end.
std::string_view take_word(std::string_view& text);

/// Fields between separators, trimmed, double quotes around a field taken off. An empty line has one empty field.
std::vector<std::string_view> split(std::string_view line, char separator);

/// A whole field as a number, by std::from_chars ('.' whatever the locale); a leading '+' is allowed, "nan" and "inf" too.
std::optional<double> parse_double(std::string_view field);
std::optional<std::int64_t> parse_integer(std::string_view field);

}  // namespace mien::io
