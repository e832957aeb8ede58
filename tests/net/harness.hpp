#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "core/environment_error.hpp"
#include "net/client.hpp"
#include "net/server.hpp"
#include "net/stream_list.hpp"
#include "sample_stream.hpp"
#include "tests/temporary_folder.hpp"

/// What the network tests stand on: a folder of streams, a served one, and plain blocking sockets.
namespace mien::net::harness {

using namespace std::chrono_literals;
using protocol::sample::Stream;

constexpr auto kPatience = 20s;  // far above what anything takes, also under a sanitizer on a busy machine

/// A folder that streams are put into.
class Folder : public tests::TemporaryFolder {
public:
    void write(const std::string& name, const Bytes& bytes) const {
        std::ofstream out(path() / name, std::ios::binary);
        out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    }
};

/// Waits until `done` says so; false when patience ends.
template <class Done>
bool wait_until(Done done) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(2ms);
    }
    return true;
}

/// A server on a free loopback port with one stream, "take".
struct Served {
    explicit Served(const Stream& s, ServerOptions options = {}) : stream(s) {
        folder.write("take.mien", protocol::sample::file_of(stream));
        options.folder = folder.path();
        options.port = 0;
        server = std::make_unique<Server>(options);
        server->start();
    }
    Url url(std::string name = "take") const { return {"127.0.0.1", server->port(), std::move(name)}; }

    Stream stream;
    Folder folder;
    std::unique_ptr<Server> server;
};

inline SourceOptions unpaced() {
    SourceOptions options;
    options.rate = 0;
    options.first_backoff = 10ms;
    options.last_backoff = 50ms;
    return options;
}

/// All that comes until the end of the stream, or until patience ends (then the last one has a group).
inline std::vector<Arrival> play_all(StreamSource& source) {
    std::vector<Arrival> all;
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
        auto arrival = source.next(100ms);
        if (!arrival) {
            if (source.status().state == SourceState::failed) break;
            continue;
        }
        all.push_back(std::move(*arrival));
        if (all.back().is_end()) break;
    }
    return all;
}

/// Groups in the order in which they are handed out: of each number the texture (slot 1 and above 2) last.
inline std::vector<protocol::Group> as_played(const Stream& stream) {
    std::vector<protocol::Group> groups = stream.groups;
    const auto order = [](const protocol::Group& g) { return std::tuple(g.group, g.slot != 0 && g.slot != 2, g.slot); };
    std::ranges::stable_sort(groups, {}, order);
    return groups;
}

/// Checks that `arrivals` are the groups from `first` on, each once and whole, and then the end.
inline void expect_groups(const std::vector<Arrival>& arrivals, const Stream& stream, std::size_t first = 0) {
    ASSERT_EQ(arrivals.size(), stream.groups.size() - first + 1);
    const std::vector<protocol::Group> expected = as_played(stream);
    for (std::size_t g = first; g < expected.size(); ++g) {
        const auto& arrival = arrivals[g - first];
        ASSERT_TRUE(arrival.group.has_value()) << g;
        EXPECT_TRUE(protocol::sample::same(*arrival.group, expected[g])) << g;
    }
    EXPECT_FALSE(arrivals.back().group.has_value());
}

/// A blocking TCP socket, for saying what no client says.
class RawSocket {
public:
    explicit RawSocket(std::uint16_t port);
    ~RawSocket();
    RawSocket(const RawSocket&) = delete;
    RawSocket& operator=(const RawSocket&) = delete;

    bool send(ByteView bytes);                  ///< false: the other side has closed
    bool send(const protocol::Message& message) { return send(protocol::encode(message)); }
    /// The next message; none when the connection is closed (or patience ends).
    std::optional<protocol::Message> receive();
    bool closed_by_peer();                      ///< waits for it, throwing away what still comes
    void shrink_receive_buffer();

private:
    friend class RawServer;
    struct Accepted {
        int socket;
    };
    explicit RawSocket(Accepted accepted);

    int socket_ = -1;
    Bytes buffer_;
};

/// A server that says whatever a test wants, to one viewer at a time.
class RawServer {
public:
    RawServer();
    ~RawServer();
    RawServer(const RawServer&) = delete;
    RawServer& operator=(const RawServer&) = delete;
    std::uint16_t port() const { return port_; }
    RawSocket accept();                         ///< waits for a viewer

private:
    std::uint16_t port_ = 0;
    int listener_ = -1;
};

/// make_stream() with `count` refinements of `bytes` bytes each before its motion basis.
inline Stream refined_stream(int seconds, int count, std::size_t bytes, std::size_t texture_bytes = 40) {
    Stream stream = protocol::sample::make_stream(seconds, texture_bytes);
    for (int r = 0; r < count; ++r)
        stream.blobs.insert(stream.blobs.end() - 1, protocol::sample::make_blob(protocol::BlobKind::refinement, protocol::sample::noise(bytes, std::uint32_t(100 + r))));
    return stream;
}
/// The refinements of a stream, in order.
inline std::vector<protocol::StaticBlob> refinements_of(const Stream& stream) {
    std::vector<protocol::StaticBlob> refinements;
    for (const auto& blob : stream.blobs)
        if (blob.kind == protocol::BlobKind::refinement) refinements.push_back(blob);
    return refinements;
}

/// Stands between client and server, counts bytes, and cuts when told.
class Proxy {
public:
    explicit Proxy(std::uint16_t target);
    ~Proxy();
    std::uint16_t port() const { return port_; }
    void cut();                                  ///< every connection there is now
    void cut_after(std::uint64_t bytes) { cut_after_ = bytes; }  ///< from the server, of each new connection; 0: never
    /// Bytes per second from the server that each connection takes, little of it buffered; 0: as many as come.
    void throttle(std::uint64_t bytes) { throttle_ = bytes; }
    /// From the server, over all connections, no more passes until this grows; 0: all that comes.
    void hold_after(std::uint64_t bytes) { hold_after_ = bytes; }
    void freeze(bool frozen) { frozen_ = frozen; }  ///< open, but no byte passes: half-open
    void refuse(bool refuse) { refuse_ = refuse; }  ///< new connections are closed at once
    int connections() const { return connections_; }
    std::uint64_t served() const { return served_; }   ///< bytes from the server so far, over all connections

private:
    void accept();
    void pump(int from, int to, bool from_server);

    std::uint16_t port_ = 0;
    int listener_ = -1;
    std::uint16_t target_ = 0;
    std::atomic<bool> stop_ = false, frozen_ = false, refuse_ = false;
    std::atomic<std::uint64_t> cut_after_ = 0, throttle_ = 0, hold_after_ = 0;
    std::atomic<std::uint64_t> served_ = 0;   // bytes from the server so far
    std::atomic<int> connections_ = 0;
    std::mutex mutex_;
    std::vector<int> open_;
    std::vector<std::thread> threads_;
    std::thread acceptor_;
};

}  // namespace mien::net::harness
