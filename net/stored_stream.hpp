#pragma once

#include <filesystem>

#include "core/result.hpp"
#include "protocol/stream_file.hpp"

namespace mien::net {

/// Opens a stored stream on disk. The file stays open as long as the reader or a copy of it lives; it may be used from
/// several threads. Errors name the file: `unavailable` when it cannot be opened, else what StreamFileReader::open says.
Result<protocol::StreamFileReader> open_stored_stream(const std::filesystem::path& path);

}  // namespace mien::net
