#include "player/playback.hpp"

#include <algorithm>
#include <cmath>

namespace mien::player {

Playback::Playback(Session session, std::unique_ptr<SoundOutput> sound, bool loop)
    : sound_(std::move(sound)), session_(std::move(session)), frame_rate_(session_.stream->frame_rate.value()), loop_(loop) {
    const StreamModel& stream = *session_.stream;
    rung_ = stream.first_texture_rung;
    adapts_ = session_.adapts;
    if (session_.networked && !stream.live && stream.texture_rungs.size() > 1) {
        std::vector<double> needs;
        for (const StreamModel::TextureRung& rung : stream.texture_rungs)
            needs.push_back(rung.bits_per_second > 0 ? stream.other_bits_per_second + rung.bits_per_second : 0);
        chooser_.emplace(std::move(needs), rung_);
    }
    session_.decode->start(std::int64_t(std::floor(session_.start * frame_rate_ + 1e-6)));
}

void Playback::start(double now) {
    clock_.run(now);
    if (sound_) sound_->play();
}

void Playback::halt(double now) {
    clock_.stop(now);
    if (sound_) sound_->pause();
}

void Playback::end(double now) {
    halt(now);
    ended_ = true;
    show_next_ = waiting_ = false;
}

std::optional<PlayFrame> Playback::shown(std::optional<PlayFrame> frame) {
    if (frame) shown_frame_ = frame->frame;
    return frame;
}

std::optional<PlayFrame> Playback::tick(double now) {
    DecodeThread& decode = *session_.decode;
    if (live()) return tick_live(now);
    adapt(now);
    if (show_next_) {
        auto frame = decode.pop();
        if (!frame) {
            if (decode.drained()) end(now);   // nothing is left behind here, because it is lost
            return std::nullopt;
        }
        show_next_ = false;
        return shown(std::move(frame));
    }
    if (paused_ || ended_) return std::nullopt;
    if (waiting_) {
        if (!decode.ready() && !decode.drained()) return std::nullopt;
        waiting_ = false;
        start(now);
    }
    if (sound_)
        if (const auto heard = sound_->heard()) clock_.follow(now, *heard);
    const auto due = std::int64_t(std::floor(clock_.at(now) * frame_rate_ + 1e-6));
    decode.set_due(due);
    auto frame = decode.take(due);
    if (!frame && decode.empty()) {
        if (decode.drained()) {
            // The last frame stays for its own length.
            if (due > shown_frame_) {
                if (loop_) {
                    seek(now, 0);
                } else {
                    end(now);
                }
            }
        } else if (decode.starved() && due > shown_frame_ + 1) {
            // The clock has run past frames that were not there: they are shown when they come, not skipped.
            halt(now);
            clock_.set(double(shown_frame_ + 1) / frame_rate_);
            waiting_ = true;
            ++stalls_;
        }
    }
    return shown(std::move(frame));
}

std::optional<PlayFrame> Playback::tick_live(double now) {
    constexpr double kSilence = 1;   // seconds without a frame
    if (paused_) return std::nullopt;
    auto frame = session_.decode->take_live(now, sound_ ? sound_->heard() : std::nullopt);
    ended_ = !frame && session_.decode->drained();
    if (frame) {
        waiting_ = false;
        shown_at_ = now;
        fresh_until_ = now + kSilence;
    } else if (ended_) {
        waiting_ = false;
    } else if (now > fresh_until_ && !waiting_) {
        waiting_ = true;
        ++stalls_;
    }
    return shown(std::move(frame));
}

void Playback::toggle_pause(double now) {
    if (live()) {
        paused_ = !paused_;
        if (sound_) paused_ ? sound_->pause() : sound_->play();
        return session_.source->pause(paused_);
    }
    if (ended_) return seek(now, 0);
    paused_ = !paused_;
    if (!paused_ && stepped_) seek(now, shown_frame_ / frame_rate_);   // sound stayed where the pause began
    if (!waiting_) paused_ ? halt(now) : start(now);
    session_.source->pause(paused_);
}

void Playback::seek(double now, double seconds) {
    if (live()) return;
    const double end = session_.stream->frames > 0 ? (session_.stream->frames - 1) / frame_rate_ : seconds;
    // On a frame's own time, so that the clock and the frame agree when it comes.
    const double target = std::round(std::clamp(seconds, 0.0, std::max(0.0, end)) * frame_rate_) / frame_rate_;
    halt(now);
    session_.decode->seek(target, [&] {
        if (sound_) sound_->flush(target);
    });
    clock_.set(target);
    if (chooser_) chooser_->refill();
    shown_frame_ = std::int64_t(std::llround(target * frame_rate_));
    waiting_ = show_next_ = true;
    ended_ = stepped_ = false;
}

void Playback::step(double now, int frames) {
    if (live()) return;
    if (!paused_) toggle_pause(now);
    if (ended_) return seek(now, shown_frame_ / frame_rate_);
    if (frames == 1 && !session_.decode->empty() && !show_next_) {
        show_next_ = true;
        stepped_ = true;
        clock_.set((shown_frame_ + 1) / frame_rate_);
        return;
    }
    seek(now, (shown_frame_ + frames) / frame_rate_);
}

void Playback::set_rate(double now, double rate) {
    if (live()) return;
    rate = std::clamp(rate, 0.25, 4.0);
    clock_.set_rate(now, rate);
    if (sound_) sound_->set_rate(rate);
    session_.source->set_rate(rate);
}

void Playback::toggle_mute() {
    muted_ = !muted_;
    if (sound_) sound_->set_muted(muted_);
}

void Playback::set_volume(double volume) {
    volume_ = std::clamp(volume, 0.0, 1.0);
    if (sound_) sound_->set_volume(volume_);
}

void Playback::use_rung(std::size_t rung) {
    if (rung == rung_) return;
    rung_ = rung;
    session_.decode->select(session_.stream->slots(rung));
}

void Playback::set_rung(std::size_t rung) {
    if (session_.stream->texture_rungs.empty()) return;
    adapts_ = false;
    use_rung(std::min(rung, session_.stream->texture_rungs.size() - 1));
}

void Playback::follow_line(double now) {
    if (session_.stream->texture_rungs.empty()) return;
    if (!chooser_) return use_rung(session_.stream->texture_rungs.size() - 1);
    adapts_ = true;
    chooser_->set_rung(rung_);
    adapted_ = now;
}

void Playback::adapt(double now) {
    constexpr double kEvery = 0.2;
    if (!follows_line() || now - adapted_ < kEvery) return;
    adapted_ = now;
    const net::SourceStatistics source = session_.source->statistics();
    // Near the end less and less is left, however quick the line.
    if (paused_ || ended_ || source.until >= session_.stream->seconds() - 1e-6) return;
    constexpr double kMost = 60;   // whatever a server says
    use_rung(chooser_->choose(now, {std::clamp(source.until - clock_.at(now), 0.0, kMost), source.line}, clock_.rate()));
}

double Playback::position(double now) const {
    if (live()) return double(shown_frame_) / frame_rate_;
    const double length = session_.stream->seconds();
    return length > 0 ? std::clamp(clock_.at(now), 0.0, length) : clock_.at(now);
}

std::optional<double> Playback::sound_lead(double now) const {
    const auto heard = sound_ ? sound_->heard() : std::nullopt;
    if (!heard || (live() && shown_at_ == 0)) return std::nullopt;
    return *heard - (live() ? double(shown_frame_) / frame_rate_ + now - shown_at_ : clock_.at(now));
}

}  // namespace mien::player
