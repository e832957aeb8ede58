#pragma once

#include <asio/steady_timer.hpp>
#include <asio/thread_pool.hpp>
#include <atomic>
#include <deque>
#include <memory>
#include <optional>

#include "net/group_walk.hpp"
#include "net/library.hpp"
#include "net/live_stream.hpp"
#include "net/server.hpp"
#include "net/wire.hpp"

/// One viewer of a server, or one publisher. Internal to this room.
namespace mien::net {

/// What all viewers of a server share.
struct ServerShared {
    const ServerOptions options;
    Library library;
    LiveStreams live;                ///< on the server's thread only
    asio::thread_pool files{2};      ///< reads files, so that a slow disk never holds up the sockets

    std::atomic<std::uint64_t> viewers = 0, accepted = 0, refused = 0;
    std::atomic<std::uint64_t> groups_sent = 0, blobs_sent = 0, bytes_sent = 0;
    std::atomic<std::uint64_t> queued_bytes = 0, peak_viewer_bytes = 0;

    explicit ServerShared(ServerOptions o) : options(std::move(o)), library(options.folder) {}
    void log(const std::string& line) const {
        if (options.log) options.log(line);
    }
};

/// A reader takes the viewer's messages, a writer sends what they ask for, a watchdog ends both. All run on the server's
/// one thread, so nothing here is locked. Memory: the message being sent, a few short replies, and the asked-for hashes.
class Viewer : public std::enable_shared_from_this<Viewer> {
public:
    Viewer(asio::ip::tcp::socket socket, ServerShared& shared, std::uint64_t number);
    ~Viewer();

    void start();
    /// Sends a last message (FAILURE, BYE), then closes; harmless when already closing.
    void close_with(const protocol::Message& last);
    /// Closes at once.
    void drop(const std::string& why);

private:
    asio::awaitable<void> read_messages();
    asio::awaitable<void> write_messages();
    asio::awaitable<void> watch();

    /// False when the message has no place here: the connection is closing then.
    asio::awaitable<bool> handle(const RawMessage& raw);
    asio::awaitable<bool> open(const std::string& name);
    bool want(const std::vector<protocol::WantPart>& parts);
    asio::awaitable<void> list();
    asio::awaitable<bool> publish(const std::string& name);
    asio::awaitable<bool> take_published(RawMessage raw);
    void open_live(std::shared_ptr<LiveStream> stream);
    void close_stream();
    const protocol::Catalogue& catalogue() const { return live_ ? live_->catalogue() : stream_->catalogue(); }

    asio::awaitable<bool> send(ByteView message);
    asio::awaitable<bool> send_blob(Hash hash);
    asio::awaitable<bool> send_part(protocol::WantPart wanted);
    /// Sends the next thing play asks for: PLAYING, a group, END; or, when nothing is due, rests.
    asio::awaitable<bool> play_on();
    asio::awaitable<bool> play_live();
    /// Sends the next static blob, or part of one, that is wanted; without one waits until something is asked for, or `longest` has passed.
    asio::awaitable<bool> rest(std::optional<Clock::duration> longest);
    asio::awaitable<void> wait(std::optional<Clock::duration> longest);

    void reply(const protocol::Message& message);
    void fail(protocol::FailureCode code, const std::string& text);
    void ring() { bell_.cancel(); }
    void hold(std::uint64_t bytes);

    void restart_live();                         ///< at the newest group
    double position() const;                     ///< seconds: where the viewer's play clock stands
    void set_position(double seconds);

    ServerShared& shared_;
    const std::uint64_t number_;
    std::string peer_;
    Wire wire_;
    asio::steady_timer bell_;                    ///< wakes the writer
    asio::steady_timer guard_;                   ///< the watchdog's
    Clock::time_point since_ = Clock::now();
    bool greeted_ = false;
    bool closed_ = false;
    std::string why_ = "it went away";
    std::optional<Bytes> last_;                  ///< to be sent before closing
    std::optional<Clock::time_point> closing_since_;
    std::deque<Bytes> replies_;
    std::size_t reply_bytes_ = 0;                ///< sum of replies_
    std::deque<protocol::WantPart> wanted_;      ///< of 0 bytes: the whole blob
    std::uint64_t held_ = 0;                     ///< bytes counted in shared_.queued_bytes

    std::unique_ptr<Publication> publication_;   ///< of a publisher; then nothing below is used
    std::shared_ptr<LiveStream> live_;           ///< this or stream_ is what is open
    std::uint64_t next_record_ = 0;              ///< of live_
    std::uint64_t started_ = 0;                  ///< bit per slot whose group has been started here
    std::optional<std::uint32_t> live_group_;    ///< the newest that has been started here
    std::uint64_t live_slots_ = 0;               ///< selected when it was
    std::shared_ptr<const protocol::StreamFileReader> stream_;
    std::optional<GroupWalk> walk_;              ///< of stream_
    bool playing_ = false;                       ///< PLAY has come
    bool announce_ = false;                      ///< PLAYING is due
    bool ended_ = false;                         ///< END has been sent
    std::uint32_t generation_ = 0;
    std::uint64_t slots_ = ~std::uint64_t(0);    ///< selected, for groups that have not begun
    double base_ = 0;                            ///< seconds of the stream at base_at_
    Clock::time_point base_at_ = Clock::now();
    double rate_ = 1;                            ///< 0: unpaced
    bool paused_ = false;
};

}  // namespace mien::net
