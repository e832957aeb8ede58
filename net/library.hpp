#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "protocol/stream_file.hpp"

/// The streams of a folder, by name. Internal to this room.
namespace mien::net {

class Library {
public:
    explicit Library(std::filesystem::path folder) : folder_(std::move(folder)) {}

    struct Listing {
        std::vector<protocol::StreamEntry> streams;   ///< by name
        std::vector<std::string> unreadable;          ///< "file: why"
        std::vector<std::string> incomplete;          ///< likewise: served as far as they go
    };
    /// Looks at the folder again; only new and changed files are opened. Thread-safe.
    Listing list();
    /// A stream by its name, as list() tells it. A name is only ever compared, never made into a path. Thread-safe.
    Result<std::shared_ptr<const protocol::StreamFileReader>> open(const std::string& name);

private:
    struct Known {
        std::filesystem::path path;
        std::filesystem::file_time_type changed;
        std::uintmax_t size = 0;
        protocol::StreamEntry entry;
        std::string complaint;                        ///< why it cannot be served; empty: it can
        std::string remark;                           ///< what it lacks although it can be served
        std::weak_ptr<const protocol::StreamFileReader> open;
    };
    void look();
    std::shared_ptr<const protocol::StreamFileReader> read(Known& file) const;

    const std::filesystem::path folder_;
    std::mutex mutex_;
    std::map<std::string, Known> files_;
    std::string folder_complaint_;
};

}  // namespace mien::net
