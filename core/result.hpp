#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace mien {

/// Why bytes from outside were refused. The message says what and where; the code lets a caller react.
enum class ErrorCode {
    truncated,            ///< The bytes end before what they announce.
    bad_magic,            ///< Not this kind of file or stream at all.
    unsupported_version,  ///< Ours, but another version.
    limit_exceeded,       ///< A length or count above protocol/limits.hpp or its like.
    damaged,              ///< A checksum or hash does not match, or a value cannot occur.
    trailing_bytes,       ///< More bytes than the content uses.
    invalid,              ///< Well-formed but makes no sense (NaN where a position belongs, unknown codec name, ...).
    mismatch,             ///< Two inputs that belong together disagree (vertex counts, frame counts, hashes).
    missing,              ///< A named part is not there.
    unavailable,          ///< The environment lacks something: a file cannot be opened, a codec is not built in.
};

struct Error {
    ErrorCode code;
    std::string message;  ///< One sentence for a person, without a final full stop.
};

/// A value or the reason there is none. Bytes from outside return this; a caller's mistake asserts instead.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }

    T& value() & { return (assert(ok()), *std::get_if<0>(&state_)); }
    const T& value() const& { return (assert(ok()), *std::get_if<0>(&state_)); }
    T&& value() && { return (assert(ok()), std::move(*std::get_if<0>(&state_))); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    const Error& error() const { return (assert(!ok()), *std::get_if<1>(&state_)); }

private:
    std::variant<T, Error> state_;
};

/// Success without a value, or the reason there was none.
template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : error_(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return error_.index() == 0; }
    explicit operator bool() const { return ok(); }
    const Error& error() const { return (assert(!ok()), *std::get_if<1>(&error_)); }

private:
    std::variant<std::monostate, Error> error_;
};

}  // namespace mien

/// Evaluates `expression` (a Result); on an error returns that error from the calling function, else names the value.
#define MIEN_TRY(name, expression)                            \
    auto name##_result = (expression);                        \
    if (!name##_result.ok()) return name##_result.error();    \
    auto& name = *name##_result
/// The same for a Result<void>, or where the value is not wanted.
#define MIEN_CHECK(expression)                                                     \
    do {                                                                           \
        if (auto mien_check = (expression); !mien_check.ok()) return mien_check.error(); \
    } while (false)
