#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mien::net {

struct ServerOptions {
    std::filesystem::path folder;             ///< every *.mien in it is served, under its name without extension
    std::string bind = "127.0.0.1";           ///< loopback by default: serving the world is a decision
    std::uint16_t port = 7777;                ///< 0: any free one
    std::size_t max_viewers = 256;
    bool publish = false;                     ///< whether this machine's programs may send live streams
    std::size_t max_publishers = 16;
    std::uint64_t live_bytes = 4u << 20;      ///< of each live stream, kept for viewers that join or are slow
    double ahead = 5;                         ///< seconds that groups are sent before they are due
    std::chrono::milliseconds handshake_timeout{5000};  ///< until HELLO has come
    std::chrono::milliseconds idle_timeout{30000};      ///< without a byte from the viewer; clients ping every 5 s
    std::chrono::milliseconds stall_timeout{300000};    ///< of one write without progress, although the viewer still pings
    /// One line per event (viewer came, left and why); called from the server's thread. Empty: silence.
    std::function<void(const std::string& line)> log;
};

/// Counts since the start; a copy.
struct ServerStatistics {
    std::uint64_t viewers = 0;         ///< connected now
    std::uint64_t accepted = 0;
    std::uint64_t refused = 0;         ///< above max_viewers
    std::uint64_t groups_sent = 0;     ///< whole ones, and started ones of live streams
    std::uint64_t blobs_sent = 0;
    std::uint64_t bytes_sent = 0;
    std::uint64_t queued_bytes = 0;    ///< held for all viewers now
    std::uint64_t peak_viewer_bytes = 0;  ///< the most ever held for one viewer
};

/// Serves the recorded streams of a folder, and live ones if asked to, to many viewers. A slow or dead viewer never touches another: each has its own
/// place in the file, one group in memory at most, and time-outs.
class Server {
public:
    /// Binds and listens. Throws EnvironmentError: folder missing, address or port not to be had.
    explicit Server(ServerOptions options);
    ~Server();  ///< stops

    std::uint16_t port() const;                    ///< the one that was bound
    std::vector<std::string> streams() const;      ///< names served now
    /// "name: why" for every *.mien file of the folder that cannot be served.
    std::vector<std::string> unreadable() const;
    /// Likewise for those that are served although their end is cut off or damaged.
    std::vector<std::string> incomplete() const;

    void start();                                  ///< serves on a thread of its own
    /// Serves on this thread until stop(), or until SIGINT or SIGTERM arrives.
    void run_until_signal();
    /// Says BYE to all viewers, closes, joins. Harmless when repeated.
    void stop();
    ServerStatistics statistics() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::net
