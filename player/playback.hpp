#pragma once

#include <optional>
#include <string>

#include "player/play_clock.hpp"
#include "player/rung_chooser.hpp"
#include "player/session.hpp"
#include "player/sound_output.hpp"

namespace mien::player {

/// Plays a session in time: which frame is due, when to wait, what the keys do to it. Called from the window's thread
/// only; `now` is in steady seconds.
class Playback {
public:
    /// `sound` may be null: no device, or no sound in the stream.
    Playback(Session session, std::unique_ptr<SoundOutput> sound, bool loop);

    /// The frame to show from now on, when it is another one than before.
    std::optional<PlayFrame> tick(double now);

    void toggle_pause(double now);
    void seek_by(double now, double seconds) { seek(now, position(now) + seconds); }
    void seek(double now, double seconds);
    void step(double now, int frames);             ///< pauses; backwards seeks
    void set_rate(double now, double rate);        ///< 0.25 .. 4
    void toggle_mute();
    void set_volume(double volume);                ///< 0 .. 1
    void toggle_loop() { loop_ = !loop_; }
    /// Another rung of texture, from the next group that has not been sent; it no longer follows the line.
    void set_rung(std::size_t rung);
    void follow_line(double now);                  ///< the rung does again; of a file: the finest

    double position(double now) const;             ///< seconds
    double rate() const { return clock_.rate(); }
    bool paused() const { return paused_; }
    bool muted() const { return muted_; }
    bool loops() const { return loop_; }
    double volume() const { return volume_; }
    std::size_t rung() const { return rung_; }     ///< asked for; what is shown follows when what was sent before has been
    bool follows_line() const { return chooser_ && adapts_; }
    bool waiting() const { return waiting_ && !paused_; }   ///< for the network
    bool ended() const { return ended_; }
    bool live() const { return session_.stream->live; }     ///< then only toggle_pause() does anything
    bool has_sound() const { return sound_ != nullptr; }
    /// Sound heard minus picture shown, seconds; none when there is no sound to be heard.
    std::optional<double> sound_lead(double now) const;
    std::uint32_t stalls() const { return stalls_; }
    const Session& session() const { return session_; }

private:
    std::optional<PlayFrame> tick_live(double now);
    void adapt(double now);
    void use_rung(std::size_t rung);
    void start(double now);
    void halt(double now);
    void end(double now);
    std::optional<PlayFrame> shown(std::optional<PlayFrame> frame);

    std::unique_ptr<SoundOutput> sound_;           // outlives the decode thread that fills it
    Session session_;
    PlayClock clock_;
    double frame_rate_;
    bool loop_, paused_ = false, waiting_ = true, ended_ = false, muted_ = false;
    bool show_next_ = true;                        // the next frame is shown whatever the time: after a seek or step
    bool stepped_ = false;                         // frame by frame while paused; sound did not follow
    std::int64_t shown_frame_ = 0;
    double shown_at_ = 0;                          // live: when that was
    std::uint32_t stalls_ = 0;
    double volume_ = 1;
    std::optional<RungChooser> chooser_;           // of a recording with several rungs, from a server
    bool adapts_ = false;
    std::size_t rung_ = 0;
    double adapted_ = 0;                           // when the line was last looked at
    double fresh_until_ = 0;                       // live: when no frame has come by then, we wait for one
};

}  // namespace mien::player
